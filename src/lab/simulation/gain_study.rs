//! Effect of the position loop's gain: duration, accuracy and energy of a cycle.

use rayon::prelude::*;

use dynamics::motion::{Course, LinearLoops, MotionError, SimulationSettings, Trace, TraceSample, simulate};
use machine::{Machine, Value};
use numeric::parallel::OrFirstError;
use report::loops::GainStudyRow;

/// A cycle of which the figures are evaluated.
#[derive(Debug, Clone, Copy)]
pub struct GainCycle<'a> {
    /// Command from its first value to its last.
    pub course: &'a Course,
    /// Rest (s) at the start and at the end of the command.
    pub rest_s: f64,
    /// Point (index) whose position is evaluated, and the travel per unit of its motion; the reading of the
    /// encoder where absent.
    pub point: Option<(usize, f64)>,
}

/// Share of the travel at which the axis has arrived.
const ARRIVED: f64 = 0.99;
/// Share of the rest over which the static error is evaluated.
const RESTING: f64 = 0.2;
/// Change of the reading, relative to the static error, that is rest for an encoder without steps.
const REST: f64 = 1e-3;

/// Simulates a cycle with each gain of the position loop and computes its cost
///
/// ```text
/// C = e/e_max − (1 − E/E_max) − (1 − τ/τ_max),     −2 ≤ C ≤ 1
/// ```
///
/// Each term is relative to the largest value of the gains that come to rest, so that the optimum depends on
/// the range of gains. Gains with an unstable pole are not simulated, since limits of current or voltage
/// would hide it.
///
/// # Units      gains 1/s, as a controller has them in 1/min divided by 60
/// # Source     lumped servo axis, Eq. 22, Fig. 11 and Tab. 1 (energy while the shaft is dragged is not
///   counted)
/// # Errors     as [`simulate`]
pub fn gain_study(
    machine: &Machine,
    values: &[f64],
    gains_per_s: &[f64],
    cycle: &GainCycle<'_>,
    settings: &SimulationSettings,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<GainStudyRow>, MotionError> {
    let row = |gain_per_s: &f64| -> Result<GainStudyRow, MotionError> {
        let mut machine = machine.clone();
        let drive = machine.drive.as_mut().ok_or(MotionError::NoDrive)?;
        drive.position.gain_per_s = Value::number(*gain_per_s);
        let rest = Rest {
            step: drive.position.encoder.step.at(values, &settings.operating),
            integrates: drive.velocity.integral_time_s.at(values, &settings.operating).is_finite(),
        };
        let none = GainStudyRow {
            gain_per_s: *gain_per_s,
            gain_per_min: 60.0 * gain_per_s,
            time_s: None,
            static_error: None,
            energy_j: None,
            cost: None,
            settled: false,
        };
        if LinearLoops::new(&machine, values, settings)?.unstable().is_some() {
            return Ok(none);
        }
        let trace = simulate(&machine, values, cycle.course, settings, go_on)?;
        let at = cycle.point.and_then(|(p, travel)| {
            Some((trace.points.iter().position(|n| *n == machine.points[p].name)?, travel))
        });
        Ok(of(none, &trace, cycle, at, rest))
    };
    let mut rows = gains_per_s.par_iter().map(row).or_first_error()?;
    let counts = |r: &&GainStudyRow| r.time_s.is_some() && r.settled;
    let largest = |rows: &[GainStudyRow], of: fn(&GainStudyRow) -> Option<f64>| {
        rows.iter().filter(counts).filter_map(of).reduce(f64::max)
    };
    let (e, energy, tau) =
        (largest(&rows, |r| r.static_error), largest(&rows, |r| r.energy_j), largest(&rows, |r| r.time_s));
    let share = |x: Option<f64>, largest: Option<f64>| Some(if largest? > 0.0 { x? / largest? } else { 0.0 });
    for row in rows.iter_mut().filter(|row| row.settled) {
        let shares = (share(row.static_error, e), share(row.energy_j, energy), share(row.time_s, tau));
        if let (Some(error), Some(energy), Some(time)) = shares {
            row.cost = Some(error - (1.0 - energy) - (1.0 - time));
        }
    }
    Ok(rows)
}

/// What rest means for a drive.
#[derive(Clone, Copy)]
struct Rest {
    /// Step of the position encoder.
    step: f64,
    /// Whether the velocity loop integrates.
    integrates: bool,
}

impl Rest {
    /// Whether the samples of (command, reading) are at rest.
    fn holds(self, samples: &[(f64, f64)]) -> bool {
        let off = |(command, reading): &(f64, f64)| command - reading;
        let (low, high) = samples
            .iter()
            .map(off)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        // A reading has rounding errors of its own.
        let tolerance =
            if self.step > 0.0 { self.step * (1.0 + 1e-6) } else { REST * low.abs().max(high.abs()) };
        let constant = high - low <= tolerance;
        let equal = self.step == 0.0 || low.abs().max(high.abs()) <= tolerance;
        !samples.is_empty() && constant && (equal || !self.integrates)
    }
}

fn of(
    none: GainStudyRow,
    trace: &Trace,
    cycle: &GainCycle<'_>,
    point: Option<(usize, f64)>,
    rest: Rest,
) -> GainStudyRow {
    let course = cycle.course;
    let (first, last) = (course.command[0], course.command[course.command.len() - 1]);
    let zero = point.map_or(0.0, |(at, travel)| trace.samples[0].points[at] * travel);
    let position =
        |s: &TraceSample| point.map_or(s.position, |(at, travel)| first + s.points[at] * travel - zero);
    let passed = trace.samples.iter().find(|s| (position(s) - first) / (last - first) >= ARRIVED);
    let from_s = course.duration_s() - RESTING * cycle.rest_s;
    let resting = || trace.samples.iter().filter(|s| s.time_s >= from_s);
    let errors: Vec<f64> = resting().map(|s| (s.command - position(s)).abs()).collect();
    let settled =
        trace.complete && rest.holds(&resting().map(|s| (s.command, s.position)).collect::<Vec<_>>());
    GainStudyRow {
        time_s: passed.map(|s| s.time_s - cycle.rest_s),
        static_error: settled.then(|| errors.iter().sum::<f64>() / errors.len() as f64),
        energy_j: trace.complete.then_some(trace.energy.driving_j),
        settled,
        ..none
    }
}
