//! Quantities computed from the displacements of a solved model.

use num_complex::Complex64;

use super::assembled_model::AssembledModel;
use super::rod::{RodLanes, loss_each};
use super::simd::{Complexes, Reals};

/// A solution: displacements under a unit force at the excitation and at the response, and the rods' entries.
#[derive(Clone, Copy)]
pub(super) struct Solution<'w> {
    pub omega_rad_s: &'w [Reals],
    pub at_excitation: &'w [Complexes],
    pub at_response: &'w [Complexes],
    pub rods: &'w [RodLanes],
}

impl Solution<'_> {
    /// Computes the deformation Σ cᵢ·xᵢ for one group of frequencies.
    #[inline]
    pub fn deformation(&self, x: &[Complexes], on: &[(usize, f64)], w: usize) -> Complexes {
        on.iter().fold(Complexes::ZERO, |sum, &(i, c)| sum + x[i * self.omega_rad_s.len() + w] * c)
    }

    /// Computes the factors of a rod's direct and cross entry in aᵀ·D·b, for one group of frequencies.
    #[inline]
    pub fn rod_factors(&self, ends: [Option<usize>; 2], w: usize) -> (Complexes, Complexes) {
        let of = |x: &[Complexes], at: Option<usize>| {
            at.map_or(Complexes::ZERO, |at| x[at * self.omega_rad_s.len() + w])
        };
        let [a, b] = ends.map(|end| (of(self.at_response, end), of(self.at_excitation, end)));
        (a.0 * a.1 + b.0 * b.1, a.0 * b.1 + b.0 * a.1)
    }

    /// Computes the product of the displacements of a coordinate under both forces, for one group of
    /// frequencies.
    #[inline]
    pub fn product(&self, coordinate: usize, w: usize) -> Complexes {
        let at = coordinate * self.omega_rad_s.len() + w;
        self.at_response[at] * self.at_excitation[at]
    }
}

/// A receptance at one frequency.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Angular frequency (rad/s).
    pub omega_rad_s: f64,
    /// H = response / force (m/N, rad/N, …).
    pub receptance: Complex64,
    /// dH/dω.
    pub slope: Complex64,
}

impl AssembledModel {
    /// Adds aᵀ·(dD/dω)·b of a solution's displacements to `sums`, one per group.
    pub(super) fn bilinear_slopes(&self, of: Solution<'_>, sums: &mut [Complexes]) {
        let (shape, omega_rad_s, abreast) = (&self.structure, of.omega_rad_s, sums.len());
        for (at, m) in self.inertia.iter().enumerate().filter(|(_, m)| **m != 0.0) {
            let (a, b) = (&of.at_response[at * abreast..], &of.at_excitation[at * abreast..]);
            for (((sum, omega), a), b) in sums.iter_mut().zip(omega_rad_s).zip(a).zip(b) {
                *sum -= *a * *b * (*omega * Reals::splat(2.0 * m));
            }
        }
        for (joint, on) in self
            .joints
            .iter()
            .zip(&self.joint_points)
            .filter(|(j, _)| j.damping != 0.0 || j.loss_factor != 0.0 || j.integral_rate != 0.0)
        {
            for (w, sum) in sums.iter_mut().enumerate() {
                let product = of.deformation(of.at_response, on, w) * of.deformation(of.at_excitation, on, w);
                let s = self.complex_frequency_each(omega_rad_s[w]);
                *sum += joint.damper_derivative_each(product, s).times_i() * joint.damping;
                if joint.integral_rate != 0.0 {
                    *sum -= product.times_i() * (joint.integral_each(s).im / omega_rad_s[w]);
                }
                if joint.loss_factor != 0.0 {
                    *sum += product
                        * (loss_each(omega_rad_s[w], self.dispersion).1
                            * Reals::splat(joint.stiffness * joint.loss_factor));
                }
            }
        }
        for (beam, shape) in self.beams.iter().zip(&shape.beams) {
            for (w, (sum, omega)) in sums.iter_mut().zip(omega_rad_s).enumerate() {
                *sum += beam.frequency_slopes_each(*omega) * of.product(shape.coordinate, w);
            }
        }
        for ((entries, rod), rod_shape) in of.rods.chunks_exact(abreast).zip(&self.rods).zip(&shape.rods) {
            for (w, ((sum, omega), entries)) in sums.iter_mut().zip(omega_rad_s).zip(entries).enumerate() {
                let (direct, cross) = of.rod_factors(rod_shape.ends, w);
                let slopes = rod.slopes_each(*omega, entries);
                *sum += if entries.lossless {
                    direct * slopes.0.re + cross * slopes.1.re
                } else {
                    let (by_direct, by_cross) = entries.by_material(*omega, slopes);
                    let drift = entries.material_inverse
                        * (loss_each(*omega, self.dispersion).1 * Reals::splat(rod.loss_factor));
                    direct * (slopes.0 + by_direct * drift) + cross * (slopes.1 + by_cross * drift)
                };
            }
        }
    }
}
