//! What the gain of the position loop does: promptness, precision and energy of a cycle.

use super::reference::Course;
use super::run::simulate;
use super::trace::Trace;
use super::{MotionError, Settings};
use crate::machine::{Machine, Value};

/// What a gain gives.
#[derive(Debug, Clone, PartialEq)]
pub struct GainRow {
    /// k_v (1/s).
    pub gain_per_s: f64,
    /// From the beginning of the travel to 99 % of it (s); `None` where it is not reached.
    pub time_s: Option<f64>,
    /// Mean |command − position| over the last fifth of the rest (m or rad).
    pub static_error: f64,
    /// What the drive puts in while it drives (J).
    pub energy_j: f64,
    /// C; `None` where a gain is unstable or does not arrive.
    pub cost: Option<f64>,
    /// Whether the loop kept its bounds.
    pub stable: bool,
}

/// Share of the travel at which it has arrived.
const ARRIVED: f64 = 0.99;

/// Cycles with each gain of the position loop, and their cost
///
/// ```text
/// C = e/e_max − (1 − E/E_max) − (1 − τ/τ_max),     −2 ≤ C ≤ 1
/// ```
///
/// each relative to the largest of the stable gains. The command goes from its first value to its last; `rest_s` of it are rest at its end and at its
/// beginning. The position is that of a point times `travel`, or what the encoder reads.
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
    settings: &Settings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<GainRow>, MotionError> {
    use rayon::prelude::*;
    let row = |gain_per_s: &f64| {
        let mut machine = machine.clone();
        let drive = machine.drive.as_mut().ok_or(MotionError::NoDrive)?;
        drive.position.gain_per_s = Value::number(*gain_per_s);
        let trace = simulate(&machine, values, course, settings, go_on)?;
        let at = point.and_then(|(p, travel)| Some((trace.points.iter().position(|n| *n == machine.points[p].name)?, travel)));
        Ok(of(*gain_per_s, &trace, course, rest_s, at))
    };
    let mut rows = gains_per_s.par_iter().map(row).collect::<Result<Vec<_>, MotionError>>()?;
    let arrived = |rows: &[GainRow], of: &dyn Fn(&GainRow) -> f64| {
        rows.iter().filter(|r| r.stable && r.time_s.is_some()).map(of).fold(0.0_f64, f64::max)
    };
    let (e, energy, tau) =
        (arrived(&rows, &|r| r.static_error), arrived(&rows, &|r| r.energy_j), arrived(&rows, &|r| r.time_s.unwrap_or(0.0)));
    for row in rows.iter_mut().filter(|r| r.stable) {
        let share = |x: f64, largest: f64| if largest > 0.0 { x / largest } else { 0.0 };
        row.cost = row.time_s.map(|t| share(row.static_error, e) - (1.0 - share(row.energy_j, energy)) - (1.0 - share(t, tau)));
    }
    Ok(rows)
}

fn of(gain_per_s: f64, trace: &Trace, course: &Course, rest_s: f64, point: Option<(usize, f64)>) -> GainRow {
    let (first, last) = (course.command[0], course.command[course.command.len() - 1]);
    let zero = point.map_or(0.0, |(at, travel)| trace.samples[0].points[at] * travel);
    let position = |s: &super::Sample| point.map_or(s.position, |(at, travel)| first + s.points[at] * travel - zero);
    let passed = trace.samples.iter().find(|s| (position(s) - first) / (last - first) >= ARRIVED);
    let from_s = course.duration_s() - 0.2 * rest_s;
    let resting: Vec<f64> = trace.samples.iter().filter(|s| s.time_s >= from_s).map(|s| (s.command - position(s)).abs()).collect();
    GainRow {
        gain_per_s,
        time_s: passed.map(|s| s.time_s - rest_s),
        static_error: resting.iter().sum::<f64>() / resting.len().max(1) as f64,
        energy_j: trace.energy.driving_j,
        cost: None,
        stable: trace.complete,
    }
}
