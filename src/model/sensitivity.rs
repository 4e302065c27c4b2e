//! Exact derivatives of a receptance with a machine's parameters.
//!
//! ```text
//! ∂H_rv/∂a = − x_rᵀ·(∂D/∂a)·x_e        x_r, x_e: displacements under a unit force at the response and at the excitation
//! ```
//!
//! D depends on a few elements (a stiffness, an inertia, a rod's transit time …) and those on the parameters; the second step is
//! worked out once per operating condition, the first at each frequency.
//!
//! # Source  derivative of the inverse of a symmetric matrix, d(D⁻¹) = −D⁻¹·dD·D⁻¹.

use num_complex::Complex64;

use super::network::{Network, Workspace};
use super::rod::{RodEntries, loss};
use crate::machine::{Machine, Operating};

/// A number that the dynamic stiffness is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Element {
    /// Inertia at a coordinate.
    Inertia(usize),
    /// Stiffness of a joint.
    Stiffness(usize),
    /// Damping of a joint.
    Damping(usize),
    /// Loss factor of a joint.
    Loss(usize),
    /// Relaxation stiffness of a joint.
    Relaxation(usize),
    /// A/L of a rod.
    RodStiffness(usize),
    /// Transit time of a rod.
    RodTransit(usize),
    /// Loss factor of a rod.
    RodLoss(usize),
}

/// How the elements of a network depend on some of the parameters, for one operating condition and one set of parameters.
#[derive(Debug, Clone, Default)]
pub struct Sensitivity {
    /// Element, column, d(element)/d(parameter of the column).
    entries: Vec<(Element, usize, f64)>,
}

impl Network {
    /// How the elements depend on the parameters; `column[i]` is the column of the machine's parameter i, where it is asked for, and
    /// `nut` that of the nut position.
    pub fn sensitivity(
        &self,
        machine: &Machine,
        parameters: &[f64],
        operating: &Operating,
        column: &[Option<usize>],
        nut: Option<usize>,
    ) -> Sensitivity {
        let shape = &self.structure;
        let mut entries = Vec::new();
        for (point, coordinate) in machine.points.iter().zip(&shape.coordinate) {
            if let Some(i) = *coordinate {
                point.inertia.gradient(parameters, operating, |p, d| {
                    entries.extend(column[p].map(|c| (Element::Inertia(i), c, d)));
                });
            }
        }
        let share_s = machine.stiffness_proportional_damping_s;
        for (index, joint) in machine.joints.iter().enumerate() {
            joint.stiffness.gradient(parameters, operating, |p, d| {
                if let Some(c) = column[p] {
                    entries.push((Element::Stiffness(index), c, d));
                    if share_s != 0.0 {
                        entries.push((Element::Damping(index), c, share_s * d));
                    }
                }
            });
            let mut push = |element, value: &crate::machine::Value| {
                value.gradient(parameters, operating, |p, d| entries.extend(column[p].map(|c| (element, c, d))));
            };
            push(Element::Damping(index), &joint.damping);
            push(Element::Loss(index), &joint.loss_factor);
            if let Some(relaxation) = &joint.relaxation_stiffness {
                push(Element::Relaxation(index), relaxation);
            }
        }
        for (index, (rod_shape, rod)) in shape.rods.iter().zip(&self.rods).enumerate() {
            let shaft = &machine.shafts[rod_shape.shaft];
            let place = |p| shaft.place_m(p, parameters, operating).unwrap_or(f64::NAN);
            let length_m = place(rod_shape.places.1) - place(rod_shape.places.0);
            // d ln(stiffness) and d ln(transit) with length, diameter, modulus and density.
            let (k, t) = (rod.stiffness, rod.transit_s);
            let mut push = |column: usize, dk: f64, dt: f64| {
                if dk != 0.0 {
                    entries.push((Element::RodStiffness(index), column, dk));
                }
                if dt != 0.0 {
                    entries.push((Element::RodTransit(index), column, dt));
                }
            };
            let mut with = |value: &crate::machine::Value, dk: f64, dt: f64| {
                let number = value.at(parameters, operating);
                value.gradient(parameters, operating, |p, d| {
                    if let Some(c) = column[p] {
                        push(c, dk * k * d / number, dt * t * d / number);
                    }
                });
            };
            with(&shaft.diameter, if rod_shape.torsional { 4.0 } else { 2.0 }, 0.0);
            with(if rod_shape.torsional { &shaft.shear_modulus } else { &shaft.youngs_modulus }, 1.0, -0.5);
            with(&shaft.density, 0.0, 0.5);
            let at_end = |p| f64::from(u8::from(p == crate::machine::Place::End));
            let with_end = at_end(rod_shape.places.1) - at_end(rod_shape.places.0);
            if with_end != 0.0 {
                let share = with_end * shaft.length.at(parameters, operating) / length_m;
                with(&shaft.length, -share, share);
            }
            let at_nut = |p| f64::from(u8::from(matches!(p, crate::machine::Place::Nut | crate::machine::Place::BesideNut(_))));
            if let Some(nut) = nut {
                let share = (at_nut(rod_shape.places.1) - at_nut(rod_shape.places.0)) / length_m;
                push(nut, -k * share, t * share);
            }
            shaft.loss_factor.gradient(parameters, operating, |p, d| entries.extend(column[p].map(|c| (Element::RodLoss(index), c, d))));
        }
        Sensitivity { entries }
    }

    /// Receptance at a frequency and its derivatives with the columns of a [`Sensitivity`], which are added into `gradient`.
    pub fn gradient(&self, omega_rad_s: f64, sensitivity: &Sensitivity, work: &mut Workspace, gradient: &mut [Complex64]) -> Complex64 {
        let receptance = self.solve(omega_rad_s, work);
        let (xe, xr, rods) = work.solutions(&self.structure);
        for &(element, column, slope) in &sensitivity.entries {
            gradient[column] -= self.element_product(element, omega_rad_s, rods, xr, xe) * slope;
        }
        receptance
    }

    /// aᵀ·(∂D/∂element)·b.
    fn element_product(&self, element: Element, omega: f64, rods: &[RodEntries], a: &[Complex64], b: &[Complex64]) -> Complex64 {
        let across = |joint: usize| {
            let on = &self.structure.joints[joint];
            let x: Complex64 = on.iter().map(|&(i, c)| a[i] * c).sum();
            let y: Complex64 = on.iter().map(|&(i, c)| b[i] * c).sum();
            x * y
        };
        let i = Complex64::i();
        match element {
            Element::Inertia(at) => -a[at] * b[at] * (omega * omega),
            Element::Stiffness(joint) => across(joint) * (1.0 + loss(omega).0 * self.joints[joint].loss_factor),
            Element::Loss(joint) => across(joint) * (loss(omega).0 * self.joints[joint].stiffness),
            Element::Damping(joint) => {
                let numbers = &self.joints[joint];
                let share =
                    numbers.relaxation_stiffness.map_or(Complex64::new(1.0, 0.0), |k| (1.0 + i * (omega * numbers.damping / k)).inv());
                across(joint) * (i * omega) * share * share
            }
            Element::Relaxation(joint) => {
                let numbers = &self.joints[joint];
                let Some(k) = numbers.relaxation_stiffness else { return Complex64::new(0.0, 0.0) };
                let damper = i * (omega * numbers.damping);
                let share = damper / (k + damper);
                across(joint) * share * share
            }
            Element::RodStiffness(rod) => self.rod_product(rod, omega, rods, a, b, Element::RodStiffness),
            Element::RodTransit(rod) => self.rod_product(rod, omega, rods, a, b, Element::RodTransit),
            Element::RodLoss(rod) => self.rod_product(rod, omega, rods, a, b, Element::RodLoss),
        }
    }

    fn rod_product(
        &self,
        index: usize,
        omega: f64,
        entries: &[RodEntries],
        a: &[Complex64],
        b: &[Complex64],
        which: fn(usize) -> Element,
    ) -> Complex64 {
        let (shape, rod) = (&self.structure.rods[index], &self.rods[index]);
        let zero = Complex64::new(0.0, 0.0);
        let end = |x: &[Complex64], at: Option<usize>| at.map_or(zero, |at| x[at]);
        let (ai, aj) = (end(a, shape.along[0]), end(a, shape.along[1]));
        let (bi, bj) = (end(b, shape.along[0]), end(b, shape.along[1]));
        let (direct, cross) = (ai * bi + aj * bj, ai * bj + aj * bi);
        let entry = &entries[index];
        let (of_direct, of_cross) = match which(index) {
            Element::RodStiffness(_) => (entry.direct / rod.stiffness, entry.cross / rod.stiffness),
            Element::RodTransit(_) => (entry.direct_slope * (omega / rod.transit_s), entry.cross_slope * (omega / rod.transit_s)),
            _ => {
                let scale = loss(omega).0 / rod.material(omega);
                let (direct, cross) = entry.by_material(omega);
                (direct * scale, cross * scale)
            }
        };
        direct * of_direct + cross * of_cross
    }
}
