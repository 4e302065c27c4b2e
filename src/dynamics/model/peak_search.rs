//! What a search of peaks is asked for, and where it begins.

use super::frequency_grid::FrequencyGrid;
use super::rational_interpolant::nodes;
use numeric::unit::omega_rad_s;

/// Pieces the band is first cut into.
pub(super) const PIECES: usize = 4;

/// Band and precision of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakSearch {
    /// Lower end of the band (Hz), above 0.
    pub from_hz: f64,
    /// Upper end of the band (Hz).
    pub to_hz: f64,
    /// Relative precision of the frequencies.
    pub precision: f64,
    /// Factor on |H|: ω to this power (0 receptance, 1 mobility, 2 accelerance), whose peaks are sought.
    pub omega_power: i32,
}

impl PeakSearch {
    /// Ends of the pieces that the band is first cut into, even in the square root of frequency: finer where modes of heavy tables lie.
    pub(super) fn cuts(&self) -> [f64; PIECES + 1] {
        let (from, to) = (omega_rad_s(self.from_hz), omega_rad_s(self.to_hz));
        std::array::from_fn(|at| match at {
            0 => from,
            PIECES => to,
            _ => (from.sqrt() + at as f64 / PIECES as f64 * (to.sqrt() - from.sqrt())).powi(2),
        })
    }

    /// Frequencies at which every search begins.
    pub fn lines(&self) -> FrequencyGrid {
        let cuts = self.cuts();
        FrequencyGrid::new(&cuts.windows(2).flat_map(|ends| nodes((ends[0], ends[1]))).collect::<Vec<_>>())
    }
}
