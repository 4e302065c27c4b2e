//! Settings and starting grid of a peak search.

use super::frequency_grid::FrequencyGrid;
use super::rational_interpolant::nodes;
use numeric::unit::omega_rad_s;

/// Number of pieces into which the band is divided first.
pub(super) const PIECES: usize = 4;

/// Band and precision of a peak search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakSearch {
    /// Lower end of the band (Hz), above 0.
    pub from_hz: f64,
    /// Upper end of the band (Hz).
    pub to_hz: f64,
    /// Relative precision of the frequencies.
    pub precision: f64,
    /// Power p of the factor ω^p on |H|: 0 receptance, 1 mobility, 2 accelerance.
    pub omega_power: i32,
}

impl PeakSearch {
    /// Returns the ends of the first pieces (rad/s), equally spaced in √ω: the low frequencies, where modes
    /// of heavy tables lie, get finer pieces.
    pub(super) fn cuts(&self) -> [f64; PIECES + 1] {
        let (from, to) = (omega_rad_s(self.from_hz), omega_rad_s(self.to_hz));
        std::array::from_fn(|at| match at {
            0 => from,
            PIECES => to,
            _ => (from.sqrt() + at as f64 / PIECES as f64 * (to.sqrt() - from.sqrt())).powi(2),
        })
    }

    /// Returns the frequencies at which every search starts.
    pub fn start_grid(&self) -> FrequencyGrid {
        let cuts = self.cuts();
        FrequencyGrid::new(&cuts.windows(2).flat_map(|ends| nodes((ends[0], ends[1]))).collect::<Vec<_>>())
    }
}
