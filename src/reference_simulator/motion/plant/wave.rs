//! Periodic or smooth variations along the travel.

use std::f64::consts::TAU;

/// A sine over the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Amplitude, in the unit of the varying quantity.
    pub amplitude: f64,
    /// Cycles per metre.
    pub per_m: f64,
    /// Phase at the origin, rad.
    pub phase_rad: f64,
}

impl Wave {
    /// Returns the value at a position.
    pub fn at(&self, position_m: f64) -> f64 {
        self.amplitude * (TAU * self.per_m * position_m + self.phase_rad).sin()
    }
}

/// Returns the sum of waves at a position.
pub fn wave_sum(waves: &[Wave], position_m: f64) -> f64 {
    waves.iter().map(|wave| wave.at(position_m)).sum()
}
