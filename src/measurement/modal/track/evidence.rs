//! Evidence for or against a regular track.

use super::super::FittedMode;
use super::super::noise::median;
use super::observation::SightingChain;
use super::process::leave_one_out;
use super::search::{Track, expected};

/// Ratio of the bound modes·e^−s of the sequential test (Wald) to the number of chance tracks that reach a
/// score s (1). Source: counted on sets without real modes (test `limit_chance_makes_few_regular_tracks`).
const CHANCE_MARGIN: f64 = 50.0;

/// Smallest share of the records covering a mode that show it (1).
const LEAST_SEEN: f64 = 0.6;
/// Mean number of false tracks allowed per set.
const FALSE_ALARMS: f64 = 0.03;
/// Largest leave-one-out prediction error of a frequency, in standard deviations.
const MOST_ERROR_SD: f64 = 4.0;
/// Largest number of sightings that are predicted from the others.
const MOST_PREDICTED: usize = 100;
/// Several records: smallest median share of orders at which the pole is stable (1); a misfit that repeats in
/// all records lies below.
const LEAST_TRACK_STABILITY: f64 = 0.2;
/// Single record: smallest share of orders at which the pole is stable (1).
const LEAST_STABILITY: f64 = 0.3;
/// Single record: smallest contribution over the rest of H (1).
const LEAST_PROMINENCE: f64 = 0.1;
/// Single record: smallest signal-to-noise ratio (1).
const LEAST_SIGNAL_TO_NOISE: f64 = 10.0;

/// Evidence on a tracked mode, in numbers and in words.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackEvidence {
    /// Number of records that show it.
    pub seen: usize,
    /// Number of records whose band covers it.
    pub expected: usize,
    /// Root mean square leave-one-out prediction error of ln f over the positions (1); `None` with one
    /// sighting.
    pub roughness: Option<f64>,
    /// Median share of the orders at which the pole was stable.
    pub stability: f64,
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
pub(super) fn judge_single(mode: &FittedMode) -> (bool, TrackEvidence) {
    let (stability, prominence, signal_to_noise) = medians(&[mode]);
    let mut reasons = vec![
        "one record: judged by stability and significance alone, not by regularity over positions".to_owned(),
    ];
    let mut regular = true;
    for (value, least, what) in [
        (stability, LEAST_STABILITY, "share of orders at which the pole is stable"),
        (prominence, LEAST_PROMINENCE, "contribution over the rest of H"),
        (signal_to_noise, LEAST_SIGNAL_TO_NOISE, "signal-to-noise ratio"),
    ] {
        let enough = value >= least;
        regular &= enough;
        reasons.push(format!("{what} {value:.2}: {} {least}", if enough { "at least" } else { "below" }));
    }
    (regular, TrackEvidence { seen: 1, expected: 1, roughness: None, stability, signal_to_noise, reasons })
}

/// Decides on a track over several records.
pub(super) fn judge(chain: &SightingChain, track: &Track, modes: &[&FittedMode]) -> (bool, TrackEvidence) {
    let (stability, prominence, signal_to_noise) = medians(modes);
    let (seen, expected) = (track.sightings.len(), expected(chain, track));
    // The errors of evenly chosen sightings: their time grows with the third power of the number.
    let stride = seen.div_ceil(MOST_PREDICTED);
    let chosen = track.sightings.iter().step_by(stride);
    let points: Vec<_> = chosen.map(|s| chain.sightings[*s].point).collect();
    let errors = leave_one_out(&points);
    let roughness =
        errors.as_ref().map(|e| (e.iter().map(|e| e.0 * e.0).sum::<f64>() / e.len() as f64).sqrt());
    let largest = errors.as_ref().map(|e| e.iter().map(|e| e.1.abs()).fold(0.0, f64::max));
    let needed = (chain.sightings.len() as f64 / (CHANCE_MARGIN * FALSE_ALARMS)).ln().max(0.0);
    let enough_seen = seen >= 2 && seen as f64 >= LEAST_SEEN * expected as f64;
    let probable = track.score >= needed;
    let smooth = largest.is_some_and(|l| l <= MOST_ERROR_SD);
    let mut reasons = vec![format!(
        "seen in {seen} of {expected} records whose band covers it ({} {:.0} %)",
        if enough_seen { "at least" } else { "below" },
        100.0 * LEAST_SEEN
    )];
    if let (Some(roughness), Some(largest)) = (roughness, largest) {
        reasons.push(format!(
            "frequency predicted from the other positions within {:.2} % rms, largest error {largest:.1} standard deviations ({} {})",
            100.0 * roughness,
            if smooth { "at most" } else { "above" },
            MOST_ERROR_SD
        ));
    }
    reasons.push(format!(
        "frequency, damping, amplitude and sign are e^{:.1} times as probable for one smooth mode as for irregular modes ({} \
         e^{needed:.1}; {:.1} irregular modes per record)",
        track.score,
        if probable { "at least" } else { "below" },
        chain.clutter
    ));
    let stable = stability >= LEAST_TRACK_STABILITY;
    reasons.push(format!(
        "median: stable at {:.0} % of orders ({} {:.0} %), contribution {prominence:.2} of the rest of H, signal-to-noise {signal_to_noise:.0}",
        100.0 * stability,
        if stable { "at least" } else { "below" },
        100.0 * LEAST_TRACK_STABILITY
    ));
    let evidence = TrackEvidence { seen, expected, roughness, stability, signal_to_noise, reasons };
    (enough_seen && probable && smooth && stable, evidence)
}
