//! The operating condition of a simulation.

use crate::outcome::to_message;
use crate::sources::Loaded;
use machine::{Machine, Operating};

/// Load on the rolling contacts of nut and bearings.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct LoadArguments {
    /// Velocity of the table (m/s); the friction at this velocity loads the contacts
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), upward positive on a vertical axis; its inertia force loads the contacts
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub acceleration_m_s2: Option<f64>,
    /// External axial force (N) on the table, which loads the contacts
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub force_n: Option<f64>,
}

/// Returns the operating condition at a nut position, at a named position, or at mid-stroke.
///
/// # Errors  no position has this name; the machine does not allow this condition.
pub fn find_operating(loaded: &Loaded, nut_m: Option<f64>, position: Option<&str>, load: &LoadArguments) -> Result<Operating, String> {
    let machine = &loaded.config.machine;
    let (place, at_rest) = match (nut_m, position) {
        (Some(nut_m), _) => ("--nut-m".to_string(), Operating::at_nut(nut_m)),
        (None, Some(name)) => {
            let index = loaded.set.positions_named(&[name.to_string()]).map_err(to_message)?[0];
            (format!("position {name}"), Operating::at(loaded.set.positions[index].nut_m))
        }
        (None, None) => ("mid-stroke".into(), Operating::at(machine.stroke_m().map(|s| 0.5 * s))),
    };
    let operating = with_load(at_rest, load);
    machine.check_operating(&place, &operating).map_err(to_message)?;
    Ok(operating)
}

/// Sets velocity, acceleration and force of an operating condition.
fn with_load(at_rest: Operating, load: &LoadArguments) -> Operating {
    let LoadArguments { velocity_m_s, acceleration_m_s2, force_n } = *load;
    Operating { velocity_m_s, acceleration_m_s2, force_n, ..at_rest }
}

/// Lists warnings: a load on a machine without contacts, and joints whose nonlinearities a linear prediction leaves out.
pub fn load_warnings(machine: &Machine, load: &LoadArguments) -> Vec<String> {
    let given = load.velocity_m_s.is_some() || load.acceleration_m_s2.is_some() || load.force_n.is_some();
    let no_contact = (given && machine.contacts.is_empty())
        .then(|| "velocity, acceleration and force change nothing: the machine describes no joint as [contact.…]".to_string());
    let joints = machine.joints_ignored_by_frequency_responses().join(", ");
    let left_out = (!joints.is_empty()).then(|| {
        format!("friction, backlash and lead error of {joints} are left out of this linear model; viscous friction is the joint's damping")
    });
    no_contact.into_iter().chain(left_out).collect()
}

/// Returns a number if it is finite and above 0.
///
/// # Errors  any other number; the message names the argument `key`.
pub fn require_positive(key: &str, x: f64) -> Result<f64, String> {
    if x > 0.0 && x.is_finite() { Ok(x) } else { Err(format!("{key} {x}: write a finite number above 0")) }
}
