//! The operating condition of a simulation.

use crate::outcome::to_message;
use crate::sources::Loaded;
use machine::{Machine, Operating};

/// Load of the machine.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct LoadArguments {
    /// Velocity of the table (m/s), whose friction loads the contacts
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), whose inertia force loads the contacts
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub acceleration_m_s2: Option<f64>,
    /// External axial force (N) on the contacts
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub force_n: Option<f64>,
}

/// Returns the operating condition at a nut position, at a named position, or at mid-stroke.
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

/// Adds velocity, acceleration and force to an operating condition.
fn with_load(at_rest: Operating, load: &LoadArguments) -> Operating {
    let LoadArguments { velocity_m_s, acceleration_m_s2, force_n } = *load;
    Operating { velocity_m_s, acceleration_m_s2, force_n, ..at_rest }
}

/// Warns of a load that nothing depends on, and of effects that act in motion only.
pub fn load_warnings(machine: &Machine, load: &LoadArguments) -> Vec<String> {
    let given = load.velocity_m_s.is_some() || load.acceleration_m_s2.is_some() || load.force_n.is_some();
    let none = given && machine.contacts.is_empty();
    let unmoved = none.then(|| "velocity, acceleration and force change nothing: no joint of this machine is a [contact.…]".to_string());
    let left_out = machine.joints_ignored_by_frequency_responses().join(", ");
    let left_out = (!left_out.is_empty()).then(|| {
        format!("friction, backlash and lead error of {left_out} act in motion only and are left out; damping of a joint is its viscous friction")
    });
    unmoved.into_iter().chain(left_out).collect()
}

/// Returns a number above 0, or an error.
pub fn require_positive(key: &str, x: f64) -> Result<f64, String> {
    if x > 0.0 && x.is_finite() { Ok(x) } else { Err(format!("{key} {x}: write a number above 0")) }
}
