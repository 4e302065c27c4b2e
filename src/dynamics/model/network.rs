//! The numbers on a [`Structure`]: dynamic stiffness, receptance and its slope, count of modes.

use std::sync::Arc;

use num_complex::Complex64;

use super::joint::JointNumbers;
use super::lanes::{ABREAST, Complexes, LANES, Reals};
use super::lines::{KnownRod, Lines};
use super::peaks;
use super::rod::{Rod, RodLanes};
use super::solution::Solution;
use super::structure::{Rods, Structure};
use machine::{Machine, Operating};

/// A machine's numbers at one operating condition and one set of parameters.
#[derive(Debug, Clone)]
pub struct Network {
    pub(super) structure: Arc<Structure>,
    pub(super) rods: Vec<Rod>,
    pub(super) joints: Vec<JointNumbers>,
    /// Lumped inertia of each coordinate.
    pub(super) inertia: Vec<f64>,
    /// K, C and ηK of everything but rods and relaxing dampers, by slot.
    pub(super) stiffness: Vec<f64>,
    pub(super) damping: Vec<f64>,
    pub(super) loss: Vec<f64>,
    /// Which slots hold real numbers while D is factored.
    pub(super) real: Vec<bool>,
    /// Whether any joint has a loss factor.
    pub(super) loses: bool,
    /// r of sensor and hammer of each lever of the machine.
    levers: Vec<[f64; 2]>,
}

/// Room for evaluations at some frequencies at once; keep it and none allocates. What is kept for each of some groups of frequencies stands side by side.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub(super) real: Vec<Reals>,
    pub(super) complex: Vec<Complexes>,
    rods: Vec<RodLanes>,
    at_excitation: Vec<Complexes>,
    at_response: Vec<Complexes>,
    /// What is read on an arm.
    on_arm: Vec<Complexes>,
    /// Room for a search of peaks.
    pub(super) peaks: Option<Box<peaks::Room>>,
}

/// Where is read and where is struck.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum End {
    /// The response.
    Response,
    /// The excitation.
    Excitation,
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
}

impl Point {
    /// d ln|H| / dω (s): zero at a peak.
    pub fn log_slope_s(&self) -> f64 {
        (self.slope * self.receptance.conj()).re / self.receptance.norm_sqr()
    }
}

impl Structure {
    /// Room for evaluations of this structure.
    pub fn workspace(&self) -> Workspace {
        Workspace {
            real: vec![Reals::ZERO; self.elimination.slots() * ABREAST],
            complex: vec![Complexes::ZERO; self.elimination.slots() * ABREAST],
            rods: Vec::with_capacity(self.rods.len() * ABREAST),
            at_excitation: vec![Complexes::ZERO; self.size() * ABREAST],
            at_response: vec![Complexes::ZERO; self.size() * ABREAST],
            on_arm: vec![Complexes::ZERO; ABREAST],
            peaks: None,
        }
    }

    /// Whether response and excitation differ: points, or arms at them.
    fn has_two_ends(&self) -> bool {
        self.response != self.excitation || !self.read.is_empty()
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
            real: vec![false; slots],
            loses: false,
            levers: Vec::new(),
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
            let (area_m2, polar_m4) = shaft.section(parameters, operating);
            let density = shaft.density.at(parameters, operating);
            let (modulus, section) = if rod_shape.torsional {
                (shaft.shear_modulus.at(parameters, operating), polar_m4)
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
                integral_rate: joint.integral_rate.at(parameters, operating),
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
        self.find_real();
        self.loses = self.loss.iter().any(|h| *h != 0.0);
        self.levers.clear();
        self.levers.extend(machine.chain.levers.iter().map(|l| [&l.read, &l.struck].map(|r| r.at(parameters, operating))));
    }

    /// Displacements under a unit force at the excitation, or at the response, with its arms, for some groups of frequencies, once D is factored.
    fn displaced_by(&self, end: End, abreast: usize, (entries, x): (&[Complexes], &mut [Complexes])) {
        let shape = &self.structure;
        let (at, arms) = match end {
            End::Response => (shape.response, &shape.read),
            End::Excitation => (shape.excitation, &shape.struck),
        };
        x[..shape.size() * abreast].fill(Complexes::ZERO);
        x[at * abreast..][..abreast].fill(Complexes::real(Reals::ONE));
        for (lever, on) in arms {
            x[on * abreast..][..abreast].fill(Complexes::real(Reals::splat(self.levers[*lever][end as usize])));
        }
        if arms.is_empty() && end == End::Excitation {
            // The force acts where is eliminated last.
            shape.elimination.solve_last(abreast, entries, x);
        } else {
            shape.elimination.solve(abreast, entries, x);
        }
    }

    /// Number of undamped natural frequencies below ω, rigid-body modes included.
    ///
    /// # Source  Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263–284: J = J₀ + s{D}.
    pub fn modes_below(&self, omega_rad_s: f64, work: &mut Workspace) -> usize {
        self.factor_undamped(&[Reals::splat(omega_rad_s)], &mut work.real)[0].to_array()[0] as usize
    }

    /// As [`Network::modes_below`], at some frequencies.
    pub fn modes_below_each(&self, omega_rad_s: &[f64], work: &mut Workspace, below: &mut Vec<usize>) {
        below.clear();
        for some in omega_rad_s.chunks(ABREAST * LANES) {
            let (omegas, abreast) = grouped(some);
            let counts = self.factor_undamped(&omegas[..abreast], &mut work.real);
            below.extend(counts.iter().flat_map(|c| c.to_array()).take(some.len()).map(|c| c as usize));
        }
    }

    /// Displacements of all coordinates under a unit force at the response, without damping.
    pub(super) fn undamped_shape(&self, omega_rad_s: f64, force: &[f64], work: &mut Workspace) -> Vec<f64> {
        self.factor_undamped(&[Reals::splat(omega_rad_s)], &mut work.real);
        let mut x: Vec<Reals> = force.iter().map(|f| Reals::splat(*f)).collect();
        self.structure.elimination.solve(1, &work.real, &mut x);
        x.into_iter().map(|x| x.to_array()[0]).collect()
    }

    /// Factors D(ω), with the rods' entries left in `work`, and fills in the displacements under unit forces at the excitation and at the response.
    fn displace(&self, omega_rad_s: &[Reals], work: &mut Workspace) {
        let (shape, abreast) = (&self.structure, omega_rad_s.len());
        let entries = &mut work.complex[..shape.elimination.slots() * abreast];
        self.assemble(omega_rad_s, entries);
        work.rods.clear();
        for (rod, slots) in self.rods.iter().zip(&shape.rod_slots) {
            for (w, omega) in omega_rad_s.iter().enumerate() {
                let of = rod.damped_each(*omega);
                for (slot, entry) in slots.iter().zip([of.direct, of.direct, of.cross]) {
                    if let Some(slot) = *slot {
                        entries[slot * abreast + w] += entry;
                    }
                }
                work.rods.push(of);
            }
        }
        shape.elimination.factor(abreast, entries, &self.real, |_, _, _| ());
        self.displaced_by(End::Excitation, abreast, (&work.complex, &mut work.at_excitation));
        if shape.has_two_ends() {
            self.displaced_by(End::Response, abreast, (&work.complex, &mut work.at_response));
        }
        self.read_on_arm(abreast, work);
    }

    /// What [`Network::displace`] left behind.
    fn solution<'w>(&self, omega_rad_s: &'w [Reals], work: &'w Workspace) -> Solution<'w> {
        let at_response = if self.structure.has_two_ends() { &work.at_response } else { &work.at_excitation };
        Solution { omega_rad_s, at_excitation: &work.at_excitation, at_response, rods: &work.rods }
    }

    /// Works out what is read on the response's arms.
    fn read_on_arm(&self, abreast: usize, work: &mut Workspace) {
        let shape = &self.structure;
        if shape.read.is_empty() {
            return;
        }
        for (w, sum) in work.on_arm[..abreast].iter_mut().enumerate() {
            let arms =
                shape.read.iter().map(|(lever, on)| work.at_excitation[on * abreast + w] * self.levers[*lever][End::Response as usize]);
            *sum = arms.fold(work.at_excitation[shape.response * abreast + w], |sum, x| sum + x);
        }
    }

    /// Displacement of the response under a unit force at the excitation.
    fn response<'w>(&self, abreast: usize, work: &'w Workspace) -> &'w [Complexes] {
        if !self.structure.read.is_empty() {
            return &work.on_arm[..abreast];
        }
        &work.at_excitation[self.structure.response * abreast..][..abreast]
    }

    /// Receptance at one frequency, alone.
    pub fn receptance(&self, omega_rad_s: f64, work: &mut Workspace) -> Complex64 {
        self.receptances(&[Reals::splat(omega_rad_s)], work)[0].apart()[0]
    }

    /// Receptances at any number of frequencies.
    pub fn sweep(&self, omega_rad_s: &[f64], work: &mut Workspace) -> Vec<Complex64> {
        let mut values = Vec::with_capacity(omega_rad_s.len());
        for some in omega_rad_s.chunks(ABREAST * LANES) {
            let (omegas, abreast) = grouped(some);
            let found = self.receptances(&omegas[..abreast], work);
            values.extend(found.iter().flat_map(|h| h.apart()).take(some.len()));
        }
        values
    }

    /// Receptances at up to [`ABREAST`] groups of frequencies.
    pub fn receptances<'w>(&self, omega_rad_s: &[Reals], work: &'w mut Workspace) -> &'w [Complexes] {
        self.solved(omega_rad_s, |_, _| None, work, None);
        self.displaced(omega_rad_s.len(), work)
    }

    /// Receptances at up to [`ABREAST`] groups of some lines, with what is known of rods there.
    pub fn receptances_on<'w>(&self, lines: &Lines, groups: std::ops::Range<usize>, work: &'w mut Workspace) -> &'w [Complexes] {
        let omega_rad_s = &lines.omega_rad_s()[groups.clone()];
        self.solved(omega_rad_s, |at, rod| lines.known(at, rod, groups.clone()), work, None);
        self.displaced(omega_rad_s.len(), work)
    }

    /// Numerator and denominator of the receptance at up to [`ABREAST`] groups of frequencies, with what is known of rods there: N = H·Δ and
    /// Δ = det D·Π sin φ, neither of which has a pole, in one scale for all of a call.
    pub(super) fn fractions<'k>(
        &self,
        omega_rad_s: &[Reals],
        known: impl Fn(usize, &Rod) -> Option<KnownRod<'k>>,
        work: &mut Workspace,
    ) -> [(Complexes, Complexes); ABREAST] {
        let mut denominators = [Complexes::real(Reals::ONE); ABREAST];
        self.solved(omega_rad_s, known, work, Some(&mut denominators));
        let mut fractions = denominators.map(|d| (d, d));
        for ((n, _), h) in fractions.iter_mut().zip(self.displaced(omega_rad_s.len(), work)) {
            *n *= *h;
        }
        fractions
    }

    /// Displacement of the response under a unit force at the excitation, once D is factored.
    #[inline]
    fn displaced<'w>(&self, abreast: usize, work: &'w mut Workspace) -> &'w [Complexes] {
        let shape = &self.structure;
        // What is eliminated last needs no way back: its pivot is the dynamic stiffness there.
        if !shape.has_two_ends() {
            return &work.complex[shape.diagonal[shape.excitation] * abreast..][..abreast];
        }
        self.displaced_by(End::Excitation, abreast, (&work.complex, &mut work.at_excitation));
        self.read_on_arm(abreast, work);
        self.response(abreast, work)
    }

    /// Receptances at some groups of frequencies, and the solution they were read from.
    pub(super) fn solve<'w>(&self, omega_rad_s: &'w [Reals], work: &'w mut Workspace) -> (&'w [Complexes], Solution<'w>) {
        self.displace(omega_rad_s, work);
        (self.response(omega_rad_s.len(), work), self.solution(omega_rad_s, work))
    }

    /// Receptance and its slope at one frequency.
    pub fn at(&self, omega_rad_s: f64, work: &mut Workspace) -> Point {
        let mut points = Vec::with_capacity(1);
        self.at_each(&[omega_rad_s], work, &mut points);
        points[0]
    }

    /// As [`Network::at`], at some frequencies; `points` are replaced.
    pub fn at_each(&self, omega_rad_s: &[f64], work: &mut Workspace, points: &mut Vec<Point>) {
        points.clear();
        for some in omega_rad_s.chunks(ABREAST * LANES) {
            let (omegas, abreast) = grouped(some);
            let omegas = &omegas[..abreast];
            self.displace(omegas, work);
            let mut slopes = [Complexes::ZERO; ABREAST];
            self.bilinear_slopes(self.solution(omegas, work), &mut slopes[..abreast]);
            let groups = self.response(abreast, work).iter().zip(&slopes);
            let each = groups.flat_map(|(h, slope)| {
                let (h, slope) = (h.apart(), slope.apart());
                (0..LANES).map(move |lane| (h[lane], slope[lane]))
            });
            points.extend(some.iter().zip(each).map(|(&omega_rad_s, (receptance, slope))| Point {
                omega_rad_s,
                receptance,
                slope: -slope,
            }));
        }
    }

    /// Whether a rod has the same numbers here and in another network of the same structure.
    pub fn has_rod_of(&self, other: &Network, rod: usize) -> bool {
        self.rods[rod] == other.rods[rod]
    }
}

/// Up to [`ABREAST`] groups of frequencies side by side, and how many they are; the last frequency is repeated where the last group has room.
fn grouped(omega_rad_s: &[f64]) -> ([Reals; ABREAST], usize) {
    let abreast = omega_rad_s.len().div_ceil(LANES);
    let group = |w: usize| if w < abreast { filled(&omega_rad_s[w * LANES..omega_rad_s.len().min((w + 1) * LANES)]) } else { Reals::ONE };
    (std::array::from_fn(group), abreast)
}

/// Up to as many numbers as stand side by side, the last one repeated.
pub(super) fn filled(some: &[f64]) -> Reals {
    Reals::from(std::array::from_fn(|lane| some[lane.min(some.len() - 1)]))
}
