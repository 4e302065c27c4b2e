//! Assembly and factorisation of the dynamic stiffness D(ω), and the mode count that follows from it.

use super::assembled_model::AssembledModel;
use super::frequency_grid::{Frequencies, KnownRod};
use super::rod::{Rod, loss_each};
use super::simd::{ABREAST, Complexes, LANES, Reals, grouped};
use super::workspace::Workspace;

impl AssembledModel {
    /// Counts the undamped natural frequencies below ω, rigid-body modes included.
    ///
    /// # Source  Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263–284: J = J₀ + s{D}.
    pub fn modes_below(&self, omega_rad_s: f64, work: &mut Workspace) -> usize {
        self.factor_undamped(&[Reals::splat(omega_rad_s)], &mut work.real)[0].to_array()[0] as usize
    }

    /// Counts as [`AssembledModel::modes_below`], at several frequencies.
    pub fn modes_below_each(&self, omega_rad_s: &[f64], work: &mut Workspace, below: &mut Vec<usize>) {
        below.clear();
        for some in omega_rad_s.chunks(ABREAST * LANES) {
            let (omegas, abreast) = grouped(some);
            let counts = self.factor_undamped(&omegas[..abreast], &mut work.real);
            below.extend(counts.iter().flat_map(|c| c.to_array()).take(some.len()).map(|c| c as usize));
        }
    }

    /// Assembles D(ω) without damping and factors it. Returns the number of negative pivots plus the number
    /// of rod poles below each ω.
    pub(super) fn factor_undamped(&self, omega_rad_s: &[Reals], entries: &mut [Reals]) -> [Reals; ABREAST] {
        let (pattern, abreast) = (&self.structure.elimination, omega_rad_s.len());
        let entries = &mut entries[..pattern.slots() * abreast];
        for (entries, k) in entries.chunks_exact_mut(abreast).zip(&self.stiffness) {
            entries.fill(Reals::splat(*k));
        }
        for (slot, m) in self.structure.diagonal.iter().zip(&self.inertia).filter(|(_, m)| **m != 0.0) {
            for (entry, omega) in entries[slot * abreast..].iter_mut().zip(omega_rad_s) {
                *entry -= *omega * *omega * Reals::splat(*m);
            }
        }
        let mut below = [Reals::ZERO; ABREAST];
        for (rod, slots) in self.rods.iter().zip(&self.structure.rod_slots) {
            for (w, (omega, below)) in omega_rad_s.iter().zip(&mut below).enumerate() {
                *below += rod.clamped_modes_below_each(*omega);
                let (direct, cross) = rod.undamped_each(*omega);
                for (slot, entry) in slots.iter().zip([direct, direct, cross]) {
                    if let Some(slot) = *slot {
                        entries[slot * abreast + w] += entry;
                    }
                }
            }
        }
        for (beam, shape) in self.beams.iter().zip(&self.structure.beams) {
            for (w, (omega, below)) in omega_rad_s.iter().zip(&mut below).enumerate() {
                let (of, held) = beam.undamped_each(*omega);
                *below += held;
                entries[self.structure.diagonal[shape.coordinate] * abreast + w] += of;
            }
        }
        pattern.factor(abreast, entries, &self.real, |w, d, _| below[w] += d.is_sign_negative() & Reals::ONE);
        below
    }

    /// Returns s = iω, or iω + σ with the window of a record.
    #[inline]
    pub(super) fn complex_frequency_each(&self, omega_rad_s: Reals) -> Complexes {
        Complexes::new(Reals::splat(self.window_per_s), omega_rad_s)
    }

    /// Assembles D(ω) with damping into `entries`, except for the rods.
    ///
    /// # Source  window: the transform of x(t)·e^(−σt) is that of x(t) at s + σ, so that all iω become iω +
    ///   σ.
    pub(super) fn assemble(&self, omega_rad_s: &[Reals], entries: &mut [Complexes]) {
        let (shape, abreast) = (&self.structure, omega_rad_s.len());
        let spring_dampers = self.stiffness.iter().zip(&self.damping).zip(&self.loss);
        let dispersion: [Reals; ABREAST] = match self.has_loss {
            true => std::array::from_fn(|w| {
                omega_rad_s.get(w).map_or(Reals::ZERO, |omega| loss_each(*omega, self.dispersion).0.re)
            }),
            false => [Reals::ZERO; ABREAST],
        };
        for (entries, ((k, c), h)) in entries.chunks_exact_mut(abreast).zip(spring_dampers) {
            let (k, c) = (Reals::splat(*k + self.window_per_s * *c), Reals::splat(*c));
            entries
                .iter_mut()
                .zip(omega_rad_s)
                .for_each(|(entry, omega)| *entry = Complexes::new(k, *omega * c));
            if *h != 0.0 {
                let h = Reals::splat(*h);
                for (entry, dispersion) in entries.iter_mut().zip(&dispersion) {
                    *entry += Complexes::new(h * *dispersion, h);
                }
            }
        }
        for (slot, m) in shape.diagonal.iter().zip(&self.inertia).filter(|(_, m)| **m != 0.0) {
            for (entry, omega) in entries[slot * abreast..].iter_mut().zip(omega_rad_s) {
                entry.re -= *omega * *omega * Reals::splat(*m);
            }
            if self.window_per_s != 0.0 {
                let (square, twice) =
                    (Reals::splat(m * self.window_per_s.powi(2)), Reals::splat(2.0 * m * self.window_per_s));
                for (entry, omega) in entries[slot * abreast..].iter_mut().zip(omega_rad_s) {
                    *entry += Complexes::new(square, *omega * twice);
                }
            }
        }
        for (beam, of) in self.beams.iter().zip(&shape.beams) {
            for (w, omega) in omega_rad_s.iter().enumerate() {
                entries[shape.diagonal[of.coordinate] * abreast + w] += beam.damped_each(*omega);
            }
        }
        for (joint, on) in self.joints.iter().zip(&self.joint_points) {
            if !joint.has_extra_dynamics() {
                continue;
            }
            for (w, omega) in omega_rad_s.iter().enumerate() {
                let s = self.complex_frequency_each(*omega);
                let mut damper =
                    joint.relaxation_stiffness.map_or(Complexes::ZERO, |k| joint.damper_each(k, s));
                if joint.integral_rate != 0.0 {
                    damper += joint.integral_each(s);
                }
                for (at, &(i, a)) in on.iter().enumerate() {
                    for &(j, b) in &on[..=at] {
                        entries[shape.elimination.entry(i, j) * abreast + w] += damper * (a * b);
                    }
                }
            }
        }
    }

    /// Assembles D(ω) with damping and factors it. Multiplies `determinants` by det D·Π sin φ, which has no
    /// rod poles, with one scale for all frequencies.
    #[inline]
    pub(super) fn factor_damped<'k>(
        &self,
        at: Frequencies<'_>,
        known: impl Fn(usize, &Rod) -> Option<KnownRod<'k>>,
        work: &mut Workspace,
        mut determinants: Option<&mut [Complexes; ABREAST]>,
    ) {
        let omega_rad_s = at.omega_rad_s;
        let (shape, abreast) = (&self.structure, omega_rad_s.len());
        let entries = &mut work.complex[..shape.elimination.slots() * abreast];
        self.assemble(omega_rad_s, entries);
        let mut materials = [None; ABREAST];
        for (number, (rod, slots)) in self.rods.iter().zip(&shape.rod_slots).enumerate() {
            let [left, right, cross] =
                slots.map(|slot| slot.map(|slot| slot * abreast..(slot + 1) * abreast));
            if let Some(known) = known(number, rod) {
                for slots in left.into_iter().chain(right) {
                    entries[slots].iter_mut().zip(known.entries).for_each(|(entry, of)| entry.re += of.0);
                }
                if let Some(slots) = cross {
                    entries[slots].iter_mut().zip(known.entries).for_each(|(entry, of)| entry.re += of.1);
                }
                if let Some(determinants) = &mut determinants {
                    determinants.iter_mut().zip(known.sines).for_each(|(d, sin)| *d = *d * *sin);
                }
                continue;
            }
            for (pair, omegas) in omega_rad_s.chunks(2).enumerate() {
                let first = 2 * pair;
                let lossless = rod
                    .is_lossless()
                    .then(|| rod.lossless_each([omegas[0], omegas[omegas.len() - 1]]))
                    .flatten();
                if let Some(pair) = lossless {
                    for (w, [direct, cross_entry, sin]) in (first..abreast).zip(pair) {
                        for (slots, entry) in
                            [&left, &right, &cross].into_iter().zip([direct, direct, cross_entry])
                        {
                            slots.iter().for_each(|slots| entries[slots.start + w].re += entry);
                        }
                        determinants.iter_mut().for_each(|d| d[w] = d[w] * sin);
                    }
                    continue;
                }
                for (w, omega) in (first..).zip(omegas) {
                    let compute = || rod.damped_with_material(*omega, &mut materials[w]);
                    at.with_entries(number, rod, w, compute, |of| {
                        for (slots, entry) in
                            [&left, &right, &cross].into_iter().zip([of.direct, of.direct, of.cross])
                        {
                            slots.iter().for_each(|slots| entries[slots.start + w] += entry);
                        }
                        determinants.iter_mut().for_each(|d| d[w] *= of.sin);
                    });
                }
            }
        }
        let Some(determinants) = determinants else {
            shape.elimination.factor(abreast, entries, &self.real, |_, _, _| ());
            return;
        };
        for beam in &self.beams {
            determinants.iter_mut().zip(omega_rad_s).for_each(|(d, omega)| *d *= beam.poles_each(*omega));
        }
        let mut scale = Reals::ONE;
        shape.elimination.factor(abreast, entries, &self.real, |w, d, inverse| {
            if w == 0 {
                scale = Reals::splat((inverse.re.abs() + inverse.im.abs()).to_array()[0]);
            }
            determinants[w] *= d * scale;
        });
    }
}
