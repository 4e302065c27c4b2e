//! A motion on its way: steps, events, energy.

use super::MotionError;
use super::force_element::{Input, along};
use super::plant::Plant;
use super::state::ContactMode;
use super::step::Stepper;
use super::trace::{Energy, Event, EventKind};

/// Halvings after which a change of mode happens at the end of a step.
const FINEST: u8 = 32;
/// Halvings after which a parabola is taken as it is.
const BENT: u8 = 24;
/// Events in one period of the velocity loop that are no longer a motion.
const MOST_EVENTS: usize = 2000;

/// Share of the largest rate so far, and of a play, that is rounding.
const GRAIN: f64 = 1e-10;

/// Sizes below which states are small: µm, 0.1 mm/s and mA.
fn scale_at_start(plant: &Plant) -> impl Iterator<Item = f64> {
    let current = |i: usize| plant.winding.is_some_and(|w| w.q == i || w.d == Some(i));
    (0..plant.states).map(move |i| match i {
        _ if (plant.size..2 * plant.size).contains(&i) => 1e-4,
        _ if current(i) => 1e-3,
        _ => 1e-6,
    })
}

/// A motion on its way.
pub struct Runner {
    pub stepper: Stepper,
    mode: ContactMode,
    number: usize,
    pub y: Vec<f64>,
    input: Input,
    scale: Vec<f64>,
    /// Largest scale of each state: a thousand times the velocity over which a friction's level falls.
    finest: Vec<f64>,
    tolerance: f64,
    pub events: Vec<Event>,
    in_period: usize,
    period_s: f64,
    /// Halvings at which parabolas have been fine so far.
    usual: u8,
    energy: Energy,
    stored_at_start: f64,
    /// Room for margins at the start, middle and end of a step.
    room: [Vec<(f64, f64)>; 3],
}

impl Runner {
    pub fn new(stepper: Stepper, y: Vec<f64>, tolerance: f64) -> Self {
        let plant = &stepper.plant;
        let moving = |velocity: f64| if velocity.abs() < 1e-12 { 0 } else { velocity.signum() as i8 };
        let rubs = plant.rubs.iter().map(|r| if r.bristle.is_some() { 0 } else { moving(along(&r.along, &y[plant.size..])) }).collect();
        let side = |stretch: f64, half: f64| if stretch > half { 1 } else { -i8::from(stretch < -half) };
        let gaps = plant.gaps.iter().map(|g| side(g.stretch(&y[..plant.size]), g.half)).collect();
        let mode = ContactMode { rubs, gaps, relaxing: vec![None; plant.rubs.iter().filter(|r| r.bristle.is_some()).count()] };
        let n = plant.size;
        let mut finest = vec![f64::INFINITY; plant.states];
        for rub in plant.rubs.iter().filter(|r| r.stribeck > 0.0) {
            rub.along.iter().for_each(|&(i, c)| finest[n + i] = finest[n + i].min(1e3 * rub.velocity / c.abs()));
        }
        let scale: Vec<f64> = scale_at_start(plant).zip(&finest).map(|(s, f)| s.min(*f)).collect();
        let stored_at_start = plant.stored_j(&mode, &y);
        let mut runner = Runner {
            stepper,
            mode,
            number: 0,
            y,
            input: [0.0; 2],
            scale,
            finest,
            tolerance,
            events: Vec::new(),
            in_period: 0,
            period_s: 0.0,
            usual: 0,
            energy: Energy::default(),
            stored_at_start,
            room: Default::default(),
        };
        runner.energy.turned_over_j = stored_at_start.abs();
        runner.number = runner.stepper.mode(&runner.mode);
        runner
    }

    pub fn begin_period(&mut self, time_s: f64) {
        (self.in_period, self.period_s) = (0, time_s);
    }

    pub fn account(&self) -> Energy {
        Energy { stored_j: self.stepper.plant.stored_j(&self.mode, &self.y) - self.stored_at_start, ..self.energy }
    }

    /// Over 2^−level of a unit with one input of the drive.
    pub fn advance(&mut self, (unit, level): (u8, u8), time_s: f64, input: Input) -> Result<(), MotionError> {
        self.input = input;
        self.settle(time_s)?;
        self.piece(unit, level, time_s)
    }

    /// Over 2^−level of a unit, in halves where that is too long.
    fn piece(&mut self, unit: u8, level: u8, time_s: f64) -> Result<(), MotionError> {
        if level < self.usual {
            return self.halves(unit, level, time_s);
        }
        let tau = self.stepper.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level));
        if !self.mode.relaxing.is_empty() {
            let mut steps = std::mem::take(&mut self.mode.relaxing);
            self.stepper.plant.ladder_steps(&self.y, self.input, tau, &mut steps);
            self.mode.relaxing = steps;
            self.number = self.stepper.mode(&self.mode);
        }
        let mut start = self.margins(PeriodPosition::Start);
        if start.iter().any(|(margin, _)| *margin < 0.0) {
            // Used up within rounding.
            self.change(time_s)?;
            start = self.margins(PeriodPosition::Start);
        }
        let off = self.stepper.step(self.number, &self.mode, &self.y, self.input, (unit, level), &self.scale);
        if off > self.tolerance && level < BENT {
            self.usual = level + 1;
            return self.halves(unit, level, time_s);
        }
        let ends = self.ends(&start);
        self.room[PeriodPosition::Start as usize] = start;
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
        let lost = |y: &[f64]| plant.lost_w(&self.mode, y, self.input);
        self.energy.lost_j += tau / 6.0 * (lost(&self.y) + 4.0 * lost(&stepper.half) + lost(&stepper.end));
        self.energy.lost_j += plant.rubbed_j(&self.mode, &self.y, &stepper.end);
        let work = match &plant.winding {
            None => self.input[0] * (stepper.end[plant.drive] - self.y[plant.drive]),
            Some(_) => {
                let power = |y: &[f64]| plant.supplied_w(y, self.input);
                tau / 6.0 * (power(&self.y) + 4.0 * power(&stepper.half) + power(&stepper.end))
            }
        };
        self.energy.supplied_j += work;
        let force = plant.winding.map_or(self.input[0], |w| w.force(&stepper.half));
        if force * stepper.half[plant.size + plant.drive] >= 0.0 {
            self.energy.driving_j += work;
        }
        self.energy.turned_over_j += work.abs();
        self.y.copy_from_slice(&stepper.end);
        let sizes = self.y.iter().zip(&self.finest);
        self.scale.iter_mut().zip(sizes).for_each(|(s, (y, finest))| *s = s.max(y.abs().min(*finest)));
    }

    /// Whether the mode ends in the step just made: a margin is used up at its middle or end, or may have been between.
    fn ends(&mut self, start: &[(f64, f64)]) -> bool {
        let (half, end) = (self.margins(PeriodPosition::Half), self.margins(PeriodPosition::End));
        let ends = start.iter().zip(&half).zip(&end).any(|(((a, _), (m, _)), (b, grain))| {
            // Least value of the parabola through the three, inside the step.
            let (slope, bend) = (4.0 * m - 3.0 * a - b, 2.0 * (a - 2.0 * m + b));
            let at = -slope / (2.0 * bend);
            let least = if bend > 0.0 && at > 0.0 && at < 1.0 { a + slope * at + bend * at * at } else { *b };
            least.min(*m).min(*b) < -grain
        });
        (self.room[PeriodPosition::Half as usize], self.room[PeriodPosition::End as usize]) = (half, end);
        ends
    }

    /// Margins by which each law keeps its form, and by how much less than nothing they are used up: rates of what slides, depths of plays,
    /// forces left to what sticks.
    fn margins(&mut self, at: PeriodPosition) -> Vec<(f64, f64)> {
        let mut margins = std::mem::take(&mut self.room[at as usize]);
        margins.clear();
        let y = match at {
            PeriodPosition::Start => std::mem::take(&mut self.y),
            PeriodPosition::Half => std::mem::take(&mut self.stepper.half),
            PeriodPosition::End => std::mem::take(&mut self.stepper.end),
        };
        let plant = &self.stepper.plant;
        let fastest = |rub: usize| plant.rubs[rub].along.iter().map(|&(i, c)| c.abs() * self.scale[plant.size + i]).sum::<f64>();
        self.stepper.sliding(&self.mode, &y, |rub, rate| margins.push((rate, GRAIN * fastest(rub))));
        self.stepper.playing(&self.mode, &y, |gap, depth| margins.push((depth, GRAIN * plant.gaps[gap].half)));
        let mut held = Vec::new();
        self.stepper.held(self.number, &self.mode, &y, self.input, |rub, force| held.push((rub, force)));
        for (rub, force) in held {
            let plant = &self.stepper.plant;
            let rub = &plant.rubs[rub];
            let slack = plant.slack(rub, &y, self.input);
            margins.push((plant.level(rub, &y, self.input) + slack - force.abs(), 0.1 * slack));
        }
        match at {
            PeriodPosition::Start => self.y = y,
            PeriodPosition::Half => self.stepper.half = y,
            PeriodPosition::End => self.stepper.end = y,
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
            let stretch = plant.gaps[gap].stretch(&self.y[..plant.size]);
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
            self.stepper.held(self.number, &self.mode, &y, self.input, |rub, force| held.push((rub, force)));
            let plant = &self.stepper.plant;
            let over = |(rub, force): &(usize, f64)| {
                let rub = &plant.rubs[*rub];
                force.abs() - plant.level(rub, &y, self.input) - plant.slack(rub, &y, self.input)
            };
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
enum PeriodPosition {
    Start,
    Half,
    End,
}
