//! Tests of the servo axis: closed forms, energy, convergence, limits, missing effects, records.

mod drive;
mod missing;
mod plant;
mod record;

use super::friction::Friction;
use super::missing::Missing;
use super::nominal::{Axis, Nominal};
use super::run::run;
use super::sensor::{Record, Sensors};

/// The linear axis: no friction, no backlash, no missing effects.
fn linear() -> Axis {
    let nominal = Nominal { table_friction: Friction::none(), backlash_m: 0.0, ..Nominal::x() };
    Axis { nominal, missing: Missing::none() }
}

/// The axis with friction, backlash and the given missing effects only.
fn with(missing: Missing) -> Axis {
    Axis { nominal: Nominal::x(), missing }
}

/// A command at constant speed from zero, after a standstill of a tenth of a second.
fn ramp(speed_m_s: f64, duration_s: f64) -> Vec<f64> {
    (0..(duration_s * 1000.0) as usize).map(|k| speed_m_s * (k as f64 * 1e-3 - 0.1).max(0.0)).collect()
}

/// A run recorded by perfect sensors.
fn ideal_run(axis: &Axis, command_m: &[f64]) -> Record {
    run(axis, &Sensors::perfect(), command_m, 0).unwrap()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| a.max(b.abs()))
}

/// Returns the component at an angular frequency of equidistant values over whole periods: 2/n Σ v e^{−iωt},
/// real and imaginary part.
fn tone(values: &[f64], omega: f64, step: f64) -> (f64, f64) {
    let sum = values.iter().enumerate().fold((0.0, 0.0), |sum, (k, value)| {
        let (sin, cos) = (omega * step * k as f64).sin_cos();
        (sum.0 + value * cos, sum.1 - value * sin)
    });
    (2.0 * sum.0 / values.len() as f64, 2.0 * sum.1 / values.len() as f64)
}
