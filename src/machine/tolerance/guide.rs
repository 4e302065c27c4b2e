//! Damping of a guide that the description lacks.

use super::number::{STOP, size, tolerance};
use crate::{Joint, Machine, Mechanism, PointMotion, Prior, Value};

/// Begins the name of its tolerance.
pub(super) const OF_GUIDE: &str = "guide damping of ";

/// Returns the point with the largest mass, where no joint connects it to the ground alone.
pub(super) fn undescribed(machine: &Machine) -> Option<usize> {
    let point = machine.largest(PointMotion::Translation)?;
    let is_guided = machine.joints.iter().any(|j| matches!(j.on[..], [(on, _)] if on == point));
    (!is_guided).then_some(point)
}

/// Adds a viscous damper between the largest mass and the ground, with a half-normal prior.
///
/// Every guide has some damping. Where the description states none, other joints take its part: their
/// dampings and the stiffness of a hold end far from their true values, and the misfit does not show it.
pub(super) fn damp_undescribed_guide(machine: &mut Machine) {
    let per_s = machine.tolerance.guide_damping;
    let Some(point) = undescribed(machine).filter(|_| per_s > 0.0) else { return };
    let sd = per_s * size(&machine.points[point].inertia, machine);
    let name = format!("{OF_GUIDE}{}", machine.points[point].name);
    let parameter =
        tolerance(name, (Mechanism::Damping, "N*s/m"), (0.0, Prior::Normal(sd)), [0.0, STOP * sd]);
    let damping = Value::parameter(machine.parameters.len());
    machine.joints.push(Joint { damping, ..Joint::new(parameter.id.clone(), vec![(point, 1.0)]) });
    machine.parameters.push(parameter);
}
