//! Effects in the library of the diagnosis that add parts to the structure.

use std::f64::consts::PI;

use super::Effect;
use super::EffectKind::*;
use crate::element::beam::Beam;
use crate::element::law::Law;
use crate::machine::assembly::{Frame, difference};

impl Effect {
    /// Adds the parts of the effect. The machine's joints follow later, between the motions that the frame
    /// then contains.
    pub fn attach(&self, frame: &mut Frame, level: f64) {
        let table = vec![(frame.table, 1.0)];
        // A part that is clamped on, or one that is missing.
        let added = |mass: f64, loss: f64| {
            if mass > 0.0 { Law::suspended(mass, 6000.0, loss) } else { Law::Mass(mass) }
        };
        match self.kind {
            GuideStiffness => {
                let stiffness = self.guide_stiffness(frame.machine.table_mass_kg);
                frame.structure.branch(table.clone(), Law::spring(0.6 * stiffness, 0.03));
                frame.structure.branch(table, Law::spring(0.4 * stiffness, 0.06));
            }
            GuideViscous => {
                let damping = self.guide_damping(frame.machine.table_mass_kg);
                for wiper in 0..4 {
                    let time_s = 1e-5 * f64::from(wiper + 1);
                    frame
                        .structure
                        .branch(table.clone(), Law::Maxwell { stiffness: 0.25 * damping / time_s, time_s });
                }
            }
            TableMass => {
                frame.structure.branch(table, added(self.added_mass(frame.machine.table_mass_kg), 0.02));
            }
            TableRelaxation => {
                let stiffness = self.relaxing_stiffness(frame.machine.table_mass_kg);
                let corner_hz = self.log_scaled(1, 8.0, 40.0);
                for (share, factor) in [(0.5, 1.0), (0.3, 4.0), (0.2, 16.0)] {
                    let time_s = 1.0 / (2.0 * PI * corner_hz * factor);
                    frame
                        .structure
                        .branch(table.clone(), Law::Maxwell { stiffness: stiffness * share, time_s });
                }
            }
            ContactLevel if !self.is_left() => {
                let stiffness =
                    self.guide_stiffness(frame.machine.table_mass_kg) * 2.0 / (1.0 + level.powf(1.5));
                frame.structure.branch(table, Law::spring(stiffness, 0.05));
            }
            BedCompliance => self.bed(frame),
            NutFlangeCompliance => self.flange(frame),
            CouplingInertia => {
                frame.structure.branch(
                    vec![(frame.ends[0].1, 1.0)],
                    added(self.ring_inertia(frame.machine.hub_inertia_kg_m2), 0.01),
                );
            }
            DriveFlexibility => self.intermediate_stage(frame),
            TableRocking => self.rocking(frame),
            ScrewBending => self.bending(frame),
            _ => self.attach_unlisted(frame),
        }
    }

    /// Adds a bed on its mounts: it shifts and pitches, and the bearings stand above its centre of mass.
    fn bed(&self, frame: &mut Frame) {
        let bed = self.bed_numbers(frame.machine.table_mass_kg);
        let [shift, pitch] = [frame.structure.freedom(), frame.structure.freedom()];
        frame.structure.inertia(shift, bed.mass_kg);
        frame.structure.inertia(pitch, bed.mass_kg * bed.radius_m.powi(2));
        let stiffness = bed.mass_kg * (2.0 * PI * bed.shift_hz).powi(2);
        frame
            .structure
            .branch(vec![(shift, 1.0), (pitch, -0.5 * bed.height_m)], Law::spring(stiffness, bed.loss));
        let stiffness = bed.mass_kg * (2.0 * PI * bed.pitch_hz).powi(2) / 2.0;
        for arm in [bed.radius_m, -bed.radius_m] {
            frame.structure.branch(vec![(pitch, arm)], Law::spring(stiffness, bed.loss));
        }
        let housing = vec![(shift, 1.0), (pitch, bed.height_m)];
        frame.housings = [housing.clone(), housing];
    }

    /// Adds the compliance between nut body and flange: part of the table mass moves with the nut.
    fn flange(&self, frame: &mut Frame) {
        let body = frame.structure.freedom();
        let mass = self.nut_mass(frame.machine.table_mass_kg);
        frame.machine.table_mass_kg -= mass;
        frame.structure.inertia(body, mass);
        let stiffness = self.flange_stiffness(frame.machine.nut.joint.stiffness);
        let law = Law::Kelvin { stiffness, damping: 0.02 * (stiffness * mass).sqrt(), loss: 0.01 };
        frame.structure.branch(difference(&frame.carrier, &[(body, 1.0)]), law);
        frame.carrier = vec![(body, 1.0)];
    }

    /// Adds a stage between rotor and coupling; its inertia is part of the rotor inertia.
    fn intermediate_stage(&self, frame: &mut Frame) {
        let stage = frame.structure.freedom();
        let inertia = self.stage_inertia(frame.machine.rotor_inertia_kg_m2);
        frame.machine.rotor_inertia_kg_m2 -= inertia;
        frame.structure.inertia(stage, inertia);
        let stiffness = self.stage_stiffness(frame.machine.coupling.stiffness);
        frame.structure.branch(vec![(frame.rotor, 1.0), (stage, -1.0)], Law::spring(stiffness, 0.02));
        frame.driver = vec![(stage, 1.0)];
    }

    /// Adds a rigid table on four carriages: shift, heave and pitch, with hammer, sensor and nut at different
    /// heights.
    fn rocking(&self, frame: &mut Frame) {
        let rock = self.rocking_numbers(frame.machine.table_mass_kg);
        let mass = frame.machine.table_mass_kg;
        let [heave, pitch] = [frame.structure.freedom(), frame.structure.freedom()];
        frame.structure.inertia(heave, mass);
        frame.structure.inertia(pitch, mass * rock.radius_m.powi(2));
        let arm = 1.2 * rock.radius_m;
        let carriage = mass * rock.radius_m.powi(2) * (2.0 * PI * rock.pitch_hz).powi(2) / (4.0 * arm * arm);
        for (side, uneven) in [(1.0, 1.0 + rock.uneven), (-1.0, 1.0 - rock.uneven)] {
            for _row in 0..2 {
                frame.structure.branch(
                    vec![(heave, 1.0), (pitch, side * arm)],
                    Law::spring(carriage * uneven, rock.loss),
                );
            }
        }
        frame.hit.push((pitch, rock.hammer_m));
        frame.sensor.push((pitch, rock.sensor_m));
        frame.carrier.push((pitch, rock.nut_m));
    }

    /// Adds bending of the screw: a beam on its bearings with the nut between, whose contacts are loaded off
    /// the axis.
    fn bending(&self, frame: &mut Frame) {
        let screw = frame.machine.screw;
        let [left, middle, right] =
            std::array::from_fn(|_| (frame.structure.freedom(), frame.structure.freedom()));
        let rigidity = screw.youngs_modulus_pa * 0.5 * screw.polar(screw.diameter_m);
        let mass_per_length = screw.density_kg_m3 * screw.area(screw.diameter_m);
        let spans = [(left, middle, frame.nut_m), (middle, right, screw.length_m - frame.nut_m)];
        for (start, end, length_m) in spans {
            let beam = Beam { rigidity, mass_per_length, element_m: length_m / 32.0, doublings: 5 };
            frame.structure.beam([start.0, start.1, end.0, end.1], beam);
        }
        let support = 3.0 * frame.machine.bearing_left.stiffness;
        for (end, clamping) in [(left, self.scaled(1, 0.0, 20.0)), (right, self.scaled(2, 0.0, 4.0))] {
            frame.structure.branch(vec![(end.0, 1.0)], Law::spring(support, 0.02));
            frame
                .structure
                .branch(vec![(end.1, 1.0)], Law::spring(clamping * rigidity / screw.length_m, 0.02));
        }
        frame.structure.inertia(middle.0, frame.machine.nut.screw_mass_kg);
        frame
            .structure
            .branch(vec![(middle.0, 1.0)], Law::spring(self.log_scaled(3, 0.005, 0.1) * support, 0.02));
        let (across, slope) = self.bending_numbers(screw.diameter_m);
        frame.lateral = vec![(middle.0, across), (middle.1, slope)];
    }
}
