//! Effects outside the library of the diagnosis, and the location of each effect.

use std::f64::consts::PI;

use super::EffectKind::*;
use super::{Effect, Place};
use crate::element::law::Law;
use crate::machine::assembly::Frame;

impl Effect {
    pub(super) fn attach_unlisted(&self, frame: &mut Frame) {
        let size = (frame.machine.screw.diameter_m / 0.04).powi(3);
        let table_kg = frame.machine.table_mass_kg;
        let mut suspend = |freedom: usize, mass: f64, natural_hz: f64, loss: f64| {
            frame.structure.branch(vec![(freedom, 1.0)], Law::suspended(mass, natural_hz, loss));
        };
        match self.kind {
            HoseResonator => suspend(
                frame.table,
                0.03 * self.size * table_kg,
                self.in_band_hz(0, 0.06, 0.5),
                self.scaled(1, 0.03, 0.1),
            ),
            // At one amplitude, dry friction in series with a spring is a spring with a large loss factor.
            FrictionDamper => suspend(
                frame.table,
                0.05 * self.size * table_kg,
                self.in_band_hz(0, 0.05, 0.3),
                self.scaled(1, 0.4, 0.8),
            ),
            RingAbsorber => {
                let inertia = 0.1 * self.size * frame.machine.screw.polar_inertia();
                suspend(frame.ends[1].1, inertia, self.in_band_hz(0, 0.15, 0.7), self.scaled(1, 0.03, 0.08));
            }
            BrakeDisc => {
                let inertia = 0.3 * self.size * frame.machine.rotor_inertia_kg_m2;
                suspend(frame.rotor, inertia, self.in_band_hz(0, 0.08, 0.5), self.scaled(1, 0.03, 0.08));
            }
            MotorThrust => suspend(
                frame.ends[0].0,
                3.0 * size * self.size,
                self.in_band_hz(0, 0.15, 0.8),
                self.scaled(1, 0.02, 0.05),
            ),
            ServoLag => {
                if let Some(hold) = frame.machine.hold {
                    let delay_s = self.log_scaled(0, 5e-4, 2e-3);
                    let law = Law::Servo {
                        stiffness: 0.0,
                        damping: self.size * hold.damping,
                        integral: 0.0,
                        delay_s,
                    };
                    frame.structure.branch(vec![(frame.rotor, 1.0)], law);
                }
            }
            HousingTilt => self.compliant_housing(frame, usize::from(!self.is_left()), size),
            LooseFoot => {
                let natural_hz = self.log_scaled(0, 60.0, 300.0);
                frame.housings[1] = vec![(sprung(frame, 0.4 * table_kg / self.size, natural_hz, 0.025), 1.0)];
            }
            NutYaw => {
                let yaw = sprung(frame, 0.4 * table_kg / self.size, self.in_band_hz(0, 0.1, 0.6), 0.03);
                frame.carrier.push((yaw, 1.0));
            }
            SqueezedFilm => {
                let exponent = if self.is_left() { 0.5 } else { 1.5 };
                let corner: f64 = 2.0 * PI * 60.0;
                let coefficient = 0.02 * self.size * table_kg * corner.powf(2.0 - exponent);
                frame.structure.branch(vec![(frame.table, 1.0)], Law::Power { coefficient, exponent });
            }
            MiddleSupport => {
                if let Some(&(axial, angle)) = frame.extra.first() {
                    let stiffness = 0.1 * self.size * frame.machine.bearing_left.stiffness;
                    frame.structure.branch(
                        vec![(axial, 1.0)],
                        Law::Kelvin { stiffness, damping: stiffness * 3e-5, loss: 0.02 },
                    );
                    let drag = 0.01 * self.size * frame.machine.coupling.stiffness;
                    frame.structure.branch(
                        vec![(angle, 1.0)],
                        Law::Kelvin { stiffness: drag, damping: drag * 1e-4, loss: 0.0 },
                    );
                }
            }
            ScaleFeedback => {
                if let Some(hold) = frame.machine.hold {
                    let share = 0.3 * self.size;
                    let part = |factor: f64| Law::Kelvin {
                        stiffness: factor * hold.stiffness,
                        damping: factor * hold.damping,
                        loss: 0.0,
                    };
                    frame.structure.link(frame.rotor, frame.rotor, part(-share));
                    frame.structure.link(
                        frame.rotor,
                        frame.table,
                        part(share * frame.machine.drive_ratio / frame.machine.ratio_m()),
                    );
                }
            }
            _ => {}
        }
    }

    /// Adds a compliant bearing housing with its own mass.
    fn compliant_housing(&self, frame: &mut Frame, end: usize, size: f64) {
        let housing = frame.structure.freedom();
        let bearing = if end == 0 { frame.machine.bearing_left } else { frame.machine.bearing_right };
        frame.structure.inertia(housing, self.scaled(0, 3.0, 9.0) * size);
        frame.structure.branch(vec![(housing, 1.0)], Law::spring(3.0 * bearing.stiffness / self.size, 0.03));
        frame.housings[end] = vec![(housing, 1.0)];
    }

    /// Returns the location of the effect.
    pub fn place(&self) -> Place {
        let side = if self.is_left() { ["left", "bearing-left"] } else { ["right", "bearing-right"] };
        Place::new(match self.kind {
            RotorHold | ServoLag | BrakeDisc => &["rotor"],
            ScaleFeedback => &["rotor", "table"],
            GuideStiffness | GuideViscous | TableMass | TableRocking | TableRelaxation | HoseResonator
            | FrictionDamper | SqueezedFilm => &["table"],
            BedCompliance => &["bearing-left", "bearing-right", "left", "right"],
            NutFlangeCompliance | NutYaw => &["nut", "table", "screw", "screw-angle"],
            NutStiffnessPosition => &["nut"],
            BearingStiffnessPosition | HousingTilt => &side,
            CouplingInertia => &["left-angle", "coupling"],
            DriveFlexibility => &["coupling", "rotor", "left-angle"],
            ScrewDiameter | ScrewLossFactor => &["screw"],
            ScrewBending => &["screw", "nut", "screw-angle"],
            FrfGain | MeasurementDelay | FrfQuantity => &["measurement"],
            ContactLevel if self.is_left() => &["nut"],
            ContactLevel => &["table"],
            RingAbsorber => &["right-angle", "screw"],
            MiddleSupport if self.is_left() => &["screw", "left", "bearing-left"],
            MiddleSupport => &["screw", "right", "bearing-right"],
            LooseFoot => &["right", "bearing-right"],
            MotorThrust => &["left", "bearing-left"],
        })
    }
}

/// Adds a mass on a spring to ground and returns its degree of freedom.
fn sprung(frame: &mut Frame, mass: f64, natural_hz: f64, loss: f64) -> usize {
    let freedom = frame.structure.freedom();
    frame.structure.inertia(freedom, mass);
    frame.structure.branch(vec![(freedom, 1.0)], Law::spring(mass * (2.0 * PI * natural_hz).powi(2), loss));
    freedom
}
