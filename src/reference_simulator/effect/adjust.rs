//! Effects that change numbers of the machine.

use super::Effect;
use super::EffectKind::*;
use crate::machine::number::{Hold, Machine};

impl Effect {
    /// Changes the machine's numbers for one nut position and one force level (force over the nominal force).
    pub fn adjust(&self, machine: &mut Machine, nut_m: f64, level: f64) {
        match self.kind {
            RotorHold => machine.hold = Some(self.hold(machine)),
            NutStiffnessPosition => {
                let factor = self.preload_factor(nut_m);
                machine.nut.joint.stiffness *= factor;
                machine.nut.joint.damping *= factor.sqrt();
            }
            BearingStiffnessPosition => {
                let offset = 2.0 * self.stroke_fraction(nut_m) - 1.0;
                let factor = (0.25 * self.size * self.sign * (2.5 * offset).tanh()).exp();
                let bearing =
                    if self.is_left() { &mut machine.bearing_left } else { &mut machine.bearing_right };
                bearing.stiffness *= factor;
            }
            ScrewDiameter if self.is_hollow() => {
                machine.screw.bore_m = 0.45 * machine.screw.diameter_m * self.size.sqrt()
            }
            ScrewDiameter => machine.screw.diameter_m *= 1.0 - 0.04 * self.size * self.sign,
            ScrewLossFactor => machine.screw.loss += 0.02 * self.size,
            ContactLevel if self.is_left() => {
                let factor = level.powf(0.08 * self.size * self.sign);
                machine.nut.joint.stiffness *= factor;
            }
            _ => {}
        }
    }

    /// Returns the drive's hold: position and velocity loop with integral action.
    pub(super) fn hold(&self, machine: &Machine) -> Hold {
        let stiffness =
            self.size * 3e3 * (machine.screw.diameter_m / 0.04).powi(3) * self.log_scaled(0, 0.5, 4.0);
        let damping = 2.0 * self.log_scaled(1, 0.05, 0.3) * (stiffness * machine.rotor_inertia_kg_m2).sqrt();
        Hold {
            stiffness,
            damping,
            integral: stiffness * self.scaled(2, 0.0, 4.0),
            lag_s: (self.scaled(3, 0.0, 0.3) * damping / stiffness).min(5e-5),
        }
    }

    /// Returns the factor on the nut stiffness at a position: a zone of less or more preload with ramps on
    /// both sides.
    pub(super) fn preload_factor(&self, nut_m: f64) -> f64 {
        let distance = (self.stroke_fraction(nut_m) - self.scaled(0, 0.25, 0.75)).abs();
        let half = self.scaled(1, 0.08, 0.2);
        let inside = (1.0 - (distance - half) / self.scaled(2, 0.15, 0.35)).clamp(0.0, 1.0);
        (1.0 - 0.25 * self.size * self.sign * inside).max(0.15)
    }

    /// Returns the position along the stroke, 0 to 1.
    pub(super) fn stroke_fraction(&self, nut_m: f64) -> f64 {
        (nut_m - self.stroke_m[0]) / (self.stroke_m[1] - self.stroke_m[0])
    }

    /// Whether the effect takes the left or first of its two variants.
    pub(super) fn is_left(&self) -> bool {
        self.shape[5] < 0.5
    }

    /// Whether the screw is hollow instead of thinner or thicker.
    pub(super) fn is_hollow(&self) -> bool {
        self.shape[4] < 0.4
    }
}
