//! Measurement sets of simulated FRFs in memory.

use std::f64::consts::TAU;
use std::sync::Arc;

use dynamics::model::{RodModel, Structure};
use machine::{Machine, Operating};
use measurement::{Condition, Frf, FrfLine, FrfNoise, Gain, MeasurementSet, Position, Quantity};
use num_complex::Complex64;

use super::{Draws, POSITIONS};

/// Makes a set of receptances at the positions of the bench, with noise of relative standard deviation `sd`
/// (total, complex).
pub fn set_of(
    channels: &[(&str, &str)],
    lines: &[f64],
    sd: f64,
    random: &mut Draws,
    mut receptance: impl FnMut(usize, (&str, &str), f64) -> Complex64,
) -> MeasurementSet {
    let mut frfs = Vec::new();
    for (position, (name, _)) in POSITIONS.iter().enumerate() {
        for channel in channels {
            let lines = lines
                .iter()
                .map(|&frequency_hz| {
                    let noise = Complex64::new(random.normal(), random.normal()) * (sd / 2.0_f64.sqrt());
                    let value = receptance(position, *channel, TAU * frequency_hz) * noise.exp();
                    FrfLine { frequency_hz, value, noise: Some(FrfNoise::RelativeSd(sd)) }
                })
                .collect();
            frfs.push(Frf {
                position: Some(position),
                record: None,
                response: channel.0.into(),
                excitation: channel.1.into(),
                quantity: Quantity::Receptance,
                condition: Condition::default(),
                averages: None,
                source: format!("{name}-{}-{}", channel.0, channel.1),
                lines,
                rejected: Vec::new(),
            });
        }
    }
    MeasurementSet {
        path: "simulated".into(),
        title: "simulated".into(),
        quantity: Some(Quantity::Receptance),
        gain: Gain::Known(1.0),
        response: None,
        excitation: None,
        positions: POSITIONS
            .iter()
            .map(|(name, nut)| Position { name: (*name).into(), nut_m: Some(*nut) })
            .collect(),
        modes: None,
        frfs,
        motions: Vec::new(),
        split: None,
        tolerance: measurement::ChannelTolerance::default(),
        published: Default::default(),
        files: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Returns evenly spaced frequencies (Hz).
pub fn spread(from_hz: f64, to_hz: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| from_hz + (to_hz - from_hz) * i as f64 / (count - 1) as f64).collect()
}

/// Makes FRFs of the model under test at given parameters.
pub fn own_set(
    machine: &Machine,
    values: &[f64],
    lines: &[f64],
    sd: f64,
    random: &mut Draws,
) -> MeasurementSet {
    let table = machine.point("table").unwrap();
    let structure = Arc::new(Structure::new(machine, table, table, RodModel::Exact).unwrap());
    let mut work = structure.workspace();
    set_of(&[("table", "table")], lines, sd, random, |position, _, omega| {
        let mut network = structure.empty_model();
        network.update(machine, values, &Operating::at_nut(POSITIONS[position].1));
        network.receptance(omega, &mut work)
    })
}
