//! What a prediction computes.

use crate::simulation::Place;
use identification::Drawing;
use report::document::Input;

/// Number of machines drawn about each minimum: the 5th and the 195th of 199 values enclose a further one
/// with a probability of exactly 95 %.
const DRAWS: usize = 199;
/// Largest number of positions of a prediction.
pub(super) const MOST_PLACES: usize = 2000;
/// Largest number of lines of an FRF, and of places times lines times draws.
pub(super) const MOST_LINES: (usize, f64) = (200_000, 4e8);

/// What a prediction computes. The default predicts all positions of the measurement set, without FRFs.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionRequest {
    /// Places of the nut; all positions of the measurement set where empty.
    pub places: Vec<Place>,
    /// Lowest and highest frequency (Hz); those of the fitted data by default.
    pub band_hz: Option<(f64, f64)>,
    /// Whether FRFs are predicted.
    pub frf: bool,
    /// Frequencies of the FRFs (Hz); by default spread over the band, and dense about the peaks.
    pub lines_hz: Option<Vec<f64>>,
    /// Number of machines drawn about each minimum.
    pub draws: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// How machines are drawn: from the posterior, or by a bootstrap over lines, for comparison.
    pub drawing: Drawing,
    /// File of the identification; absent for a result in memory.
    pub file: Option<Input>,
}

impl Default for PredictionRequest {
    fn default() -> Self {
        PredictionRequest {
            places: Vec::new(),
            band_hz: None,
            frf: false,
            lines_hz: None,
            draws: DRAWS,
            seed: 1,
            drawing: Drawing::Posterior,
            file: None,
        }
    }
}

impl PredictionRequest {
    pub(super) fn name(&self) -> String {
        self.file.as_ref().map_or_else(|| "the identification".into(), |file| file.path.clone())
    }
}

/// Numbers of draws.
pub(super) const DRAWS_RANGE: std::ops::RangeInclusive<usize> = 39..=9999;
