//! Commands every millisecond: a point on a circle with a smooth start, or one coordinate of it.

use std::f64::consts::TAU;

use super::nominal::{check_values, with_names};
use super::run::RECORD_S;
use crate::Result;

/// Returns the angle after a time, rad: the speed rises as the smooth step s³ (10 − 15 s + 6 s²) over the
/// ramp.
fn angle_rad(speed_rad_s: f64, ramp_s: f64, time_s: f64) -> f64 {
    if time_s >= ramp_s {
        return speed_rad_s * (time_s - 0.5 * ramp_s);
    }
    let s = time_s / ramp_s;
    speed_rad_s * ramp_s * s.powi(4) * (2.5 - 3.0 * s + s * s)
}

/// Returns the times of a ramp and whole revolutions after it, s.
fn times(speed_rad_s: f64, ramp_s: f64, revolutions: usize) -> impl Iterator<Item = f64> {
    let duration = ramp_s + revolutions as f64 * TAU / speed_rad_s;
    (0..=(duration / RECORD_S).floor() as usize).map(|k| k as f64 * RECORD_S)
}

/// A sine by its largest feed. It begins at rest at zero. Its phase accelerates, not its amplitude, so that
/// even a short ramp never exceeds the feed.
#[derive(Clone, Debug, PartialEq)]
pub struct Feed {
    /// Largest feed, mm/min.
    pub feed_mm_min: f64,
    /// Amplitude, m.
    pub amplitude_m: f64,
    /// Duration of the acceleration of the phase, s.
    pub ramp_s: f64,
    /// Whole periods after the ramp.
    pub periods: usize,
}

impl Feed {
    /// Returns a sine of 0.1 m amplitude with a ramp of 1 s and two periods; one period if two would exceed
    /// 40 s.
    pub fn of(feed_mm_min: f64) -> Self {
        let one = Self { feed_mm_min, amplitude_m: 0.1, ramp_s: 1.0, periods: 1 };
        let two = Self { periods: 2, ..one.clone() };
        if two.ramp_s + 2.0 * TAU / two.speed_rad_s() <= 40.0 { two } else { one }
    }

    /// Returns F1000, F2000 … F6000.
    pub fn standard() -> Vec<Self> {
        (1..=6).map(|thousands| Self::of(1000.0 * f64::from(thousands))).collect()
    }

    /// Returns the name of the record: F and the feed.
    pub fn name(&self) -> String {
        format!("F{}", self.feed_mm_min)
    }

    /// Returns the angular frequency, rad/s: largest speed over amplitude.
    pub fn speed_rad_s(&self) -> f64 {
        self.feed_mm_min / 60_000.0 / self.amplitude_m
    }

    /// Computes the commands, m, one for each millisecond from 0.
    ///
    /// # Errors     `SimulatorError::Refused` for a feed, an amplitude or a ramp that is not positive.
    pub fn commands_m(&self) -> Result<Vec<f64>> {
        let numbers = with_names! { self.feed_mm_min, self.amplitude_m, self.ramp_s };
        check_values(&numbers, "a positive number", |value| value > 0.0)?;
        let speed = self.speed_rad_s();
        Ok(times(speed, self.ramp_s, self.periods)
            .map(|time| self.amplitude_m * angle_rad(speed, self.ramp_s, time).sin())
            .collect())
    }
}

/// A circle through the origin by its angular speed: x = R sin φ, y = R (1 − cos φ). It begins at rest, along
/// x.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Radius, m.
    pub radius_m: f64,
    /// Angular speed, rad/min.
    pub speed_rad_min: f64,
    /// Time until the angular speed is reached, s.
    pub ramp_s: f64,
    /// Whole revolutions after the ramp.
    pub revolutions: usize,
}

impl Circle {
    /// Returns a circle of 50 mm radius with a ramp of 1 s and two revolutions.
    pub fn of(speed_rad_min: f64) -> Self {
        Self { radius_m: 0.05, speed_rad_min, ramp_s: 1.0, revolutions: 2 }
    }

    /// Returns circles of 60, 80, 100 and 120 rad/min.
    pub fn standard() -> Vec<Self> {
        [60.0, 80.0, 100.0, 120.0].map(Self::of).to_vec()
    }

    /// Returns the name of the record: circle and the speed.
    pub fn name(&self) -> String {
        format!("circle-{}", self.speed_rad_min)
    }

    /// Computes the commands of x and y, m, one for each millisecond from 0.
    ///
    /// # Errors     `SimulatorError::Refused` for a radius, a speed or a ramp that is not positive.
    pub fn commands_m(&self) -> Result<[Vec<f64>; 2]> {
        let numbers = with_names! { self.radius_m, self.speed_rad_min, self.ramp_s };
        check_values(&numbers, "a positive number", |value| value > 0.0)?;
        let speed = self.speed_rad_min / 60.0;
        let angles: Vec<f64> = times(speed, self.ramp_s, self.revolutions)
            .map(|time| angle_rad(speed, self.ramp_s, time))
            .collect();
        let x = angles.iter().map(|angle| self.radius_m * angle.sin()).collect();
        let y = angles.iter().map(|angle| self.radius_m * (1.0 - angle.cos())).collect();
        Ok([x, y])
    }
}
