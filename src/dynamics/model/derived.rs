//! Derived quantities of a machine: natural frequencies, antiresonances, ratios of inertia, parameters.

use std::sync::Arc;

use super::{RodModel, Structure, undamped_modes};
use machine::{Derivation, Machine, Operating};

/// Upper limit of the search for natural frequencies (Hz), far above the band of hammer tests.
const HIGHEST_HZ: f64 = 1e5;
/// Upper limit of the first search (Hz), far below [`HIGHEST_HZ`]: most machines need only their lowest
/// modes.
const FIRST_LIMIT_HZ: f64 = 100.0;
/// Factor on the upper limit from one search to the next (1).
const LIMIT_FACTOR: f64 = 10.0;
/// Frequency (Hz) above which a mode counts as elastic. Rigid-body modes have 0 Hz; elastic modes lie far
/// higher.
const ELASTIC_HZ: f64 = 1e-2;

/// Computes the derived quantities of a machine, in the order of [`Machine::derived`]; frequencies in Hz.
///
/// A frequency is `None` if it does not exist up to 100 kHz, or if the machine has no free point or no valid
/// model. A ratio of inertia is `None` if it is not finite.
pub fn derived(machine: &Machine, parameters: &[f64], operating: &Operating) -> Vec<Option<f64>> {
    machine
        .derived
        .iter()
        .map(|d| match d.from {
            Derivation::NaturalFrequency(mode_number) => {
                natural_frequency_hz(machine, mode_number, parameters, operating)
            }
            Derivation::Antiresonance(mode_number, point) => {
                // An antiresonance of a driving point is a natural frequency of the machine with that point
                // fixed.
                let mut clamped = machine.clone();
                clamped.points[point].fixed = true;
                natural_frequency_hz(&clamped, mode_number, parameters, operating)
            }
            Derivation::InertiaRatio(a, b) => {
                let inertia = |point: usize| machine.points[point].inertia.at(parameters, operating);
                Some(inertia(a) / inertia(b)).filter(|ratio| ratio.is_finite())
            }
            Derivation::Parameter(index) => Some(parameters[index]),
        })
        .collect()
}

/// Returns the undamped natural frequency (Hz) of the elastic mode `mode_number` (from 1).
fn natural_frequency_hz(
    machine: &Machine,
    mode_number: usize,
    parameters: &[f64],
    operating: &Operating,
) -> Option<f64> {
    elastic_frequencies_hz(machine, mode_number, parameters, operating).get(mode_number - 1).copied()
}

/// Returns the undamped natural frequencies (Hz) of the first `count` elastic modes, ascending.
///
/// Fewer are returned if fewer lie below 100 kHz, and none if the machine has no free point or no valid
/// model.
pub fn elastic_frequencies_hz(
    machine: &Machine,
    count: usize,
    parameters: &[f64],
    operating: &Operating,
) -> Vec<f64> {
    let Some(free_point) = machine.points.iter().position(|p| !p.fixed) else { return Vec::new() };
    let Ok(structure) = Structure::new(machine, free_point, free_point, RodModel::Exact) else {
        return Vec::new();
    };
    let structure = Arc::new(structure);
    let (mut model, mut work) = (structure.empty_model(), structure.workspace());
    model.update(machine, parameters, operating);
    let mut highest_hz = FIRST_LIMIT_HZ;
    loop {
        let modes = undamped_modes(&model, highest_hz, &mut work);
        let elastic: Vec<f64> =
            modes.iter().map(|m| m.frequency_hz).filter(|f| *f > ELASTIC_HZ).take(count).collect();
        if elastic.len() >= count || highest_hz >= HIGHEST_HZ {
            return elastic;
        }
        highest_hz *= LIMIT_FACTOR;
    }
}
