//! A machine that moves as one rigid axis.

use nalgebra::DMatrix;

use super::error::InverseError;
use super::preprocessing::MotionSignal;
use machine::{Machine, Operating, PointMotion as Kind};

/// The rigid-body motion of a machine: the rates of its points relative to the reading of the position
/// encoder.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigid {
    /// Rate of each point over the rate of the reading.
    ratios: Vec<f64>,
    /// Rate of the driven point over the rate of the reading.
    pub(super) driven: f64,
}

impl Rigid {
    /// Computes the one motion that deforms neither a spring nor a shaft, scaled to unit motion of the
    /// position encoder.
    ///
    /// # Errors  the machine has no drive, has further independent motions, or cannot move.
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
        machine
            .shafts
            .iter()
            .filter_map(|shaft| shaft.bending.as_ref())
            .for_each(|bending| tie(&[(bending.point, 1.0)]));
        for shaft in &machine.shafts {
            for pair in shaft.stations.windows(2) {
                for (a, b) in [(pair[0].axial, pair[1].axial), (pair[0].torsion, pair[1].torsion)] {
                    if let (Some(a), Some(b)) = (a, b) {
                        tie(&[(a, 1.0), (b, -1.0)]);
                    }
                }
            }
        }
        // The null space of the constraints: eigenvectors of Tᵀ·T with eigenvalue 0.
        let ties = DMatrix::from_fn(rows.len(), count, |i, j| rows[i][j]);
        let eigen = (ties.transpose() * &ties).symmetric_eigen();
        let largest = eigen.eigenvalues.iter().fold(1.0_f64, |m, x| m.max(*x));
        let free: Vec<usize> = (0..count).filter(|i| eigen.eigenvalues[*i] < 1e-12 * largest).collect();
        let [only] = free[..] else {
            let fault = format!("{} independent motions deform no spring and no shaft", free.len());
            return Err(InverseError::NotRigid { fault });
        };
        let shape = eigen.eigenvectors.column(only);
        let encoder = &drive.position.encoder;
        let reading = encoder.travel * shape[encoder.at];
        if !(reading.abs() > 1e-9 && shape[drive.on].abs() > 1e-9) {
            let fault = "its drive or its encoder does not move in the rigid-body motion".to_string();
            return Err(InverseError::NotRigid { fault });
        }
        let ratios: Vec<f64> = shape.iter().map(|x| x / reading).collect();
        Ok(Rigid { driven: ratios[drive.on], ratios })
    }

    /// Checks that the recorded load has the kind of the drive's load, and the position that of its encoder.
    ///
    /// # Errors  a force is recorded where the driven point rotates, or a torque where it translates; angles
    ///   are recorded where the encoder reads a travel.
    pub fn check(&self, machine: &Machine, motion: &MotionSignal) -> Result<(), InverseError> {
        let drive = machine.drive.as_ref().ok_or(InverseError::NoDrive)?;
        let (point, encoder) = (&machine.points[drive.on], &drive.position.encoder);
        if motion.is_angle && !encoder.reads_angle(machine) {
            let (path, point) = (motion.source.clone(), machine.points[encoder.at].name.clone());
            return Err(InverseError::Angle { path, point });
        }
        let wanted = if point.motion == Kind::Translation { "force_n" } else { "torque_nm" };
        if motion.load_column == wanted {
            return Ok(());
        }
        Err(InverseError::Load {
            path: motion.source.clone(),
            given: motion.load_column,
            wanted,
            point: point.name.clone(),
        })
    }

    /// Computes the force (N) or torque (N·m) of the drive per acceleration of the reading (m/s²).
    pub fn inertia(&self, machine: &Machine, values: &[f64]) -> f64 {
        self.inertia_of(machine, values, &|_| true) / self.driven
    }

    /// Computes the mass (kg) of some of the points, and of the shafts between them, reduced to the reading.
    pub(super) fn inertia_of(
        &self,
        machine: &Machine,
        values: &[f64],
        counts: &dyn Fn(usize) -> bool,
    ) -> f64 {
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

    /// Returns the point with the largest mass reduced to the reading.
    pub fn largest_mass_point(&self, machine: &Machine, values: &[f64]) -> Option<usize> {
        let weight = |i: &usize| self.inertia_of(machine, values, &|p| p == *i);
        (0..machine.points.len()).max_by(|a, b| weight(a).total_cmp(&weight(b)))
    }

    /// Computes the rate of a joint's combination over the rate of the reading.
    pub fn ratio(&self, on: &[(usize, f64)]) -> f64 {
        on.iter().map(|(point, c)| c * self.ratios[*point]).sum()
    }

    /// Returns the rate of a point over the rate of the reading.
    pub fn point_ratio(&self, point: usize) -> f64 {
        self.ratios[point]
    }
}
