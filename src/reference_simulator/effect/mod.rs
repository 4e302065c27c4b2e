//! What may be missing from the engineer's model, in this module's own parametrisation.
//!
//! An effect has a kind, a dimensionless size (0 is absent, 1 is clear on most machines), a sign where both occur, and six numbers in
//! [0, 1) that fix its shape. All physical values follow from these and from the machine.

mod adjust;
mod attach;
mod kind;
mod numbers;
mod outside;

pub use kind::{EffectKind, Place};

use crate::draw::Draw;
use crate::machine::catalogue::Drawn;
use crate::machine::number::Machine;

/// One effect of a machine or of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Which.
    pub kind: EffectKind,
    /// How much; 0 is absent.
    pub size: f64,
    /// +1 or −1.
    pub sign: f64,
    /// Shape, each in [0, 1).
    pub shape: [f64; 6],
    /// Upper end of the measured band.
    pub band_hz: f64,
    /// First and last nut position.
    pub stroke_m: [f64; 2],
}

impl Effect {
    /// An effect of size 1 and random shape.
    pub fn drawn(kind: EffectKind, machine: &Drawn, draw: &mut Draw) -> Self {
        let sign = if kind.is_two_sided() { draw.sign() } else { 1.0 };
        let shape = std::array::from_fn(|_| draw.unit());
        Self { kind, size: 1.0, sign, shape, band_hz: machine.band_hz, stroke_m: [machine.nut_m[0], machine.nut_m[5]] }
    }

    /// The same effect at another size.
    pub fn sized(&self, size: f64) -> Self {
        Self { size, ..self.clone() }
    }

    /// Factor on every response.
    pub fn gain(&self) -> f64 {
        if self.kind == EffectKind::FrfGain { (0.04 * self.size * self.sign).exp() } else { 1.0 }
    }

    /// Delay of every response against the force.
    pub fn delay_s(&self) -> f64 {
        if self.kind == EffectKind::MeasurementDelay { 1.5e-5 * self.size * self.sign } else { 0.0 }
    }

    /// Where the screw needs a node for this effect.
    pub fn station(&self, machine: &Machine) -> Option<f64> {
        (self.kind == EffectKind::MiddleSupport).then(|| self.support_m(machine))
    }

    /// A number of the shape, scaled between two limits.
    fn scaled(&self, index: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.shape[index]
    }

    /// A number of the shape, scaled between two limits in the logarithm.
    fn log_scaled(&self, index: usize, low: f64, high: f64) -> f64 {
        self.scaled(index, low.ln(), high.ln()).exp()
    }

    /// A frequency inside the band, between two shares of it.
    fn inside_hz(&self, index: usize, low: f64, high: f64) -> f64 {
        self.band_hz * self.log_scaled(index, low, high)
    }
}
