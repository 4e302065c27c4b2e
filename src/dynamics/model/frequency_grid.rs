//! A fixed grid of frequencies, with cached entries of the rods.

use super::assembled_model::AssembledModel;
use super::rod::Rod;
use super::simd::{LANES, Reals, padded};

/// Frequencies for repeated receptance evaluations, in SIMD groups, with the cached entries of the rods.
#[derive(Debug, Clone)]
pub struct FrequencyGrid {
    omega_rad_s: Vec<Reals>,
    rods: Vec<RodCache>,
}

/// Direct and cross entries of a rod at all frequencies, and sin φ; empty where the rod is not cached.
#[derive(Debug, Clone)]
struct RodCache {
    rod: Rod,
    entries: Vec<(Reals, Reals)>,
    sines: Vec<Reals>,
}

/// Cached entries of a rod at some groups of frequencies.
#[derive(Clone, Copy)]
pub(super) struct KnownRod<'k> {
    /// Direct and cross entries.
    pub entries: &'k [(Reals, Reals)],
    /// sin φ.
    pub sines: &'k [Reals],
}

impl FrequencyGrid {
    /// Creates a grid from frequencies (rad/s), without cached rods.
    pub fn new(omega_rad_s: &[f64]) -> Self {
        FrequencyGrid { omega_rad_s: omega_rad_s.chunks(LANES).map(padded).collect(), rods: Vec::new() }
    }

    /// Caches the entries of the lossless rods for which `stays` is true (by rod number). A rod whose numbers differ from the cached ones is
    /// computed anew.
    pub fn keep_rods(&mut self, model: &AssembledModel, stays: impl Fn(usize) -> bool) {
        let known = |(at, rod): (usize, &Rod)| {
            let kept = rod.loss_factor == 0.0 && stays(at);
            let lines = if kept { self.omega_rad_s.as_slice() } else { &[] };
            let (entries, sines) =
                lines.iter().map(|omega| rod.damped_each(*omega)).map(|of| ((of.direct.re, of.cross.re), of.sin.re)).unzip();
            RodCache { rod: *rod, entries, sines }
        };
        self.rods = model.rods.iter().enumerate().map(known).collect();
    }

    /// Frequencies (rad/s) in SIMD groups; the last group is padded with the last frequency.
    pub fn omega_rad_s(&self) -> &[Reals] {
        &self.omega_rad_s
    }

    /// Returns the cached entries of a rod at some groups of frequencies.
    pub(super) fn known(&self, at: usize, rod: &Rod, groups: std::ops::Range<usize>) -> Option<KnownRod<'_>> {
        let known = self.rods.get(at).filter(|known| known.rod == *rod && !known.entries.is_empty())?;
        Some(KnownRod { entries: &known.entries[groups.clone()], sines: &known.sines[groups] })
    }
}
