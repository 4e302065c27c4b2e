//! Curves with known modes.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A planted mode: natural frequency (Hz), damping ratio, receptance at resonance (signed).
#[derive(Debug, Clone, Copy)]
pub struct PlantedMode {
    pub frequency_hz: f64,
    pub damping: f64,
    pub peak: f64,
}

pub fn mode(frequency_hz: f64, damping: f64, peak: f64) -> PlantedMode {
    PlantedMode { frequency_hz, damping, peak }
}

/// Σ 2ζ a ω_n²/(ω_n² − ω² + 2iζω_nω) − lower/ω² + upper: each mode has magnitude |a| at ω_n.
pub fn receptance(modes: &[PlantedMode], lower: f64, upper: f64, frequency_hz: f64) -> Complex64 {
    let omega = TAU * frequency_hz;
    let mut h = Complex64::new(upper - lower / (omega * omega), 0.0);
    for m in modes {
        let natural = TAU * m.frequency_hz;
        h += 2.0 * m.damping * m.peak * natural * natural
            / Complex64::new(natural * natural - omega * omega, 2.0 * m.damping * natural * omega);
    }
    h
}

pub fn even(from_hz: f64, step_hz: f64, lines: usize) -> Vec<f64> {
    (0..lines).map(|k| from_hz + step_hz * k as f64).collect()
}

pub struct Draw(Xoshiro256PlusPlus);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.0.random::<f64>()).ln()).sqrt();
        radius * (TAU * self.0.random::<f64>()).cos()
    }

    /// Multiplies by noise with a relative standard deviation per component.
    pub fn noisy(&mut self, clean: &[Complex64], component_sd: f64) -> Vec<Complex64> {
        clean
            .iter()
            .map(|h| h * Complex64::new(1.0 + component_sd * self.normal(), component_sd * self.normal()))
            .collect()
    }
}
