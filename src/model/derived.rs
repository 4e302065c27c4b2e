//! Quantities that follow from a machine's parameters by its models.

use std::sync::Arc;

use super::{Rods, Structure, undamped_modes};
use crate::machine::{Derivation, Machine, Operating};

/// Highest frequency that is looked at for a natural frequency (Hz).
const HIGHEST_HZ: f64 = 1e5;
/// Lowest frequency that is not a rigid body's (Hz).
const ELASTIC_HZ: f64 = 1e-2;

/// The quantities a machine reports, in its order; `None` where there is no such frequency below 100 kHz.
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

/// The n-th (from 1) undamped natural frequency above 0 (Hz).
fn natural_frequency_hz(machine: &Machine, order: usize, parameters: &[f64], operating: &Operating) -> Option<f64> {
    let moving = machine.points.iter().position(|p| !p.fixed)?;
    let structure = Arc::new(Structure::new(machine, moving, moving, Rods::Exact).ok()?);
    let (mut network, mut work) = (structure.network(), structure.workspace());
    network.update(machine, parameters, operating);
    let mut highest_hz = 100.0;
    loop {
        let modes = undamped_modes(&network, highest_hz, &mut work);
        let mut elastic = modes.iter().filter(|m| m.frequency_hz > ELASTIC_HZ);
        if let Some(mode) = elastic.nth(order - 1) {
            return Some(mode.frequency_hz);
        }
        if highest_hz >= HIGHEST_HZ {
            return None;
        }
        highest_hz *= 10.0;
    }
}
