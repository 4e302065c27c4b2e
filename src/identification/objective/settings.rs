//! How FRFs are weighed and compared.

use dynamics::model::Rods;

/// Weights and options of an FRF objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfSettings {
    /// Standard deviation of each component of ln H that the model itself causes, beside the noise of the lines.
    pub model_error: f64,
    /// Lowest and highest frequency fitted and compared (Hz).
    pub band_hz: (f64, f64),
    /// Standard deviation of each nut position (m): one unknown more for each, known beforehand that well. 0: they are exact.
    pub nut_sd_m: f64,
    /// Standard deviations of ln(gain) and of the delay (s) of each channel, two unknowns more for each: known beforehand that well. 0: exact.
    pub channel_sd: (f64, f64),
    /// Whether the model's error is a share of the level around a line, a third of an octave to either side, rather than of the line itself: where
    /// |H| is less than around it, near antiresonances, ln H tells little.
    pub of_level: bool,
    /// How rods are represented.
    pub rods: Rods,
}

impl FrfSettings {
    /// The same with nut positions, gains and delays as they are stated.
    #[must_use]
    pub fn as_stated(self) -> Self {
        FrfSettings { nut_sd_m: 0.0, channel_sd: (0.0, 0.0), ..self }
    }
}

impl Default for FrfSettings {
    /// One percent and all lines: the repeatability of a hammer test that was set up anew.
    fn default() -> Self {
        FrfSettings {
            model_error: 0.01,
            band_hz: (0.0, f64::INFINITY),
            nut_sd_m: 0.0,
            channel_sd: (0.0, 0.0),
            of_level: false,
            rods: Rods::Exact,
        }
    }
}
