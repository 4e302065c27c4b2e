//! The sampled loops of a drive.

use std::collections::VecDeque;

use super::plant::{Plant, Reading};
use super::reference::Course;
use crate::machine::{Drive, Operating, Tachometry};

/// Numbers of a drive's loops, and what they remember.
#[derive(Debug, Clone)]
pub struct Loops {
    /// Recorded force per unit of output.
    pub constant: f64,
    /// True force over recorded force.
    pub factor: f64,
    pub delay_s: f64,
    pub period_s: f64,
    /// Periods of the velocity loop in one of the position loop.
    ratio: usize,
    saturation: f64,
    position_gain: f64,
    feed_forward: f64,
    velocity_gain: f64,
    integral_time_s: f64,
    acceleration_gain: f64,
    tachometry: Tachometry,
    encoders: (Reading, Reading),
    /// Readings of the velocity loop, the oldest first.
    readings: VecDeque<f64>,
    integral: f64,
    reference: f64,
    acceleration: f64,
    last_rate: f64,
    tick: usize,
}

/// What the loops did at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Output {
    /// Command at the time of the last position sample.
    pub command: f64,
    /// Reading of the position encoder.
    pub position: f64,
    /// Velocity as the loop has it.
    pub velocity: f64,
    /// What goes to the drive, with what is added there.
    pub signal: f64,
}

impl Loops {
    pub fn new(drive: &Drive, plant: &Plant, values: &[f64], operating: &Operating, velocity: f64, start: &[f64]) -> Self {
        let at = |value: &crate::machine::Value| value.at(values, operating);
        let period_s = drive.velocity.period_s;
        let now = plant.velocity.travel * start[plant.velocity.at];
        let rate = velocity * plant.velocity.travel.signum();
        let readings = match drive.velocity.tachometry {
            Tachometry::Direct => VecDeque::new(),
            Tachometry::Difference(periods) => (1..=periods).rev().map(|i| now - rate * period_s * i as f64).collect(),
        };
        Loops {
            constant: at(&drive.constant),
            factor: at(&drive.force_factor),
            delay_s: at(&drive.delay_s),
            period_s,
            ratio: ((drive.position.period_s / period_s).round() as usize).max(1),
            saturation: at(&drive.saturation),
            position_gain: at(&drive.position.gain_per_s),
            feed_forward: at(&drive.position.feed_forward),
            velocity_gain: at(&drive.velocity.gain),
            integral_time_s: at(&drive.velocity.integral_time_s),
            acceleration_gain: at(&drive.velocity.acceleration_feed_forward),
            tachometry: drive.velocity.tachometry,
            encoders: (plant.position, plant.velocity),
            readings,
            integral: 0.0,
            reference: 0.0,
            acceleration: 0.0,
            last_rate: 0.0,
            tick: 0,
        }
    }

    /// One sample of the velocity loop, and of the position loop where it is its turn.
    pub fn sample(&mut self, course: &Course, y: &[f64], size: usize) -> Output {
        let time_s = self.tick as f64 * self.period_s;
        let command = course.command(time_s);
        let position = self.encoders.0.of(y);
        if self.tick.is_multiple_of(self.ratio) {
            let period_s = self.period_s * self.ratio as f64;
            let rate = (command - course.command(time_s - period_s)) / period_s;
            self.acceleration = if self.tick == 0 { 0.0 } else { (rate - self.last_rate) / period_s };
            self.last_rate = rate;
            self.reference = self.position_gain * (command - position) + self.feed_forward * rate;
        }
        self.tick += 1;
        let reading = self.encoders.1;
        let velocity = match self.tachometry {
            Tachometry::Direct => reading.travel * y[size + reading.at],
            Tachometry::Difference(periods) => {
                let now = reading.of(y);
                self.readings.push_back(now);
                let before = self.readings.pop_front().unwrap_or(now);
                (now - before) / (periods as f64 * self.period_s)
            }
        };
        let error = self.reference - velocity;
        let wanted = self.velocity_gain * (error + self.integral) + self.acceleration_gain * self.acceleration;
        let given = wanted.clamp(-self.saturation, self.saturation);
        // An output at its limit does not wind the integral up further.
        if given == wanted || error * wanted < 0.0 {
            self.integral += error * self.period_s / self.integral_time_s;
        }
        Output { command, position, velocity, signal: given + course.added(time_s) }
    }
}
