//! Closed-loop simulation of a measured record.

use super::reference::Course;
use super::run::simulate;
use super::trace::Trace;
use super::{MotionError, SimulationSettings};
use machine::Machine;
use measurement::MotionRecord;
use numeric::statistics::root_mean_square;

/// Column of a record with the voltage that is added to the drive's input (V).
const ADDED: &str = "pulse_v";

/// Deviation of a simulated record from the measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordGap {
    /// rms(simulated − measured)/rms(measured) of force or torque.
    pub force: f64,
    /// The same ratio for the tracking error, command − position.
    pub tracking: f64,
}

impl Course {
    /// Returns the course of a record: its command, and the voltage in its column `pulse_v`, from the initial
    /// state of the record.
    ///
    /// The initial velocity is that of a parabola through the first eleven positions.
    pub fn of_record(record: &MotionRecord) -> Self {
        let first = &record.position_m[..record.position_m.len().min(11)];
        Course {
            step_s: record.step_s,
            command: record.command_m.clone(),
            added: record.others.get(ADDED).cloned().unwrap_or_default(),
            start_position: first.first().copied(),
            start_velocity: Some(slope_at_start(first) / record.step_s),
        }
    }
}

/// Returns the slope, per sample, of the least-squares parabola at the first sample.
fn slope_at_start(samples: &[f64]) -> f64 {
    let n = samples.len();
    if n < 3 {
        return if n == 2 { samples[1] - samples[0] } else { 0.0 };
    }
    let design = nalgebra::DMatrix::from_fn(n, 3, |i, j| (i as f64).powi(j as i32));
    let right = nalgebra::DVector::from_column_slice(samples);
    let normal = design.transpose() * &design;
    normal.lu().solve(&(design.transpose() * right)).map_or(0.0, |x| x[1])
}

/// Simulates a record in closed loop: its command, and the voltage added to the drive's input, through
/// machine and drive.
///
/// The samples are those of the record if the velocity loop's period is its step; [`RecordGap`] compares at
/// the record's times.
///
/// # Errors  as [`simulate`]; the velocity loop's period does not divide the record's step.
pub fn simulate_record(
    machine: &Machine,
    values: &[f64],
    record: &MotionRecord,
    settings: &SimulationSettings,
    go_on: &dyn Fn() -> bool,
) -> Result<(Trace, Option<RecordGap>), MotionError> {
    let drive = machine.drive.as_ref().ok_or(MotionError::NoDrive)?;
    let ratio = record.step_s / drive.velocity.period_s;
    if !(ratio > 1.0 - 1e-6 && (ratio - ratio.round()).abs() < 1e-6 * ratio) {
        return Err(MotionError::Input(format!(
            "record {}: its step of {} s is no multiple of the velocity loop's period of {} s; write a loop period that divides it",
            record.name, record.step_s, drive.velocity.period_s
        )));
    }
    let rms = |values: &mut dyn Iterator<Item = f64>| root_mean_square(values).unwrap_or(f64::NAN);
    let trace = simulate(machine, values, &Course::of_record(record), settings, go_on)?;
    let gap = trace.complete.then(|| {
        let every = ratio.round() as usize;
        let at = |i: usize| &trace.samples[i * every];
        let count = trace.samples.len().div_ceil(every).min(record.samples());
        let force = record.load.samples();
        let gap = |error: &dyn Fn(usize) -> f64, size: &dyn Fn(usize) -> f64| {
            rms(&mut (0..count).map(error)) / rms(&mut (0..count).map(size))
        };
        RecordGap {
            force: gap(&|i| at(i).force - force[i], &|i| force[i]),
            tracking: gap(&|i| record.position_m[i] - at(i).position, &|i| {
                record.command_m[i] - record.position_m[i]
            }),
        }
    });
    Ok((trace, gap))
}
