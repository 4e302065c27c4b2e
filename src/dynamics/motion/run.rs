//! Simulation of a whole motion.

use std::collections::VecDeque;

use super::control::{ControlLoops, ControllerOutput};
use super::force_element::Input;
use super::inverter::{LEVELS, pulses};
use super::plant::Plant;
use super::reference::Course;
use super::runner::Runner;
use super::step::Stepper;
use super::trace::{Energy, Trace, TraceSample};
use super::{MotionError, SimulationSettings};
use machine::Machine;
use numeric::statistics::extremes;

/// Largest number of samples of the velocity loop in a motion: ten minutes at 8 kHz.
const MOST_SAMPLES: usize = 5_000_000;
/// Largest number of steps in a period of the innermost loop.
const MOST_PARTS: f64 = 1e6;
/// Largest number of steps at which the drive holds its input, in a motion.
const MOST_HOLDS: usize = 50_000_000;

/// Fault of steps or of a delay that do not suit a switching inverter.
const UNSWITCHED: &str = "a switching inverter has its own steps and needs a delay of whole periods of the current loop; \
     leave out the step, or write inverter = \"averaged\"";

/// Simulates a driven machine on a course. `go_on` is called at intervals; when it returns false, the motion
/// stops incomplete.
///
/// The machine starts at rest, or at the initial rate of the course. Its springs are strained as little as
/// the encoder's reading allows.
///
/// # Units      parameters in the machine's order and units; see [`Course`] and [`TraceSample`]
/// # Limits     without friction and backlash the samples are those of the matrix exponential (test
///   `limit_a_linear_machine…`)
/// # Errors     no drive; a step that does not divide the loops' period; a command beyond the stroke; an
///   element at a point without inertia;
///   events without end. A loop that leaves its bounds is no error: see [`Trace::unstable`].
pub fn simulate(
    machine: &Machine,
    values: &[f64],
    course: &Course,
    settings: &SimulationSettings,
    go_on: &dyn Fn() -> bool,
) -> Result<Trace, MotionError> {
    let drive = machine.drive.as_ref().ok_or(MotionError::NoDrive)?;
    let plant = Plant::new(machine, values, settings)?;
    check_stroke(machine, course, settings)?;
    let (points, warnings) = (plant.points.clone(), plant.warnings.clone());
    let y = start(&plant, course)?;
    let mut loops = ControlLoops::new(
        drive,
        &plant,
        values,
        &settings.operating,
        course.start_velocity.unwrap_or(0.0),
        &y,
    );
    let parts = parts(settings, loops.period_s)?;
    let step_s = loops.period_s / parts as f64;
    // The output of the drive is delayed by whole periods and a remainder, which ends within one of the
    // steps.
    let delay = periods(loops.delay_s, loops.period_s);
    let (whole_periods, remainder) = (delay.floor() as usize, delay.fract() * parts as f64);
    let (split_part, remainder) = (remainder.floor() as usize, remainder.fract());
    let mut units = vec![step_s];
    if remainder > 1e-9 {
        units.extend([remainder * step_s, (1.0 - remainder) * step_s]);
    }
    let has_rest = units.len() == 3;
    if loops.switching_v.is_some() && (parts > 1 || delay.fract() > 1e-9) {
        return Err(MotionError::Input(UNSWITCHED.into()));
    }
    let mut runner = Runner::new(Stepper::new(plant, units), y, settings.tolerance, go_on);
    let bound = settings.bound.unwrap_or_else(|| bound(course));
    let periods = (course.duration_s() / (loops.period_s * loops.to_velocity as f64) + 1e-6) as usize;
    check_extent(course, periods, periods.saturating_mul(loops.to_velocity), parts, step_s)?;
    let (size, driven) = (runner.stepper.plant.size, runner.stepper.plant.drive);
    let mut trace = Trace {
        points: points.iter().map(|(p, _)| machine.points[*p].name.clone()).collect(),
        samples: Vec::with_capacity(periods + 1),
        events: Vec::new(),
        energy: Energy::default(),
        unstable: None,
        complete: true,
        warnings,
    };
    // Inputs, newest first.
    let mut inputs: VecDeque<Input> = VecDeque::with_capacity(whole_periods + 3);
    for tick in 0..=periods * loops.to_velocity {
        let time_s = tick as f64 * loops.period_s;
        if let Some(ControllerOutput { command, position, velocity, force }) =
            loops.sample(course, &runner.y, size)
        {
            let points = points.iter().map(|(_, c)| runner.y[*c]).collect();
            trace.samples.push(TraceSample { time_s, command, position, velocity, force, points });
            if !((command - position).abs() <= bound) {
                trace.unstable = Some((time_s, (command - position).abs()));
                trace.complete = false;
                break;
            }
            runner.begin_period(time_s);
        }
        if tick == periods * loops.to_velocity {
            break;
        }
        if runner.stopped || (tick % 1024 == 0 && !go_on()) {
            trace.complete = false;
            break;
        }
        let (old, new) = delayed(&mut inputs, loops.input(&runner.y), whole_periods);
        if let Some(dc_link_v) = loops.switching_v {
            let rotation = loops.rotation(&runner.y, driven, size);
            for pulse in pulses(new, dc_link_v, rotation, tick % 2 == 1) {
                for (level, from) in pulse.pieces() {
                    runner.advance(
                        (0, level),
                        time_s + f64::from(from) / f64::from(1 << LEVELS) * step_s,
                        pulse.input,
                    )?;
                }
            }
            continue;
        }
        for part in 0..parts {
            let at_s = time_s + part as f64 * step_s;
            if !has_rest || part != split_part {
                runner.advance((0, 0), at_s, if part < split_part { old } else { new })?;
            } else {
                runner.advance((1, 0), at_s, old)?;
                runner.advance((2, 0), at_s + remainder * step_s, new)?;
            }
        }
    }
    trace.energy = runner.energy_balance();
    trace.events = runner.events;
    Ok(trace)
}

/// Adds an input to those of earlier periods, newest first. Returns those that act before and after the
/// remainder of the delay; before the start the input has its initial value.
fn delayed(inputs: &mut VecDeque<Input>, input: Input, whole_periods: usize) -> (Input, Input) {
    inputs.push_front(input);
    inputs.truncate(whole_periods + 2);
    let late = |periods: usize| inputs[periods.min(inputs.len() - 1)];
    (late(whole_periods + 1), late(whole_periods))
}

/// Returns the number of steps per period of the innermost loop.
fn parts(settings: &SimulationSettings, period_s: f64) -> Result<usize, MotionError> {
    let Some(step_s) = settings.step_s else { return Ok(1) };
    let parts = period_s / step_s;
    if !(step_s > 0.0 && parts > 1.0 - 1e-6) {
        let fault = format!(
            "a step of {step_s} s is too long for the period of {period_s} s of the innermost loop; write an integer fraction of it"
        );
        return Err(MotionError::Input(fault));
    }
    if parts > MOST_PARTS {
        let fault = format!(
            "a step of {step_s:e} s is a {parts:.0}th of the period of {period_s:e} s of the innermost loop; write one of at least {:e} s",
            period_s / MOST_PARTS
        );
        return Err(MotionError::Input(fault));
    }
    if (parts - parts.round()).abs() > 1e-6 * parts {
        let fault = format!(
            "a step of {step_s} s is not an integer fraction of the period of {period_s} s of the innermost loop; write one, such as {}",
            period_s / parts.ceil()
        );
        return Err(MotionError::Input(fault));
    }
    Ok(parts.round() as usize)
}

/// Rejects a motion of too many samples or steps.
fn check_extent(
    course: &Course,
    samples: usize,
    periods: usize,
    parts: usize,
    step_s: f64,
) -> Result<(), MotionError> {
    let duration_s = course.duration_s();
    if samples > MOST_SAMPLES {
        let fault = format!(
            "the motion of {duration_s:.3e} s has {samples} samples of the velocity loop, more than {MOST_SAMPLES}; shorten it, or lengthen \
             drive.velocity.period_s"
        );
        return Err(MotionError::Input(fault));
    }
    if periods.saturating_mul(parts) > MOST_HOLDS {
        let fault = format!(
            "the motion of {duration_s:.3e} s has more than {MOST_HOLDS} steps of {step_s:e} s; shorten it, or lengthen the step or the period \
             of the innermost loop"
        );
        return Err(MotionError::Input(fault));
    }
    Ok(())
}

/// Returns a delay in periods, rounded to a whole number if the difference is only rounding.
pub(super) fn periods(delay_s: f64, period_s: f64) -> f64 {
    let periods = delay_s / period_s;
    if (periods - periods.round()).abs() < 1e-9 { periods.round() } else { periods }
}

/// Rejects a command that leaves the stroke.
fn check_stroke(
    machine: &Machine,
    course: &Course,
    settings: &SimulationSettings,
) -> Result<(), MotionError> {
    if course.command.len() < 2
        || !(course.step_s > 0.0)
        || course.command.iter().chain(&course.added).any(|x| !x.is_finite())
    {
        return Err(MotionError::Input("the reference needs at least two samples, all finite".into()));
    }
    if let Some([lower, upper]) = machine.drive.as_ref().and_then(|d| d.position.limits) {
        let outside = course.command.iter().position(|x| !(lower..=upper).contains(x));
        if let Some(at) = outside {
            let fault = format!(
                "at {:.4} s the reference is {:.4e}, beyond the stroke from {lower} to {upper} (drive.position.limits_m); shorten the travel",
                at as f64 * course.step_s,
                course.command[at]
            );
            return Err(MotionError::Input(fault));
        }
    }
    let (Some(stroke_m), Some(nut_m)) = (machine.stroke_m(), settings.operating.nut_m) else { return Ok(()) };
    for (at, x) in course.command.iter().enumerate() {
        let nut_m = nut_m + x - course.command[0];
        if !(0.0..=stroke_m).contains(&nut_m) {
            let fault = format!(
                "at {:.4} s the reference brings the nut to {nut_m:.4} m, beyond the screw of {stroke_m} m; start elsewhere, or shorten the travel",
                at as f64 * course.step_s
            );
            return Err(MotionError::Input(fault));
        }
    }
    Ok(())
}

/// Returns the bound of |command − position| beyond which a loop is unstable: ten times the range of the
/// command.
fn bound(course: &Course) -> f64 {
    let (low, high) = extremes(&course.command);
    let away = course.start_position.map_or(0.0, |x| (x - course.command[0]).abs());
    10.0 * (high - low + away).max(1e-6)
}

/// Computes position and velocity of the machine at the start.
fn start(plant: &Plant, course: &Course) -> Result<Vec<f64>, MotionError> {
    let n = plant.size;
    let mut system = nalgebra::DMatrix::zeros(n + 1, n + 1);
    // The scale makes the stiffnesses comparable to the encoder's row.
    let scale = plant.closed.amax().max(1.0);
    system.view_mut((0, 0), (n, n)).copy_from(&(&plant.closed / scale));
    system[(n, plant.position.at)] = plant.position.travel;
    system[(plant.position.at, n)] = plant.position.travel;
    let mut right = nalgebra::DMatrix::zeros(n + 1, 2);
    right[(n, 0)] = course.start_position.unwrap_or(course.command[0]);
    right[(n, 1)] = course.start_velocity.unwrap_or(0.0);
    let loose = || {
        MotionError::Input(
            "a part of the machine moves independently of the drive's encoder; hold it by a joint".into(),
        )
    };
    let solved = system.lu().solve(&right).filter(|x| x.iter().all(|x| x.is_finite())).ok_or_else(loose)?;
    let mut y = vec![0.0; plant.states];
    for i in 0..n {
        (y[i], y[n + i]) = (solved[(i, 0)], solved[(i, 1)]);
    }
    Ok(y)
}
