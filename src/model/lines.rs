//! Lines of a record, with what depends on them alone.

use super::lanes::{LANES, Reals};
use super::network::{Network, filled};
use super::rod::Rod;

/// Frequencies at which receptances are asked for again and again, in groups side by side, with the entries of rods there.
#[derive(Debug, Clone)]
pub struct Lines {
    omega_rad_s: Vec<Reals>,
    rods: Vec<Known>,
}

/// Direct and cross entries of a rod at all lines; none where it is not known.
#[derive(Debug, Clone)]
struct Known {
    rod: Rod,
    entries: Vec<(Reals, Reals)>,
}

impl Lines {
    /// Some frequencies (rad/s) alone.
    pub fn new(omega_rad_s: &[f64]) -> Self {
        Lines { omega_rad_s: omega_rad_s.chunks(LANES).map(filled).collect(), rods: Vec::new() }
    }

    /// Keeps the entries of a network's rods, where `stays` says that a rod (by number) will not change and it has no loss. A rod that has changed all the
    /// same is computed anew.
    pub fn keep_rods(&mut self, network: &Network, stays: impl Fn(usize) -> bool) {
        let known = |(at, rod): (usize, &Rod)| {
            let entries = |omega: &Reals| {
                let of = rod.damped_each(*omega);
                (of.direct.re, of.cross.re)
            };
            let kept = rod.loss_factor == 0.0 && stays(at);
            Known { rod: *rod, entries: if kept { self.omega_rad_s.iter().map(entries).collect() } else { Vec::new() } }
        };
        self.rods = network.rods.iter().enumerate().map(known).collect();
    }

    /// Its frequencies (rad/s); the last group is filled up with the last one.
    pub fn omega_rad_s(&self) -> &[Reals] {
        &self.omega_rad_s
    }

    /// Direct and cross entries of a rod, group by group, where they are known.
    pub(super) fn known(&self, at: usize, rod: &Rod) -> Option<&[(Reals, Reals)]> {
        self.rods.get(at).filter(|known| known.rod == *rod && !known.entries.is_empty()).map(|known| known.entries.as_slice())
    }
}
