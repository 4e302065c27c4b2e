//! Receptance coupling by the method of the paper: free substructures are coupled one after another.
//!
//! Every rod and every lumped inertia is a free substructure. Rigid couplings join the ends that share a point; elastic couplings add the joints;
//! a fixed point is coupled rigidly to the ground. Each coupling is the update
//!
//! > H' = H − H·v·(vᵀ·H·v + h_J)⁻¹·vᵀ·H
//!
//! with v = e_i − e_j for a rigid coupling (h_J = 0) and h_J = 1/(k + iωc) for a joint that acts on vᵀ·q.
//!
//! # Source  Tian et al., Eq. 1–24. Deviations: cot for cos in Eq. 1–2; h_J = 1/(k + iωc) in Eq. 6 and 8, not its inverse; v = (1, −1, −i_b) in
//!   Eq. 19–20, without the extra i_b.

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::assembled_model::AssembledModel;
use super::rod::Rod;
use super::structure::ModelError;
use machine::Machine;

/// Computes all receptances at one frequency by receptance coupling: point × point in the machine's order, zero for fixed points.
///
/// # Errors  [`ModelError::Massless`] where a point has neither inertia nor shaft: it has no receptance of its own.
pub fn coupled_receptances(model: &AssembledModel, machine: &Machine, omega_rad_s: f64) -> Result<DMatrix<Complex64>, ModelError> {
    let shape = &model.structure;
    // One coordinate for each lumped inertia and each rod end; `of_coordinate` lists those at each coordinate of the structure.
    let mut blocks: Vec<(Vec<usize>, Vec<Complex64>)> = Vec::new();
    let mut of_coordinate: Vec<Vec<usize>> = vec![Vec::new(); shape.size()];
    let mut held = Vec::new();
    let mut size = 0;
    let square = omega_rad_s * omega_rad_s;
    // An inertia on a shaft is coupled to the rod's end below; any other inertia is a substructure with one coordinate.
    let mut on_shafts = Vec::new();
    for (coordinate, inertia) in model.inertia.iter().enumerate().filter(|(_, m)| **m > 0.0) {
        if shape.rods.iter().any(|r| r.ends.contains(&Some(coordinate))) {
            on_shafts.push((coordinate, Complex64::new(-1.0 / (inertia * square), 0.0)));
            continue;
        }
        blocks.push((vec![size], vec![Complex64::new(-1.0 / (inertia * square), 0.0)]));
        of_coordinate[coordinate].push(size);
        size += 1;
    }
    for (rod, rod_shape) in model.rods.iter().zip(&shape.rods) {
        let [direct, cross] = free_rod(rod, omega_rad_s);
        blocks.push((vec![size, size + 1], vec![direct, cross, cross, direct]));
        for (end, coordinate) in rod_shape.ends.iter().enumerate() {
            match coordinate {
                Some(c) => of_coordinate[*c].push(size + end),
                None => held.push(size + end),
            }
        }
        size += 2;
    }
    let mut h = DMatrix::zeros(size, size);
    for (rows, values) in &blocks {
        for (a, &i) in rows.iter().enumerate() {
            for (b, &j) in rows.iter().enumerate() {
                h[(i, j)] = values[a * rows.len() + b];
            }
        }
    }
    let zero = Complex64::new(0.0, 0.0);
    for ends in &of_coordinate {
        for pair in ends.windows(2) {
            couple(&mut h, &[(pair[0], 1.0), (pair[1], -1.0)], zero);
        }
    }
    for end in held {
        couple(&mut h, &[(end, 1.0)], zero);
    }
    for (coordinate, receptance) in on_shafts {
        if let Some(&end) = of_coordinate[coordinate].first() {
            couple(&mut h, &[(end, 1.0)], receptance);
        }
    }
    let first = |coordinate: usize| {
        of_coordinate[coordinate].first().copied().ok_or_else(|| ModelError::Massless {
            name: shape.coordinate.iter().position(|c| *c == Some(coordinate)).map_or_else(String::new, |p| machine.points[p].name.clone()),
        })
    };
    // Joints on few points come first, as in the paper: the large receptances of free bodies then cancel early.
    let mut joints: Vec<_> = model.joints.iter().zip(&model.joint_points).collect();
    joints.sort_by_key(|(_, on)| on.len());
    for (joint, on) in joints {
        let complex_stiffness = joint.dynamic(omega_rad_s);
        if complex_stiffness != zero && !on.is_empty() {
            let on: Vec<(usize, f64)> = on.iter().map(|&(c, w)| Ok((first(c)?, w))).collect::<Result<_, _>>()?;
            couple(&mut h, &on, complex_stiffness.inv());
        }
    }
    let points = machine.points.len();
    let mut all = DMatrix::zeros(points, points);
    for (i, row) in shape.coordinate.iter().enumerate().filter_map(|(i, c)| c.map(|c| (i, c))) {
        for (j, column) in shape.coordinate.iter().enumerate().filter_map(|(j, c)| c.map(|c| (j, c))) {
            all[(i, j)] = h[(first(row)?, first(column)?)];
        }
    }
    Ok(all)
}

/// Returns the direct and the cross receptance of a free–free rod at its ends.
///
/// # Source  Tian et al., Eq. 1–2 and 10–11: h11 = h22 = −cot(λx)/(Aλ), h12 = h21 = −csc(λx)/(Aλ). Deviation: cot for cos.
fn free_rod(rod: &Rod, omega_rad_s: f64) -> [Complex64; 2] {
    let material = rod.material(omega_rad_s);
    let phase = Complex64::from(omega_rad_s * rod.transit_s) / material.sqrt();
    let scale = -(phase * material * rod.stiffness).inv();
    let sin = phase.sin();
    [scale * phase.cos() / sin, scale / sin]
}

/// Computes H − H·v·(vᵀ·H·v + h_J)⁻¹·vᵀ·H in place.
fn couple(h: &mut DMatrix<Complex64>, on: &[(usize, f64)], joint_receptance: Complex64) {
    let size = h.nrows();
    let column: Vec<Complex64> = (0..size).map(|i| on.iter().map(|&(j, w)| h[(i, j)] * w).sum()).collect();
    let denominator: Complex64 = on.iter().map(|&(j, w)| column[j] * w).sum::<Complex64>() + joint_receptance;
    let scaled: Vec<Complex64> = column.iter().map(|c| c / denominator).collect();
    for j in 0..size {
        for i in 0..size {
            h[(i, j)] -= scaled[i] * column[j];
        }
    }
}
