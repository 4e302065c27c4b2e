//! From when on a mode is regular.

/// Limits of the decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackOptions {
    /// Share of the records covering a mode that must show it.
    pub least_seen: f64,
    /// False tracks allowed per set, on average.
    pub false_alarms: f64,
    /// Largest error of foretelling a frequency from the others, in standard deviations.
    pub most_error_sd: f64,
    /// Several records: least median share of orders at which the pole is stable; misfit that repeats in all records is below it.
    pub least_track_stability: f64,
    /// Single record: least share of orders at which the pole is stable.
    pub least_stability: f64,
    /// Single record: least contribution over the rest of H.
    pub least_prominence: f64,
    /// Single record: least signal-to-noise ratio.
    pub least_signal_to_noise: f64,
}

impl Default for TrackOptions {
    fn default() -> Self {
        Self {
            least_seen: 0.6,
            false_alarms: 0.03,
            most_error_sd: 4.0,
            least_track_stability: 0.2,
            least_stability: 0.3,
            least_prominence: 0.1,
            least_signal_to_noise: 10.0,
        }
    }
}
