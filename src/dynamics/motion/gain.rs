//! Effect of the position loop's gain: duration, accuracy and energy of a cycle.

use super::linear::LinearLoops;
use super::reference::Course;
use super::run::simulate;
use super::trace::Trace;
use super::{MotionError, SimulationSettings};
use machine::{Machine, Value};
use numeric::parallel::OrFirstError;

/// Results for one gain.
#[derive(Debug, Clone, PartialEq)]
pub struct GainRow {
    /// k_v (1/s).
    pub gain_per_s: f64,
    /// Time from the start of the travel to 99 % of it (s); `None` if it is not reached.
    pub time_s: Option<f64>,
    /// Mean |command − position| over the last fifth of the rest (m or rad).
    pub static_error: Option<f64>,
    /// Energy supplied while the drive drives (J).
    pub energy_j: Option<f64>,
    /// Cost C; `None` if the gain is unstable or the axis does not arrive.
    pub cost: Option<f64>,
    /// Whether the loops are stable, both linear and in the simulated motion; other figures are absent otherwise.
    pub stable: bool,
}

/// Share of the travel at which the axis has arrived.
const ARRIVED: f64 = 0.99;

/// Simulates a cycle with each gain of the position loop and computes its cost
///
/// ```text
/// C = e/e_max − (1 − E/E_max) − (1 − τ/τ_max),     −2 ≤ C ≤ 1
/// ```
///
/// Each term is relative to the largest value of the stable gains. Gains with an unstable pole are not simulated, since limits of current or
/// voltage would hide it. The command goes from its first value to its last; it rests for `rest_s` at its start and at its end. The position is
/// that of a point times `travel`, or the reading of the encoder.
///
/// # Units      gains 1/s, as a controller has them in 1/min divided by 60
/// # Source     lumped servo axis, Eq. 22, Fig. 11 and Tab. 1 (energy while the shaft is dragged is not counted)
/// # Errors     as [`simulate`]
pub fn gain_study(
    machine: &Machine,
    values: &[f64],
    gains_per_s: &[f64],
    (course, rest_s): (&Course, f64),
    point: Option<(usize, f64)>,
    settings: &SimulationSettings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<GainRow>, MotionError> {
    use rayon::prelude::*;
    let row = |gain_per_s: &f64| -> Result<GainRow, MotionError> {
        let mut machine = machine.clone();
        let drive = machine.drive.as_mut().ok_or(MotionError::NoDrive)?;
        drive.position.gain_per_s = Value::number(*gain_per_s);
        if LinearLoops::new(&machine, values, settings)?.unstable().is_some() {
            return Ok(GainRow { gain_per_s: *gain_per_s, time_s: None, static_error: None, energy_j: None, cost: None, stable: false });
        }
        let trace = simulate(&machine, values, course, settings, go_on)?;
        let at = point.and_then(|(p, travel)| Some((trace.points.iter().position(|n| *n == machine.points[p].name)?, travel)));
        Ok(of(*gain_per_s, &trace, course, rest_s, at))
    };
    let mut rows = gains_per_s.par_iter().map(row).or_first_error()?;
    let largest =
        |rows: &[GainRow], of: fn(&GainRow) -> Option<f64>| rows.iter().filter(|r| r.time_s.is_some()).filter_map(of).reduce(f64::max);
    let (e, energy, tau) = (largest(&rows, |r| r.static_error), largest(&rows, |r| r.energy_j), largest(&rows, |r| r.time_s));
    let share = |x: Option<f64>, largest: Option<f64>| Some(if largest? > 0.0 { x? / largest? } else { 0.0 });
    for row in &mut rows {
        let shares = (share(row.static_error, e), share(row.energy_j, energy), share(row.time_s, tau));
        if let (Some(error), Some(energy), Some(time)) = shares {
            row.cost = Some(error - (1.0 - energy) - (1.0 - time));
        }
    }
    Ok(rows)
}

fn of(gain_per_s: f64, trace: &Trace, course: &Course, rest_s: f64, point: Option<(usize, f64)>) -> GainRow {
    let (first, last) = (course.command[0], course.command[course.command.len() - 1]);
    let zero = point.map_or(0.0, |(at, travel)| trace.samples[0].points[at] * travel);
    let position = |s: &super::TraceSample| point.map_or(s.position, |(at, travel)| first + s.points[at] * travel - zero);
    let passed = trace.samples.iter().find(|s| (position(s) - first) / (last - first) >= ARRIVED);
    let from_s = course.duration_s() - 0.2 * rest_s;
    let resting: Vec<f64> = trace.samples.iter().filter(|s| s.time_s >= from_s).map(|s| (s.command - position(s)).abs()).collect();
    GainRow {
        gain_per_s,
        time_s: passed.map(|s| s.time_s - rest_s),
        static_error: (trace.complete && !resting.is_empty()).then(|| resting.iter().sum::<f64>() / resting.len() as f64),
        energy_j: trace.complete.then_some(trace.energy.driving_j),
        cost: None,
        stable: trace.complete,
    }
}
