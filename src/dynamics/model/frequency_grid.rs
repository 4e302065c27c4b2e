//! Lines of a record, with what depends on them alone.

use super::assembled_model::AssembledModel;
use super::rod::Rod;
use super::simd::{LANES, Reals, filled};

/// Frequencies at which receptances are asked for again and again, in groups side by side, with the entries of rods there.
#[derive(Debug, Clone)]
pub struct FrequencyGrid {
    omega_rad_s: Vec<Reals>,
    rods: Vec<RodCache>,
}

/// Direct and cross entries of a rod at all lines, and sin φ; none where it is not known.
#[derive(Debug, Clone)]
struct RodCache {
    rod: Rod,
    entries: Vec<(Reals, Reals)>,
    sines: Vec<Reals>,
}

/// What is known of a rod at some lines, group by group.
#[derive(Clone, Copy)]
pub(super) struct KnownRod<'k> {
    /// Direct and cross entries.
    pub entries: &'k [(Reals, Reals)],
    /// sin φ.
    pub sines: &'k [Reals],
}

impl FrequencyGrid {
    /// Some frequencies (rad/s) alone.
    pub fn new(omega_rad_s: &[f64]) -> Self {
        FrequencyGrid { omega_rad_s: omega_rad_s.chunks(LANES).map(filled).collect(), rods: Vec::new() }
    }

    /// Keeps the entries of a network's rods, where `stays` says that a rod (by number) will not change and it has no loss. A rod that has changed all the
    /// same is computed anew.
    pub fn keep_rods(&mut self, network: &AssembledModel, stays: impl Fn(usize) -> bool) {
        let known = |(at, rod): (usize, &Rod)| {
            let kept = rod.loss_factor == 0.0 && stays(at);
            let lines = if kept { self.omega_rad_s.as_slice() } else { &[] };
            let (entries, sines) =
                lines.iter().map(|omega| rod.damped_each(*omega)).map(|of| ((of.direct.re, of.cross.re), of.sin.re)).unzip();
            RodCache { rod: *rod, entries, sines }
        };
        self.rods = network.rods.iter().enumerate().map(known).collect();
    }

    /// Its frequencies (rad/s); the last group is filled up with the last one.
    pub fn omega_rad_s(&self) -> &[Reals] {
        &self.omega_rad_s
    }

    /// A rod at some groups of lines, where it is known.
    pub(super) fn known(&self, at: usize, rod: &Rod, groups: std::ops::Range<usize>) -> Option<KnownRod<'_>> {
        let known = self.rods.get(at).filter(|known| known.rod == *rod && !known.entries.is_empty())?;
        Some(KnownRod { entries: &known.entries[groups.clone()], sines: &known.sines[groups] })
    }
}
