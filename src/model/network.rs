//! The numbers on a [`Structure`]: dynamic stiffness, receptance and its slope, count of modes.

use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex64;

use super::lanes::{Complexes, LANES, Reals};
use super::rod::{Rod, RodLanes, loss};
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
    /// Whether any joint has a loss factor.
    loses: bool,
}

/// Room for evaluations at some frequencies at once; keep it and none allocates.
#[derive(Debug, Clone)]
pub struct Workspace {
    real: Vec<Reals>,
    complex: Vec<Complexes>,
    rods: Vec<RodLanes>,
    at_excitation: Vec<Complexes>,
    at_response: Vec<Complexes>,
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
    pub(super) fn solutions(&self, shape: &Structure) -> (&[Complexes], &[Complexes], &[RodLanes]) {
        let at_response = if shape.response == shape.excitation { &self.at_excitation } else { &self.at_response };
        (&self.at_excitation, at_response, &self.rods)
    }
}

impl Structure {
    /// Room for evaluations of this structure.
    pub fn workspace(&self) -> Workspace {
        Workspace {
            real: vec![Reals::ZERO; self.elimination.slots()],
            complex: vec![Complexes::ZERO; self.elimination.slots()],
            rods: Vec::with_capacity(self.rods.len()),
            at_excitation: vec![Complexes::ZERO; self.size()],
            at_response: vec![Complexes::ZERO; self.size()],
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
            loses: false,
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
        self.loses = self.loss.iter().any(|h| *h != 0.0);
    }

    /// Assembles D(ω) without damping and factors it; gives the numbers of negative pivots and of rod poles below each ω.
    fn factor_undamped(&self, omega_rad_s: Reals, entries: &mut [Reals]) -> [usize; LANES] {
        let pattern = &self.structure.elimination;
        for (entry, k) in entries.iter_mut().zip(&self.stiffness) {
            *entry = Reals::splat(*k);
        }
        let square = omega_rad_s * omega_rad_s;
        for (slot, m) in self.structure.diagonal.iter().zip(&self.inertia) {
            entries[*slot] -= square * Reals::splat(*m);
        }
        let mut below = Reals::ZERO;
        for (rod, slots) in self.rods.iter().zip(&self.structure.rod_slots) {
            below += rod.clamped_modes_below_each(omega_rad_s);
            let (direct, cross) = rod.undamped_each(omega_rad_s);
            for (slot, entry) in slots.iter().zip([direct, direct, cross]) {
                if let Some(slot) = *slot {
                    entries[slot] += entry;
                }
            }
        }
        pattern.factor(entries, |d| below += d.is_sign_negative() & Reals::ONE);
        below.to_array().map(|count| count as usize)
    }

    /// Number of undamped natural frequencies below ω, rigid-body modes included.
    ///
    /// # Source  Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263–284: J = J₀ + s{D}.
    pub fn modes_below(&self, omega_rad_s: f64, work: &mut Workspace) -> usize {
        self.factor_undamped(Reals::splat(omega_rad_s), &mut work.real)[0]
    }

    /// As [`Network::modes_below`], at some frequencies.
    pub fn modes_below_each(&self, omega_rad_s: &[f64], work: &mut Workspace, below: &mut Vec<usize>) {
        below.clear();
        for (omega, count) in lanes_of(omega_rad_s) {
            below.extend(&self.factor_undamped(omega, &mut work.real)[..count]);
        }
    }

    /// Displacements of all coordinates under a unit force at the response, without damping.
    pub(super) fn undamped_shape(&self, omega_rad_s: f64, force: &[f64], work: &mut Workspace) -> Vec<f64> {
        self.factor_undamped(Reals::splat(omega_rad_s), &mut work.real);
        let mut x: Vec<Reals> = force.iter().map(|f| Reals::splat(*f)).collect();
        self.structure.elimination.solve(&work.real, &mut x);
        x.into_iter().map(|x| x.to_array()[0]).collect()
    }

    /// Assembles D(ω) with damping and factors it; gives the direction of its determinant.
    fn factor_damped(&self, omega_rad_s: Reals, work: &mut Workspace) -> Complexes {
        let shape = &self.structure;
        let pattern = &shape.elimination;
        let square = omega_rad_s * omega_rad_s;
        let spring_dampers = self.stiffness.iter().zip(&self.damping).zip(&self.loss);
        if self.loses {
            let added = Complexes::each(|lane| loss(omega_rad_s.to_array()[lane]).0);
            for (entry, ((k, c), h)) in work.complex.iter_mut().zip(spring_dampers) {
                let (k, c, h) = (Reals::splat(*k), Reals::splat(*c), Reals::splat(*h));
                *entry = Complexes::new(k + h * added.re, omega_rad_s * c + h);
            }
        } else {
            for (entry, ((k, c), _)) in work.complex.iter_mut().zip(spring_dampers) {
                *entry = Complexes::new(Reals::splat(*k), omega_rad_s * Reals::splat(*c));
            }
        }
        for (slot, m) in shape.diagonal.iter().zip(&self.inertia) {
            work.complex[*slot].re -= square * Reals::splat(*m);
        }
        let mut determinant = Complexes::real(Reals::ONE);
        work.rods.clear();
        for (rod, slots) in self.rods.iter().zip(&shape.rod_slots) {
            let entries = rod.damped_each(omega_rad_s);
            if entries.lossless {
                determinant = determinant * entries.sin.re;
            } else {
                determinant *= entries.sin;
            }
            for (slot, entry) in slots.iter().zip([entries.direct, entries.direct, entries.cross]) {
                if let Some(slot) = *slot {
                    work.complex[slot] += entry;
                }
            }
            work.rods.push(entries);
        }
        for (joint, on) in self.joints.iter().zip(&shape.joints).filter(|(j, _)| j.relaxation_stiffness.is_some()) {
            let damper = Complexes::each(|lane| {
                let omega = omega_rad_s.to_array()[lane];
                joint.dynamic(omega).0 - joint.spring(omega).0
            });
            for (at, &(i, a)) in on.iter().enumerate() {
                for &(j, b) in &on[..=at] {
                    work.complex[pattern.entry(i, j)] += damper * (a * b);
                }
            }
        }
        pattern.factor(&mut work.complex, |d| {
            determinant *= d * (Reals::ONE / (d.re.abs() + d.im.abs()));
        });
        determinant
    }

    /// Factors D(ω) and fills in the displacements under a unit force at the excitation.
    fn displace(&self, omega_rad_s: Reals, work: &mut Workspace) -> Complexes {
        let shape = &self.structure;
        let determinant = self.factor_damped(omega_rad_s, work);
        work.at_excitation.fill(Complexes::ZERO);
        work.at_excitation[shape.excitation] = Complexes::real(Reals::ONE);
        shape.elimination.solve_last(&work.complex, &mut work.at_excitation);
        determinant
    }

    /// Receptance at one frequency, alone.
    pub fn receptance(&self, omega_rad_s: f64, work: &mut Workspace) -> Complex64 {
        self.receptances(Reals::splat(omega_rad_s), work).apart()[0]
    }

    /// Receptances at any number of frequencies.
    pub fn sweep(&self, omega_rad_s: &[f64], work: &mut Workspace) -> Vec<Complex64> {
        let some = |(omega, count): (Reals, usize)| self.receptances(omega, work).apart().into_iter().take(count);
        lanes_of(omega_rad_s).flat_map(some).collect()
    }

    /// Receptances at frequencies side by side.
    pub fn receptances(&self, omega_rad_s: Reals, work: &mut Workspace) -> Complexes {
        let shape = &self.structure;
        // What is eliminated last needs no way back: its pivot is the dynamic stiffness there.
        if shape.response == shape.excitation {
            self.factor_damped(omega_rad_s, work);
            return work.complex[shape.diagonal[shape.excitation]];
        }
        self.displace(omega_rad_s, work);
        work.at_excitation[shape.response]
    }

    /// Receptances, with the displacements under unit forces at the excitation and at the response left in `work`.
    pub(super) fn solve(&self, omega_rad_s: Reals, work: &mut Workspace) -> Complexes {
        self.displace(omega_rad_s, work);
        self.displace_response(work);
        work.at_excitation[self.structure.response]
    }

    fn displace_response(&self, work: &mut Workspace) {
        let shape = &self.structure;
        if shape.response != shape.excitation {
            work.at_response.fill(Complexes::ZERO);
            work.at_response[shape.response] = Complexes::real(Reals::ONE);
            shape.elimination.solve(&work.complex, &mut work.at_response);
        }
    }

    /// Receptance, its slope and the direction of the determinant at one frequency.
    pub fn at(&self, omega_rad_s: f64, work: &mut Workspace) -> Point {
        let mut points = Vec::with_capacity(1);
        self.at_each(&[omega_rad_s], work, &mut points);
        points[0]
    }

    /// As [`Network::at`], at some frequencies; `points` are replaced.
    pub fn at_each(&self, omega_rad_s: &[f64], work: &mut Workspace, points: &mut Vec<Point>) {
        points.clear();
        for (omega, count) in lanes_of(omega_rad_s) {
            let determinant = self.displace(omega, work);
            self.displace_response(work);
            let (at_excitation, at_response, rods) = work.solutions(&self.structure);
            let receptance = at_excitation[self.structure.response].apart();
            let slope = self.bilinear_slope(omega, rods, at_response, at_excitation).apart();
            let (omega, determinant) = (omega.to_array(), determinant.apart());
            points.extend((0..count).map(|lane| Point {
                omega_rad_s: omega[lane],
                receptance: receptance[lane],
                slope: -slope[lane],
                determinant: determinant[lane],
            }));
        }
    }

    /// Entries of all rods at ω.
    pub(super) fn rod_entries(&self, omega_rad_s: Reals) -> Vec<RodLanes> {
        self.rods.iter().map(|r| r.damped_each(omega_rad_s)).collect()
    }

    /// aᵀ·(dD/dω)·b.
    /// `rods` are the entries of all rods at ω.
    pub(super) fn bilinear_slope(&self, omega_rad_s: Reals, rods: &[RodLanes], a: &[Complexes], b: &[Complexes]) -> Complexes {
        let shape = &self.structure;
        let mut sum = Complexes::ZERO;
        for ((m, x), y) in self.inertia.iter().zip(a).zip(b).filter(|((m, _), _)| **m != 0.0) {
            sum -= *x * *y * (omega_rad_s * Reals::splat(2.0 * m));
        }
        for (joint, on) in self.joints.iter().zip(&shape.joints) {
            if joint.damping == 0.0 && joint.loss_factor == 0.0 {
                continue;
            }
            let of = |x: &[Complexes]| on.iter().fold(Complexes::ZERO, |sum, &(i, c)| sum + x[i] * c);
            let product = of(a) * of(b);
            if joint.relaxation_stiffness.is_none() && joint.loss_factor == 0.0 {
                sum += product.turned() * joint.damping;
            } else {
                sum += product * Complexes::each(|lane| joint.dynamic(omega_rad_s.to_array()[lane]).1);
            }
        }
        for ((entries, rod), rod_shape) in rods.iter().zip(&self.rods).zip(&shape.rods) {
            let end = |x: &[Complexes], at: Option<usize>| at.map_or(Complexes::ZERO, |at| x[at]);
            let (i, j) = (rod_shape.along[0], rod_shape.along[1]);
            let (xi, xj, yi, yj) = (end(a, i), end(a, j), end(b, i), end(b, j));
            let (direct, cross) = (xi * yi + xj * yj, xi * yj + xj * yi);
            sum += if entries.lossless {
                direct * entries.direct_slope.re + cross * entries.cross_slope.re
            } else {
                let (by_direct, by_cross) = entries.by_material(omega_rad_s);
                let drift = Complexes::each(|lane| {
                    let omega = omega_rad_s.to_array()[lane];
                    loss(omega).1 * rod.loss_factor / rod.material(omega)
                });
                direct * (entries.direct_slope + by_direct * drift) + cross * (entries.cross_slope + by_cross * drift)
            };
        }
        sum
    }
}

/// Frequencies side by side, and how many of each group count; the last is filled up.
fn lanes_of(omega_rad_s: &[f64]) -> impl Iterator<Item = (Reals, usize)> {
    omega_rad_s.chunks(LANES).map(|some| (filled(some), some.len()))
}

/// Up to as many numbers as stand side by side, the last one repeated.
pub(super) fn filled(some: &[f64]) -> Reals {
    Reals::from(std::array::from_fn(|lane| some[lane.min(some.len() - 1)]))
}
