//! Receptances of an assembled model and their slopes.

use std::ops::Range;

use num_complex::Complex64;

use super::assembled_model::AssembledModel;
use super::frequency_grid::{Frequencies, FrequencyGrid, KnownRod};
use super::rod::Rod;
use super::simd::{ABREAST, Complexes, LANES, Reals, grouped};
use super::solution::{Row, Solution};
use super::structure::Structure;
use super::workspace::Workspace;

/// The two ends of a receptance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ReceptanceEnd {
    /// The response.
    Response,
    /// The excitation.
    Excitation,
}

impl Structure {
    /// Whether response and excitation differ, in their points or in their lever arms.
    fn has_two_ends(&self) -> bool {
        self.response != self.excitation || !self.response_arms.is_empty()
    }
}

impl AssembledModel {
    /// Solves for the displacements under a unit force at one end, with its lever arms, for some groups of
    /// frequencies. D must be factored.
    fn solve_unit_force(
        &self,
        end: ReceptanceEnd,
        abreast: usize,
        (entries, x): (&[Complexes], &mut [Complexes]),
    ) {
        let shape = &self.structure;
        let (at, arms) = match end {
            ReceptanceEnd::Response => (shape.response, &shape.response_arms),
            ReceptanceEnd::Excitation => (shape.excitation, &shape.excitation_arms),
        };
        x[..shape.size() * abreast].fill(Complexes::ZERO);
        x[at * abreast..][..abreast].fill(Complexes::real(Reals::ONE));
        for (lever, on) in arms {
            x[on * abreast..][..abreast]
                .fill(Complexes::real(Reals::splat(self.levers[*lever][end as usize])));
        }
        if arms.is_empty() && end == ReceptanceEnd::Excitation {
            // The force acts on the coordinate eliminated last.
            shape.elimination.solve_last(abreast, entries, x);
        } else {
            shape.elimination.solve(abreast, entries, x);
        }
    }

    /// Factors D(ω) and solves for the displacements under unit forces at the excitation and at the response.
    /// Leaves the rods' entries in `work`.
    fn solve_both_ends(&self, at: Frequencies<'_>, work: &mut Workspace) {
        let omega_rad_s = at.omega_rad_s;
        let (shape, abreast) = (&self.structure, omega_rad_s.len());
        let entries = &mut work.complex[..shape.elimination.slots() * abreast];
        self.assemble(omega_rad_s, entries);
        work.rods.clear();
        let mut materials = [None; ABREAST];
        for (number, (rod, slots)) in self.rods.iter().zip(&shape.rod_slots).enumerate() {
            for (w, (omega, material)) in omega_rad_s.iter().zip(&mut materials).enumerate() {
                let compute = || rod.damped_with_material(*omega, material);
                at.with_entries(number, rod, w, compute, |of| {
                    for (slot, entry) in slots.iter().zip([of.direct, of.direct, of.cross]) {
                        if let Some(slot) = *slot {
                            entries[slot * abreast + w] += entry;
                        }
                    }
                    work.rods.push(*of);
                });
            }
        }
        shape.elimination.factor(abreast, entries, &self.real, |_, _, _| ());
        self.solve_unit_force(ReceptanceEnd::Excitation, abreast, (&work.complex, &mut work.at_excitation));
        if shape.has_two_ends() {
            self.solve_unit_force(ReceptanceEnd::Response, abreast, (&work.complex, &mut work.at_response));
        }
        self.add_response_arms(abreast, work);
    }

    /// Returns the result of [`AssembledModel::solve_both_ends`].
    fn solution<'w>(&self, omega_rad_s: &'w [Reals], work: &'w Workspace) -> Solution<'w> {
        let at_response = if self.structure.has_two_ends() { &work.at_response } else { &work.at_excitation };
        Solution { omega_rad_s, at_excitation: &work.at_excitation, at_response, rods: &work.rods }
    }

    /// Computes the reading of the response with its lever arms.
    fn add_response_arms(&self, abreast: usize, work: &mut Workspace) {
        let shape = &self.structure;
        if shape.response_arms.is_empty() {
            return;
        }
        for (w, sum) in work.response_with_arms[..abreast].iter_mut().enumerate() {
            let arms = shape.response_arms.iter().map(|(lever, on)| {
                work.at_excitation[on * abreast + w] * self.levers[*lever][ReceptanceEnd::Response as usize]
            });
            *sum = arms.fold(work.at_excitation[shape.response * abreast + w], |sum, x| sum + x);
        }
    }

    /// Returns the displacement of the response under a unit force at the excitation.
    fn response<'w>(&self, abreast: usize, work: &'w Workspace) -> &'w [Complexes] {
        if !self.structure.response_arms.is_empty() {
            return &work.response_with_arms[..abreast];
        }
        &work.at_excitation[self.structure.response * abreast..][..abreast]
    }

    /// Computes the receptance at one frequency.
    pub fn receptance(&self, omega_rad_s: f64, work: &mut Workspace) -> Complex64 {
        self.receptances(&[Reals::splat(omega_rad_s)], work)[0].lanes()[0]
    }

    /// Computes the receptances at any number of frequencies.
    pub fn sweep(&self, omega_rad_s: &[f64], work: &mut Workspace) -> Vec<Complex64> {
        let mut values = Vec::with_capacity(omega_rad_s.len());
        for some in omega_rad_s.chunks(ABREAST * LANES) {
            let (omegas, abreast) = grouped(some);
            let found = self.receptances(&omegas[..abreast], work);
            values.extend(found.iter().flat_map(|h| h.lanes()).take(some.len()));
        }
        values
    }

    /// Computes the receptances at up to [`ABREAST`] groups of frequencies.
    pub fn receptances<'w>(&self, omega_rad_s: &[Reals], work: &'w mut Workspace) -> &'w [Complexes] {
        self.factor_damped(Frequencies::any(omega_rad_s), |_, _| None, work, None);
        self.solve_response(omega_rad_s.len(), work)
    }

    /// Computes the receptances at up to [`ABREAST`] groups of a frequency grid, with its cached rods.
    pub fn receptances_on<'w>(
        &self,
        lines: &FrequencyGrid,
        groups: Range<usize>,
        work: &'w mut Workspace,
    ) -> &'w [Complexes] {
        self.factor_damped(
            Frequencies::of(lines, groups.clone()),
            |at, rod| lines.known(at, rod, groups.clone()),
            work,
            None,
        );
        self.solve_response(groups.len(), work)
    }

    /// Computes numerator and denominator of the receptance at up to [`ABREAST`] groups of frequencies, with
    /// cached rods: N = H·Δ and Δ = det D·Π sin φ. Neither has a pole; one call uses one common scale.
    pub(super) fn numerators_and_denominators<'k>(
        &self,
        omega_rad_s: &[Reals],
        known: impl Fn(usize, &Rod) -> Option<KnownRod<'k>>,
        work: &mut Workspace,
    ) -> [(Complexes, Complexes); ABREAST] {
        let mut denominators = [Complexes::real(Reals::ONE); ABREAST];
        self.factor_damped(Frequencies::any(omega_rad_s), known, work, Some(&mut denominators));
        let mut pairs = denominators.map(|d| (d, d));
        for ((n, _), h) in pairs.iter_mut().zip(self.solve_response(omega_rad_s.len(), work)) {
            *n *= *h;
        }
        pairs
    }

    /// Solves for the displacement of the response under a unit force at the excitation. D must be factored.
    #[inline]
    fn solve_response<'w>(&self, abreast: usize, work: &'w mut Workspace) -> &'w [Complexes] {
        let shape = &self.structure;
        // The coordinate eliminated last needs no back substitution: its inverse pivot is the receptance.
        if !shape.has_two_ends() {
            return &work.complex[shape.diagonal[shape.excitation] * abreast..][..abreast];
        }
        self.solve_unit_force(ReceptanceEnd::Excitation, abreast, (&work.complex, &mut work.at_excitation));
        self.add_response_arms(abreast, work);
        self.response(abreast, work)
    }

    /// Computes the receptances at some frequencies, and the solution behind them.
    pub(super) fn solve<'w>(
        &self,
        at: Frequencies<'w>,
        work: &'w mut Workspace,
    ) -> (&'w [Complexes], Solution<'w>) {
        self.solve_both_ends(at, work);
        (self.response(at.omega_rad_s.len(), work), self.solution(at.omega_rad_s, work))
    }

    /// Computes the receptance and its slope at one frequency.
    pub fn at(&self, omega_rad_s: f64, work: &mut Workspace) -> Row {
        let mut points = Vec::with_capacity(1);
        self.at_each(&[omega_rad_s], work, &mut points);
        points[0]
    }

    /// Computes as [`AssembledModel::at`], at several frequencies; replaces `points`.
    pub fn at_each(&self, omega_rad_s: &[f64], work: &mut Workspace, points: &mut Vec<Row>) {
        points.clear();
        for some in omega_rad_s.chunks(ABREAST * LANES) {
            let (omegas, abreast) = grouped(some);
            let omegas = &omegas[..abreast];
            self.solve_both_ends(Frequencies::any(omegas), work);
            let mut slopes = [Complexes::ZERO; ABREAST];
            self.bilinear_slopes(self.solution(omegas, work), &mut slopes[..abreast]);
            let groups = self.response(abreast, work).iter().zip(&slopes);
            let each = groups.flat_map(|(h, slope)| {
                let (h, slope) = (h.lanes(), slope.lanes());
                (0..LANES).map(move |lane| (h[lane], slope[lane]))
            });
            points.extend(some.iter().zip(each).map(|(&omega_rad_s, (receptance, slope))| Row {
                omega_rad_s,
                receptance,
                slope: -slope,
            }));
        }
    }
}
