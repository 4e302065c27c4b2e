//! Effects that may be missing from the engineer's model, in this crate's own parametrisation.
//!
//! An effect has a kind and a dimensionless size: 0 is absent, 1 is clear on most machines. It has a sign
//! where both signs occur, and six numbers in [0, 1) that fix its shape. These and the machine determine all
//! physical values.

mod adjust;
mod attach;
mod kind;
mod numbers;
mod outside;

pub use kind::{EffectKind, Place};

use crate::draw::Draw;
use crate::machine::catalogue::DrawnMachine;
use crate::machine::number::Machine;

/// One effect of a machine or of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Kind.
    pub kind: EffectKind,
    /// Size; 0 is absent.
    pub size: f64,
    /// +1 or −1.
    pub sign: f64,
    /// Shape parameters, each in [0, 1).
    pub shape: [f64; 6],
    /// Upper end of the measured band, Hz.
    pub band_hz: f64,
    /// First and last nut position, m.
    pub stroke_m: [f64; 2],
}

impl Effect {
    /// Draws an effect of size 1 and random shape.
    pub fn random(kind: EffectKind, machine: &DrawnMachine, draw: &mut Draw) -> Self {
        let sign = if kind.is_two_sided() { draw.sign() } else { 1.0 };
        let shape = std::array::from_fn(|_| draw.unit());
        Self { kind, size: 1.0, sign, shape, band_hz: machine.band_hz, stroke_m: machine.stroke_m() }
    }

    /// Returns the same effect at another size.
    pub fn sized(&self, size: f64) -> Self {
        Self { size, ..self.clone() }
    }

    /// Returns the factor on every response.
    pub fn gain(&self) -> f64 {
        if self.kind == EffectKind::FrfGain { (0.04 * self.size * self.sign).exp() } else { 1.0 }
    }

    /// Returns the delay of every response against the force, s.
    pub fn delay_s(&self) -> f64 {
        if self.kind == EffectKind::MeasurementDelay { 1.5e-5 * self.size * self.sign } else { 0.0 }
    }

    /// Returns the position where the screw needs a node for this effect, m.
    pub fn station(&self, machine: &Machine) -> Option<f64> {
        (self.kind == EffectKind::MiddleSupport).then(|| self.support_m(machine))
    }

    /// Scales a shape parameter between two limits.
    fn scaled(&self, index: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.shape[index]
    }

    /// Scales a shape parameter between two limits, in the logarithm.
    fn log_scaled(&self, index: usize, low: f64, high: f64) -> f64 {
        self.scaled(index, low.ln(), high.ln()).exp()
    }

    /// Returns a frequency (Hz) between two shares of the measured band.
    fn in_band_hz(&self, index: usize, low: f64, high: f64) -> f64 {
        self.band_hz * self.log_scaled(index, low, high)
    }
}
