//! A [`Structure`] with numbers for one operating condition and one set of parameters.

use std::sync::Arc;

use super::beam::Beam;
use super::joint::JointNumbers;
use super::rod::Rod;
use super::structure::{RodModel, Structure};
use machine::{Machine, Operating};

/// The numbers of a machine at one operating condition and one set of parameters.
#[derive(Debug, Clone)]
pub struct AssembledModel {
    pub(super) structure: Arc<Structure>,
    pub(super) rods: Vec<Rod>,
    pub(super) beams: Vec<Beam>,
    pub(super) joints: Vec<JointNumbers>,
    /// Per joint: coordinates and coefficients of the points that move.
    pub(super) joint_points: Vec<Vec<(usize, f64)>>,
    /// Lumped inertia of each coordinate.
    pub(super) inertia: Vec<f64>,
    /// K, C and ηK of everything except rods and relaxing dampers, by slot.
    pub(super) stiffness: Vec<f64>,
    pub(super) damping: Vec<f64>,
    pub(super) loss: Vec<f64>,
    /// Slots whose entries stay real while D is factored.
    pub(super) real: Vec<bool>,
    /// Whether any joint has a loss factor.
    pub(super) has_loss: bool,
    /// Share s of dispersion, common to all loss factors.
    pub(super) dispersion: f64,
    /// Lever arm r of the sensor and of the hammer, per lever of the machine.
    pub(super) levers: Vec<[f64; 2]>,
    /// Decay rate σ of an exponential window (1/s): receptances and their derivatives with parameters are
    /// those at ω − iσ. Modes and slopes with ω are of models without a window.
    pub(super) window_per_s: f64,
}

impl Structure {
    /// Returns an empty model, to be filled by [`AssembledModel::update`].
    pub fn empty_model(self: &Arc<Self>) -> AssembledModel {
        let slots = self.elimination.slots();
        AssembledModel {
            structure: Arc::clone(self),
            rods: vec![
                Rod {
                    stiffness: 0.0,
                    transit_s: 0.0,
                    loss_factor: 0.0,
                    dispersion: 0.0,
                    elements: 0,
                    window_per_s: 0.0
                };
                self.rods.len()
            ],
            beams: Vec::with_capacity(self.beams.len()),
            joints: vec![JointNumbers::default(); self.joints.len()],
            joint_points: self.joints.clone(),
            inertia: vec![0.0; self.size()],
            stiffness: vec![0.0; slots],
            damping: vec![0.0; slots],
            loss: vec![0.0; slots],
            real: vec![false; slots],
            has_loss: false,
            dispersion: 0.0,
            levers: Vec::new(),
            window_per_s: 0.0,
        }
    }
}

impl AssembledModel {
    /// Computes the numbers of a machine. `parameters` are in the machine's order and units. Allocates
    /// nothing.
    pub fn update(&mut self, machine: &Machine, parameters: &[f64], operating: &Operating) {
        let shape = Arc::clone(&self.structure);
        self.stiffness.fill(0.0);
        self.damping.fill(0.0);
        self.loss.fill(0.0);
        self.inertia.fill(0.0);
        self.dispersion = machine.loss_dispersion.at(parameters, operating);
        self.window_per_s = operating.window_per_s;
        for (point, coordinate) in machine.points.iter().zip(&shape.coordinate) {
            if let Some(i) = *coordinate {
                self.inertia[i] += point.inertia.at(parameters, operating);
            }
        }
        for (rod, rod_shape) in self.rods.iter_mut().zip(&shape.rods) {
            let shaft = &machine.shafts[rod_shape.shaft];
            let place = |p| shaft.place_m(p, parameters, operating).unwrap_or(f64::NAN);
            let length_m = place(rod_shape.places.1) - place(rod_shape.places.0);
            let (area_m2, polar_m4) = shaft.section(parameters, operating);
            let density = shaft.density.at(parameters, operating);
            let (modulus, section) = if rod_shape.torsional {
                (shaft.shear_modulus.at(parameters, operating), polar_m4)
            } else {
                (shaft.youngs_modulus.at(parameters, operating), area_m2)
            };
            *rod = Rod {
                stiffness: modulus * section / length_m,
                transit_s: length_m * (density / modulus).sqrt(),
                loss_factor: shaft.loss_factor.at(parameters, operating),
                dispersion: self.dispersion,
                elements: match shape.representation {
                    RodModel::Exact => 0,
                    RodModel::Lumped(elements) => elements.max(1),
                },
                window_per_s: self.window_per_s,
            };
        }
        self.beams.clear();
        self.beams.extend(shape.beams.iter().filter_map(|beam| {
            let shaft = &machine.shafts[beam.shaft];
            let bending = shaft.bending.as_ref()?;
            let at = |value: &machine::Value| value.at(parameters, operating);
            let (area_m2, polar_m4) = shaft.section(parameters, operating);
            Some(Beam {
                // The second moment of a round section is half of its polar one.
                rigidity: at(&shaft.youngs_modulus) * 0.5 * polar_m4,
                mass_per_length: at(&shaft.density) * area_m2,
                length: at(&shaft.length),
                nut: shaft.nut_m(parameters, operating).unwrap_or(f64::NAN),
                clamping: bending.clamping.each_ref().map(at),
                arms: [at(&bending.misalignment), at(&bending.eccentricity)],
                lateral_stiffness: at(&bending.lateral_stiffness),
                loss_factor: at(&bending.loss_factor),
                dispersion: self.dispersion,
                window_per_s: self.window_per_s,
            })
        }));
        self.update_joints(machine, parameters, operating);
        self.mark_real_slots();
        self.has_loss = self.loss.iter().any(|h| *h != 0.0);
        self.levers.clear();
        self.levers.extend(
            machine
                .chain
                .levers
                .iter()
                .map(|l| [&l.sensor_arm, &l.hammer_arm].map(|r| r.at(parameters, operating))),
        );
    }

    /// Computes the numbers of the joints and adds them to the matrices.
    fn update_joints(&mut self, machine: &Machine, parameters: &[f64], operating: &Operating) {
        let shape = Arc::clone(&self.structure);
        let pattern = &shape.elimination;
        let share_s = machine.stiffness_proportional_damping_s;
        let described = shape.joints.iter().zip(&shape.screws);
        let all = machine.joints.iter().zip(&mut self.joints).zip(&mut self.joint_points).zip(described);
        for (((joint, numbers), on), (described, screw)) in all {
            let growth = joint.lead_error.growth.at(parameters, operating);
            if growth != numbers.lead_growth {
                for ((own, (_, described)), (_, lead)) in on.iter_mut().zip(described).zip(screw) {
                    own.1 = described + growth * lead;
                }
            }
            let stiffness = joint.stiffness.at(parameters, operating);
            *numbers = JointNumbers {
                stiffness,
                damping: joint.damping.at(parameters, operating) + share_s * stiffness,
                loss_factor: joint.loss_factor.at(parameters, operating),
                dispersion: self.dispersion,
                integral_rate: joint.integral_rate.at(parameters, operating),
                relaxation_stiffness: joint
                    .relaxation_stiffness
                    .as_ref()
                    .map(|k| k.at(parameters, operating)),
                lead_growth: growth,
            };
            for (at, &(i, a)) in on.iter().enumerate() {
                for &(j, b) in &on[..=at] {
                    let slot = pattern.entry(i, j);
                    self.stiffness[slot] += a * b * numbers.stiffness;
                    self.loss[slot] += a * b * numbers.stiffness * numbers.loss_factor;
                    if numbers.relaxation_stiffness.is_none() {
                        self.damping[slot] += a * b * numbers.damping;
                    }
                }
            }
        }
    }

    /// Marks the slots whose entries stay real during factorisation: those without damping and loss, and
    /// without fill-in from such entries.
    fn mark_real_slots(&mut self) {
        let shape = &self.structure;
        for (real, (c, h)) in self.real.iter_mut().zip(self.damping.iter().zip(&self.loss)) {
            *real = *c == 0.0 && *h == 0.0;
        }
        let is_windowed = self.window_per_s != 0.0;
        for (slot, m) in shape.diagonal.iter().zip(&self.inertia) {
            self.real[*slot] &= !is_windowed || *m == 0.0;
        }
        for (_, slots) in
            self.rods.iter().zip(&shape.rod_slots).filter(|(rod, _)| is_windowed || rod.loss_factor != 0.0)
        {
            slots.iter().flatten().for_each(|slot| self.real[*slot] = false);
        }
        for (_, shape) in
            self.beams.iter().zip(&shape.beams).filter(|(beam, _)| is_windowed || beam.loss_factor != 0.0)
        {
            self.real[self.structure.diagonal[shape.coordinate]] = false;
        }
        for (_, on) in
            self.joints.iter().zip(&self.joint_points).filter(|(joint, _)| joint.has_extra_dynamics())
        {
            for (at, (i, _)) in on.iter().enumerate() {
                on[..=at].iter().for_each(|(j, _)| self.real[shape.elimination.entry(*i, *j)] = false);
            }
        }
        shape.elimination.propagate_complex(&mut self.real);
    }

    /// Whether a rod has the same numbers in this model and in another model of the same structure.
    pub fn has_rod_of(&self, other: &AssembledModel, rod: usize) -> bool {
        self.rods[rod] == other.rods[rod]
    }
}
