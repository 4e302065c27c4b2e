//! Receptances of a network and their slopes.

use num_complex::Complex64;

use super::assembled_model::AssembledModel;
use super::frequency_grid::{FrequencyGrid, KnownRod};
use super::rod::Rod;
use super::simd::{ABREAST, Complexes, LANES, Reals, grouped};
use super::solution::{Row, Solution};
use super::structure::Structure;
use super::workspace::Workspace;

/// Where is read and where is struck.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ShaftEnd {
    /// The response.
    Response,
    /// The excitation.
    Excitation,
}

impl Structure {
    /// Whether response and excitation differ: points, or arms at them.
    fn has_two_ends(&self) -> bool {
        self.response != self.excitation || !self.read.is_empty()
    }
}

impl AssembledModel {
    /// Displacements under a unit force at the excitation, or at the response, with its arms, for some groups of frequencies, once D is factored.
    fn displaced_by(&self, end: ShaftEnd, abreast: usize, (entries, x): (&[Complexes], &mut [Complexes])) {
        let shape = &self.structure;
        let (at, arms) = match end {
            ShaftEnd::Response => (shape.response, &shape.read),
            ShaftEnd::Excitation => (shape.excitation, &shape.struck),
        };
        x[..shape.size() * abreast].fill(Complexes::ZERO);
        x[at * abreast..][..abreast].fill(Complexes::real(Reals::ONE));
        for (lever, on) in arms {
            x[on * abreast..][..abreast].fill(Complexes::real(Reals::splat(self.levers[*lever][end as usize])));
        }
        if arms.is_empty() && end == ShaftEnd::Excitation {
            // The force acts where is eliminated last.
            shape.elimination.solve_last(abreast, entries, x);
        } else {
            shape.elimination.solve(abreast, entries, x);
        }
    }

    /// Factors D(ω), with the rods' entries left in `work`, and fills in the displacements under unit forces at the excitation and at the response.
    fn displace(&self, omega_rad_s: &[Reals], work: &mut Workspace) {
        let (shape, abreast) = (&self.structure, omega_rad_s.len());
        let entries = &mut work.complex[..shape.elimination.slots() * abreast];
        self.assemble(omega_rad_s, entries);
        work.rods.clear();
        let mut materials = [None; ABREAST];
        for (rod, slots) in self.rods.iter().zip(&shape.rod_slots) {
            for (w, (omega, material)) in omega_rad_s.iter().zip(&mut materials).enumerate() {
                let of = rod.damped_of(*omega, material);
                for (slot, entry) in slots.iter().zip([of.direct, of.direct, of.cross]) {
                    if let Some(slot) = *slot {
                        entries[slot * abreast + w] += entry;
                    }
                }
                work.rods.push(of);
            }
        }
        shape.elimination.factor(abreast, entries, &self.real, |_, _, _| ());
        self.displaced_by(ShaftEnd::Excitation, abreast, (&work.complex, &mut work.at_excitation));
        if shape.has_two_ends() {
            self.displaced_by(ShaftEnd::Response, abreast, (&work.complex, &mut work.at_response));
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
            let arms = shape
                .read
                .iter()
                .map(|(lever, on)| work.at_excitation[on * abreast + w] * self.levers[*lever][ShaftEnd::Response as usize]);
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
    pub fn receptances_on<'w>(&self, lines: &FrequencyGrid, groups: std::ops::Range<usize>, work: &'w mut Workspace) -> &'w [Complexes] {
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
        self.displaced_by(ShaftEnd::Excitation, abreast, (&work.complex, &mut work.at_excitation));
        self.read_on_arm(abreast, work);
        self.response(abreast, work)
    }

    /// Receptances at some groups of frequencies, and the solution they were read from.
    pub(super) fn solve<'w>(&self, omega_rad_s: &'w [Reals], work: &'w mut Workspace) -> (&'w [Complexes], Solution<'w>) {
        self.displace(omega_rad_s, work);
        (self.response(omega_rad_s.len(), work), self.solution(omega_rad_s, work))
    }

    /// Receptance and its slope at one frequency.
    pub fn at(&self, omega_rad_s: f64, work: &mut Workspace) -> Row {
        let mut points = Vec::with_capacity(1);
        self.at_each(&[omega_rad_s], work, &mut points);
        points[0]
    }

    /// As [`AssembledModel::at`], at some frequencies; `points` are replaced.
    pub fn at_each(&self, omega_rad_s: &[f64], work: &mut Workspace, points: &mut Vec<Row>) {
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
            points.extend(some.iter().zip(each).map(|(&omega_rad_s, (receptance, slope))| Row { omega_rad_s, receptance, slope: -slope }));
        }
    }
}
