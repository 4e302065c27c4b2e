//! Inverse dynamics of a record: forces and the columns of the engineer's parameters, equally smoothed and
//! thinned.

use crate::motion::belief::Belief;
use crate::motion::phase::{Phase, phases};
use crate::motion::run::{Log, RECORD_S, Side};

/// Standard deviation of the Gaussian smoothing kernel, in samples.
const WIDTH: f64 = 4.0;

/// Half length of the kernel, in samples.
const REACH: usize = 18;

/// Distance of rows, in samples.
const THIN: usize = 8;

/// Speed below which the axis counts as at rest, over the largest speed of the record.
const STILL: f64 = 0.005;

/// A row of a record: value = Σ columns · parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Force that the parameters must explain, N.
    pub value: f64,
    /// Acceleration, speed, direction of motion, 1.
    pub columns: [f64; 4],
    /// Reference of the gap, N.
    pub scale: f64,
    /// Phase.
    pub phase: Phase,
    /// Whether the axis moves. At rest, static friction balances the force, and inverse dynamics does not
    /// apply.
    pub moves: bool,
}

/// Rows of all records, by record and kind.
pub type Blocks = Vec<Vec<Vec<Row>>>;

/// Returns the smoothing kernel and its first two derivatives over the samples.
fn kernels() -> [Vec<f64>; 3] {
    let at = |k: usize| k as f64 - REACH as f64;
    let kernel: Vec<f64> = (0..=2 * REACH).map(|k| (-0.5 * (at(k) / WIDTH).powi(2)).exp()).collect();
    let whole: f64 = kernel.iter().sum();
    let kernel: Vec<f64> = kernel.iter().map(|value| value / whole).collect();
    // Exact on a line and on a parabola, despite the truncated tails of the kernel.
    let slope: f64 = kernel.iter().enumerate().map(|(k, value)| value * at(k) * at(k)).sum();
    let first: Vec<f64> = kernel.iter().enumerate().map(|(k, value)| value * at(k) / slope).collect();
    let fourth: f64 =
        kernel.iter().enumerate().map(|(k, value)| value * at(k).powi(2) * (at(k).powi(2) - slope)).sum();
    let second: Vec<f64> =
        kernel.iter().enumerate().map(|(k, value)| 2.0 * value * (at(k).powi(2) - slope) / fourth).collect();
    [kernel, first, second]
}

/// Computes the rows of the recorded force. For a scale at the table it adds, where the loops are
/// proportional, rows of the force that the drive gives for the scale's reading: k_v (k_p (r − x) + f ṙ − ẋ),
/// with x transferred to the motor by the stiffness of the described nut.
pub fn rows(log: &Log, belief: &Belief) -> Vec<Vec<Row>> {
    let kernels = kernels();
    let count = log.command_m.len();
    let apply = |kernel: &[f64], values: &[f64], k: usize| -> f64 {
        kernel.iter().zip(&values[k - REACH..=k + REACH]).map(|(a, b)| a * b).sum()
    };
    let speeds: Vec<f64> = (0..count)
        .map(|k| {
            if k < REACH || k + REACH >= count {
                0.0
            } else {
                apply(&kernels[1], &log.position_m, k) / RECORD_S
            }
        })
        .collect();
    let still = STILL * speeds.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let directions: Vec<f64> =
        speeds.iter().map(|speed| if speed.abs() < still { 0.0 } else { speed.signum() }).collect();
    let phases = phases(&log.command_m, RECORD_S);
    let motor_kg = belief.motor_kg.unwrap_or(0.0);
    let compares_tracking = belief.side == Side::Table && belief.gives_encoder();
    let (mut force, mut tracking) = (Vec::new(), Vec::new());
    for k in (2 * REACH..count.saturating_sub(2 * REACH)).step_by(THIN) {
        let acceleration = apply(&kernels[2], &log.position_m, k) / (RECORD_S * RECORD_S);
        let speed = apply(&kernels[0], &speeds, k);
        let measured_n = apply(&kernels[0], &log.force_n, k);
        let columns = [acceleration, speed, apply(&kernels[0], &directions, k), 1.0];
        let value = measured_n - motor_kg * acceleration;
        let row = Row { value, columns, scale: measured_n, phase: phases[k], moves: directions[k] != 0.0 };
        force.push(row);
        if compares_tracking {
            let error = apply(&kernels[0], &log.command_m, k) - apply(&kernels[0], &log.position_m, k);
            let windup_m = (measured_n - motor_kg * acceleration) / belief.nut[0];
            let stiffness = belief.set.velocity_gain_n_s_m * belief.set.position_gain_1_s;
            let ahead = belief.set.feed_forward * apply(&kernels[1], &log.command_m, k) / RECORD_S;
            let value = stiffness * (error - windup_m) + belief.set.velocity_gain_n_s_m * (ahead - speed)
                - motor_kg * acceleration;
            tracking.push(Row { value, scale: stiffness * error, ..row });
        }
    }
    if compares_tracking { vec![force, tracking] } else { vec![force] }
}

impl Row {
    /// Returns the residual of a row in motion; `None` at rest.
    pub fn residual(&self, parameters: &[f64; 4]) -> Option<f64> {
        self.moves.then(|| self.value - self.columns.iter().zip(parameters).map(|(a, b)| a * b).sum::<f64>())
    }
}

/// Returns the references of the gap for the rows in motion.
pub fn scales(rows: &[Row]) -> impl Iterator<Item = f64> {
    rows.iter().filter(|row| row.moves).map(|row| row.scale)
}

/// Returns the root mean square.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
