//! The response of a simulated axis to a sine.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::linear::LinearLoops;
use super::reference::Course;
use super::run::simulate;
use super::{MotionError, SimulationSettings};
use machine::Machine;

/// Least periods, and least time (s), over which a response is taken.
const LEAST: (f64, f64) = (5.0, 0.1);
/// What is left of a transient when the response is taken, and the longest wait for that (s).
const SETTLED: (f64, f64) = (1e-7, 5.0);

/// What a sine of the command becomes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineResponse {
    /// Frequency (Hz), of which whole periods fit into whole periods of the position loop.
    pub frequency_hz: f64,
    /// Output over command at that frequency; `None` where the motion was ended early or left its bounds.
    pub ratio: Option<Complex<f64>>,
}

/// The nearest frequency of which whole periods fit into whole periods of the position loop: it, and how many of the latter.
fn fitting_hz(frequency_hz: f64, position_s: f64) -> (f64, usize) {
    let periods = LEAST.0.max((frequency_hz * LEAST.1).ceil());
    let samples = (periods / (frequency_hz * position_s)).round().max(1.0);
    (periods / (samples * position_s), samples as usize)
}

/// The response of what the position encoder reads, or of a point, to a sine of the command, by simulation: the share at its frequency, of the samples
/// of the velocity loop over whole periods, when what came before has died away.
///
/// # Units      Hz; amplitude in what the encoder reads (m or rad)
/// # Limits     without friction, play and rounding it is [`LinearLoops::response`]
/// # Errors     as [`simulate`]
pub fn sine_response(
    machine: &Machine,
    values: &[f64],
    loops: &LinearLoops,
    (frequency_hz, amplitude): (f64, f64),
    point: Option<&str>,
    settings: &SimulationSettings,
    go_on: &dyn Fn() -> bool,
) -> Result<SineResponse, MotionError> {
    let (frequency_hz, samples) = fitting_hz(frequency_hz, loops.period_s);
    let slowest = loops.poles().iter().map(|p| -p.growth_per_s).fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE);
    let wait = ((-SETTLED.0.ln() / slowest).min(SETTLED.1) / loops.period_s).ceil() as usize;
    let command = (0..=wait + samples).map(|k| amplitude * (TAU * frequency_hz * loops.period_s * k as f64).sin()).collect();
    let trace = simulate(machine, values, &Course::new(loops.period_s, command), settings, go_on)?;
    if !trace.complete {
        return Ok(SineResponse { frequency_hz, ratio: None });
    }
    let at = point.and_then(|name| trace.points.iter().position(|p| p == name));
    if let (Some(name), None) = (point, at) {
        return Err(MotionError::Input(format!("point «{name}» has no inertia or no motion; name another")));
    }
    let each = (trace.samples.len() - 1) / (wait + samples);
    let last = &trace.samples[wait * each..(wait + samples) * each];
    // About their mean, so that what does not move does not count where rounding leaves a trace of it.
    let output = |s: &super::TraceSample| at.map_or(s.position, |at| s.points[at]);
    let mean = last.iter().map(output).sum::<f64>() / last.len() as f64;
    let sum: Complex<f64> = last.iter().map(|s| Complex::from_polar(output(s) - mean, -TAU * frequency_hz * s.time_s)).sum();
    // A sine is (e^{iωt} − e^{−iωt})/2i.
    let ratio = sum * Complex::new(0.0, 2.0) / (amplitude * last.len() as f64);
    Ok(SineResponse { frequency_hz, ratio: Some(ratio) })
}
