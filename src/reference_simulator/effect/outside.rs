//! Effects outside the library of the diagnosis, and the location of each effect.

use std::f64::consts::PI;

use super::{Effect, EffectKind, Place};
use crate::element::law::Law;
use crate::machine::assembly::Frame;

impl Effect {
    pub(super) fn attach_unlisted(&self, frame: &mut Frame) {
        let size = (frame.machine.screw.diameter_m / 0.04).powi(3);
        let suspended =
            |mass: f64, hz: f64, loss: f64| Law::Suspended { mass, stiffness: mass * (2.0 * PI * hz).powi(2), damping: 0.0, loss };
        match self.kind {
            EffectKind::HoseResonator => {
                let law =
                    suspended(0.03 * self.size * frame.machine.table_mass_kg, self.in_band_hz(0, 0.06, 0.5), self.scaled(1, 0.03, 0.1));
                frame.structure.branch(vec![(frame.table, 1.0)], law);
            }
            EffectKind::FrictionDamper => {
                // At one amplitude, dry friction in series with a spring is a spring with a large loss factor.
                let law =
                    suspended(0.05 * self.size * frame.machine.table_mass_kg, self.in_band_hz(0, 0.05, 0.3), self.scaled(1, 0.4, 0.8));
                frame.structure.branch(vec![(frame.table, 1.0)], law);
            }
            EffectKind::ServoLag => {
                if let Some(hold) = frame.machine.hold {
                    let delay_s = self.log_scaled(0, 5e-4, 2e-3);
                    let law = Law::Servo { stiffness: 0.0, damping: self.size * hold.damping, integral: 0.0, delay_s };
                    frame.structure.branch(vec![(frame.rotor, 1.0)], law);
                }
            }
            EffectKind::HousingTilt => self.compliant_housing(frame, usize::from(!self.is_left()), size),
            EffectKind::LooseFoot => {
                let foot = frame.structure.freedom();
                let mass = 0.4 * frame.machine.table_mass_kg / self.size;
                let stiffness = mass * (2.0 * PI * self.log_scaled(0, 60.0, 300.0)).powi(2);
                frame.structure.inertia(foot, mass);
                frame.structure.branch(vec![(foot, 1.0)], Law::spring(stiffness, 0.025));
                frame.housings[1] = vec![(foot, 1.0)];
            }
            EffectKind::RingAbsorber => {
                let law = suspended(
                    0.1 * self.size * frame.machine.screw.polar_inertia(),
                    self.in_band_hz(0, 0.15, 0.7),
                    self.scaled(1, 0.03, 0.08),
                );
                frame.structure.branch(vec![(frame.ends[1].1, 1.0)], law);
            }
            EffectKind::NutYaw => {
                let yaw = frame.structure.freedom();
                let mass = 0.4 * frame.machine.table_mass_kg / self.size;
                frame.structure.inertia(yaw, mass);
                let stiffness = mass * (2.0 * PI * self.in_band_hz(0, 0.1, 0.6)).powi(2);
                frame.structure.branch(vec![(yaw, 1.0)], Law::spring(stiffness, 0.03));
                frame.carrier.push((yaw, 1.0));
            }
            EffectKind::SqueezedFilm => {
                let exponent = if self.is_left() { 0.5 } else { 1.5 };
                let corner: f64 = 2.0 * PI * 60.0;
                let coefficient = 0.02 * self.size * frame.machine.table_mass_kg * corner.powf(2.0 - exponent);
                frame.structure.branch(vec![(frame.table, 1.0)], Law::Power { coefficient, exponent });
            }
            EffectKind::MiddleSupport => {
                if let Some(&(axial, angle)) = frame.extra.first() {
                    let stiffness = 0.1 * self.size * frame.machine.bearing_left.stiffness;
                    frame.structure.branch(vec![(axial, 1.0)], Law::Kelvin { stiffness, damping: stiffness * 3e-5, loss: 0.02 });
                    let drag = 0.01 * self.size * frame.machine.coupling.stiffness;
                    frame.structure.branch(vec![(angle, 1.0)], Law::Kelvin { stiffness: drag, damping: drag * 1e-4, loss: 0.0 });
                }
            }
            EffectKind::BrakeDisc => {
                let law = suspended(
                    0.3 * self.size * frame.machine.rotor_inertia_kg_m2,
                    self.in_band_hz(0, 0.08, 0.5),
                    self.scaled(1, 0.03, 0.08),
                );
                frame.structure.branch(vec![(frame.rotor, 1.0)], law);
            }
            EffectKind::ScaleFeedback => {
                if let Some(hold) = frame.machine.hold {
                    let share = 0.3 * self.size;
                    let part = |factor: f64| Law::Kelvin { stiffness: factor * hold.stiffness, damping: factor * hold.damping, loss: 0.0 };
                    frame.structure.link(frame.rotor, frame.rotor, part(-share));
                    frame.structure.link(frame.rotor, frame.table, part(share * frame.machine.drive_ratio / frame.machine.ratio_m()));
                }
            }
            EffectKind::MotorThrust => {
                let law = suspended(3.0 * size * self.size, self.in_band_hz(0, 0.15, 0.8), self.scaled(1, 0.02, 0.05));
                frame.structure.branch(vec![(frame.ends[0].0, 1.0)], law);
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
        let names: &[&str] = match self.kind {
            EffectKind::RotorHold | EffectKind::ServoLag | EffectKind::BrakeDisc => &["rotor"],
            EffectKind::ScaleFeedback => &["rotor", "table"],
            EffectKind::GuideStiffness
            | EffectKind::GuideViscous
            | EffectKind::TableMass
            | EffectKind::TableRocking
            | EffectKind::TableRelaxation
            | EffectKind::HoseResonator
            | EffectKind::FrictionDamper
            | EffectKind::SqueezedFilm => &["table"],
            EffectKind::BedCompliance => &["bearing-left", "bearing-right", "left", "right"],
            EffectKind::NutFlangeCompliance | EffectKind::NutYaw => &["nut", "table", "screw", "screw-angle"],
            EffectKind::NutStiffnessPosition => &["nut"],
            EffectKind::BearingStiffnessPosition | EffectKind::HousingTilt => &side,
            EffectKind::CouplingInertia => &["left-angle", "coupling"],
            EffectKind::DriveFlexibility => &["coupling", "rotor", "left-angle"],
            EffectKind::ScrewDiameter | EffectKind::ScrewLossFactor => &["screw"],
            EffectKind::ScrewBending => &["screw", "nut", "screw-angle"],
            EffectKind::FrfGain | EffectKind::MeasurementDelay | EffectKind::FrfQuantity => &["measurement"],
            EffectKind::ContactLevel if self.is_left() => &["nut"],
            EffectKind::ContactLevel => &["table"],
            EffectKind::RingAbsorber => &["right-angle", "screw"],
            EffectKind::MiddleSupport if self.is_left() => &["screw", "left", "bearing-left"],
            EffectKind::MiddleSupport => &["screw", "right", "bearing-right"],
            EffectKind::LooseFoot => &["right", "bearing-right"],
            EffectKind::MotorThrust => &["left", "bearing-left"],
        };
        Place { interface: names[0].to_owned(), accepted: names.iter().map(|name| (*name).to_owned()).collect() }
    }
}
