//! The modes of a chain of records, prepared for tracking, and what is known of modes that belong to no track.

use num_complex::Complex64;

use super::super::FittedMode;
use super::TrackRecord;
use super::process::{JITTER, JITTER_UNPLACED, TrackPoint};

/// Spread of ln ζ along a track, from bench to bench experience: damping of a joint changes by a third between positions.
const DAMPING_SPREAD: f64 = 0.3;
/// Spread of ln amplitude along a track within a series: the shape at the response changes with position.
const AMPLITUDE_SPREAD: f64 = 0.5;
/// Most that damping or amplitude of one mode may speak for a track, or against it (ln of a probability ratio).
const VOICE: (f64, f64) = (-2.0, 1.5);
/// Probability that a mode keeps the sign of its residue from one record of a series to the next: it turns only across a node.
const SIGN_KEPT: f64 = 0.9;
/// Least number of irregular modes per record that is reckoned with.
const LEAST_CLUTTER: f64 = 0.5;

/// A mode of a record.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    /// Index of the record in the chain, in order of position.
    pub step: usize,
    /// Index of the mode in the record.
    pub mode: usize,
    /// Frequency at position.
    pub point: TrackPoint,
    /// ln ζ and its variance.
    pub damping: (f64, f64),
    /// ln of amplitude over the trend of all modes of the series.
    pub amplitude: f64,
    /// Direction of the residue, of length 1.
    pub direction: Complex64,
    /// Index of the series.
    pub series: usize,
}

/// Records of a chain in order of position, with their modes.
#[derive(Debug)]
pub(super) struct SightingChain {
    /// Indices into the records given.
    pub records: Vec<usize>,
    /// Positions over the travel.
    pub u: Vec<f64>,
    /// Bands (Hz).
    pub band_hz: Vec<(f64, f64)>,
    /// Modes, grouped by step.
    pub sightings: Vec<Sighting>,
    /// Widest band (Hz).
    widest: (f64, f64),
    damping: (f64, f64),
    amplitude_spread: f64,
    /// Probability that the residues of two modes of a series point the same way by chance.
    same_sign: f64,
    /// Irregular modes per record reckoned with.
    pub clutter: f64,
}

impl SightingChain {
    /// The chain of the records at these indices, in this order.
    pub fn of(records: &[TrackRecord], order: Vec<usize>) -> Self {
        let positions: Vec<f64> = order.iter().map(|r| records[*r].nut_m.unwrap_or(0.0)).collect();
        let low = positions.iter().copied().fold(f64::INFINITY, f64::min);
        let travel = positions.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low;
        let u: Vec<f64> = positions.iter().map(|x| if travel > 0.0 { (x - low) / travel } else { 0.0 }).collect();
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
            (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt())
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

    /// Expected number of irregular modes of a record per unit of ln f: half spread evenly over Hz, half over ln Hz.
    pub fn density(&self, y: f64) -> f64 {
        let (low, high) = self.widest;
        let width = (high - low).max(1e-9 * high);
        self.clutter * 0.5 * (y.exp() / width + 1.0 / (high / low).ln().max(1e-9))
    }

    /// Sets the number of irregular modes per record.
    pub fn set_clutter(&mut self, irregular: usize) {
        self.clutter = (irregular as f64 / self.records.len().max(1) as f64).max(LEAST_CLUTTER);
    }

    /// ln probability ratio, track over chance, of a damping after others of the track.
    pub fn damping_voice(&self, sighting: &Sighting, before: &[&Sighting]) -> f64 {
        let values: Vec<(f64, f64)> = before.iter().map(|s| s.damping).collect();
        let chance = (self.damping.0, self.damping.1.powi(2) + sighting.damping.1);
        voice(sighting.damping, &values, DAMPING_SPREAD * DAMPING_SPREAD, chance)
    }

    /// The same of an amplitude after those of its series.
    pub fn amplitude_voice(&self, sighting: &Sighting, before: &[&Sighting]) -> f64 {
        let values: Vec<(f64, f64)> = before.iter().filter(|s| s.series == sighting.series).map(|s| (s.amplitude, 0.0)).collect();
        voice((sighting.amplitude, 0.0), &values, AMPLITUDE_SPREAD * AMPLITUDE_SPREAD, (0.0, self.amplitude_spread.powi(2)))
    }

    /// The same of the sign of a residue after the last one of its series.
    pub fn sign_voice(&self, sighting: &Sighting, before: &[&Sighting]) -> f64 {
        match before.iter().rev().find(|s| s.series == sighting.series) {
            Some(last) if agree(sighting, last) => (SIGN_KEPT / self.same_sign).ln(),
            Some(_) => ((1.0 - SIGN_KEPT) / (1.0 - self.same_sign)).ln(),
            None => 0.0,
        }
    }
}

/// Share of pairs of modes of a series whose residues point the same way, held off 0 and 1.
fn same_sign(sightings: &[Sighting]) -> f64 {
    let (mut same, mut pairs) = (1.0, 2.0);
    for (at, a) in sightings.iter().enumerate() {
        for b in sightings[..at].iter().filter(|b| b.series == a.series && b.step != a.step) {
            pairs += 1.0;
            same += f64::from(u8::from(agree(a, b)));
        }
    }
    same / pairs
}

/// Whether two residues point the same way.
fn agree(a: &Sighting, b: &Sighting) -> bool {
    (a.direction * b.direction.conj()).re > 0.0
}

/// ln N(x; mean of the values before) − ln N(x; chance), held within [`VOICE`]; 0 where nothing came before.
fn voice(x: (f64, f64), before: &[(f64, f64)], spread: f64, chance: (f64, f64)) -> f64 {
    let weights: f64 = before.iter().map(|b| 1.0 / (spread + b.1)).sum();
    if !(weights > 0.0) {
        return 0.0;
    }
    let mean = before.iter().map(|b| b.0 / (spread + b.1)).sum::<f64>() / weights;
    let log_normal = |mean: f64, variance: f64| -0.5 * ((x.0 - mean).powi(2) / variance + variance.ln());
    (log_normal(mean, spread + x.1 + 1.0 / weights) - log_normal(chance.0, chance.1)).clamp(VOICE.0, VOICE.1)
}

/// A mode as seen by the tracker.
fn sighting(mode: &FittedMode, (step, index, series): (usize, usize, usize), u: f64, jitter: f64) -> Sighting {
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

/// Takes the straight line of ln amplitude over ln f out of a series: receptances fall steeply with frequency.
fn remove_trend(sightings: &mut [Sighting], series: usize) {
    let own: Vec<(f64, f64)> = sightings.iter().filter(|s| s.series == series).map(|s| (s.point.y, s.amplitude)).collect();
    let n = own.len().max(1) as f64;
    let (mx, my) = (own.iter().map(|p| p.0).sum::<f64>() / n, own.iter().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = own.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let sxy: f64 = own.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let slope = if sxx > 1e-6 { sxy / sxx } else { 0.0 };
    for sighting in sightings.iter_mut().filter(|s| s.series == series) {
        sighting.amplitude -= my + slope * (sighting.point.y - mx);
    }
}
