//! State of a running simulation: steps, events, energy.

use super::MotionError;
use super::force_element::{Input, combine};
use super::plant::Plant;
use super::state::ContactMode;
use super::step::Stepper;
use super::trace::{Energy, Event, EventKind};

/// Number of halvings after which a mode changes at the end of a step.
const MAX_EVENT_HALVINGS: u8 = 32;
/// Number of halvings after which the error of a parabola is accepted.
const MAX_ERROR_HALVINGS: u8 = 24;
/// Largest number of events in one period of the velocity loop.
const MAX_EVENTS: usize = 2000;
/// Largest number of steps in one period of the velocity loop: each of its events, approached by halvings and
/// left by doublings.
const MAX_STEPS: usize = MAX_EVENTS * 2 * MAX_EVENT_HALVINGS as usize;
/// Largest number of steps of a motion: as many as take a few seconds, and besides [`MOST_PER_HOLD`] for each
/// time that the drive holds its input, where stiff machines need 20.
const MOST_STEPS: usize = 1_000_000;
/// See [`MOST_STEPS`].
const MOST_PER_HOLD: usize = 50;
/// Steps between two looks at the stop flag: below 10 ms on any machine within the limits.
const STEPS_BETWEEN_LOOKS: usize = 64;

/// Tolerance for rounding, as a share of the largest rate so far or of a backlash.
const ROUNDING: f64 = 1e-10;
/// Tolerance for rounding of the deformation of a backlash, as a share of the coordinates that it is the
/// difference of: some ten roundings.
const COORDINATE_ROUNDING: f64 = 1e-14;

/// Returns the initial scales of the states: 1 µm, 0.1 mm/s and 1 mA.
fn scale_at_start(plant: &Plant) -> impl Iterator<Item = f64> {
    let current = |i: usize| plant.winding.is_some_and(|w| w.q == i || w.d == Some(i));
    (0..plant.states).map(move |i| match i {
        _ if (plant.size..2 * plant.size).contains(&i) => 1e-4,
        _ if current(i) => 1e-3,
        _ => 1e-6,
    })
}

/// Why a step was halved last.
#[derive(Debug, Clone, Copy)]
enum Halving {
    /// The margin of this number, in the order of [`Runner::margins`], ends.
    Event(usize),
    /// The parabola is least accurate in this state.
    Error(usize),
}

/// A running simulation.
pub struct Runner<'g> {
    pub stepper: Stepper,
    /// Whether to go on; asked every [`STEPS_BETWEEN_LOOKS`] steps.
    go_on: &'g dyn Fn() -> bool,
    /// Whether the simulation was stopped within a step.
    pub stopped: bool,
    mode: ContactMode,
    number: usize,
    pub y: Vec<f64>,
    input: Input,
    scale: Vec<f64>,
    /// Upper limit of the scale of each state: a thousand times the Stribeck velocity of a friction.
    max_scale: Vec<f64>,
    tolerance: f64,
    pub events: Vec<Event>,
    in_period: usize,
    /// Steps in the current period of the velocity loop, and in all; times that the drive held its input.
    steps: [usize; 2],
    holds: usize,
    halving: Option<Halving>,
    period_s: f64,
    /// Number of halvings at which recent parabolas are accurate enough.
    start_level: u8,
    energy: Energy,
    stored_at_start: f64,
    /// Buffers for the margins at start, middle and end of a step.
    margin_buffers: [Vec<(f64, f64)>; 3],
}

impl<'g> Runner<'g> {
    pub fn new(stepper: Stepper, y: Vec<f64>, tolerance: f64, go_on: &'g dyn Fn() -> bool) -> Self {
        let plant = &stepper.plant;
        let moving = |velocity: f64| if velocity.abs() < 1e-12 { 0 } else { velocity.signum() as i8 };
        let frictions = plant
            .frictions
            .iter()
            .map(|r| if r.bristle.is_some() { 0 } else { moving(combine(&r.along, &y[plant.size..])) })
            .collect();
        let side = |stretch: f64, half: f64| if stretch > half { 1 } else { -i8::from(stretch < -half) };
        let gaps = plant.gaps.iter().map(|g| side(g.stretch(&y[..plant.size]), g.half)).collect();
        let mode = ContactMode {
            frictions,
            gaps,
            relaxing: vec![None; plant.frictions.iter().filter(|r| r.bristle.is_some()).count()],
        };
        let n = plant.size;
        let mut max_scale = vec![f64::INFINITY; plant.states];
        for friction in &plant.frictions {
            // The level changes over the Stribeck velocity, and between the rows of a table.
            let law = &friction.law;
            let velocities =
                (law.stribeck > 0.0).then_some(law.velocity).into_iter().chain(law.table.resolution());
            for velocity in velocities {
                friction
                    .along
                    .iter()
                    .for_each(|&(i, c)| max_scale[n + i] = max_scale[n + i].min(1e3 * velocity / c.abs()));
            }
        }
        let scale: Vec<f64> = scale_at_start(plant).zip(&max_scale).map(|(s, f)| s.min(*f)).collect();
        let stored_at_start = plant.stored_j(&mode, &y);
        let mut runner = Runner {
            stepper,
            go_on,
            stopped: false,
            mode,
            number: 0,
            y,
            input: [0.0; 2],
            scale,
            max_scale,
            tolerance,
            events: Vec::new(),
            in_period: 0,
            steps: [0; 2],
            holds: 0,
            halving: None,
            period_s: 0.0,
            start_level: 0,
            energy: Energy::default(),
            stored_at_start,
            margin_buffers: Default::default(),
        };
        runner.energy.throughput_j = stored_at_start.abs();
        runner.number = runner.stepper.mode(&runner.mode);
        runner
    }

    pub fn begin_period(&mut self, time_s: f64) {
        (self.in_period, self.steps[0], self.period_s) = (0, 0, time_s);
    }

    pub fn energy_balance(&self) -> Energy {
        Energy {
            stored_j: self.stepper.plant.stored_j(&self.mode, &self.y) - self.stored_at_start,
            ..self.energy
        }
    }

    /// Advances by 2^−level of a unit with one input of the drive.
    pub fn advance(&mut self, (unit, level): (u8, u8), time_s: f64, input: Input) -> Result<(), MotionError> {
        self.input = input;
        self.holds += 1;
        self.release_at_step_start(time_s)?;
        self.advance_piece(unit, level, time_s)
    }

    /// Advances by 2^−level of a unit, in two halves if the step is too long.
    fn advance_piece(&mut self, unit: u8, level: u8, time_s: f64) -> Result<(), MotionError> {
        if self.stopped {
            return Ok(());
        }
        if level < self.start_level {
            return self.advance_halves(unit, level, time_s);
        }
        self.count_step()?;
        let tau = self.stepper.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level));
        if !self.mode.relaxing.is_empty() {
            let mut steps = std::mem::take(&mut self.mode.relaxing);
            self.stepper.plant.ladder_steps(&self.y, self.input, tau, &mut steps);
            self.mode.relaxing = steps;
            self.number = self.stepper.mode(&self.mode);
        }
        let mut start = self.margins(StepPosition::Start);
        if start.iter().any(|(margin, _)| *margin < 0.0) {
            // A margin is negative within rounding.
            self.switch_modes(time_s)?;
            start = self.margins(StepPosition::Start);
        }
        let (error, state) =
            self.stepper.step(self.number, &self.mode, &self.y, self.input, (unit, level), &self.scale);
        if error > self.tolerance && level < MAX_ERROR_HALVINGS {
            self.start_level = level + 1;
            self.halving = Some(Halving::Error(state));
            return self.advance_halves(unit, level, time_s);
        }
        let ending = self.mode_ends(&start);
        self.margin_buffers[StepPosition::Start as usize] = start;
        if let Some(margin) = ending.filter(|_| level < MAX_EVENT_HALVINGS) {
            self.halving = Some(Halving::Event(margin));
            return self.advance_halves(unit, level, time_s);
        }
        // If the error is far below the tolerance, the next step may be longer: halving a step divides the
        // error of a parabola by eight.
        self.start_level = if error < self.tolerance / 16.0 { level.saturating_sub(1) } else { level };
        self.accept(tau);
        if ending.is_some() { self.switch_modes(time_s + tau) } else { Ok(()) }
    }

    /// Counts a step and looks at the stop flag.
    ///
    /// # Errors  one period, or the motion as a whole, needs too many steps.
    fn count_step(&mut self) -> Result<(), MotionError> {
        self.steps = self.steps.map(|steps| steps + 1);
        self.stopped = self.steps[1].is_multiple_of(STEPS_BETWEEN_LOOKS) && !(self.go_on)();
        let most = MOST_STEPS + MOST_PER_HOLD * self.holds;
        let fault = |within, count| MotionError::TooFast {
            time_s: self.period_s,
            within,
            count,
            part: self.fastest_part(),
        };
        match self.steps {
            [in_period, _] if in_period > MAX_STEPS => {
                Err(fault("one period of the velocity loop", MAX_STEPS))
            }
            [_, all] if all > most => Err(fault("the motion so far", most)),
            _ => Ok(()),
        }
    }

    /// Returns the configuration key of the part that the last halving was for, with its number where one
    /// alone is to blame.
    fn fastest_part(&self) -> String {
        let plant = &self.stepper.plant;
        match self.halving {
            None => "drive".into(),
            Some(Halving::Error(state)) => plant.key_of_state(state),
            Some(Halving::Event(margin)) => {
                let sliding =
                    self.mode.frictions.iter().enumerate().filter(|(_, sign)| **sign != 0).map(|(at, _)| at);
                let frictions: Vec<usize> = sliding.collect();
                let gap = margin.checked_sub(frictions.len()).and_then(|at| plant.gaps.get(at));
                match (frictions.get(margin), gap) {
                    (Some(at), _) => format!("joint.{}.friction", plant.frictions[*at].name),
                    (None, Some(gap)) => format!("joint.{}.gap = {:e}", gap.name, 2.0 * gap.half),
                    (None, None) => {
                        let sticking = margin - frictions.len() - plant.gaps.len();
                        let frictions = plant
                            .frictions
                            .iter()
                            .zip(&self.mode.frictions)
                            .filter(|(f, sign)| **sign == 0 && f.bristle.is_none());
                        frictions
                            .map(|(f, _)| f)
                            .nth(sticking)
                            .map_or_else(|| "drive".into(), |f| format!("joint.{}.friction", f.name))
                    }
                }
            }
        }
    }

    fn advance_halves(&mut self, unit: u8, level: u8, time_s: f64) -> Result<(), MotionError> {
        let half_s = self.stepper.units_s[usize::from(unit)] * 0.5_f64.powi(i32::from(level) + 1);
        self.advance_piece(unit, level + 1, time_s)?;
        self.advance_piece(unit, level + 1, time_s + half_s)
    }

    /// Accepts the step and updates the energy balance: Simpson's rule for the losses of dampers, exact for
    /// the work of constant forces.
    fn accept(&mut self, tau: f64) {
        let stepper = &self.stepper;
        let plant = &stepper.plant;
        let lost = |y: &[f64]| plant.lost_w(&self.mode, y, self.input);
        self.energy.lost_j += tau / 6.0 * (lost(&self.y) + 4.0 * lost(&stepper.half) + lost(&stepper.end));
        self.energy.lost_j += plant.level_friction_loss_j(&self.mode, &self.y, &stepper.end);
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
        self.energy.throughput_j += work.abs();
        self.y.copy_from_slice(&stepper.end);
        let sizes = self.y.iter().zip(&self.max_scale);
        self.scale.iter_mut().zip(sizes).for_each(|(s, (y, max_scale))| *s = s.max(y.abs().min(*max_scale)));
    }

    /// Whether a mode ends within the step: a margin is negative at its middle or end, or in between by the
    /// parabola through the three. Returns the number of the first margin that ends.
    fn mode_ends(&mut self, start: &[(f64, f64)]) -> Option<usize> {
        let (half, end) = (self.margins(StepPosition::Half), self.margins(StepPosition::End));
        let ends = start.iter().zip(&half).zip(&end).position(|(((a, _), (m, _)), (b, grain))| {
            // Minimum of the parabola through the three values, inside the step.
            let (slope, bend) = (4.0 * m - 3.0 * a - b, 2.0 * (a - 2.0 * m + b));
            let at = -slope / (2.0 * bend);
            let least = if bend > 0.0 && at > 0.0 && at < 1.0 { a + slope * at + bend * at * at } else { *b };
            least.min(*m).min(*b) < -grain
        });
        (self.margin_buffers[StepPosition::Half as usize], self.margin_buffers[StepPosition::End as usize]) =
            (half, end);
        ends
    }

    /// Computes the margin of each law to the end of its mode, and the tolerance below zero. Margins are the
    /// rates of sliding frictions, the depths of contacts or clearances, and the force reserves of sticking
    /// frictions.
    fn margins(&mut self, at: StepPosition) -> Vec<(f64, f64)> {
        let mut margins = std::mem::take(&mut self.margin_buffers[at as usize]);
        margins.clear();
        let y = match at {
            StepPosition::Start => std::mem::take(&mut self.y),
            StepPosition::Half => std::mem::take(&mut self.stepper.half),
            StepPosition::End => std::mem::take(&mut self.stepper.end),
        };
        let plant = &self.stepper.plant;
        let fastest = |friction: usize| {
            plant.frictions[friction]
                .along
                .iter()
                .map(|&(i, c)| c.abs() * self.scale[plant.size + i])
                .sum::<f64>()
        };
        margins.extend(
            self.stepper
                .sliding_rates(&self.mode, &y)
                .map(|(friction, rate)| (rate, ROUNDING * fastest(friction))),
        );
        margins.extend(self.stepper.gap_margins(&self.mode, &y).map(|(gap, depth)| {
            let coordinates: f64 = plant.gaps[gap].along.iter().map(|&(i, c)| (c * y[i]).abs()).sum();
            (depth, (ROUNDING * plant.gaps[gap].half).max(COORDINATE_ROUNDING * coordinates))
        }));
        for (friction, force) in self.stepper.sticking_forces(self.number, &self.mode, &y, self.input) {
            let plant = &self.stepper.plant;
            let friction = &plant.frictions[friction];
            let slack = plant.slack(friction, &y, self.input);
            margins.push((plant.level(friction, &y, self.input) + slack - force.abs(), 0.1 * slack));
        }
        match at {
            StepPosition::Start => self.y = y,
            StepPosition::Half => self.stepper.half = y,
            StepPosition::End => self.stepper.end = y,
        }
        margins
    }

    /// Changes the mode of every law with a negative margin.
    fn switch_modes(&mut self, time_s: f64) -> Result<(), MotionError> {
        let before = self.mode.clone();
        let ended = |(at, margin): (usize, f64)| (margin < 0.0).then_some(at);
        let stopped: Vec<usize> = self.stepper.sliding_rates(&self.mode, &self.y).filter_map(ended).collect();
        let changed: Vec<usize> = self.stepper.gap_margins(&self.mode, &self.y).filter_map(ended).collect();
        for gap in changed {
            let plant = &self.stepper.plant;
            let stretch = plant.gaps[gap].stretch(&self.y[..plant.size]);
            self.mode.gaps[gap] = if self.mode.gaps[gap] == 0 { stretch.signum() as i8 } else { 0 };
            let side = self.mode.gaps[gap];
            let kind = if side == 0 { EventKind::Opens } else { EventKind::Closes };
            self.event(time_s, kind, gap, side, false)?;
        }
        for friction in &stopped {
            self.mode.frictions[*friction] = 0;
        }
        self.number = self.stepper.mode(&self.mode);
        if !stopped.is_empty() {
            let mut y = std::mem::take(&mut self.y);
            self.stepper.stop_sticking(self.number, &mut y);
            self.y = y;
        }
        self.release()?;
        for (friction, was) in before.frictions.iter().enumerate() {
            let is = self.mode.frictions[friction];
            if is == *was {
                continue;
            }
            let kind = match (*was, is) {
                (_, 0) => EventKind::Sticks,
                (0, _) => EventKind::Slides,
                _ => EventKind::Reverses,
            };
            self.event(time_s, kind, friction, if is == 0 { *was } else { is }, true)?;
        }
        Ok(())
    }

    /// Releases overloaded frictions at the start of a step, where the drive's force has just changed.
    fn release_at_step_start(&mut self, time_s: f64) -> Result<(), MotionError> {
        let before = self.mode.frictions.clone();
        self.release()?;
        for (friction, was) in before.iter().enumerate() {
            if self.mode.frictions[friction] != *was {
                self.event(time_s, EventKind::Slides, friction, self.mode.frictions[friction], true)?;
            }
        }
        Ok(())
    }

    /// Releases sticking frictions whose force exceeds their level, the most overloaded first.
    fn release(&mut self) -> Result<(), MotionError> {
        for _ in 0..=self.mode.frictions.len() {
            let y = std::mem::take(&mut self.y);
            let sticking = self.stepper.sticking_forces(self.number, &self.mode, &y, self.input);
            let plant = &self.stepper.plant;
            let over = |(friction, force): &(usize, f64)| {
                let friction = &plant.frictions[*friction];
                force.abs() - plant.level(friction, &y, self.input) - plant.slack(friction, &y, self.input)
            };
            let most_overloaded =
                sticking.into_iter().filter(|h| over(h) > 0.0).max_by(|a, b| over(a).total_cmp(&over(b)));
            self.y = y;
            let Some((friction, force)) = most_overloaded else { return Ok(()) };
            self.mode.frictions[friction] = force.signum() as i8;
            self.number = self.stepper.mode(&self.mode);
        }
        Ok(())
    }

    fn event(
        &mut self,
        time_s: f64,
        kind: EventKind,
        at: usize,
        direction: i8,
        is_friction: bool,
    ) -> Result<(), MotionError> {
        let plant = &self.stepper.plant;
        let joint = if is_friction { plant.frictions[at].name.clone() } else { plant.gaps[at].name.clone() };
        self.in_period += 1;
        if self.in_period > MAX_EVENTS {
            return Err(MotionError::Endless { time_s: self.period_s, count: MAX_EVENTS, last: joint });
        }
        self.events.push(Event { time_s, kind, joint, direction });
        Ok(())
    }
}

/// A position within a step.
#[derive(Debug, Clone, Copy)]
enum StepPosition {
    Start,
    Half,
    End,
}
