//! Thresholds for regular modes.

/// Thresholds of the decision whether a mode is regular.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackOptions {
    /// Smallest share of the records covering a mode that show it (1).
    pub least_seen: f64,
    /// Mean number of false tracks allowed per set.
    pub false_alarms: f64,
    /// Largest leave-one-out prediction error of a frequency, in standard deviations.
    pub most_error_sd: f64,
    /// Several records: smallest median share of orders at which the pole is stable (1); a misfit that repeats in all records lies below.
    pub least_track_stability: f64,
    /// Single record: smallest share of orders at which the pole is stable (1).
    pub least_stability: f64,
    /// Single record: smallest contribution over the rest of H (1).
    pub least_prominence: f64,
    /// Single record: smallest signal-to-noise ratio (1).
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
