//! A motion from its beginning to its end.

use super::control::{Loops, Output};
use super::element::along;
use super::plant::Plant;
use super::reference::Course;
use super::state::Mode;
use super::step::Stepper;
use super::{MotionError, Settings};
use crate::machine::Machine;

/// Halvings after which a change of mode happens at the end of a step.
const FINEST: u8 = 32;
/// Halvings after which a parabola is taken as it is.
const BENT: u8 = 24;
/// Events in one period of the velocity loop that are no longer a motion.
const MOST_EVENTS: usize = 2000;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// A friction came to rest.
    Sticks,
    /// A friction began to slide.
    Slides,
    /// A friction went from sliding one way to the other.
    Reverses,
    /// A play closed.
    Closes,
    /// A play opened.
    Opens,
}

/// An event of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When (s).
    pub time_s: f64,
    /// What.
    pub kind: EventKind,
    /// The joint.
    pub joint: String,
    /// Forward or upper side 1, backward or lower side −1, none 0.
    pub direction: i8,
}

/// One sample of a motion, at a period of the velocity loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Time (s).
    pub time_s: f64,
    /// Command (m or rad).
    pub command: f64,
    /// What the position loop's encoder reads.
    pub position: f64,
    /// Velocity as the velocity loop has it.
    pub velocity: f64,
    /// Force or torque as the drive records it (N or N·m).
    pub force: f64,
    /// Coordinate of every point that moves (m or rad), in the order of [`Trace::points`].
    pub points: Vec<f64>,
}

/// Where the energy went (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Work of the drive.
    pub supplied_j: f64,
    /// Stored at the end less stored at the start.
    pub stored_j: f64,
    /// Lost in dampers and friction.
    pub lost_j: f64,
    /// Sum of |work| of the drive, step by step, and of what is stored at the start: what an error is compared with.
    pub turned_over_j: f64,
}

impl Energy {
    /// |supplied − stored − lost| over what was turned over.
    pub fn imbalance(&self) -> f64 {
        let missing = (self.supplied_j - self.stored_j - self.lost_j).abs();
        if self.turned_over_j > 0.0 { missing / self.turned_over_j } else { missing }
    }
}

/// A motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Names of the points that [`Sample::points`] lists.
    pub points: Vec<String>,
    /// Samples.
    pub samples: Vec<Sample>,
    /// Events in the order of time.
    pub events: Vec<Event>,
    /// Energy.
    pub energy: Energy,
    /// When it left its bounds, and |command − position| then.
    pub unstable: Option<(f64, f64)>,
    /// Whether it ran to its end.
    pub complete: bool,
    /// What a person should know.
    pub warnings: Vec<String>,
}

/// Simulates a driven machine on a course. `go_on` is asked now and then; where it says no, the motion ends there, incomplete.
///
/// The machine begins at rest, or at the rate of the course's beginning, its springs as little strained as its encoder's reading allows.
///
/// # Units      parameters in the machine's order and units; see [`Course`] and [`Sample`]
/// # Limits     without friction and play the samples are those of the matrix exponential (test `limit_a_linear_machine…`)
/// # Errors     no drive; a step that is no part of the loops' period; a command beyond the stroke; something acts on a point without inertia;
///   events that follow each other without end. A loop that leaves its bounds is no error: see [`Trace::unstable`].
pub fn simulate(
    machine: &Machine,
    values: &[f64],
    course: &Course,
    settings: &Settings,
    go_on: &dyn Fn() -> bool,
) -> Result<Trace, MotionError> {
    let drive = machine.drive.as_ref().ok_or(MotionError::NoDrive)?;
    let plant = Plant::new(machine, values, settings)?;
    check_stroke(machine, course, settings)?;
    let (points, warnings) = (plant.points.clone(), plant.warnings.clone());
    let names: Vec<String> = points.iter().map(|(p, _)| machine.points[*p].name.clone()).collect();
    let y = start(&plant, course)?;
    let mut loops = Loops::new(drive, &plant, values, &settings.operating, course.start_velocity.unwrap_or(0.0), &y);
    let parts = parts(settings, loops.period_s)?;
    let step_s = loops.period_s / parts as f64;
    // The force follows its sample by whole periods and a rest, which lies in one of the steps.
    let delay = loops.delay_s / loops.period_s;
    let (behind, rest) = (delay.floor() as usize, delay.fract() * parts as f64);
    let (rest_at, rest) = (rest.floor() as usize, rest.fract());
    let units = if rest > 1e-9 { vec![step_s, rest * step_s, (1.0 - rest) * step_s] } else { vec![step_s] };
    let mut runner = Runner::new(Stepper::new(plant, units), y, settings.tolerance);
    let bound = settings.bound.unwrap_or_else(|| bound(course));
    let periods = (course.duration_s() / loops.period_s + 1e-6) as usize;
    let size = runner.stepper.plant.size;
    let mut trace = Trace {
        points: names,
        samples: Vec::with_capacity(periods + 1),
        events: Vec::new(),
        energy: Energy::default(),
        unstable: None,
        complete: true,
        warnings,
    };
    let mut signals: Vec<f64> = Vec::with_capacity(periods + 1);
    for period in 0..=periods {
        let time_s = period as f64 * loops.period_s;
        let Output { command, position, velocity, signal } = loops.sample(course, &runner.y, size);
        trace.samples.push(Sample {
            time_s,
            command,
            position,
            velocity,
            force: loops.constant * signal,
            points: points.iter().map(|(_, c)| runner.y[*c]).collect(),
        });
        if !((command - position).abs() <= bound) {
            trace.unstable = Some((time_s, (command - position).abs()));
            trace.complete = false;
            break;
        }
        signals.push(signal);
        if period == periods {
            break;
        }
        if period % 1024 == 0 && !go_on() {
            trace.complete = false;
            break;
        }
        // Before the beginning it was as it is then.
        let force = |late: usize| loops.constant * loops.factor * signals[period.saturating_sub(late)];
        let (old, new) = (force(behind + 1), force(behind));
        runner.begin_period(time_s);
        for part in 0..parts {
            let at_s = time_s + part as f64 * step_s;
            if units_of(&runner) == 1 || part != rest_at {
                let late = part < rest_at || (part == rest_at && units_of(&runner) == 3);
                runner.advance(0, at_s, if late { old } else { new })?;
            } else {
                runner.advance(1, at_s, old)?;
                runner.advance(2, at_s + rest * step_s, new)?;
            }
        }
    }
    trace.energy = runner.account();
    trace.events = runner.events;
    Ok(trace)
}

fn units_of(runner: &Runner) -> usize {
    runner.stepper.units_s.len()
}

/// Steps to a period of the velocity loop.
fn parts(settings: &Settings, period_s: f64) -> Result<usize, MotionError> {
    let Some(step_s) = settings.step_s else { return Ok(1) };
    let parts = period_s / step_s;
    if !(step_s > 0.0 && parts > 1.0 - 1e-6) {
        let fault = format!("a step of {step_s} s is too long for the velocity loop's period of {period_s} s; write a whole part of it");
        return Err(MotionError::Input(fault));
    }
    if (parts - parts.round()).abs() > 1e-6 * parts || parts > 1e6 {
        let fault = format!(
            "a step of {step_s} s is no whole part of the velocity loop's period of {period_s} s; write one, such as {}",
            period_s / parts.ceil()
        );
        return Err(MotionError::Input(fault));
    }
    Ok(parts.round() as usize)
}

/// Refuses a command that leaves the stroke.
fn check_stroke(machine: &Machine, course: &Course, settings: &Settings) -> Result<(), MotionError> {
    if course.command.len() < 2 || !(course.step_s > 0.0) || course.command.iter().chain(&course.added).any(|x| !x.is_finite()) {
        return Err(MotionError::Input("the reference needs at least two samples, all finite".into()));
    }
    let (Some(stroke_m), Some(nut_m)) = (machine.stroke_m(), settings.operating.nut_m) else { return Ok(()) };
    for (at, x) in course.command.iter().enumerate() {
        let nut_m = nut_m + x - course.command[0];
        if !(0.0..=stroke_m).contains(&nut_m) {
            let fault = format!(
                "at {:.4} s the reference brings the nut to {nut_m:.4} m, beyond the screw of {stroke_m} m; begin elsewhere, or travel less",
                at as f64 * course.step_s
            );
            return Err(MotionError::Input(fault));
        }
    }
    Ok(())
}

/// |command − position| beyond which a loop is unstable: ten times what the command covers.
fn bound(course: &Course) -> f64 {
    let (low, high) = course.command.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let away = course.start_position.map_or(0.0, |x| (x - course.command[0]).abs());
    10.0 * (high - low + away).max(1e-6)
}

/// Where the machine stands and how it moves at the start.
fn start(plant: &Plant, course: &Course) -> Result<Vec<f64>, MotionError> {
    let n = plant.size;
    let mut system = nalgebra::DMatrix::zeros(n + 1, n + 1);
    // Stiffnesses of any size, beside the encoder's row.
    let scale = plant.closed.amax().max(1.0);
    system.view_mut((0, 0), (n, n)).copy_from(&(&plant.closed / scale));
    system[(n, plant.position.at)] = plant.position.travel;
    system[(plant.position.at, n)] = plant.position.travel;
    let mut right = nalgebra::DMatrix::zeros(n + 1, 2);
    right[(n, 0)] = course.start_position.unwrap_or(course.command[0]);
    right[(n, 1)] = course.start_velocity.unwrap_or(0.0);
    let loose = || MotionError::Input("a part of the machine moves without the drive's encoder; hold it by a joint".into());
    let solved = system.lu().solve(&right).filter(|x| x.iter().all(|x| x.is_finite())).ok_or_else(loose)?;
    let mut y = vec![0.0; plant.states];
    for i in 0..n {
        (y[i], y[n + i]) = (solved[(i, 0)], solved[(i, 1)]);
    }
    Ok(y)
}

/// Sizes below which states are small: µm and 0.1 mm/s.
fn scale_at_start(states: usize, n: usize) -> impl Iterator<Item = f64> {
    (0..states).map(move |i| if (n..2 * n).contains(&i) { 1e-4 } else { 1e-6 })
}

/// A motion on its way.
struct Runner {
    stepper: Stepper,
    mode: Mode,
    number: usize,
    y: Vec<f64>,
    drive_n: f64,
    scale: Vec<f64>,
    /// Largest scale of each state: a thousand times the velocity over which a friction's level falls.
    finest: Vec<f64>,
    tolerance: f64,
    events: Vec<Event>,
    in_period: usize,
    period_s: f64,
    /// Halvings at which parabolas have been fine so far.
    usual: u8,
    energy: Energy,
    stored_at_start: f64,
}

impl Runner {
    fn new(stepper: Stepper, y: Vec<f64>, tolerance: f64) -> Self {
        let plant = &stepper.plant;
        let moving = |velocity: f64| if velocity.abs() < 1e-12 { 0 } else { velocity.signum() as i8 };
        let rubs = plant.rubs.iter().map(|r| if r.bristle.is_some() { 0 } else { moving(along(&r.along, &y[plant.size..])) }).collect();
        let side = |stretch: f64, half: f64| if stretch > half { 1 } else { -i8::from(stretch < -half) };
        let gaps = plant.gaps.iter().map(|g| side(along(&g.along, &y[..plant.size]), g.half)).collect();
        let mode = Mode { rubs, gaps, relaxing: vec![None; plant.rubs.iter().filter(|r| r.bristle.is_some()).count()] };
        let n = plant.size;
        let mut finest = vec![f64::INFINITY; plant.states];
        for rub in plant.rubs.iter().filter(|r| r.stribeck > 0.0) {
            rub.along.iter().for_each(|&(i, c)| finest[n + i] = finest[n + i].min(1e3 * rub.velocity / c.abs()));
        }
        let scale: Vec<f64> = scale_at_start(plant.states, n).zip(&finest).map(|(s, f)| s.min(*f)).collect();
        let stored_at_start = plant.stored_j(&mode, &y);
        let mut runner = Runner {
            stepper,
            mode,
            number: 0,
            y,
            drive_n: 0.0,
            scale,
            finest,
            tolerance,
            events: Vec::new(),
            in_period: 0,
            period_s: 0.0,
            usual: 0,
            energy: Energy::default(),
            stored_at_start,
        };
        runner.energy.turned_over_j = stored_at_start.abs();
        runner.number = runner.stepper.mode(&runner.mode);
        runner
    }

    fn begin_period(&mut self, time_s: f64) {
        (self.in_period, self.period_s) = (0, time_s);
    }

    fn account(&self) -> Energy {
        Energy { stored_j: self.stepper.plant.stored_j(&self.mode, &self.y) - self.stored_at_start, ..self.energy }
    }

    /// Over one unit with one force of the drive.
    fn advance(&mut self, unit: u8, time_s: f64, drive_n: f64) -> Result<(), MotionError> {
        self.drive_n = drive_n;
        self.settle(time_s)?;
        self.piece(unit, 0, time_s)
    }

    /// Over 2^−level of a unit, in halves where that is too long.
    fn piece(&mut self, unit: u8, level: u8, time_s: f64) -> Result<(), MotionError> {
        if level < self.usual {
            return self.halves(unit, level, time_s);
        }
        let tau = self.stepper.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level));
        if !self.mode.relaxing.is_empty() {
            let mut steps = std::mem::take(&mut self.mode.relaxing);
            self.stepper.plant.ladder_steps(&self.y, self.drive_n, tau, &mut steps);
            self.mode.relaxing = steps;
            self.number = self.stepper.mode(&self.mode);
        }
        let off = self.stepper.step(self.number, &self.mode, &self.y, self.drive_n, (unit, level), &self.scale);
        if off > self.tolerance && level < BENT {
            self.usual = level + 1;
            return self.halves(unit, level, time_s);
        }
        let ends = self.ends();
        if ends && level < FINEST {
            return self.halves(unit, level, time_s);
        }
        // The next may be longer where this one was easily short enough: halving divides what a parabola is off by eight.
        self.usual = if off < self.tolerance / 16.0 { level.saturating_sub(1) } else { level };
        self.accept(tau);
        if ends { self.change(time_s + tau) } else { Ok(()) }
    }

    fn halves(&mut self, unit: u8, level: u8, time_s: f64) -> Result<(), MotionError> {
        let half_s = self.stepper.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level) + 1);
        self.piece(unit, level + 1, time_s)?;
        self.piece(unit, level + 1, time_s + half_s)
    }

    /// Takes the step, and keeps account of its energy: Simpson's rule for what is lost to dampers, exact for work of constant forces.
    fn accept(&mut self, tau: f64) {
        let stepper = &self.stepper;
        let plant = &stepper.plant;
        let lost = |y: &[f64]| plant.lost_w(&self.mode, y, self.drive_n);
        self.energy.lost_j += tau / 6.0 * (lost(&self.y) + 4.0 * lost(&stepper.half) + lost(&stepper.end));
        self.energy.lost_j += plant.rubbed_j(&self.mode, &self.y, &stepper.end);
        let work = self.drive_n * (stepper.end[plant.drive] - self.y[plant.drive]);
        self.energy.supplied_j += work;
        self.energy.turned_over_j += work.abs();
        self.y.copy_from_slice(&stepper.end);
        let sizes = self.y.iter().zip(&self.finest);
        self.scale.iter_mut().zip(sizes).for_each(|(s, (y, finest))| *s = s.max(y.abs().min(*finest)));
    }

    /// Whether the mode ends in the step just made: a margin is below zero at its middle or end, or may have been between.
    fn ends(&mut self) -> bool {
        let mut ends = false;
        let (start, half, end) = (self.margins(At::Start), self.margins(At::Half), self.margins(At::End));
        for ((a, m), b) in start.iter().zip(&half).zip(&end) {
            let vertex = {
                // Least value of the parabola through the three, inside the step.
                let (slope, bend) = (4.0 * m - 3.0 * a - b, 2.0 * (a - 2.0 * m + b));
                let at = -slope / (2.0 * bend);
                if bend > 0.0 && at > 0.0 && at < 1.0 { a + slope * at + bend * at * at } else { f64::INFINITY }
            };
            let size = a.abs().max(m.abs()).max(b.abs());
            ends |= *m < 0.0 || *b < 0.0 || vertex < -1e-6 * size;
        }
        ends
    }

    /// Margins by which each law keeps its form: rates of what slides, forces left to what sticks, depths of plays.
    fn margins(&mut self, at: At) -> Vec<f64> {
        let mut margins = Vec::with_capacity(self.mode.rubs.len() + self.mode.gaps.len());
        let y = match at {
            At::Start => std::mem::take(&mut self.y),
            At::Half => std::mem::take(&mut self.stepper.half),
            At::End => std::mem::take(&mut self.stepper.end),
        };
        self.stepper.sliding(&self.mode, &y, |_, rate| margins.push(rate));
        self.stepper.playing(&self.mode, &y, |_, depth| margins.push(depth));
        let mut held = Vec::new();
        self.stepper.held(self.number, &self.mode, &y, self.drive_n, |rub, force| held.push((rub, force)));
        for (rub, force) in held {
            let plant = &self.stepper.plant;
            margins.push(plant.level(&plant.rubs[rub], &y, self.drive_n) - force.abs());
        }
        match at {
            At::Start => self.y = y,
            At::Half => self.stepper.half = y,
            At::End => self.stepper.end = y,
        }
        margins
    }

    /// Changes the form of every law whose margin is used up.
    fn change(&mut self, time_s: f64) -> Result<(), MotionError> {
        let before = self.mode.clone();
        let mut stopped = Vec::new();
        self.stepper.sliding(&self.mode, &self.y, |rub, rate| {
            if rate < 0.0 {
                stopped.push(rub)
            }
        });
        let mut left = Vec::new();
        self.stepper.playing(&self.mode, &self.y, |gap, depth| {
            if depth < 0.0 {
                left.push(gap)
            }
        });
        for gap in left {
            let plant = &self.stepper.plant;
            let stretch = along(&plant.gaps[gap].along, &self.y[..plant.size]);
            self.mode.gaps[gap] = if self.mode.gaps[gap] == 0 { stretch.signum() as i8 } else { 0 };
            let side = self.mode.gaps[gap];
            let kind = if side == 0 { EventKind::Opens } else { EventKind::Closes };
            self.event(time_s, kind, gap, side, false)?;
        }
        for rub in &stopped {
            self.mode.rubs[*rub] = 0;
        }
        self.number = self.stepper.mode(&self.mode);
        if !stopped.is_empty() {
            let mut y = std::mem::take(&mut self.y);
            self.stepper.rest(self.number, &mut y);
            self.y = y;
        }
        self.release()?;
        for (rub, was) in before.rubs.iter().enumerate() {
            let is = self.mode.rubs[rub];
            if is == *was {
                continue;
            }
            let kind = match (*was, is) {
                (_, 0) => EventKind::Sticks,
                (0, _) => EventKind::Slides,
                _ => EventKind::Reverses,
            };
            self.event(time_s, kind, rub, if is == 0 { *was } else { is }, true)?;
        }
        Ok(())
    }

    /// At the beginning of a step, where the drive's force has just changed.
    fn settle(&mut self, time_s: f64) -> Result<(), MotionError> {
        let before = self.mode.rubs.clone();
        self.release()?;
        for (rub, was) in before.iter().enumerate() {
            if self.mode.rubs[rub] != *was {
                self.event(time_s, EventKind::Slides, rub, self.mode.rubs[rub], true)?;
            }
        }
        Ok(())
    }

    /// Lets go what is held by more than its level, the most overloaded first.
    fn release(&mut self) -> Result<(), MotionError> {
        for _ in 0..=self.mode.rubs.len() {
            let y = std::mem::take(&mut self.y);
            let mut held = Vec::new();
            self.stepper.held(self.number, &self.mode, &y, self.drive_n, |rub, force| held.push((rub, force)));
            let plant = &self.stepper.plant;
            let over = |(rub, force): &(usize, f64)| force.abs() - plant.level(&plant.rubs[*rub], &y, self.drive_n);
            let worst = held.into_iter().filter(|h| over(h) > 0.0).max_by(|a, b| over(a).total_cmp(&over(b)));
            self.y = y;
            let Some((rub, force)) = worst else { return Ok(()) };
            self.mode.rubs[rub] = force.signum() as i8;
            self.number = self.stepper.mode(&self.mode);
        }
        Ok(())
    }

    fn event(&mut self, time_s: f64, kind: EventKind, at: usize, direction: i8, rub: bool) -> Result<(), MotionError> {
        let plant = &self.stepper.plant;
        let joint = if rub { plant.rubs[at].name.clone() } else { plant.gaps[at].name.clone() };
        self.in_period += 1;
        if self.in_period > MOST_EVENTS {
            return Err(MotionError::Endless { time_s: self.period_s, count: MOST_EVENTS, last: joint });
        }
        self.events.push(Event { time_s, kind, joint, direction });
        Ok(())
    }
}

/// A place in a step.
#[derive(Debug, Clone, Copy)]
enum At {
    Start,
    Half,
    End,
}
