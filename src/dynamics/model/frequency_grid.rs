//! A fixed grid of frequencies, with cached entries of the rods.

use std::ops::Range;
use std::sync::Mutex;

use super::assembled_model::AssembledModel;
use super::rod::{Rod, RodLanes};
use super::simd::{LANES, Reals, padded};

/// Frequencies for repeated receptance evaluations, in SIMD groups, with the cached entries of the rods.
#[derive(Debug, Clone)]
pub struct FrequencyGrid {
    omega_rad_s: Vec<Reals>,
    rods: Vec<RodCache>,
    recent: Recent,
}

/// Entries of the rods at each group of frequencies, as last computed: trial values of other parameters leave
/// them unchanged. Channels of one position share them.
#[derive(Debug)]
struct Recent(Vec<Mutex<Vec<(Rod, RodLanes)>>>);

impl Recent {
    fn new(groups: usize) -> Self {
        Recent((0..groups).map(|_| Mutex::default()).collect())
    }
}

impl Clone for Recent {
    fn clone(&self) -> Self {
        Recent::new(self.0.len())
    }
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
        let omega_rad_s: Vec<Reals> = omega_rad_s.chunks(LANES).map(padded).collect();
        FrequencyGrid { recent: Recent::new(omega_rad_s.len()), omega_rad_s, rods: Vec::new() }
    }

    /// Caches the entries of the lossless rods for which `stays` is true (by rod number). A rod whose numbers
    /// differ from the cached ones is computed anew.
    pub fn keep_rods(&mut self, model: &AssembledModel, stays: impl Fn(usize) -> bool) {
        let known = |(at, rod): (usize, &Rod)| {
            let kept = rod.is_lossless() && stays(at);
            let lines = if kept { self.omega_rad_s.as_slice() } else { &[] };
            let (entries, sines) = lines
                .iter()
                .map(|omega| rod.damped_each(*omega))
                .map(|of| ((of.direct.re, of.cross.re), of.sin.re))
                .unzip();
            RodCache { rod: *rod, entries, sines }
        };
        self.rods = model.rods.iter().enumerate().map(known).collect();
    }

    /// Frequencies (rad/s) in SIMD groups; the last group is padded with the last frequency.
    pub fn omega_rad_s(&self) -> &[Reals] {
        &self.omega_rad_s
    }

    /// Returns the cached entries of a rod at some groups of frequencies.
    pub(super) fn known(&self, at: usize, rod: &Rod, groups: Range<usize>) -> Option<KnownRod<'_>> {
        let known = self.rods.get(at).filter(|known| known.rod == *rod && !known.entries.is_empty())?;
        Some(KnownRod { entries: &known.entries[groups.clone()], sines: &known.sines[groups] })
    }
}

/// Frequencies evaluated together.
#[derive(Debug, Clone, Copy)]
pub struct Frequencies<'g> {
    /// Frequencies (rad/s) in SIMD groups.
    pub(super) omega_rad_s: &'g [Reals],
    /// The grid to which they belong, and their first group there; `None` for others.
    grid: Option<(&'g FrequencyGrid, usize)>,
}

impl<'g> Frequencies<'g> {
    /// Returns some groups of a grid.
    pub fn of(grid: &'g FrequencyGrid, groups: Range<usize>) -> Self {
        Frequencies { omega_rad_s: &grid.omega_rad_s[groups.clone()], grid: Some((grid, groups.start)) }
    }

    /// Returns frequencies (rad/s) that belong to no grid.
    pub fn any(omega_rad_s: &'g [Reals]) -> Self {
        Frequencies { omega_rad_s, grid: None }
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.omega_rad_s.len()
    }

    /// Calls `read` with the entries of a rod (by number) at one of the groups: those last computed there,
    /// where the rod is the same. Handing out copies would cost more than most entries.
    #[inline]
    pub(super) fn with_entries(
        &self,
        at: usize,
        rod: &Rod,
        group: usize,
        compute: impl FnOnce() -> RodLanes,
        read: impl FnOnce(&RodLanes),
    ) {
        // A group that another thread uses is computed anew.
        let recent = self.grid.map(|(grid, first)| grid.recent.0[first + group].try_lock());
        let Some(Ok(mut recent)) = recent else { return read(&compute()) };
        match recent.get_mut(at) {
            Some((same, entries)) if same == rod => read(entries),
            Some((known, entries)) => {
                *known = *rod;
                *entries = compute();
                read(entries);
            }
            None => {
                let entries = compute();
                read(&entries);
                if recent.len() == at {
                    recent.push((*rod, entries));
                }
            }
        }
    }
}
