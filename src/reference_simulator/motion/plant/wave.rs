//! What repeats, or wanders, along the travel.

use std::f64::consts::TAU;

/// A sine of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Amplitude, in the unit of what it describes.
    pub amplitude: f64,
    /// Cycles for one metre.
    pub per_m: f64,
    /// Phase at the origin, rad.
    pub phase_rad: f64,
}

impl Wave {
    /// Value at a position.
    pub fn at(&self, position_m: f64) -> f64 {
        self.amplitude * (TAU * self.per_m * position_m + self.phase_rad).sin()
    }
}

/// Sum of waves at a position.
pub fn along(waves: &[Wave], position_m: f64) -> f64 {
    waves.iter().map(|wave| wave.at(position_m)).sum()
}
