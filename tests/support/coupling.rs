//! Receptance coupling by the method of the paper, from the description of a machine alone: free
//! substructures are coupled one after another.
//!
//! Every rod and every lumped inertia is a free substructure. Rigid couplings join the ends that share a
//! point; elastic couplings add the joints; a fixed point is coupled rigidly to the ground. Each coupling is
//! the update
//!
//! > H' = H − H·v·(vᵀ·H·v + h_J)⁻¹·vᵀ·H
//!
//! with v = e_i − e_j for a rigid coupling (h_J = 0) and h_J = 1/(k + iωc) for a joint that acts on vᵀ·q.
//!
//! # Source  Tian et al., Eq. 1–24. Deviations: cot for cos in Eq. 1–2; h_J = 1/(k + iωc) in Eq. 6 and 8, not
//!   its inverse; v = (1, −1, −i_b) in
//!   Eq. 19–20, without the extra i_b.

use std::f64::consts::{FRAC_2_PI, TAU};

use machine::{Joint, Machine, Operating, Shaft, StationPlace, Value};
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Computes all receptances at one frequency: point × point in the machine's order, zero for fixed points.
/// Every point needs an inertia or a shaft.
pub fn coupled_receptances(
    machine: &Machine,
    values: &[f64],
    operating: &Operating,
    omega_rad_s: f64,
) -> DMatrix<Complex64> {
    let description = Description { machine, values, operating, omega_rad_s };
    let points = machine.points.len();
    // One coordinate for each lumped inertia and each rod end; `of_point` lists those at each point.
    let mut blocks: Vec<(Vec<usize>, Vec<Complex64>)> = Vec::new();
    let mut of_point: Vec<Vec<usize>> = vec![Vec::new(); points];
    let mut size = 0;
    let rods: Vec<([usize; 2], [Complex64; 2])> =
        machine.shafts.iter().flat_map(|shaft| description.rods(shaft)).collect();
    // An inertia on a shaft is coupled to the rod's end below; any other inertia is a substructure with one
    // coordinate.
    let mut on_shafts = Vec::new();
    for (point, described) in machine.points.iter().enumerate().filter(|(_, p)| !p.fixed) {
        let inertia = description.at(&described.inertia);
        let free = Complex64::from(-1.0 / (inertia * omega_rad_s * omega_rad_s));
        if !(inertia > 0.0) {
            continue;
        } else if rods.iter().any(|(ends, _)| ends.contains(&point)) {
            on_shafts.push((point, free));
        } else {
            blocks.push((vec![size], vec![free]));
            of_point[point].push(size);
            size += 1;
        }
    }
    for (ends, [direct, cross]) in rods {
        blocks.push((vec![size, size + 1], vec![direct, cross, cross, direct]));
        ends.iter().enumerate().for_each(|(end, point)| of_point[*point].push(size + end));
        size += 2;
    }
    let mut h = DMatrix::zeros(size, size);
    for (rows, entries) in &blocks {
        for (a, &i) in rows.iter().enumerate() {
            for (b, &j) in rows.iter().enumerate() {
                h[(i, j)] = entries[a * rows.len() + b];
            }
        }
    }
    for (ends, point) in of_point.iter().zip(&machine.points) {
        if point.fixed {
            ends.iter().for_each(|end| couple(&mut h, &[(*end, 1.0)], Complex64::ZERO));
        } else {
            ends.windows(2)
                .for_each(|pair| couple(&mut h, &[(pair[0], 1.0), (pair[1], -1.0)], Complex64::ZERO));
        }
    }
    for (point, receptance) in on_shafts {
        couple(&mut h, &[(of_point[point][0], 1.0)], receptance);
    }
    // Joints on few points come first, as in the paper: the large receptances of free bodies then cancel
    // early.
    let moving = |joint: &Joint| joint.on.iter().filter(|(p, _)| !machine.points[*p].fixed).count();
    let mut joints: Vec<&Joint> = machine.joints.iter().collect();
    joints.sort_by_key(|joint| moving(joint));
    for joint in joints.into_iter().filter(|joint| moving(joint) > 0) {
        let stiffness = description.joint(joint);
        if stiffness != Complex64::ZERO {
            let growth = description.at(&joint.lead_error.growth);
            let factor = |point: usize| if machine.has_lead(joint, point) { 1.0 + growth } else { 1.0 };
            let on = joint
                .on
                .iter()
                .filter(|(p, _)| !machine.points[*p].fixed)
                .map(|(p, c)| (of_point[*p][0], c * factor(*p)));
            couple(&mut h, &on.collect::<Vec<_>>(), stiffness.inv());
        }
    }
    let is_fixed = |point: usize| machine.points[point].fixed;
    DMatrix::from_fn(points, points, |i, j| {
        if is_fixed(i) || is_fixed(j) { Complex64::ZERO } else { h[(of_point[i][0], of_point[j][0])] }
    })
}

/// A machine with numbers, at one frequency.
struct Description<'d> {
    machine: &'d Machine,
    values: &'d [f64],
    operating: &'d Operating,
    omega_rad_s: f64,
}

impl Description<'_> {
    fn at(&self, value: &Value) -> f64 {
        value.at(self.values, self.operating)
    }

    /// Computes 1 + η·(i + s·2/π·ln(ω/ω₀)) with ω₀ at 100 Hz; below 1 Hz the real part is constant.
    fn complex(&self, loss_factor: f64) -> Complex64 {
        let dispersion = self.at(&self.machine.loss_dispersion)
            * FRAC_2_PI
            * (self.omega_rad_s.max(TAU) / (100.0 * TAU)).ln();
        1.0 + loss_factor * Complex64::new(dispersion, 1.0)
    }

    /// Computes the dynamic stiffness of a joint: spring with loss and integral action, and damper, in series
    /// with its relaxation spring.
    fn joint(&self, joint: &Joint) -> Complex64 {
        let (stiffness, omega) = (self.at(&joint.stiffness), self.omega_rad_s);
        let damping = self.at(&joint.damping) + self.machine.stiffness_proportional_damping_s * stiffness;
        let integral = Complex64::new(0.0, -self.at(&joint.integral_rate) / omega);
        let damper = Complex64::new(0.0, omega * damping);
        let series =
            joint.relaxation_stiffness.as_ref().map_or(Complex64::ONE, |k| 1.0 + damper / self.at(k));
        stiffness * (self.complex(self.at(&joint.loss_factor)) + integral) + damper / series
    }

    /// Returns the free–free rods of a shaft: points at both ends, direct and cross receptance.
    ///
    /// # Source  Tian et al., Eq. 1–2 and 10–11: h11 = h22 = −cot(λx)/(Aλ), h12 = h21 = −csc(λx)/(Aλ).
    ///   Deviation: cot for cos.
    fn rods(&self, shaft: &Shaft) -> Vec<([usize; 2], [Complex64; 2])> {
        let (area_m2, polar_m4) = shaft.section(self.values, self.operating);
        let place_m = |place: StationPlace| {
            shaft.place_m(place, self.values, self.operating).expect("the nut has a position")
        };
        let of_kind = |modulus: f64, section: f64, stations: Vec<(StationPlace, usize)>| {
            let rod = move |pair: &[(StationPlace, usize)]| {
                let length_m = place_m(pair[1].0) - place_m(pair[0].0);
                let material = self.complex(self.at(&shaft.loss_factor));
                let phase = self.omega_rad_s * length_m * (self.at(&shaft.density) / modulus).sqrt()
                    / material.sqrt();
                let scale = -(phase * material * (modulus * section / length_m)).inv();
                ([pair[0].1, pair[1].1], [scale * phase.cos() / phase.sin(), scale / phase.sin()])
            };
            stations.windows(2).map(rod).collect::<Vec<_>>()
        };
        let axial = shaft.stations.iter().filter_map(|s| Some((s.place, s.axial?))).collect();
        let torsional = shaft.stations.iter().filter_map(|s| Some((s.place, s.torsion?))).collect();
        [
            of_kind(self.at(&shaft.youngs_modulus), area_m2, axial),
            of_kind(self.at(&shaft.shear_modulus), polar_m4, torsional),
        ]
        .concat()
    }
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
