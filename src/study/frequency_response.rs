//! Receptances and closed-loop responses of a machine with given values.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use num_complex::Complex64;

use crate::{StudyError, StudyResult};
use dynamics::model::{RodModel, Structure};
use dynamics::motion::ServoImpedance;
use identification::objective::Excitation;
use machine::{Machine, Operating, PointMotion};

/// A machine with values, at an operating condition.
pub struct Evaluated<'m> {
    /// The machine.
    pub machine: &'m Machine,
    /// Values of its parameters.
    pub values: &'m [f64],
    /// Operating condition.
    pub operating: Operating,
    /// Model of the rods.
    pub rods: RodModel,
}

impl Evaluated<'_> {
    /// Computes the receptances of a point under a force on another, with the loops of the drive open.
    fn open(&self, response: usize, force: usize, omega_rad_s: &[f64]) -> StudyResult<Vec<Complex64>> {
        let structure = Arc::new(
            Structure::new(self.machine, response, force, self.rods).map_err(StudyError::impossible)?,
        );
        let mut model = structure.empty_model();
        model.update(self.machine, self.values, &self.operating);
        Ok(model.sweep(omega_rad_s, &mut structure.workspace()))
    }

    /// Computes the response of a point per force (loops open, or closed), or per command (loops closed). A
    /// rotation in a drive that positions in m responds to a command with its travel.
    ///
    /// # Errors  the machine has no loops that could be closed; a point is fixed.
    pub fn response(
        &self,
        response: usize,
        excitation: Excitation,
        closed: bool,
        omega_rad_s: &[f64],
    ) -> StudyResult<Vec<Complex64>> {
        if let (Excitation::Point(force), false) = (excitation, closed) {
            return self.open(response, force, omega_rad_s);
        }
        let servo = ServoImpedance::new(self.machine, self.values, &self.operating)
            .map_err(StudyError::impossible)?;
        let forces = match excitation {
            Excitation::Point(force) => vec![servo.on, force],
            Excitation::Command => vec![servo.on],
        };
        let mut open = BTreeMap::new();
        for at in servo.points().into_iter().chain([response]) {
            for &force in &forces {
                if let Entry::Vacant(place) = open.entry((at, force)) {
                    place.insert(self.open(at, force, omega_rad_s)?);
                }
            }
        }
        let travel = match (self.machine.points[response].motion, &self.machine.drive) {
            (PointMotion::Rotation, Some(drive)) => drive.position.encoder.travel,
            _ => 1.0,
        };
        let at = |(line, omega): (usize, &f64)| {
            let of = |point: usize, force: usize| open[&(point, force)][line];
            match excitation {
                Excitation::Point(force) => servo.close(*omega, response, force, of),
                Excitation::Command => {
                    servo.follow(*omega, of(response, servo.on) * travel, |point| of(point, servo.on))
                }
            }
        };
        Ok(omega_rad_s.iter().enumerate().map(at).collect())
    }
}
