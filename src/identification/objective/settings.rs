//! Weights and options of FRF objectives.

use dynamics::model::RodModel;

/// Weights and options of an FRF objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfSettings {
    /// Standard deviation of each component of ln H by model error, in addition to the noise of the lines
    /// (1).
    pub model_error: f64,
    /// Lowest and highest frequency fitted and compared (Hz).
    pub band_hz: (f64, f64),
    /// Prior standard deviation of each nut position (m), one nuisance parameter each. 0: exact.
    pub nut_sd_m: f64,
    /// Prior standard deviations of ln(gain) (1) and delay (s) of each channel, two nuisance parameters each.
    /// 0: exact.
    pub channel_sd: (f64, f64),
    /// Whether the model error is relative to the level around a line, a third of an octave to either side,
    /// instead of the line itself. Near antiresonances, where |H| lies below that level, ln H carries little
    /// information.
    pub of_level: bool,
    /// How rods are represented.
    pub rods: RodModel,
}

impl FrfSettings {
    /// Returns the settings with exact nut positions, gains and delays.
    #[must_use]
    pub fn as_stated(self) -> Self {
        FrfSettings { nut_sd_m: 0.0, channel_sd: (0.0, 0.0), ..self }
    }
}

impl Default for FrfSettings {
    /// A model error of 1 %, the repeatability of a hammer test after a new set-up, and all lines.
    fn default() -> Self {
        FrfSettings {
            model_error: 0.01,
            band_hz: (0.0, f64::INFINITY),
            nut_sd_m: 0.0,
            channel_sd: (0.0, 0.0),
            of_level: false,
            rods: RodModel::Exact,
        }
    }
}
