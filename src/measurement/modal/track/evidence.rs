//! Evidence for or against a regular track.

use super::super::FittedMode;
use super::super::noise::median;
use super::TrackOptions;
use super::observation::SightingChain;
use super::process::leave_one_out;
use super::search::{Track, expected};

/// Ratio of the bound modes·e^−s of the sequential test (Wald) to the number of chance tracks that reach a score s (1). Source: counted
/// on sets without real modes (test `limit_chance_makes_few_regular_tracks`).
const CHANCE_MARGIN: f64 = 50.0;

/// Evidence on a tracked mode, in numbers and in words.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackEvidence {
    /// Number of records that show it.
    pub seen: usize,
    /// Number of records whose band covers it.
    pub expected: usize,
    /// Root mean square leave-one-out prediction error of ln f over the positions (1); `None` with one sighting.
    pub roughness: Option<f64>,
    /// Largest of these errors over its standard deviation (1).
    pub largest_error_sd: Option<f64>,
    /// ln of the probability ratio of one smooth mode to irregular modes; `None` with a single record.
    pub score: Option<f64>,
    /// Score from which a track is regular: ln(modes in the chain / (50 × false alarms allowed)).
    pub needed: Option<f64>,
    /// Median share of the orders at which the pole was stable.
    pub stability: f64,
    /// Median contribution over the rest of H.
    pub prominence: f64,
    /// Median signal-to-noise ratio.
    pub signal_to_noise: f64,
    /// Reasons, one sentence each.
    pub reasons: Vec<String>,
}

/// Returns the medians of stability, prominence and signal-to-noise ratio.
fn medians(modes: &[&FittedMode]) -> (f64, f64, f64) {
    let of = |get: fn(&FittedMode) -> f64| median(modes.iter().map(|m| get(m)).collect());
    (of(|m| m.stability.share()), of(|m| m.prominence), of(|m| m.signal_to_noise))
}

/// Decides on a mode of a single record, without criteria over positions.
pub(super) fn judge_single(mode: &FittedMode, options: &TrackOptions) -> (bool, TrackEvidence) {
    let (stability, prominence, signal_to_noise) = medians(&[mode]);
    let mut reasons = vec!["one record: judged by stability and significance alone, not by regularity over positions".to_owned()];
    let mut regular = true;
    for (value, least, what) in [
        (stability, options.least_stability, "share of orders at which the pole is stable"),
        (prominence, options.least_prominence, "contribution over the rest of H"),
        (signal_to_noise, options.least_signal_to_noise, "signal-to-noise ratio"),
    ] {
        let enough = value >= least;
        regular &= enough;
        reasons.push(format!("{what} {value:.2}: {} {least}", if enough { "at least" } else { "below" }));
    }
    let evidence = TrackEvidence {
        seen: 1,
        expected: 1,
        roughness: None,
        largest_error_sd: None,
        score: None,
        needed: None,
        stability,
        prominence,
        signal_to_noise,
        reasons,
    };
    (regular, evidence)
}

/// Decides on a track over several records.
pub(super) fn judge(chain: &SightingChain, track: &Track, modes: &[&FittedMode], options: &TrackOptions) -> (bool, TrackEvidence) {
    let (stability, prominence, signal_to_noise) = medians(modes);
    let (seen, expected) = (track.sightings.len(), expected(chain, track));
    let points: Vec<_> = track.sightings.iter().map(|s| chain.sightings[*s].point).collect();
    let errors = leave_one_out(&points);
    let roughness = errors.as_ref().map(|e| (e.iter().map(|e| e.0 * e.0).sum::<f64>() / e.len() as f64).sqrt());
    let largest = errors.as_ref().map(|e| e.iter().map(|e| e.1.abs()).fold(0.0, f64::max));
    let needed = (chain.sightings.len() as f64 / (CHANCE_MARGIN * options.false_alarms)).ln().max(0.0);
    let enough_seen = seen >= 2 && seen as f64 >= options.least_seen * expected as f64;
    let probable = track.score >= needed;
    let smooth = largest.is_some_and(|l| l <= options.most_error_sd);
    let mut reasons = vec![format!(
        "seen in {seen} of {expected} records whose band covers it ({} {:.0} %)",
        if enough_seen { "at least" } else { "below" },
        100.0 * options.least_seen
    )];
    if let (Some(roughness), Some(largest)) = (roughness, largest) {
        reasons.push(format!(
            "frequency predicted from the other positions within {:.2} % rms, largest error {largest:.1} standard deviations ({} {})",
            100.0 * roughness,
            if smooth { "at most" } else { "above" },
            options.most_error_sd
        ));
    }
    reasons.push(format!(
        "frequency, damping, amplitude and sign are e^{:.1} times as probable for one smooth mode as for irregular modes ({} \
         e^{needed:.1}; {:.1} irregular modes per record)",
        track.score,
        if probable { "at least" } else { "below" },
        chain.clutter
    ));
    let stable = stability >= options.least_track_stability;
    reasons.push(format!(
        "median: stable at {:.0} % of orders ({} {:.0} %), contribution {prominence:.2} of the rest of H, signal-to-noise {signal_to_noise:.0}",
        100.0 * stability,
        if stable { "at least" } else { "below" },
        100.0 * options.least_track_stability
    ));
    let evidence = TrackEvidence {
        seen,
        expected,
        roughness,
        largest_error_sd: largest,
        score: Some(track.score),
        needed: Some(needed),
        stability,
        prominence,
        signal_to_noise,
        reasons,
    };
    (enough_seen && probable && smooth && stable, evidence)
}
