//! Sampled loops of a drive.

use std::collections::VecDeque;

use super::force_element::{Input, Winding};
use super::plant::{Plant, Reading};
use super::reference::Course;
use machine::{Drive, Inverter, Operating, Tachometry};

/// Parameters and state of a drive's loops.
#[derive(Debug, Clone)]
pub struct ControlLoops {
    /// Recorded force per unit of output, or per current with a winding.
    constant: f64,
    /// True force over recorded force.
    factor: f64,
    pub delay_s: f64,
    /// Period of the innermost loop (s).
    pub period_s: f64,
    /// Periods of the innermost loop in one of the velocity loop, and in one of the position loop.
    pub to_velocity: usize,
    to_position: usize,
    saturation: f64,
    position_gain: f64,
    feed_forward: f64,
    velocity_gain: f64,
    acceleration_gain: f64,
    tachometry: Tachometry,
    encoders: (Reading, Reading),
    winding: Option<Winding>,
    current: Option<Currents>,
    /// Largest voltage (V).
    limit_v: f64,
    /// DC-link voltage of a switching inverter (V).
    pub switching_v: Option<f64>,
    /// Readings of the velocity loop, oldest first.
    readings: VecDeque<f64>,
    speed: Integral,
    reference: f64,
    acceleration: f64,
    last_rate: f64,
    signal: f64,
    tick: usize,
}

/// Loops of both currents.
#[derive(Debug, Clone)]
struct Currents {
    gain: f64,
    q: Integral,
    d: Integral,
}

/// Integral term ∫e dt/T.
#[derive(Debug, Clone, Copy)]
struct Integral {
    time_s: f64,
    value: f64,
}

impl Integral {
    fn over(time_s: f64) -> Self {
        Integral { time_s, value: 0.0 }
    }

    fn add(&mut self, error: f64, period_s: f64) {
        self.value += error * period_s / self.time_s;
    }
}

/// Signals at a sample of the velocity loop.
#[derive(Debug, Clone, Copy)]
pub struct ControllerOutput {
    /// Command at the time of the last position sample.
    pub command: f64,
    /// Reading of the position encoder.
    pub position: f64,
    /// Velocity as measured by the loop.
    pub velocity: f64,
    /// Force as recorded by the drive.
    pub force: f64,
}

impl ControlLoops {
    pub fn new(
        drive: &Drive,
        plant: &Plant,
        values: &[f64],
        operating: &Operating,
        velocity: f64,
        start: &[f64],
    ) -> Self {
        let at = |value: &machine::Value| value.at(values, operating);
        let velocity_s = drive.velocity.period_s;
        let now = plant.velocity.travel * start[plant.velocity.at];
        let rate = velocity * plant.velocity.travel.signum();
        let readings = match drive.velocity.tachometry {
            Tachometry::Direct => VecDeque::new(),
            Tachometry::Difference(periods) => {
                (1..=periods).rev().map(|i| now - rate * velocity_s * i as f64).collect()
            }
        };
        let times = |outer: f64, inner: f64| ((outer / inner).round() as usize).max(1);
        let to_velocity = times(velocity_s, drive.period_s());
        let dc_link_v = drive.motor.as_ref().map_or(f64::INFINITY, |m| at(&m.dc_link_v));
        let three_phases = plant.winding.is_some_and(|w| w.d.is_some());
        ControlLoops {
            constant: at(&drive.constant),
            factor: at(&drive.force_factor),
            delay_s: at(&drive.delay_s),
            period_s: velocity_s / to_velocity as f64,
            to_velocity,
            to_position: to_velocity * times(drive.position.period_s, velocity_s),
            saturation: at(&drive.saturation),
            position_gain: at(&drive.position.gain_per_s),
            feed_forward: at(&drive.position.feed_forward),
            velocity_gain: at(&drive.velocity.gain),
            acceleration_gain: at(&drive.velocity.acceleration_feed_forward),
            tachometry: drive.velocity.tachometry,
            encoders: (plant.position, plant.velocity),
            winding: plant.winding,
            current: drive.current.as_ref().map(|c| {
                let integral = Integral::over(at(&c.integral_time_s));
                Currents { gain: at(&c.gain), q: integral, d: integral }
            }),
            limit_v: if three_phases { dc_link_v / 3.0_f64.sqrt() } else { dc_link_v },
            switching_v: drive
                .current
                .as_ref()
                .and_then(|c| (c.inverter == Inverter::Switching).then_some(dc_link_v)),
            readings,
            speed: Integral::over(at(&drive.velocity.integral_time_s)),
            reference: 0.0,
            acceleration: 0.0,
            last_rate: 0.0,
            signal: 0.0,
            tick: 0,
        }
    }

    /// Runs a sample of the velocity loop, preceded by one of the position loop when it is due; `None`
    /// between samples of the velocity loop.
    pub fn sample(&mut self, course: &Course, y: &[f64], size: usize) -> Option<ControllerOutput> {
        let (tick, time_s) = (self.tick, self.tick as f64 * self.period_s);
        self.tick += 1;
        if !tick.is_multiple_of(self.to_velocity) {
            return None;
        }
        let command = course.command(time_s);
        let position = self.encoders.0.of(y);
        if tick.is_multiple_of(self.to_position) {
            let period_s = self.period_s * self.to_position as f64;
            let rate = (command - course.command(time_s - period_s)) / period_s;
            self.acceleration = if tick == 0 { 0.0 } else { (rate - self.last_rate) / period_s };
            self.last_rate = rate;
            self.reference = self.position_gain * (command - position) + self.feed_forward * rate;
        }
        let period_s = self.period_s * self.to_velocity as f64;
        let reading = self.encoders.1;
        let velocity = match self.tachometry {
            Tachometry::Direct => reading.travel * y[size + reading.at],
            Tachometry::Difference(periods) => {
                let now = reading.of(y);
                self.readings.push_back(now);
                let before = self.readings.pop_front().unwrap_or(now);
                (now - before) / (periods as f64 * period_s)
            }
        };
        let error = self.reference - velocity;
        let wanted =
            self.velocity_gain * (error + self.speed.value) + self.acceleration_gain * self.acceleration;
        let limited = wanted.clamp(-self.saturation, self.saturation);
        // Anti-windup: a saturated output does not increase the integral further.
        if limited == wanted || error * wanted < 0.0 {
            self.speed.add(error, period_s);
        }
        self.signal = limited + course.added_voltage(time_s);
        let force = self.constant * self.winding.map_or(self.signal, |w| y[w.q]);
        Some(ControllerOutput { command, position, velocity, force })
    }

    /// Runs a sample of the current loop; without a current loop returns the input of the drive.
    pub fn input(&mut self, y: &[f64]) -> Input {
        let Some(winding) = &self.winding else { return [self.constant * self.factor * self.signal, 0.0] };
        let Some(loops) = &mut self.current else {
            return [self.signal.clamp(-self.limit_v, self.limit_v), 0.0];
        };
        let (q, d) = winding.currents(y);
        let errors = [self.signal - q, -d];
        let wanted = [loops.gain * (errors[0] + loops.q.value), loops.gain * (errors[1] + loops.d.value)];
        let size = wanted[0].hypot(wanted[1]);
        let share = if size > self.limit_v { self.limit_v / size } else { 1.0 };
        for (integral, error, wanted) in
            [(&mut loops.q, errors[0], wanted[0]), (&mut loops.d, errors[1], wanted[1])]
        {
            if share == 1.0 || error * wanted < 0.0 {
                integral.add(error, self.period_s);
            }
        }
        wanted.map(|u| share * u)
    }

    /// Computes the electrical angle of the driven point, and its advance over one period.
    pub fn rotation(&self, y: &[f64], drive: usize, size: usize) -> super::inverter::ShaftRotation {
        let pairs = self.winding.map_or(0.0, |w| w.pairs);
        super::inverter::ShaftRotation {
            angle: pairs * y[drive],
            advance: pairs * y[size + drive] * self.period_s,
        }
    }
}
