//! The force pulse of one blow.

use num_complex::Complex64;

use super::setting::{PRETRIGGER_S, SPREAD, Setting};
use crate::draw::Draw;

/// A half-sine pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Peak force over the nominal peak of the series.
    pub height: f64,
    /// Width, s.
    pub width_s: f64,
    /// Start, s.
    pub start_s: f64,
}

impl Pulse {
    /// Returns the nominal pulse of a series.
    pub fn nominal(setting: &Setting) -> Self {
        Self { height: 1.0, width_s: setting.width_s, start_s: PRETRIGGER_S }
    }

    /// Draws one blow with random height, width and start.
    pub fn random(setting: &Setting, draw: &mut Draw) -> Self {
        Self {
            height: (SPREAD * draw.normal()).exp(),
            width_s: setting.width_s * (1.0 + 0.04 * draw.within(1.0)),
            start_s: PRETRIGGER_S + draw.unit() / setting.rate_hz,
        }
    }

    /// Returns the Laplace transform at s: (π/w) (1 + e^{−sw}) / (s² + (π/w)²) e^{−s t₀}.
    pub fn transform(&self, s: Complex64) -> Complex64 {
        let rate = std::f64::consts::PI / self.width_s;
        let span = s * s + rate * rate;
        // At s = ± iπ/w numerator and denominator both vanish; the limit is ∓ i w/2.
        let shape = if span.norm() < 1e-9 * rate * rate {
            Complex64::new(0.0, -0.5 * self.width_s * s.im.signum())
        } else {
            (1.0 + (-s * self.width_s).exp()) * rate / span
        };
        shape * (-s * self.start_s).exp() * self.height
    }
}
