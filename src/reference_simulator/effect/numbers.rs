//! Physical values of effects, derived from size, shape and machine.

use std::collections::BTreeMap;

use super::Effect;
use super::EffectKind::*;
use crate::machine::number::{Hold, Machine};

/// A bed that shifts and pitches.
pub(super) struct Bed {
    pub mass_kg: f64,
    pub radius_m: f64,
    pub height_m: f64,
    pub shift_hz: f64,
    pub pitch_hz: f64,
    pub loss: f64,
}

/// A table that pitches on its carriages.
pub(super) struct Rocking {
    pub radius_m: f64,
    pub pitch_hz: f64,
    pub uneven: f64,
    pub loss: f64,
    pub hammer_m: f64,
    pub sensor_m: f64,
    pub nut_m: f64,
}

impl Effect {
    pub(super) fn guide_stiffness(&self, table_kg: f64) -> f64 {
        self.size * table_kg * (2.0 * std::f64::consts::PI * self.scaled(0, 6.0, 14.0)).powi(2)
    }

    pub(super) fn guide_damping(&self, table_kg: f64) -> f64 {
        self.size * table_kg * self.scaled(0, 3.0, 8.0)
    }

    pub(super) fn relaxing_stiffness(&self, table_kg: f64) -> f64 {
        self.size * table_kg * (2.0 * std::f64::consts::PI * self.scaled(0, 8.0, 20.0)).powi(2)
    }

    pub(super) fn added_mass(&self, table_kg: f64) -> f64 {
        (0.05 * self.size * self.sign).max(-0.4) * table_kg
    }

    pub(super) fn ring_inertia(&self, hub_kg_m2: f64) -> f64 {
        0.5 * self.size * self.sign * hub_kg_m2
    }

    pub(super) fn nut_mass(&self, table_kg: f64) -> f64 {
        self.scaled(0, 0.03, 0.08) * table_kg
    }

    pub(super) fn flange_stiffness(&self, nut_n_per_m: f64) -> f64 {
        4.0 * nut_n_per_m / self.size
    }

    pub(super) fn stage_inertia(&self, rotor_kg_m2: f64) -> f64 {
        self.scaled(0, 0.15, 0.5) * rotor_kg_m2
    }

    pub(super) fn stage_stiffness(&self, coupling: f64) -> f64 {
        3.0 * coupling / self.size
    }

    pub(super) fn bed_numbers(&self, table_kg: f64) -> Bed {
        let mass_kg = 3.0 * table_kg / self.size;
        let radius_m = self.scaled(0, 0.3, 0.5) * (table_kg / 100.0).cbrt();
        let height_m = radius_m * self.scaled(1, 0.6, 1.1);
        Bed {
            mass_kg,
            radius_m,
            height_m,
            shift_hz: self.log_scaled(2, 18.0, 60.0),
            pitch_hz: self.log_scaled(3, 70.0, 220.0),
            loss: self.scaled(4, 0.02, 0.05),
        }
    }

    pub(super) fn rocking_numbers(&self, table_kg: f64) -> Rocking {
        let radius_m = 0.3 * (table_kg / 272.0).cbrt();
        let height = radius_m * self.size.sqrt();
        Rocking {
            radius_m,
            pitch_hz: self.in_band_hz(0, 0.06, 0.35),
            uneven: self.scaled(1, -0.15, 0.15),
            loss: self.scaled(2, 0.015, 0.05),
            hammer_m: height * self.scaled(3, 0.25, 0.5),
            sensor_m: height * self.scaled(4, 0.25, 0.5) * self.sign,
            nut_m: -height * self.scaled(5, 0.1, 0.4),
        }
    }

    /// Returns deflection and slope of the screw at a contact, as shares.
    pub(super) fn bending_numbers(&self, diameter_m: f64) -> (f64, f64) {
        let root = self.size.sqrt();
        (0.15 * root * self.scaled(4, 0.5, 1.0), 0.5 * root * diameter_m * self.scaled(0, 0.5, 1.5))
    }

    pub(super) fn support_m(&self, machine: &Machine) -> f64 {
        if self.is_left() {
            0.55 * self.stroke_m[0]
        } else {
            0.5 * (self.stroke_m[1] + machine.screw.length_m)
        }
    }

    /// Returns the physical values for the label, in SI units.
    pub fn values(&self, machine: &Machine) -> BTreeMap<String, f64> {
        let table_kg = machine.table_mass_kg;
        let values = match self.kind {
            RotorHold => {
                let Hold { stiffness, damping, integral, .. } = self.hold(machine);
                vec![
                    ("stiffness_nm_per_rad", stiffness),
                    ("damping_nms_per_rad", damping),
                    ("integral_nm_per_rad_s", integral),
                ]
            }
            GuideStiffness => vec![("stiffness_n_per_m", self.guide_stiffness(table_kg))],
            GuideViscous => vec![("damping_ns_per_m", self.guide_damping(table_kg))],
            TableMass => vec![("mass_kg", self.added_mass(table_kg))],
            BedCompliance => {
                let bed = self.bed_numbers(table_kg);
                vec![("mass_kg", bed.mass_kg), ("shift_hz", bed.shift_hz), ("pitch_hz", bed.pitch_hz)]
            }
            NutFlangeCompliance => {
                vec![
                    ("mass_kg", self.nut_mass(table_kg)),
                    ("stiffness_n_per_m", self.flange_stiffness(machine.nut.joint.stiffness)),
                ]
            }
            NutStiffnessPosition => {
                let middle_m =
                    self.stroke_m[0] + self.scaled(0, 0.25, 0.75) * (self.stroke_m[1] - self.stroke_m[0]);
                vec![("least_or_largest_factor", self.preload_factor(middle_m))]
            }
            BearingStiffnessPosition => {
                vec![
                    ("log_factor_over_stroke", 0.5 * self.size * self.sign * 2.5f64.tanh()),
                    ("left", f64::from(u8::from(self.is_left()))),
                ]
            }
            CouplingInertia => vec![("inertia_kg_m2", self.ring_inertia(machine.hub_inertia_kg_m2))],
            DriveFlexibility => vec![
                ("stiffness_nm_per_rad", self.stage_stiffness(machine.coupling.stiffness)),
                ("inertia_kg_m2", self.stage_inertia(machine.rotor_inertia_kg_m2)),
            ],
            ScrewDiameter => {
                let mut changed = machine.clone();
                self.adjust(&mut changed, self.stroke_m[0], 1.0);
                vec![("diameter_m", changed.screw.diameter_m), ("bore_m", changed.screw.bore_m)]
            }
            ScrewLossFactor => vec![("loss_factor", machine.screw.loss + 0.02 * self.size)],
            TableRocking => vec![("pitch_hz", self.rocking_numbers(table_kg).pitch_hz)],
            ScrewBending => {
                let (misalignment_rad, eccentricity_m) = self.bending_numbers(machine.screw.diameter_m);
                vec![("misalignment_rad", misalignment_rad), ("eccentricity_m", eccentricity_m)]
            }
            TableRelaxation => {
                vec![
                    ("stiffness_n_per_m", self.relaxing_stiffness(table_kg)),
                    ("corner_hz", self.log_scaled(1, 8.0, 40.0)),
                ]
            }
            FrfGain => vec![("gain", self.gain())],
            MeasurementDelay => vec![("delay_s", self.delay_s())],
            _ => Vec::new(),
        };
        let size = ("size", self.size * self.sign);
        values.into_iter().chain([size]).map(|(name, value)| (name.to_owned(), value)).collect()
    }
}
