//! A machine whose moving points keep in step.

use nalgebra::DMatrix;

use super::error::InverseError;
use super::preprocessing::MotionSignal;
use machine::{Machine, Operating, PointMotion as Kind};

/// A machine whose moving points keep in step: how fast each moves beside what the position encoder reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigid {
    /// Rate of each point over that of the reading.
    ratios: Vec<f64>,
    /// The same of the driven point.
    pub(super) driven: f64,
}

impl Rigid {
    /// The one motion that deforms neither a spring nor a shaft of the machine, scaled to one of the position encoder.
    ///
    /// # Errors  the machine has no drive, or can move otherwise, or not at all.
    pub fn new(machine: &Machine, values: &[f64]) -> Result<Self, InverseError> {
        let drive = machine.drive.as_ref().ok_or(InverseError::NoDrive)?;
        let count = machine.points.len();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut tie = |on: &[(usize, f64)]| {
            let mut row = vec![0.0; count];
            on.iter().for_each(|(point, c)| row[*point] += c);
            rows.push(row);
        };
        machine.points.iter().enumerate().filter(|(_, p)| p.fixed).for_each(|(i, _)| tie(&[(i, 1.0)]));
        for joint in &machine.joints {
            if joint.stiffness.at(values, &Operating::default()) > 0.0 {
                tie(&joint.on);
            }
        }
        for shaft in &machine.shafts {
            for pair in shaft.stations.windows(2) {
                for (a, b) in [(pair[0].axial, pair[1].axial), (pair[0].torsion, pair[1].torsion)] {
                    if let (Some(a), Some(b)) = (a, b) {
                        tie(&[(a, 1.0), (b, -1.0)]);
                    }
                }
            }
        }
        // The null space of the ties: eigenvectors of Tᵀ·T to eigenvalue 0.
        let ties = DMatrix::from_fn(rows.len(), count, |i, j| rows[i][j]);
        let eigen = (ties.transpose() * &ties).symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(1.0_f64, |m, x| m.max(*x));
        let free: Vec<usize> = (0..count).filter(|i| eigen.eigenvalues[*i] < 1e-12 * largest).collect();
        let [only] = free[..] else {
            let fault = format!("{} motions deform no spring and no shaft of it", free.len());
            return Err(InverseError::NotRigid { fault });
        };
        let shape = eigen.eigenvectors.column(only);
        let encoder = &drive.position.encoder;
        let reading = encoder.travel * shape[encoder.at];
        if !(reading.abs() > 1e-9 && shape[drive.on].abs() > 1e-9) {
            let fault = "neither its drive nor its encoder moves where no spring is deformed".to_string();
            return Err(InverseError::NotRigid { fault });
        }
        let ratios: Vec<f64> = shape.iter().map(|x| x / reading).collect();
        Ok(Rigid { driven: ratios[drive.on], ratios })
    }

    /// Checks that a record gives what the drive gives.
    ///
    /// # Errors  a force is recorded where the drive turns, or a torque where it does not.
    pub fn check(&self, machine: &Machine, motion: &MotionSignal) -> Result<(), InverseError> {
        let drive = machine.drive.as_ref().ok_or(InverseError::NoDrive)?;
        let point = &machine.points[drive.on];
        let wanted = if point.motion == Kind::Translation { "force_n" } else { "torque_nm" };
        if motion.load_column == wanted {
            return Ok(());
        }
        Err(InverseError::Load { path: motion.source.clone(), given: motion.load_column, wanted, point: point.name.clone() })
    }

    /// Force (N) or torque (N·m) of the drive per acceleration of the reading (m/s²).
    pub fn inertia(&self, machine: &Machine, values: &[f64]) -> f64 {
        self.inertia_of(machine, values, &|_| true) / self.driven
    }

    /// Mass (kg) felt at the reading of some of the points, with the shafts between them.
    pub(super) fn inertia_of(&self, machine: &Machine, values: &[f64], counts: &dyn Fn(usize) -> bool) -> f64 {
        let at = Operating::default();
        let own = machine.points.iter().zip(&self.ratios).enumerate().filter(|(i, _)| counts(*i));
        let mut inertia: f64 = own.map(|(_, (p, r))| p.inertia.at(values, &at) * r * r).sum();
        for shaft in &machine.shafts {
            for (kind, point) in [
                (Kind::Translation, shaft.stations.iter().find_map(|s| s.axial)),
                (Kind::Rotation, shaft.stations.iter().find_map(|s| s.torsion)),
            ] {
                let ratio = point.filter(|p| counts(*p)).map_or(0.0, |p| self.ratios[p]);
                inertia += shaft.inertia(kind, values, &at) * ratio * ratio;
            }
        }
        inertia
    }

    /// The point that weighs most at the reading.
    pub fn heaviest(&self, machine: &Machine, values: &[f64]) -> Option<usize> {
        let weight = |i: &usize| self.inertia_of(machine, values, &|p| p == *i);
        (0..machine.points.len()).max_by(|a, b| weight(a).total_cmp(&weight(b)))
    }

    /// Rate of a joint's combination over that of the reading.
    pub fn ratio(&self, on: &[(usize, f64)]) -> f64 {
        on.iter().map(|(point, c)| c * self.ratios[*point]).sum()
    }

    /// Rate of a point over that of the reading.
    pub fn point_ratio(&self, point: usize) -> f64 {
        self.ratios[point]
    }
}
