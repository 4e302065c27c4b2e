//! Quantities derived from a machine's parameters through its model.

use std::sync::Arc;

use super::{RodModel, Structure, undamped_modes};
use machine::{Derivation, Machine, Operating};

/// Upper limit of the search for natural frequencies (Hz).
const HIGHEST_HZ: f64 = 1e5;
/// Limit (Hz) above which a natural frequency is elastic; below it a mode is a rigid-body mode.
const ELASTIC_HZ: f64 = 1e-2;

/// Computes the derived quantities of a machine, in its order; `None` where the frequency does not exist below 100 kHz.
pub fn derived(machine: &Machine, parameters: &[f64], operating: &Operating) -> Vec<Option<f64>> {
    machine
        .derived
        .iter()
        .map(|d| match d.from {
            Derivation::NaturalFrequency(order) => natural_frequency_hz(machine, order, parameters, operating),
            Derivation::Antiresonance(order, point) => {
                let mut held = machine.clone();
                held.points[point].fixed = true;
                natural_frequency_hz(&held, order, parameters, operating)
            }
            Derivation::InertiaRatio(a, b) => {
                let inertia = |point: usize| machine.points[point].inertia.at(parameters, operating);
                Some(inertia(a) / inertia(b)).filter(|ratio| ratio.is_finite())
            }
            Derivation::Parameter(index) => Some(parameters[index]),
        })
        .collect()
}

/// Returns the n-th (from 1) undamped natural frequency above 0 (Hz).
fn natural_frequency_hz(machine: &Machine, order: usize, parameters: &[f64], operating: &Operating) -> Option<f64> {
    elastic_frequencies_hz(machine, order, parameters, operating).get(order - 1).copied()
}

/// Returns the first `count` undamped natural frequencies above 0 (Hz), or fewer where fewer lie below 100 kHz.
pub fn elastic_frequencies_hz(machine: &Machine, count: usize, parameters: &[f64], operating: &Operating) -> Vec<f64> {
    let Some(moving) = machine.points.iter().position(|p| !p.fixed) else { return Vec::new() };
    let Ok(structure) = Structure::new(machine, moving, moving, RodModel::Exact) else { return Vec::new() };
    let structure = Arc::new(structure);
    let (mut model, mut work) = (structure.empty_model(), structure.workspace());
    model.update(machine, parameters, operating);
    let mut highest_hz = 100.0;
    loop {
        let modes = undamped_modes(&model, highest_hz, &mut work);
        let elastic: Vec<f64> = modes.iter().map(|m| m.frequency_hz).filter(|f| *f > ELASTIC_HZ).take(count).collect();
        if elastic.len() >= count || highest_hz >= HIGHEST_HZ {
            return elastic;
        }
        highest_hz *= 10.0;
    }
}
