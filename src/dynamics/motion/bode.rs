//! Response of a simulated axis to a sine.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::linear::LinearLoops;
use super::reference::Course;
use super::run::simulate;
use super::trace::{EventKind, Trace};
use super::{MotionError, SimulationSettings};
use machine::{Joint, Machine, Value};

/// Smallest number of periods, and shortest time (s), over which a response is evaluated.
const MIN_DURATION: (f64, f64) = (5.0, 0.1);
/// Remaining share of the transient when the evaluation starts, and the longest wait for it (s).
const SETTLING: (f64, f64) = (1e-7, 5.0);

/// Response to a sinusoidal command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineResponse {
    /// Frequency (Hz), chosen so that a whole number of its periods fits into whole periods of the position
    /// loop.
    pub frequency_hz: f64,
    /// Output over command at that frequency; `None` if the motion was stopped early or left its bounds.
    pub ratio: Option<Complex<f64>>,
    /// Largest share of the evaluated time (1) in which the friction of a joint sticks, and the joint
    /// (index); `None` where none sticks. Elastic friction before sliding does not stick.
    pub stuck: Option<(usize, f64)>,
}

/// Returns the joint whose friction sticks longest between two times (s), and its share of the time. A
/// machine starts at rest, where frictions stick.
fn longest_stuck(
    machine: &Machine,
    values: &[f64],
    trace: &Trace,
    settings: &SimulationSettings,
    (from_s, to_s): (f64, f64),
) -> Option<(usize, f64)> {
    let at = |value: &Value| value.at(values, &settings.operating);
    let sticks = |joint: &Joint| {
        let friction = &joint.friction;
        at(&friction.coulomb) + at(&friction.stribeck) + friction.table.level(0.0) > 0.0
            && at(&friction.presliding_stiffness) == 0.0
    };
    let share = |joint: &Joint| {
        let (mut since_s, mut stuck, mut time_s) = (0.0, true, 0.0);
        let inside = |a: f64, b: f64| (b.min(to_s) - a.max(from_s)).max(0.0);
        for event in trace.events.iter().filter(|e| e.joint == joint.name) {
            time_s += if stuck { inside(since_s, event.time_s) } else { 0.0 };
            (since_s, stuck) = (event.time_s, event.kind == EventKind::Sticks);
        }
        (time_s + if stuck { inside(since_s, to_s) } else { 0.0 }) / (to_s - from_s)
    };
    let shares = machine
        .joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| sticks(joint))
        .map(|(index, joint)| (index, share(joint)));
    shares.filter(|(_, share)| *share > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the nearest frequency whose periods fit into whole periods of the position loop, and the number of
/// the latter.
fn fitting_hz(frequency_hz: f64, position_s: f64) -> (f64, usize) {
    let periods = MIN_DURATION.0.max((frequency_hz * MIN_DURATION.1).ceil());
    let samples = (periods / (frequency_hz * position_s)).round().max(1.0);
    (periods / (samples * position_s), samples as usize)
}

/// Simulates the response of the position encoder's reading, or of a point, to a sinusoidal command. The
/// result is the Fourier coefficient at its frequency, over the samples of the velocity loop in whole
/// periods, after the transient has decayed.
///
/// # Units      Hz; amplitude in units of the encoder (m or rad)
/// # Limits     without friction, backlash and rounding it is [`LinearLoops::response`]
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
    let slowest =
        loops.poles().iter().map(|p| -p.growth_per_s).fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE);
    let wait = ((-SETTLING.0.ln() / slowest).min(SETTLING.1) / loops.period_s).ceil() as usize;
    let command = (0..=wait + samples)
        .map(|k| amplitude * (TAU * frequency_hz * loops.period_s * k as f64).sin())
        .collect();
    let trace = simulate(machine, values, &Course::new(loops.period_s, command), settings, go_on)?;
    if !trace.complete {
        return Ok(SineResponse { frequency_hz, ratio: None, stuck: None });
    }
    let at = point.and_then(|name| trace.points.iter().position(|p| p == name));
    if let (Some(name), None) = (point, at) {
        return Err(MotionError::Input(format!("point «{name}» has no inertia or no motion; name another")));
    }
    let each = (trace.samples.len() - 1) / (wait + samples);
    let settled = &trace.samples[wait * each..(wait + samples) * each];
    // Without the mean, so that the rounding of an output at rest does not contribute.
    let output = |s: &super::TraceSample| at.map_or(s.position, |at| s.points[at]);
    let mean = settled.iter().map(output).sum::<f64>() / settled.len() as f64;
    let sum: Complex<f64> =
        settled.iter().map(|s| Complex::from_polar(output(s) - mean, -TAU * frequency_hz * s.time_s)).sum();
    // A sine is (e^{iωt} − e^{−iωt})/2i.
    let ratio = sum * Complex::new(0.0, 2.0) / (amplitude * settled.len() as f64);
    let times_s = (wait as f64 * loops.period_s, (wait + samples) as f64 * loops.period_s);
    Ok(SineResponse {
        frequency_hz,
        ratio: Some(ratio),
        stuck: longest_stuck(machine, values, &trace, settings, times_s),
    })
}
