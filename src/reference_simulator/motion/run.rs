//! A motion of the axis under its drive, and what the record says of it.

use super::drive::{Drive, Loops, quantised};
use super::path::Path;
use super::plant::{Axis, Chain};
use crate::draw::Draw;

/// Step of the integration, s.
pub const STEP_S: f64 = 25e-6;

/// A step that suffices to weigh effects, s.
pub const COARSE_S: f64 = 50e-6;

/// Period of the records, s.
pub const RECORD_S: f64 = 1e-3;

/// Axis and drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Axis.
    pub axis: Axis,
    /// Drive.
    pub drive: Drive,
}

/// What happened, every millisecond, without noise, rounding and lateness of a sensor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Reference, m.
    pub command_m: Vec<f64>,
    /// Motor as its encoder reads it, m.
    pub motor_m: Vec<f64>,
    /// Its speed, m/s.
    pub motor_m_s: Vec<f64>,
    /// Table by a scale that stands still, m.
    pub table_m: Vec<f64>,
    /// Its speed, m/s.
    pub table_m_s: Vec<f64>,
    /// Force demanded, N.
    pub force_n: Vec<f64>,
}

/// Noise that acts on the motor: standard deviation in N and corner in Hz, drawn with a seed.
pub type Unrest<'a> = Option<(f64, f64, &'a mut Draw)>;

impl Machine {
    /// Goes along a path in steps of `step_s`, which must divide the drive's period and the record's.
    pub fn run(&self, path: &Path, step_s: f64, mut unrest: Unrest) -> Track {
        let each = (RECORD_S / step_s).round() as usize;
        let tick = (self.drive.period_s / step_s).round() as usize;
        let count = (path.duration_s() / RECORD_S).ceil() as usize + 1;
        let reference = path.sampled(self.drive.period_s, (count - 1) * each / tick + 2);
        let commands = path.sampled(RECORD_S, count);
        let mut chain = Chain::at_rest(&self.axis, path.start_m);
        let read = |position: f64| position + self.axis.reading_error_m(position);
        let mut loops = Loops::at_rest(&self.drive, read(path.start_m));
        let mut track = Track::default();
        let (mut demand, mut shake) = (0.0, 0.0);
        for k in 0..=(count - 1) * each {
            if k.is_multiple_of(tick) {
                let reading = read(chain.position_m[0]);
                demand = loops.sample(&self.drive, k as f64 * step_s, reference[k / tick], reading);
                if let Some((sd, corner_hz, draw)) = &mut unrest {
                    let keep = (-std::f64::consts::TAU * *corner_hz * self.drive.period_s).exp();
                    shake = keep * shake + *sd * (1.0 - keep * keep).sqrt() * draw.normal();
                }
            }
            if k.is_multiple_of(each) {
                track.command_m.push(commands[k / each]);
                track.motor_m.push(read(chain.position_m[0]));
                track.motor_m_s.push(chain.speed_m_s[0]);
                let then = chain.position_m[2] - chain.speed_m_s[2] * self.axis.scale_late_s;
                track.table_m.push(read(self.axis.scale_m(then, chain.time_s)));
                track.table_m_s.push(chain.speed_m_s[2]);
                track.force_n.push(demand);
            }
            let force = self.axis.amplified(loops.force(&self.drive, (k as f64 + 0.5) * step_s, step_s));
            chain.step(&self.axis, step_s, force + shake);
        }
        track
    }
}

/// Where the position of a record is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// By the encoder at the motor, which closes the loops.
    Motor,
    /// By a scale at the table that only watches.
    Table,
}

/// Sensors of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// Where the position is measured.
    pub side: Side,
    /// Step of the reading, m.
    pub quantum_m: f64,
    /// Lateness of the reading, s.
    pub late_s: f64,
    /// Largest scatter of the moment of a reading, s.
    pub jitter_s: f64,
    /// Standard deviation of the position's noise, m.
    pub noise_m: f64,
    /// Standard deviation of the force channel, N.
    pub noise_n: f64,
    /// Share of its power that is coloured.
    pub coloured: f64,
    /// Corner of the coloured share, Hz.
    pub corner_hz: f64,
}

/// A record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Reference, m.
    pub command_m: Vec<f64>,
    /// Position as read, m.
    pub position_m: Vec<f64>,
    /// Force as recorded, N.
    pub force_n: Vec<f64>,
}

impl Sensors {
    /// The record of a track by perfect sensors.
    pub fn exact(&self, track: &Track) -> Log {
        let position_m = if self.side == Side::Motor { &track.motor_m } else { &track.table_m };
        Log { command_m: track.command_m.clone(), position_m: position_m.clone(), force_n: track.force_n.clone() }
    }

    /// The same sensors without what differs from one reading to the next: no noise, no jitter, no rounding.
    pub fn quiet(&self) -> Self {
        Self { quantum_m: 0.0, jitter_s: 0.0, noise_m: 0.0, noise_n: 0.0, ..self.clone() }
    }

    /// The record of a track; `spoil` is what a bad channel does to it before it is noisy and rounded.
    pub fn read(&self, track: &Track, spoil: impl Fn(&mut Log), draw: &mut Draw) -> Log {
        let mut log = self.exact(track);
        let speeds = if self.side == Side::Motor { &track.motor_m_s } else { &track.table_m_s };
        for (position, speed) in log.position_m.iter_mut().zip(speeds) {
            *position += speed * (draw.within(self.jitter_s) - self.late_s);
        }
        spoil(&mut log);
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

    /// Noise of the force channel, N.
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
