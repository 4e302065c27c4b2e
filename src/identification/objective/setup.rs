//! Parts common to all objectives: measured points, free parameters, the range of an unknown gain,
//! precomputed rods.

use std::sync::Arc;

use super::ObjectiveError;
use dynamics::model::{FrequencyGrid, Structure};
use machine::{FitRule, Machine, Operating};

/// Range of an unknown gain (1).
pub const GAIN_RANGE: (f64, f64) = (1e-9, 1e9);

/// Finds the point of the machine that a measurement names.
pub fn point_named(machine: &Machine, source: &str, key: &str, name: &str) -> Result<usize, ObjectiveError> {
    machine.point(name).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().map(|p| p.name.as_str()).collect();
        ObjectiveError::Data(format!(
            "{source}: {key} = \"{name}\" is not a point of the machine; it has {}",
            known.join(", ")
        ))
    })
}

/// Returns the indices of the parameters to fit, without frozen ones and those that affect motion alone;
/// `of_drive` marks those of the loops on which the data depend.
pub(crate) fn free_parameters(
    machine: &Machine,
    frozen: &[String],
    of_drive: &[bool],
    fitted: impl Fn(FitRule) -> bool,
) -> Result<Vec<usize>, ObjectiveError> {
    for id in frozen {
        if machine.parameter(id).is_none() {
            let known: Vec<&str> = machine.parameters.iter().map(|p| p.id.as_str()).collect();
            let fault = format!("the machine has no such parameter; it has {}", known.join(", "));
            return Err(ObjectiveError::Setting { key: "freeze", given: id.clone(), fault });
        }
    }
    let linear = machine.linear_parameters();
    let acts = |i: usize| linear[i] || of_drive.get(i).is_some_and(|of_drive| *of_drive);
    let free = |i: &usize| {
        acts(*i) && fitted(machine.parameters[*i].fit) && !frozen.contains(&machine.parameters[*i].id)
    };
    Ok((0..machine.parameters.len()).filter(free).collect())
}

/// Precomputes rods on a frequency grid whose entries agree at two sets of parameters, each with its
/// operating condition.
pub(super) fn keep_rods(
    lines: &mut FrequencyGrid,
    (machine, structure): (&Machine, &Arc<Structure>),
    places: [(&[f64], Operating); 2],
) {
    let [network, other] = places.map(|(parameters, operating)| {
        let mut network = structure.empty_model();
        network.update(machine, parameters, &operating);
        network
    });
    lines.keep_rods(&network, |rod| network.has_rod_of(&other, rod));
}
