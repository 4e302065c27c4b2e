//! The operating condition of a simulation.

use crate::{Study, StudyError, StudyResult};
use machine::{LoadedPair, Machine, Operating};

/// Load on the rolling contacts of nut and bearings; by default none, at rest.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Load {
    /// Velocity of the table (m/s); the friction at this velocity loads the contacts.
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), upward positive on a vertical axis; its inertia force loads the
    /// contacts.
    pub acceleration_m_s2: Option<f64>,
    /// External axial force (N) on the table.
    pub force_n: Option<f64>,
}

/// Place of the nut on the screw.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Place {
    /// The middle of the stroke; for a machine without a nut, the machine as it is.
    #[default]
    MidStroke,
    /// Distance from the left end of the screw (m).
    Nut(f64),
    /// Name of a position of the measurement set.
    Position(String),
}

/// Returns the operating condition at a place, under a load.
///
/// # Errors  no position has this name; the machine does not allow this condition.
pub fn find_operating(study: &Study, place: &Place, load: &Load) -> StudyResult<Operating> {
    let machine = study.machine();
    let Load { velocity_m_s, acceleration_m_s2, force_n } = *load;
    let loaded = |at_rest: Operating| Operating { velocity_m_s, acceleration_m_s2, force_n, ..at_rest };
    match place {
        Place::Nut(nut_m) => checked_nut(machine, "nut_m", loaded(Operating::at_nut(*nut_m))),
        Place::Position(name) => {
            let index = study.measurements().position_named(name)?;
            checked(
                machine,
                &format!("position {name}"),
                loaded(Operating::at(study.measurements().positions[index].nut_m)),
            )
        }
        Place::MidStroke => {
            checked(machine, "mid-stroke", loaded(Operating::at(machine.stroke_m().map(|s| 0.5 * s))))
        }
    }
}

fn checked(machine: &Machine, place: &str, operating: Operating) -> StudyResult<Operating> {
    machine.check_operating(place, &operating)?;
    Ok(operating)
}

/// Returns an operating condition whose nut position was given as a setting, if the machine allows it.
///
/// # Errors  the machine has no nut, or does not allow this condition; the error names the setting where its
///   value is at fault.
pub fn checked_nut(machine: &Machine, key: &str, operating: Operating) -> StudyResult<Operating> {
    if let (None, Some(nut_m)) = (machine.stroke_m(), operating.nut_m) {
        return Err(StudyError::setting(
            key,
            nut_m,
            "this machine describes no screw with a nut on it; leave the nut position out",
        ));
    }
    match machine.check_operating(key, &operating) {
        Ok(()) => Ok(operating),
        Err(error) if error.part == key => Err(StudyError::setting(key, "", error.fault)),
        Err(error) => Err(error.into()),
    }
}

/// Lists warnings: a load on a machine without contacts, contacts of which a side lets go, and joints whose
/// nonlinearities a linear prediction leaves out.
pub fn load_warnings(machine: &Machine, load: &Load, operating: &[Operating]) -> Vec<String> {
    let no_contact = (*load != Load::default() && machine.contacts.is_empty()).then(|| {
        "velocity, acceleration and force change nothing: the machine describes no joint as [contact.…]"
            .to_string()
    });
    let joints = machine.joints_ignored_by_frequency_responses().join(", ");
    let left_out = (!joints.is_empty()).then(|| {
        format!("friction, backlash and lead error of {joints} are left out of this linear model; viscous friction is the joint's damping")
    });
    let unloaded = machine
        .contacts
        .iter()
        .filter_map(|contact| operating.iter().find_map(|here| unloaded_warning(contact, here)));
    no_contact.into_iter().chain(left_out).chain(unloaded).collect()
}

/// Says that a side of a preloaded pair carries no load at an operating condition.
fn unloaded_warning(contact: &LoadedPair, operating: &Operating) -> Option<String> {
    let state = contact.at(operating).ok()?;
    let side = match (state.share.load_a_n > 0.0, state.share.load_b_n > 0.0) {
        (true, true) => return None,
        (false, _) => "A",
        (true, false) => "B",
    };
    let (a_n, b_n) = contact.pair.unloading_forces_n(contact.rule);
    let unloads_n = if side == "A" { a_n } else { b_n };
    Some(format!(
        "contact.{}: side {side} has let go under {:.0} N, it unloads at {unloads_n:.0} N: the preload is lost, and the stiffness is that of the \
         other side alone",
        contact.name, state.force_n
    ))
}

/// Returns a number if it is finite and above 0.
///
/// # Errors  any other number; the error names the setting `key`.
pub fn require_positive(key: &str, x: f64) -> StudyResult<f64> {
    if x > 0.0 && x.is_finite() {
        Ok(x)
    } else {
        Err(StudyError::setting(key, x, "write a finite number above 0"))
    }
}

/// Checks that a count is not below its least value.
///
/// # Errors  a smaller count; the error names the setting `key`.
pub fn require_count(key: &str, count: usize, least: usize) -> StudyResult<usize> {
    if count >= least {
        Ok(count)
    } else {
        Err(StudyError::setting(key, count, format!("write a number from {least}")))
    }
}
