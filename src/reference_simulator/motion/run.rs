//! A motion of the axis under its drive, and its record.

use super::drive::{Drive, Loops, quantised};
use super::path::Path;
use super::plant::{Axis, Chain};
use crate::draw::Draw;

/// Integration step, s.
pub const STEP_S: f64 = 25e-6;

/// Coarse integration step, sufficient for the strength of effects, s.
pub const COARSE_S: f64 = 50e-6;

/// Sampling period of the records, s.
pub const RECORD_S: f64 = 1e-3;

/// Axis and drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Axis.
    pub axis: Axis,
    /// Drive.
    pub drive: Drive,
}

/// True motion, every millisecond, without the noise, rounding and delay of sensors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Reference, m.
    pub command_m: Vec<f64>,
    /// Motor position by its encoder, m.
    pub motor_m: Vec<f64>,
    /// Speed of the motor, m/s.
    pub motor_m_s: Vec<f64>,
    /// Table position by a stationary scale, m.
    pub table_m: Vec<f64>,
    /// Speed of the table, m/s.
    pub table_m_s: Vec<f64>,
    /// Demanded force, N.
    pub force_n: Vec<f64>,
}

/// Random force on the motor: standard deviation (N), corner frequency (Hz) and random source.
pub type MotorNoise<'a> = Option<(f64, f64, &'a mut Draw)>;

impl Machine {
    /// Moves along a path in steps of `step_s`, which must divide the periods of drive and record.
    pub fn run(&self, path: &Path, step_s: f64, mut motor_noise: MotorNoise) -> Track {
        let steps_per_record = (RECORD_S / step_s).round() as usize;
        let steps_per_period = (self.drive.set.period_s / step_s).round() as usize;
        let count = (path.duration_s() / RECORD_S).ceil() as usize + 1;
        let reference =
            path.sampled(self.drive.set.period_s, (count - 1) * steps_per_record / steps_per_period + 2);
        let commands = path.sampled(RECORD_S, count);
        let mut chain = Chain::at_rest(&self.axis, path.start_m);
        let read = |position: f64| position + self.axis.reading_error_m(position);
        let mut loops = Loops::at_rest(&self.drive, read(path.start_m));
        let mut track = Track::default();
        let (mut demand, mut motor_noise_n) = (0.0, 0.0);
        for k in 0..=(count - 1) * steps_per_record {
            if k.is_multiple_of(steps_per_period) {
                let (motor_m, table_m) =
                    (read(chain.position_m[0]), read(self.axis.scale_m(chain.position_m[2], chain.time_s)));
                demand = loops.sample(
                    &self.drive,
                    k as f64 * step_s,
                    reference[k / steps_per_period],
                    motor_m,
                    table_m,
                );
                if let Some((sd, corner_hz, draw)) = &mut motor_noise {
                    let keep = (-std::f64::consts::TAU * *corner_hz * self.drive.set.period_s).exp();
                    motor_noise_n = keep * motor_noise_n + *sd * (1.0 - keep * keep).sqrt() * draw.normal();
                }
            }
            if k.is_multiple_of(steps_per_record) {
                track.command_m.push(commands[k / steps_per_record]);
                track.motor_m.push(read(chain.position_m[0]));
                track.motor_m_s.push(chain.speed_m_s[0]);
                let delayed_m = chain.position_m[2] - chain.speed_m_s[2] * self.axis.scale_delay_s;
                track.table_m.push(read(self.axis.scale_m(delayed_m, chain.time_s)));
                track.table_m_s.push(chain.speed_m_s[2]);
                track.force_n.push(demand);
            }
            let force = self.axis.amplified(loops.force(&self.drive, (k as f64 + 0.5) * step_s, step_s));
            chain.step(&self.axis, step_s, force + motor_noise_n);
        }
        track
    }
}

/// Location of the position sensor of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The motor encoder, which closes the velocity loop.
    Motor,
    /// A scale at the table.
    Table,
}

/// Sensors of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// Location of the position sensor.
    pub side: Side,
    /// Step of the reading, m.
    pub quantum_m: f64,
    /// Delay of the reading, s.
    pub delay_s: f64,
    /// Largest scatter of the sampling time, s.
    pub jitter_s: f64,
    /// Standard deviation of the position noise, m.
    pub noise_m: f64,
    /// Standard deviation of the noise of the force channel, N.
    pub noise_n: f64,
    /// Share of the noise power that is coloured.
    pub coloured: f64,
    /// Corner frequency of the coloured share, Hz.
    pub corner_hz: f64,
}

/// A record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Reference, m.
    pub command_m: Vec<f64>,
    /// Measured position, m.
    pub position_m: Vec<f64>,
    /// Recorded force, N.
    pub force_n: Vec<f64>,
}

impl Sensors {
    /// Returns the record of a track by perfect sensors.
    pub fn exact(&self, track: &Track) -> Log {
        let position_m = if self.side == Side::Motor { &track.motor_m } else { &track.table_m };
        Log {
            command_m: track.command_m.clone(),
            position_m: position_m.clone(),
            force_n: track.force_n.clone(),
        }
    }

    /// Returns the same sensors without random errors: no noise, no jitter, no rounding.
    pub fn quiet(&self) -> Self {
        Self { quantum_m: 0.0, jitter_s: 0.0, noise_m: 0.0, noise_n: 0.0, ..self.clone() }
    }

    /// Records a track; `distort` applies a data fault before noise and rounding.
    pub fn read(&self, track: &Track, distort: impl Fn(&mut Log), draw: &mut Draw) -> Log {
        let mut log = self.exact(track);
        let speeds = if self.side == Side::Motor { &track.motor_m_s } else { &track.table_m_s };
        for (position, speed) in log.position_m.iter_mut().zip(speeds) {
            *position += speed * (draw.within(self.jitter_s) - self.delay_s);
        }
        distort(&mut log);
        self.disturb(&mut log, draw);
        log
    }

    /// Adds the noise of both channels and rounds the position.
    pub fn disturb(&self, log: &mut Log, draw: &mut Draw) {
        for position in &mut log.position_m {
            *position = quantised(*position + self.noise_m * draw.normal(), self.quantum_m);
        }
        for (force, noise) in log.force_n.iter_mut().zip(self.noise(log.command_m.len(), draw)) {
            *force += noise;
        }
    }

    /// Draws noise of the force channel, N.
    pub fn noise(&self, count: usize, draw: &mut Draw) -> Vec<f64> {
        let keep = (-std::f64::consts::TAU * self.corner_hz * RECORD_S).exp();
        let mut slow = draw.normal();
        let (white, slowly) = ((1.0 - self.coloured).sqrt(), self.coloured.sqrt());
        let mut one = || {
            slow = keep * slow + (1.0 - keep * keep).sqrt() * draw.normal();
            self.noise_n * (white * draw.normal() + slowly * slow)
        };
        (0..count).map(|_| one()).collect()
    }
}
