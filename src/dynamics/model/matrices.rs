//! Mass, damping and stiffness matrices of a machine whose shafts are chains of springs and masses.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use super::structure::ModelError;
use super::{RodModel, Structure};
use machine::{Machine, Operating};
use std::sync::Arc;

/// Eigenvalue of the stiffness matrix, scaled to a unit diagonal, below which the motion is free.
const ZERO_STIFFNESS: f64 = 1e-9;

/// M, C and K of M·q̈ + C·q̇ + K·q = Q.
///
/// # Units      kg or kg·m², N·s/m or N·m·s/rad, N/m or N·m/rad, and their mixtures where a joint couples a
///   displacement to an angle
/// # Source     Duan et al., Eq. 6, with M_w in its place and (lead/2π)·θ for the printed lead·θ.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrices {
    /// Name of each coordinate: the name of its point; inner coordinates of a shaft are numbered.
    pub names: Vec<String>,
    /// M.
    pub mass: DMatrix<f64>,
    /// C.
    pub damping: DMatrix<f64>,
    /// K.
    pub stiffness: DMatrix<f64>,
}

/// Computes the matrices of a machine, each rod a chain of `lumps` springs with half of each spring's mass at
/// its ends.
///
/// Loss factors cannot be represented in the matrices and are omitted. A shaft that bends has its static
/// stiffness, without modes of its own.
///
/// # Errors  a joint has a relaxing damper or integral action, which a damping matrix cannot represent; the
///   machine has no point that moves.
pub fn matrices(
    machine: &Machine,
    parameters: &[f64],
    operating: &Operating,
    lumps: usize,
) -> Result<Matrices, ModelError> {
    if let Some(joint) = machine.joints.iter().find(|j| j.relaxation_stiffness.is_some()) {
        return Err(ModelError::Point {
            name: joint.name.clone(),
            fault: "has a relaxing damper, which a damping matrix cannot represent; leave relaxation_stiffness out",
        });
    }
    if let Some(joint) = machine.joints.iter().find(|j| j.integral_rate.at(parameters, operating) != 0.0) {
        return Err(ModelError::Point {
            name: joint.name.clone(),
            fault: "has integral action, which a damping matrix cannot represent; leave integral_rate out, and describe the loops under [drive]",
        });
    }
    let moving = machine.points.iter().position(|p| !p.fixed);
    let moving = moving.ok_or_else(|| ModelError::Point {
        name: machine.title.clone(),
        fault: "has no point that moves; free one of its points",
    })?;
    let structure = Arc::new(Structure::new(machine, moving, moving, RodModel::Lumped(lumps))?);
    let mut model = structure.empty_model();
    model.update(machine, parameters, operating);
    let mut names: Vec<String> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.clone()).collect();
    let elements = lumps.max(1);
    let points = names.len();
    let size = points + structure.rods.len() * (elements - 1);
    let zero = DMatrix::zeros(size, size);
    let (mut mass, mut damping, mut stiffness) = (zero.clone(), zero.clone(), zero);
    for (i, m) in model.inertia.iter().enumerate() {
        mass[(i, i)] += m;
    }
    for (joint, on) in model.joints.iter().zip(&model.joint_points) {
        for &(i, a) in on {
            for &(j, b) in on {
                stiffness[(i, j)] += a * b * joint.stiffness;
                damping[(i, j)] += a * b * joint.damping;
            }
        }
    }
    for (beam, shape) in model.beams.iter().zip(&structure.beams) {
        stiffness[(shape.coordinate, shape.coordinate)] += beam.static_stiffness();
    }
    for (at, (rod, shape)) in model.rods.iter().zip(&structure.rods).enumerate() {
        let first = points + at * (elements - 1);
        let kind = if shape.torsional { "turn" } else { "axial" };
        names.extend(
            (1..elements).map(|i| format!("{}-{kind}-{}-{i}", machine.shafts[shape.shaft].name, at + 1)),
        );
        let coordinate = |i: usize| match i {
            0 => shape.ends[0],
            i if i == elements => shape.ends[1],
            i => Some(first + i - 1),
        };
        let (k, m) = (
            rod.stiffness * elements as f64,
            rod.stiffness * rod.transit_s * rod.transit_s / elements as f64,
        );
        for i in 0..elements {
            let (a, b) = (coordinate(i), coordinate(i + 1));
            for end in [a, b].into_iter().flatten() {
                mass[(end, end)] += 0.5 * m;
                stiffness[(end, end)] += k;
            }
            if let (Some(a), Some(b)) = (a, b) {
                stiffness[(a, b)] -= k;
                stiffness[(b, a)] -= k;
            }
        }
    }
    Ok(Matrices { names, mass, damping, stiffness })
}

impl Matrices {
    /// Condenses the matrices to the coordinates with inertia. The massless coordinates follow statically, u
    /// = −K_mm⁻¹·K_mk·q.
    ///
    /// Exact for M and K. C is Tᵀ·C·T with the same T, exact where it is proportional to K.
    ///
    /// # Errors  a coordinate without inertia is not held by any spring.
    pub fn condensed(&self) -> Result<Matrices, ModelError> {
        let (kept, massless): (Vec<usize>, Vec<usize>) =
            (0..self.names.len()).partition(|i| self.mass[(*i, *i)] > 0.0);
        let pick = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| self.stiffness[(rows[i], columns[j])])
        };
        let inner = pick(&massless, &massless);
        let unconstrained = |i: usize| ModelError::Point {
            name: self.names[massless.get(i).copied().unwrap_or(0)].clone(),
            fault: "has neither inertia nor a spring; give it one of them",
        };
        let follow = match Cholesky::new(inner.clone()) {
            Some(factor) => -factor.solve(&pick(&massless, &kept)),
            None => {
                return Err(unconstrained(
                    (0..massless.len()).find(|i| !(inner[(*i, *i)] > 0.0)).unwrap_or(0),
                ));
            }
        };
        let mut transfer = DMatrix::zeros(self.names.len(), kept.len());
        for (column, row) in kept.iter().enumerate() {
            transfer[(*row, column)] = 1.0;
        }
        for (at, row) in massless.iter().enumerate() {
            for column in 0..kept.len() {
                transfer[(*row, column)] = follow[(at, column)];
            }
        }
        let of = |matrix: &DMatrix<f64>| {
            let product = transfer.transpose() * matrix * &transfer;
            (&product + product.transpose()) * 0.5
        };
        Ok(Matrices {
            names: kept.iter().map(|i| self.names[*i].clone()).collect(),
            mass: of(&self.mass),
            damping: of(&self.damping),
            stiffness: of(&self.stiffness),
        })
    }

    /// Finds the parts that can move without stretching a spring. Returns the names of the moving coordinates
    /// for each such motion.
    pub fn free_parts(&self) -> Vec<Vec<String>> {
        let size = self.names.len();
        // Scaled to a unit diagonal, so that displacements and angles compare.
        let scale = DVector::from_fn(size, |i, _| {
            let k = self.stiffness[(i, i)];
            if k > 0.0 { 1.0 / k.sqrt() } else { 1.0 }
        });
        let scaled = DMatrix::from_fn(size, size, |i, j| self.stiffness[(i, j)] * scale[i] * scale[j]);
        let eigen = SymmetricEigen::new(scaled);
        let mut parts = Vec::new();
        for (at, value) in eigen.eigenvalues.iter().enumerate() {
            if value.abs() <= ZERO_STIFFNESS {
                let vector = eigen.eigenvectors.column(at);
                let largest = vector.amax();
                parts.push(
                    (0..size)
                        .filter(|i| vector[*i].abs() > 1e-6 * largest)
                        .map(|i| self.names[i].clone())
                        .collect(),
                );
            }
        }
        parts
    }

    /// Computes the static stiffness (N/m or N·m/rad) at a named coordinate: force over displacement at that
    /// coordinate.
    ///
    /// # Errors  no coordinate has this name; a part of the machine can move freely.
    pub fn static_stiffness(&self, name: &str) -> Result<f64, ModelError> {
        let missing =
            || ModelError::Point { name: name.into(), fault: "is not a moving point; name one that moves" };
        let at = self.names.iter().position(|n| n == name).ok_or_else(missing)?;
        if let Some(part) = self.free_parts().into_iter().next() {
            return Err(ModelError::Unconstrained { part: part.join(", ") });
        }
        let mut force = DVector::zeros(self.names.len());
        force[at] = 1.0;
        let solved = Cholesky::new(self.stiffness.clone()).map(|factor| factor.solve(&force));
        solved.map(|x| 1.0 / x[at]).ok_or_else(missing)
    }
}
