//! Inverse dynamics of a record: forces and the columns of the engineer's parameters, smoothed alike and thinned.

use crate::motion::belief::Belief;
use crate::motion::phase::{Phase, phases};
use crate::motion::run::{Log, RECORD_S, Side};

/// Width of the bell that smooths, in samples.
const WIDTH: f64 = 4.0;

/// Samples to either side that it reaches.
const REACH: usize = 18;

/// Samples from row to row.
const THIN: usize = 8;

/// Speed over the record's largest below which the axis counts as still.
const STILL: f64 = 0.005;

/// Rows of one kind of one record: value = Σ columns · parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Force left for the parameters, N.
    pub values: Vec<f64>,
    /// Acceleration, speed, direction, 1.
    pub columns: Vec<[f64; 4]>,
    /// What the gap is relative to, N.
    pub scale: Vec<f64>,
    /// Phase of each.
    pub phases: Vec<Phase>,
    /// Whether the axis moves: at rest the force is what friction holds, and no inverse dynamics knows it.
    pub moves: Vec<bool>,
}

/// Bell and its first two derivatives over the samples.
fn bells() -> [Vec<f64>; 3] {
    let at = |k: usize| k as f64 - REACH as f64;
    let bell: Vec<f64> = (0..=2 * REACH).map(|k| (-0.5 * (at(k) / WIDTH).powi(2)).exp()).collect();
    let whole: f64 = bell.iter().sum();
    let bell: Vec<f64> = bell.iter().map(|value| value / whole).collect();
    // Exact on a line and on a parabola, whatever the bell's tails leave.
    let slope: f64 = bell.iter().enumerate().map(|(k, value)| value * at(k) * at(k)).sum();
    let first: Vec<f64> = bell.iter().enumerate().map(|(k, value)| value * at(k) / slope).collect();
    let fourth: f64 = bell.iter().enumerate().map(|(k, value)| value * at(k).powi(2) * (at(k).powi(2) - slope)).sum();
    let second: Vec<f64> = bell.iter().enumerate().map(|(k, value)| 2.0 * value * (at(k).powi(2) - slope) / fourth).collect();
    [bell, first, second]
}

/// Rows of the recorded force, and for a scale at the table those of the force that the drive gives for what the scale reads:
/// k_v (k_p (r − x) − ẋ), with x carried to the motor by the described nut.
pub fn rows(log: &Log, belief: &Belief) -> Vec<Rows> {
    let bells = bells();
    let count = log.command_m.len();
    let apply =
        |bell: &[f64], values: &[f64], k: usize| -> f64 { bell.iter().zip(&values[k - REACH..=k + REACH]).map(|(a, b)| a * b).sum() };
    let speeds: Vec<f64> =
        (0..count).map(|k| if k < REACH || k + REACH >= count { 0.0 } else { apply(&bells[1], &log.position_m, k) / RECORD_S }).collect();
    let still = STILL * speeds.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let directions: Vec<f64> = speeds.iter().map(|speed| if speed.abs() < still { 0.0 } else { speed.signum() }).collect();
    let phases = phases(&log.command_m, RECORD_S);
    let motor_kg = belief.motor_kg.unwrap_or(0.0);
    let (mut force, mut follow) = (Rows::default(), Rows::default());
    for k in (2 * REACH..count.saturating_sub(2 * REACH)).step_by(THIN) {
        let acceleration = apply(&bells[2], &log.position_m, k) / (RECORD_S * RECORD_S);
        let speed = apply(&bells[0], &speeds, k);
        let acts = apply(&bells[0], &log.force_n, k);
        let columns = [acceleration, speed, apply(&bells[0], &directions, k), 1.0];
        force.values.push(acts - motor_kg * acceleration);
        force.scale.push(acts);
        force.columns.push(columns);
        force.phases.push(phases[k]);
        force.moves.push(directions[k] != 0.0);
        if belief.side == Side::Table {
            let error = apply(&bells[0], &log.command_m, k) - apply(&bells[0], &log.position_m, k);
            let wound = (acts - motor_kg * acceleration) / belief.nut[0];
            let stiffness = belief.velocity_gain_n_s_m * belief.position_gain_1_s;
            follow.values.push(stiffness * (error - wound) - belief.velocity_gain_n_s_m * speed - motor_kg * acceleration);
            follow.scale.push(stiffness * error);
            follow.columns.push(columns);
            follow.phases.push(phases[k]);
            follow.moves.push(directions[k] != 0.0);
        }
    }
    if belief.side == Side::Table { vec![force, follow] } else { vec![force] }
}

impl Rows {
    /// What parameters leave of the values, of rows in motion.
    pub fn residual(&self, parameters: &[f64; 4]) -> Vec<Option<f64>> {
        let of = |(value, columns): (&f64, &[f64; 4])| value - columns.iter().zip(parameters).map(|(a, b)| a * b).sum::<f64>();
        self.values.iter().zip(&self.columns).map(of).zip(&self.moves).map(|(value, moves)| moves.then_some(value)).collect()
    }

    /// What the gap is relative to, of rows in motion.
    pub fn scales(&self) -> impl Iterator<Item = f64> {
        self.scale.iter().zip(&self.moves).filter(|(_, moves)| **moves).map(|(value, _)| *value)
    }
}

/// Root of the mean square.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
