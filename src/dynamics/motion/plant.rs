//! A machine as equations of motion: matrices on the coordinates with inertia, and the force elements between
//! them.

use nalgebra::DMatrix;

use super::force_element::{
    AppliedLoad, Bristle, Combination, FrictionElement, Gap, Lead, Relaxing, Winding, apply_force,
};
use super::{MotionError, SimulationSettings};
use crate::law::{FrictionLaw, TravelWave};
use crate::model::{Matrices, matrices};
use machine::{Drive, Encoder, Joint, Machine, PointMotion, Value};

/// An encoder with the reading travel·q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    pub at: usize,
    pub travel: f64,
    pub step: f64,
}

impl Reading {
    /// Returns the reading, rounded to the encoder's step.
    pub fn of(&self, q: &[f64]) -> f64 {
        let x = self.travel * q[self.at];
        if self.step > 0.0 { (x / self.step).round() * self.step } else { x }
    }
}

/// The equations of motion of a machine: M·q̈ + C·q̇ + K·q = forces of its elements and its drive.
#[derive(Debug, Clone)]
pub struct Plant {
    /// Number of coordinates.
    pub size: usize,
    /// Number of states: q, q̇, bristles, relaxing forces and currents.
    pub states: usize,
    pub names: Vec<String>,
    pub mass: Vec<f64>,
    /// Stored by rows.
    pub damping: Vec<f64>,
    pub stiffness: Vec<f64>,
    /// K with every backlash closed, for the equilibrium at the start.
    pub closed: DMatrix<f64>,
    pub frictions: Vec<FrictionElement>,
    pub gaps: Vec<Gap>,
    pub leads: Vec<Lead>,
    pub relaxing: Vec<Relaxing>,
    /// Constant force on each coordinate.
    pub constant: Vec<f64>,
    pub drive: usize,
    pub winding: Option<Winding>,
    pub ripple: TravelWave,
    pub position: Reading,
    pub velocity: Reading,
    /// Points of the machine that are coordinates: index of the point, index of the coordinate.
    pub points: Vec<(usize, usize)>,
    pub warnings: Vec<String>,
}

impl Plant {
    /// Builds the plant of a machine with the given parameters.
    ///
    /// # Errors  no drive; friction, backlash, drive or encoder at a point without inertia; two frictions on
    ///   one motion; an unconstrained point.
    pub fn new(
        machine: &Machine,
        values: &[f64],
        settings: &SimulationSettings,
    ) -> Result<Self, MotionError> {
        let drive = machine.drive.as_ref().ok_or(MotionError::NoDrive)?;
        let at = |value: &Value| value.at(values, &settings.operating);
        let matrices_of =
            |machine: &Machine| matrices(machine, values, &settings.operating, settings.lumps)?.condensed();
        let (open, closed) = linear_machines(machine, &at);
        let closed_matrices = matrices_of(&closed)?;
        let matrices = matrices_of(&open)?;
        let mut plant = Plant::empty(&matrices, closed_matrices, drive);
        plant.points = machine
            .points
            .iter()
            .enumerate()
            .filter_map(|(i, p)| Some((i, plant.coordinate(&p.name)?)))
            .collect();
        for (joint, expanded) in machine.joints.iter().zip(&closed.joints) {
            plant.add_joint(machine, joint, expanded, &at)?;
        }
        plant.drive = plant.point(machine, drive.on, "the drive")?;
        let reading = |plant: &Plant, encoder: &Encoder, part: &str| {
            let at_point = plant.point(machine, encoder.at, part)?;
            Ok::<_, MotionError>(Reading { at: at_point, travel: encoder.travel, step: at(&encoder.step) })
        };
        plant.position = reading(&plant, &drive.position.encoder, "the position loop's encoder")?;
        plant.velocity = reading(&plant, &drive.velocity.encoder, "the velocity loop's encoder")?;
        plant.ripple = TravelWave::new(&drive.ripple, &at);
        if let Some(motor) = &drive.motor {
            let q = plant.state();
            plant.winding = Some(Winding {
                q,
                d: motor.pole_pairs.map(|_| plant.state()),
                resistance: at(&motor.resistance_ohm),
                inductance_q: at(&motor.inductance_h),
                inductance_d: at(&motor.inductance_d_h),
                constant: at(&drive.constant) * at(&drive.force_factor),
                pairs: motor.pole_pairs.map_or(0.0, f64::from),
            });
        }
        if machine.joints.iter().any(|j| at(&j.loss_factor) > 0.0)
            || machine.shafts.iter().any(|s| at(&s.loss_factor) > 0.0)
        {
            plant
                .warnings
                .push("loss factors have no time-domain form and are ignored; add viscous dampers where damping is needed".into());
        }
        Ok(plant)
    }

    fn empty(matrices: &Matrices, closed_matrices: Matrices, drive: &Drive) -> Self {
        let size = matrices.names.len();
        let rows = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
        let nowhere = Reading { at: 0, travel: 1.0, step: 0.0 };
        Plant {
            size,
            states: 2 * size,
            names: matrices.names.clone(),
            mass: matrices.mass.diagonal().as_slice().to_vec(),
            damping: rows(&matrices.damping),
            stiffness: rows(&matrices.stiffness),
            closed: closed_matrices.stiffness,
            frictions: Vec::new(),
            gaps: Vec::new(),
            leads: Vec::new(),
            relaxing: Vec::new(),
            constant: vec![0.0; size],
            drive: drive.on,
            winding: None,
            ripple: TravelWave::default(),
            position: nowhere,
            velocity: nowhere,
            points: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn coordinate(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    fn point(&self, machine: &Machine, point: usize, part: &str) -> Result<usize, MotionError> {
        let name = &machine.points[point].name;
        self.coordinate(name).ok_or_else(|| MotionError::Massless { part: part.into(), point: name.clone() })
    }

    /// Returns the configuration key of the part to which a state belongs.
    pub fn key_of_state(&self, state: usize) -> String {
        if let Some(friction) = self.frictions.iter().find(|f| f.bristle.is_some_and(|b| b.at == state)) {
            return format!("joint.{}.friction.presliding_stiffness", friction.name);
        }
        match self.names.get(state % self.size.max(1)).filter(|_| state < 2 * self.size) {
            Some(point) => format!("point.{point}"),
            None if self.winding.is_some_and(|w| w.q == state || w.d == Some(state)) => {
                "drive.motor.inductance_h".into()
            }
            None => "relaxation_stiffness".into(),
        }
    }

    fn along(&self, machine: &Machine, joint: &Joint) -> Result<Combination, MotionError> {
        let moving = joint.on.iter().filter(|(p, _)| !machine.points[*p].fixed);
        moving.map(|&(p, c)| Ok((self.point(machine, p, &format!("joint «{}»", joint.name))?, c))).collect()
    }

    fn state(&mut self) -> usize {
        self.states += 1;
        self.states - 1
    }

    /// Adds the elements of a joint that are not part of the matrices. `expanded` is the joint with the
    /// thermal expansion of its lead.
    fn add_joint(
        &mut self,
        machine: &Machine,
        joint: &Joint,
        expanded: &Joint,
        at: &impl Fn(&Value) -> f64,
    ) -> Result<(), MotionError> {
        let (stiffness, damping) = (
            at(&joint.stiffness),
            at(&joint.damping) + machine.stiffness_proportional_damping_s * at(&joint.stiffness),
        );
        let (half, error) = (0.5 * at(&joint.gap), TravelWave::new(&joint.lead_error.wave, at));
        if half > 0.0 {
            if joint.relaxation_stiffness.is_some() {
                let fault = format!(
                    "joint «{}» has backlash and a relaxing damper; describe them as two joints",
                    joint.name
                );
                return Err(MotionError::Input(fault));
            }
            let travel = if error.is_flat() { 0 } else { self.travel(machine, expanded)? };
            let along = self.along(machine, expanded)?;
            self.gaps.push(Gap {
                name: joint.name.clone(),
                along,
                half,
                stiffness,
                damping,
                travel,
                wave: error,
            });
        } else if !error.is_flat() {
            let travel = self.travel(machine, expanded)?;
            let along = self.along(machine, expanded)?;
            self.leads.push(Lead { along, travel, stiffness, damping, wave: error });
        }
        if let Some(series) = joint.relaxation_stiffness.as_ref().filter(|_| at(&joint.damping) > 0.0) {
            let along = self.along(machine, expanded)?;
            let at_state = self.state();
            self.relaxing.push(Relaxing {
                along,
                at: at_state,
                stiffness: at(series),
                damping: at(&joint.damping),
            });
        }
        self.add_friction(machine, joint, at)
    }

    /// Returns the coordinate along which a joint's lead error varies: its first translation.
    fn travel(&self, machine: &Machine, joint: &Joint) -> Result<usize, MotionError> {
        let travel = joint
            .on
            .iter()
            .find(|(p, _)| machine.points[*p].motion == PointMotion::Translation)
            .map(|(p, _)| *p);
        let travel = travel.ok_or_else(|| {
            MotionError::Input(format!(
                "joint «{}» has a lead error, but connects no point that moves linearly; leave lead_error out",
                joint.name
            ))
        })?;
        self.point(machine, travel, &format!("joint «{}»", joint.name))
    }

    fn add_friction(
        &mut self,
        machine: &Machine,
        joint: &Joint,
        at: &impl Fn(&Value) -> f64,
    ) -> Result<(), MotionError> {
        let f = &joint.friction;
        let law = FrictionLaw::new(f, at);
        let (offset, stiffness, damping) = (law.offset, law.stiffness, law.damping);
        let element = FrictionElement {
            name: joint.name.clone(),
            along: Vec::new(),
            law,
            load: AppliedLoad::Drive,
            bristle: None,
        };
        let has_friction = !element.is_level() || element.law.coulomb != 0.0 || element.law.asymmetry != 0.0;
        if !has_friction && offset == 0.0 {
            return Ok(());
        }
        let along = self.along(machine, joint)?;
        apply_force(&along, offset, &mut self.constant);
        if !has_friction {
            return Ok(());
        }
        if let Some(other) = self.frictions.iter().find(|r| r.along == along) {
            let fault = format!(
                "joints «{}» and «{}» have friction on the same motion; describe one friction there",
                other.name, joint.name
            );
            return Err(MotionError::Input(fault));
        }
        let load = match f.load_of.filter(|_| element.law.load_share > 0.0) {
            None => AppliedLoad::Drive,
            Some(index) => {
                let of = &machine.joints[index];
                let (k, d) = (
                    at(&of.stiffness),
                    at(&of.damping) + machine.stiffness_proportional_damping_s * at(&of.stiffness),
                );
                AppliedLoad::Joint(self.along(machine, of)?, k, d, 0.5 * at(&of.gap))
            }
        };
        let bristle = (stiffness > 0.0).then(|| Bristle { at: self.state(), stiffness, damping });
        self.frictions.push(FrictionElement { along, load, bristle, ..element });
        Ok(())
    }
}

/// Returns the machine without the elements that its matrices cannot represent (relaxing dampers, open
/// backlash), and the machine with every backlash closed. The coefficients of both contain the relative
/// deviation of the lead.
fn linear_machines(machine: &Machine, at: &impl Fn(&Value) -> f64) -> (Machine, Machine) {
    let mut closed = machine.clone();
    for (joint, described) in closed.joints.iter_mut().zip(&machine.joints) {
        let expansion = at(&std::mem::replace(&mut joint.lead_error.growth, Value::number(0.0)));
        for (_, c) in joint.on.iter_mut().filter(|(p, _)| machine.has_lead(described, *p)) {
            *c *= 1.0 + expansion;
        }
        if joint.relaxation_stiffness.take().is_some() {
            joint.damping = Value::number(0.0);
        }
    }
    let mut open = closed.clone();
    for joint in open.joints.iter_mut().filter(|j| at(&j.gap) > 0.0) {
        joint.stiffness = Value::number(0.0);
        joint.damping = Value::number(0.0);
    }
    (open, closed)
}
