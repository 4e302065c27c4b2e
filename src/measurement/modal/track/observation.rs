//! Modes of a chain of records, prepared for tracking, with the statistics of irregular modes.

use num_complex::Complex64;

use super::super::FittedMode;
use super::TrackRecord;
use super::process::{JITTER, JITTER_UNPLACED, TrackPoint};

/// Standard deviation of ln ζ along a track (1). Source: experience from benches; joint damping changes by a
/// third between positions.
const DAMPING_SPREAD: f64 = 0.3;
/// Standard deviation of ln amplitude along a track within a series (1): the mode shape at the response point
/// changes with position.
const AMPLITUDE_SPREAD: f64 = 0.5;
/// Bounds on the log probability ratio of the damping or amplitude of one mode (1): against and for a track.
const LOG_RATIO_BOUNDS: (f64, f64) = (-2.0, 1.5);
/// Probability that a residue keeps its sign from one record of a series to the next (1): it changes only
/// across a node.
const SIGN_KEPT: f64 = 0.9;
/// Smallest assumed number of irregular modes per record.
const LEAST_CLUTTER: f64 = 0.5;

/// A mode of a record.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    /// Index of the record in the chain, in order of position.
    pub step: usize,
    /// Index of the mode in the record.
    pub mode: usize,
    /// ln f at the position.
    pub point: TrackPoint,
    /// ln ζ and its variance.
    pub damping: (f64, f64),
    /// ln of amplitude over the trend of all modes of the series.
    pub amplitude: f64,
    /// Residue, normalised to length 1.
    pub direction: Complex64,
    /// Index of the series.
    pub series: usize,
}

/// Records of a chain in order of position, with their modes.
#[derive(Debug)]
pub(super) struct SightingChain {
    /// Indices of the records.
    pub records: Vec<usize>,
    /// Positions over the travel, 0 to 1.
    pub u: Vec<f64>,
    /// Bands (Hz).
    pub band_hz: Vec<(f64, f64)>,
    /// Modes, grouped by step.
    pub sightings: Vec<Sighting>,
    /// Widest band (Hz).
    widest: (f64, f64),
    damping: (f64, f64),
    amplitude_spread: f64,
    /// Probability that the residues of two modes of a series have the same sign by chance (1).
    same_sign: f64,
    /// Assumed number of irregular modes per record.
    pub clutter: f64,
}

impl SightingChain {
    /// Creates the chain of the records at these indices, in this order.
    pub fn of(records: &[TrackRecord], order: Vec<usize>) -> Self {
        let positions: Vec<f64> = order.iter().map(|r| records[*r].nut_m.unwrap_or(0.0)).collect();
        let low = positions.iter().copied().fold(f64::INFINITY, f64::min);
        let travel = positions.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low;
        let u: Vec<f64> =
            positions.iter().map(|x| if travel > 0.0 { (x - low) / travel } else { 0.0 }).collect();
        let placed = order.iter().any(|r| records[*r].nut_m.is_some());
        let jitter = if placed { JITTER } else { JITTER_UNPLACED };
        let mut names: Vec<&str> = Vec::new();
        let mut sightings = Vec::new();
        for (step, record) in order.iter().enumerate() {
            let record = &records[*record];
            let series = names.iter().position(|n| *n == record.series).unwrap_or(names.len());
            if series == names.len() {
                names.push(record.series);
            }
            for (index, mode) in record.modes.iter().enumerate() {
                sightings.push(sighting(mode, (step, index, series), u[step], jitter));
            }
        }
        for series in 0..names.len() {
            remove_trend(&mut sightings, series);
        }
        let band_hz: Vec<(f64, f64)> = order.iter().map(|r| records[*r].band_hz).collect();
        let widest = band_hz.iter().fold((f64::INFINITY, 0.0_f64), |w, b| (w.0.min(b.0), w.1.max(b.1)));
        let spread = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            (
                mean,
                (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt(),
            )
        };
        let damping = spread(&sightings.iter().map(|s| s.damping.0).collect::<Vec<f64>>());
        let amplitude = spread(&sightings.iter().map(|s| s.amplitude).collect::<Vec<f64>>()).1;
        let same_sign = same_sign(&sightings);
        Self {
            records: order,
            u,
            band_hz,
            sightings,
            widest,
            damping: (damping.0, damping.1.max(DAMPING_SPREAD)),
            amplitude_spread: amplitude.max(AMPLITUDE_SPREAD),
            same_sign,
            clutter: LEAST_CLUTTER,
        }
    }

    /// Returns the expected number of irregular modes of a record per unit of ln f: half uniform over f, half
    /// over ln f.
    pub fn density(&self, y: f64) -> f64 {
        let (low, high) = self.widest;
        let width = (high - low).max(1e-9 * high);
        self.clutter * 0.5 * (y.exp() / width + 1.0 / (high / low).ln().max(1e-9))
    }

    /// Sets the number of irregular modes per record.
    pub fn set_clutter(&mut self, irregular: usize) {
        self.clutter = (irregular as f64 / self.records.len().max(1) as f64).max(LEAST_CLUTTER);
    }

    /// Returns the log probability ratio, track to chance, of a damping, given the earlier ones of the track.
    pub fn damping_log_ratio(&self, sighting: &Sighting, earlier: &[&Sighting]) -> f64 {
        let values: Vec<(f64, f64)> = earlier.iter().map(|s| s.damping).collect();
        let chance = (self.damping.0, self.damping.1.powi(2) + sighting.damping.1);
        log_ratio(sighting.damping, &values, DAMPING_SPREAD * DAMPING_SPREAD, chance)
    }

    /// Returns the same ratio of an amplitude, given the earlier ones of its series.
    pub fn amplitude_log_ratio(&self, sighting: &Sighting, earlier: &[&Sighting]) -> f64 {
        let values: Vec<(f64, f64)> =
            earlier.iter().filter(|s| s.series == sighting.series).map(|s| (s.amplitude, 0.0)).collect();
        log_ratio(
            (sighting.amplitude, 0.0),
            &values,
            AMPLITUDE_SPREAD * AMPLITUDE_SPREAD,
            (0.0, self.amplitude_spread.powi(2)),
        )
    }

    /// Returns the same ratio of the sign of a residue, given the last one of its series.
    pub fn sign_log_ratio(&self, sighting: &Sighting, earlier: &[&Sighting]) -> f64 {
        match earlier.iter().rev().find(|s| s.series == sighting.series) {
            Some(last) if same_direction(sighting, last) => (SIGN_KEPT / self.same_sign).ln(),
            Some(_) => ((1.0 - SIGN_KEPT) / (1.0 - self.same_sign)).ln(),
            None => 0.0,
        }
    }
}

/// Returns the share of pairs of modes of a series whose residues have the same sign, kept away from 0 and 1.
fn same_sign(sightings: &[Sighting]) -> f64 {
    let (mut same, mut pairs) = (1.0, 2.0);
    for (at, a) in sightings.iter().enumerate() {
        for b in sightings[..at].iter().filter(|b| b.series == a.series && b.step != a.step) {
            pairs += 1.0;
            same += f64::from(u8::from(same_direction(a, b)));
        }
    }
    same / pairs
}

/// Whether two residues have the same sign.
fn same_direction(a: &Sighting, b: &Sighting) -> bool {
    (a.direction * b.direction.conj()).re > 0.0
}

/// Returns ln N(x; mean of the earlier values) − ln N(x; chance), limited to [`LOG_RATIO_BOUNDS`]; 0 without
/// earlier values.
fn log_ratio(x: (f64, f64), earlier: &[(f64, f64)], spread: f64, chance: (f64, f64)) -> f64 {
    let weights: f64 = earlier.iter().map(|b| 1.0 / (spread + b.1)).sum();
    if !(weights > 0.0) {
        return 0.0;
    }
    let mean = earlier.iter().map(|b| b.0 / (spread + b.1)).sum::<f64>() / weights;
    let log_normal = |mean: f64, variance: f64| -0.5 * ((x.0 - mean).powi(2) / variance + variance.ln());
    (log_normal(mean, spread + x.1 + 1.0 / weights) - log_normal(chance.0, chance.1))
        .clamp(LOG_RATIO_BOUNDS.0, LOG_RATIO_BOUNDS.1)
}

/// Converts a fitted mode to a sighting.
fn sighting(
    mode: &FittedMode,
    (step, index, series): (usize, usize, usize),
    u: f64,
    jitter: f64,
) -> Sighting {
    let relative = (mode.frequency_sd_hz / mode.frequency_hz).min(0.05);
    let damping_sd = (mode.damping_sd / mode.damping_ratio).min(2.0);
    Sighting {
        step,
        mode: index,
        point: TrackPoint { u, y: mode.frequency_hz.ln(), variance: jitter * jitter + relative * relative },
        damping: (mode.damping_ratio.max(1e-9).ln(), damping_sd * damping_sd),
        amplitude: mode.amplitude.value.max(f64::MIN_POSITIVE).ln(),
        direction: mode.residue / mode.residue.norm().max(f64::MIN_POSITIVE),
        series,
    }
}

/// Removes the straight line of ln amplitude over ln f from a series: receptances fall steeply with
/// frequency.
fn remove_trend(sightings: &mut [Sighting], series: usize) {
    let own: Vec<(f64, f64)> =
        sightings.iter().filter(|s| s.series == series).map(|s| (s.point.y, s.amplitude)).collect();
    let n = own.len().max(1) as f64;
    let (mx, my) = (own.iter().map(|p| p.0).sum::<f64>() / n, own.iter().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = own.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let sxy: f64 = own.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let slope = if sxx > 1e-6 { sxy / sxx } else { 0.0 };
    for sighting in sightings.iter_mut().filter(|s| s.series == series) {
        sighting.amplitude -= my + slope * (sighting.point.y - mx);
    }
}
