//! The numbers on a [`Structure`]: dynamic stiffness, receptance and its slope, count of modes.

use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex64;

use super::rod::{Rod, RodEntries, loss};
use super::structure::{Rods, Structure};
use crate::machine::{Machine, Operating};

/// Numbers of one joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct JointNumbers {
    pub stiffness: f64,
    pub damping: f64,
    pub loss_factor: f64,
    pub relaxation_stiffness: Option<f64>,
}

impl JointNumbers {
    /// Stiffness with its loss, k·(1 + η·(i + 2/π·ln(ω/ω₀))), and its slope with ω.
    fn spring(&self, omega_rad_s: f64) -> (Complex64, f64) {
        let (added, slope) = loss(omega_rad_s);
        let h = self.stiffness * self.loss_factor;
        (self.stiffness + added * h, slope * h)
    }

    /// Complex stiffness: spring with its loss, and iωc, the damper through its relaxation spring where it has one; and its slope with ω.
    pub(super) fn dynamic(&self, omega_rad_s: f64) -> (Complex64, Complex64) {
        let (spring, spring_slope) = self.spring(omega_rad_s);
        match self.relaxation_stiffness {
            None => (spring + Complex64::new(0.0, omega_rad_s * self.damping), Complex64::new(spring_slope, self.damping)),
            Some(series) => {
                let damper = Complex64::new(0.0, omega_rad_s * self.damping);
                let share = (1.0 + damper / series).inv();
                (spring + damper * share, spring_slope + Complex64::new(0.0, self.damping) * share * share)
            }
        }
    }
}

/// A machine's numbers at one operating condition and one set of parameters.
#[derive(Debug, Clone)]
pub struct Network {
    pub(super) structure: Arc<Structure>,
    pub(super) rods: Vec<Rod>,
    pub(super) joints: Vec<JointNumbers>,
    /// Lumped inertia of each coordinate.
    pub(super) inertia: Vec<f64>,
    /// K, C and ηK of everything but rods and relaxing dampers, by slot.
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    loss: Vec<f64>,
}

/// Room for one evaluation; keep it and no evaluation allocates.
#[derive(Debug, Clone)]
pub struct Workspace {
    real: Vec<f64>,
    complex: Vec<Complex64>,
    rods: Vec<RodEntries>,
    at_excitation: Vec<Complex64>,
    at_response: Vec<Complex64>,
}

/// A receptance at one frequency.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Angular frequency (rad/s).
    pub omega_rad_s: f64,
    /// H = response / force (m/N, rad/N, …).
    pub receptance: Complex64,
    /// dH/dω.
    pub slope: Complex64,
    /// Direction of det D in the complex plane, without the poles of the rods; its length means nothing.
    pub determinant: Complex64,
}

impl Point {
    /// d ln|H| / dω (s): zero at a peak.
    pub fn log_slope_s(&self) -> f64 {
        (self.slope * self.receptance.conj()).re / self.receptance.norm_sqr()
    }
}

impl Workspace {
    /// Displacements under a unit force at the excitation and at the response, and the rods' entries, of the last solution.
    pub(super) fn solutions(&self, shape: &Structure) -> (&[Complex64], &[Complex64], &[RodEntries]) {
        let at_response = if shape.response == shape.excitation { &self.at_excitation } else { &self.at_response };
        (&self.at_excitation, at_response, &self.rods)
    }
}

impl Structure {
    /// Room for evaluations of this structure.
    pub fn workspace(&self) -> Workspace {
        let zero = Complex64::new(0.0, 0.0);
        Workspace {
            real: vec![0.0; self.elimination.slots()],
            complex: vec![zero; self.elimination.slots()],
            rods: Vec::with_capacity(self.rods.len()),
            at_excitation: vec![zero; self.size()],
            at_response: vec![zero; self.size()],
        }
    }

    /// An empty network to be filled by [`Network::update`].
    pub fn network(self: &Arc<Self>) -> Network {
        let slots = self.elimination.slots();
        Network {
            structure: Arc::clone(self),
            rods: vec![Rod { stiffness: 0.0, transit_s: 0.0, loss_factor: 0.0, elements: 0 }; self.rods.len()],
            joints: vec![JointNumbers::default(); self.joints.len()],
            inertia: vec![0.0; self.size()],
            stiffness: vec![0.0; slots],
            damping: vec![0.0; slots],
            loss: vec![0.0; slots],
        }
    }
}

impl Network {
    /// Fills in the numbers of a machine. `parameters` in the machine's order and units; allocates nothing.
    pub fn update(&mut self, machine: &Machine, parameters: &[f64], operating: &Operating) {
        let shape = Arc::clone(&self.structure);
        let pattern = &shape.elimination;
        self.stiffness.fill(0.0);
        self.damping.fill(0.0);
        self.loss.fill(0.0);
        self.inertia.fill(0.0);
        for (point, coordinate) in machine.points.iter().zip(&shape.coordinate) {
            if let Some(i) = *coordinate {
                self.inertia[i] += point.inertia.at(parameters, operating);
            }
        }
        for (rod, rod_shape) in self.rods.iter_mut().zip(&shape.rods) {
            let shaft = &machine.shafts[rod_shape.shaft];
            let place = |p| shaft.place_m(p, parameters, operating).unwrap_or(f64::NAN);
            let length_m = place(rod_shape.places.1) - place(rod_shape.places.0);
            let diameter_m = shaft.diameter.at(parameters, operating);
            let area_m2 = PI * diameter_m * diameter_m / 4.0;
            let density = shaft.density.at(parameters, operating);
            let (modulus, section) = if rod_shape.torsional {
                (shaft.shear_modulus.at(parameters, operating), area_m2 * diameter_m * diameter_m / 8.0)
            } else {
                (shaft.youngs_modulus.at(parameters, operating), area_m2)
            };
            *rod = Rod {
                stiffness: modulus * section / length_m,
                transit_s: length_m * (density / modulus).sqrt(),
                loss_factor: shaft.loss_factor.at(parameters, operating),
                elements: match shape.representation {
                    Rods::Exact => 0,
                    Rods::Lumped(elements) => elements.max(1),
                },
            };
        }
        let share_s = machine.stiffness_proportional_damping_s;
        for ((joint, numbers), on) in machine.joints.iter().zip(&mut self.joints).zip(&shape.joints) {
            let stiffness = joint.stiffness.at(parameters, operating);
            *numbers = JointNumbers {
                stiffness,
                damping: joint.damping.at(parameters, operating) + share_s * stiffness,
                loss_factor: joint.loss_factor.at(parameters, operating),
                relaxation_stiffness: joint.relaxation_stiffness.as_ref().map(|k| k.at(parameters, operating)),
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

    /// Assembles D(ω) without damping and factors it; gives the number of negative pivots and of rod poles below ω.
    fn factor_undamped(&self, omega_rad_s: f64, entries: &mut [f64]) -> usize {
        let pattern = &self.structure.elimination;
        entries.copy_from_slice(&self.stiffness);
        let square = omega_rad_s * omega_rad_s;
        for (slot, m) in self.structure.diagonal.iter().zip(&self.inertia) {
            entries[*slot] -= square * m;
        }
        let mut below = 0;
        for (rod, slots) in self.rods.iter().zip(&self.structure.rod_slots) {
            below += rod.clamped_modes_below(omega_rad_s);
            let (direct, cross) = rod.undamped(omega_rad_s);
            for (slot, entry) in slots.iter().zip([direct, direct, cross]) {
                if let Some(slot) = *slot {
                    entries[slot] += entry;
                }
            }
        }
        pattern.factor(entries, |d| below += usize::from(d.is_sign_negative()));
        below
    }

    /// Number of undamped natural frequencies below ω, rigid-body modes included.
    ///
    /// # Source  Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263–284: J = J₀ + s{D}.
    pub fn modes_below(&self, omega_rad_s: f64, work: &mut Workspace) -> usize {
        self.factor_undamped(omega_rad_s, &mut work.real)
    }

    /// Displacements of all coordinates under a unit force at the response, without damping.
    pub(super) fn undamped_shape(&self, omega_rad_s: f64, force: &[f64], work: &mut Workspace) -> Vec<f64> {
        self.factor_undamped(omega_rad_s, &mut work.real);
        let mut x = force.to_vec();
        self.structure.elimination.solve(&work.real, &mut x);
        x
    }

    /// Assembles D(ω) with damping and factors it; gives the direction of its determinant.
    fn factor_damped(&self, omega_rad_s: f64, work: &mut Workspace) -> Complex64 {
        let shape = &self.structure;
        let pattern = &shape.elimination;
        let square = omega_rad_s * omega_rad_s;
        let (added, _) = loss(omega_rad_s);
        let spring_dampers = self.stiffness.iter().zip(&self.damping).zip(&self.loss);
        for (entry, ((k, c), h)) in work.complex.iter_mut().zip(spring_dampers) {
            *entry = Complex64::new(*k + h * added.re, omega_rad_s * c + h);
        }
        for (slot, m) in shape.diagonal.iter().zip(&self.inertia) {
            work.complex[*slot].re -= square * m;
        }
        let mut determinant = Complex64::new(1.0, 0.0);
        work.rods.clear();
        for (rod, slots) in self.rods.iter().zip(&shape.rod_slots) {
            let entries = rod.damped(omega_rad_s);
            work.rods.push(entries);
            if entries.lossless {
                determinant *= entries.sin.re;
            } else {
                determinant *= entries.sin;
            }
            for (slot, entry) in slots.iter().zip([entries.direct, entries.direct, entries.cross]) {
                if let Some(slot) = *slot {
                    work.complex[slot] += entry;
                }
            }
        }
        for (joint, on) in self.joints.iter().zip(&shape.joints).filter(|(j, _)| j.relaxation_stiffness.is_some()) {
            let damper = joint.dynamic(omega_rad_s).0 - joint.spring(omega_rad_s).0;
            for (at, &(i, a)) in on.iter().enumerate() {
                for &(j, b) in &on[..=at] {
                    work.complex[pattern.entry(i, j)] += damper * (a * b);
                }
            }
        }
        pattern.factor(&mut work.complex, |d| {
            determinant *= d * (1.0 / (d.re.abs() + d.im.abs()));
        });
        determinant
    }

    /// Factors D(ω) and fills in the displacements under a unit force at the excitation.
    fn displace(&self, omega_rad_s: f64, work: &mut Workspace) -> (Complex64, Complex64) {
        let shape = &self.structure;
        let determinant = self.factor_damped(omega_rad_s, work);
        work.at_excitation.fill(Complex64::new(0.0, 0.0));
        work.at_excitation[shape.excitation] = Complex64::new(1.0, 0.0);
        shape.elimination.solve_last(&work.complex, &mut work.at_excitation);
        (work.at_excitation[shape.response], determinant)
    }

    /// Receptance at one frequency, alone.
    pub fn receptance(&self, omega_rad_s: f64, work: &mut Workspace) -> Complex64 {
        self.displace(omega_rad_s, work).0
    }

    /// Receptance, with the displacements under unit forces at the excitation and at the response left in `work`.
    pub(super) fn solve(&self, omega_rad_s: f64, work: &mut Workspace) -> Complex64 {
        let (receptance, _) = self.displace(omega_rad_s, work);
        self.displace_response(work);
        receptance
    }

    fn displace_response(&self, work: &mut Workspace) {
        let shape = &self.structure;
        if shape.response != shape.excitation {
            work.at_response.fill(Complex64::new(0.0, 0.0));
            work.at_response[shape.response] = Complex64::new(1.0, 0.0);
            shape.elimination.solve(&work.complex, &mut work.at_response);
        }
    }

    /// Receptance, its slope and the direction of the determinant at one frequency.
    pub fn at(&self, omega_rad_s: f64, work: &mut Workspace) -> Point {
        let (receptance, determinant) = self.displace(omega_rad_s, work);
        self.displace_response(work);
        let (at_excitation, at_response, rods) = work.solutions(&self.structure);
        let slope = -self.bilinear_slope(omega_rad_s, rods, at_response, at_excitation);
        Point { omega_rad_s, receptance, slope, determinant }
    }

    /// Entries of all rods at ω.
    pub(super) fn rod_entries(&self, omega_rad_s: f64) -> Vec<RodEntries> {
        self.rods.iter().map(|r| r.damped(omega_rad_s)).collect()
    }

    /// aᵀ·(dD/dω)·b.
    /// `rods` are the entries of all rods at ω.
    pub(super) fn bilinear_slope(&self, omega_rad_s: f64, rods: &[RodEntries], a: &[Complex64], b: &[Complex64]) -> Complex64 {
        let shape = &self.structure;
        let zero = Complex64::new(0.0, 0.0);
        let mut sum = zero;
        for ((m, x), y) in self.inertia.iter().zip(a).zip(b) {
            sum -= x * y * (2.0 * omega_rad_s * m);
        }
        for (joint, on) in self.joints.iter().zip(&shape.joints) {
            let x: Complex64 = on.iter().map(|&(i, c)| a[i] * c).sum();
            let y: Complex64 = on.iter().map(|&(i, c)| b[i] * c).sum();
            let product = x * y;
            sum += match joint.relaxation_stiffness {
                None => Complex64::new(-product.im * joint.damping, product.re * joint.damping) + product * joint.spring(omega_rad_s).1,
                Some(_) => product * joint.dynamic(omega_rad_s).1,
            };
        }
        for ((entries, rod), rod_shape) in rods.iter().zip(&self.rods).zip(&shape.rods) {
            let (i, j) = (rod_shape.along[0], rod_shape.along[1]);
            let (xi, xj) = (i.map_or(zero, |i| a[i]), j.map_or(zero, |j| a[j]));
            let (yi, yj) = (i.map_or(zero, |i| b[i]), j.map_or(zero, |j| b[j]));
            let (direct, cross) = (xi * yi + xj * yj, xi * yj + xj * yi);
            sum += if entries.lossless {
                direct * entries.direct_slope.re + cross * entries.cross_slope.re
            } else {
                let (by_direct, by_cross) = entries.by_material(omega_rad_s);
                let drift = loss(omega_rad_s).1 * rod.loss_factor / rod.material(omega_rad_s);
                direct * (entries.direct_slope + by_direct * drift) + cross * (entries.cross_slope + by_cross * drift)
            };
        }
        sum
    }
}
