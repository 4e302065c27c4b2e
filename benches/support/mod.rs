//! Simulated measurement sets for the benches, from a machine with known parameters.

use std::sync::Arc;

use dynamics::model::{RodModel, Structure};
use machine::{Machine, Operating};
use measurement::{Condition, Frf, FrfLine, FrfNoise, Gain, MeasurementSet, Position, Quantity};
use numeric::unit::omega_rad_s;

/// Computes receptances of a machine at its start values, one FRF per nut position; `None` for a machine
/// without a nut.
///
/// They are free of noise, but state a relative standard deviation of 2 %.
pub fn simulated_frfs(
    machine: &Machine,
    channel: (&str, &str),
    nuts_m: &[Option<f64>],
    frequencies_hz: &[f64],
) -> MeasurementSet {
    let index = |name| machine.point(name).expect("the machine has the point");
    let structure = Arc::new(
        Structure::new(machine, index(channel.0), index(channel.1), RodModel::Exact)
            .expect("the points can move"),
    );
    let (mut network, mut work) = (structure.empty_model(), structure.workspace());
    let mut set = MeasurementSet::none();
    set.gain = Gain::Known(1.0);
    for (position, &nut_m) in nuts_m.iter().enumerate() {
        network.update(machine, &machine.start(), &Operating::at(nut_m));
        let lines = frequencies_hz
            .iter()
            .map(|&frequency_hz| {
                let value = network.receptance(omega_rad_s(frequency_hz), &mut work);
                FrfLine { frequency_hz, value, noise: Some(FrfNoise::RelativeSd(0.02)) }
            })
            .collect();
        set.positions.push(Position { name: format!("p{position}"), nut_m });
        set.frfs.push(Frf {
            position: Some(position),
            record: None,
            response: channel.0.into(),
            excitation: channel.1.into(),
            quantity: Quantity::Receptance,
            condition: Condition::default(),
            averages: None,
            source: "bench".into(),
            lines,
            rejected: Vec::new(),
        });
    }
    set
}
