//! Search for the most probable tracks, one after the other.
//!
//! The score of a track is the log probability ratio of one smooth mode to irregular modes. Every mode starts
//! a track, which is extended from record to record: it takes a mode near its prediction or misses the
//! record. The best continuations are kept. The best track of all is removed, and the search continues with
//! the remaining modes.
//!
//! # Source
//!
//! Sittler, IEEE Trans. Military Electronics 8 (1964), 125–139 (score); Reid, IEEE Trans. Automatic Control
//! 24 (1979), 843–854 (several hypotheses kept).

use std::f64::consts::TAU;

use super::observation::{Sighting, SightingChain};
use super::process::Past;

/// Probability that a mode is observed at a position (1): it may have a node there, or be hidden by noise.
const DETECTION_PROBABILITY: f64 = 0.85;
/// Number of continuations kept.
const KEPT_TRACKS: usize = 48;
/// Largest number of records that are searched for tracks: the time grows with its third power. The tracks of
/// evenly chosen records take up the modes of all others.
const MOST_SEARCHED: usize = 50;
/// Largest distance of a mode from its prediction, in standard deviations.
const GATE: f64 = 4.0;

/// A track.
#[derive(Debug, Clone)]
pub(super) struct Track {
    /// Indices of sightings, in order of position.
    pub sightings: Vec<usize>,
    /// ln of the probability ratio to irregular modes.
    pub score: f64,
    past: Past,
}

impl Track {
    /// Returns the sightings of the track.
    fn members<'a>(&self, chain: &'a SightingChain) -> Vec<&'a Sighting> {
        self.sightings.iter().map(|s| &chain.sightings[*s]).collect()
    }

    /// Takes up the most probable of the open modes of a record, or misses it. Predictions remain those of
    /// the searched records.
    fn take_up(&mut self, chain: &SightingChain, step: usize, open: &mut Vec<usize>) {
        let missed = self.score + miss_score(chain, step, self.past.predict(chain.u[step]).mean);
        let found =
            open.iter().enumerate().filter_map(|(place, at)| Some((place, extended(chain, self, *at)?)));
        let best = found.max_by(|a, b| a.1.score.total_cmp(&b.1.score));
        match best.filter(|(_, track)| track.score > missed) {
            None => self.score = missed,
            Some((place, track)) => {
                let at = open.swap_remove(place);
                let place = self.sightings.partition_point(|s| *s < at);
                self.sightings.insert(place, at);
                self.score = track.score;
            }
        }
    }
}

/// Returns the score of a record without the mode: negative if its band covers the mode, else 0.
fn miss_score(chain: &SightingChain, step: usize, y: f64) -> f64 {
    let (low, high) = chain.band_hz[step];
    if (low.ln()..=high.ln()).contains(&y) { (1.0 - DETECTION_PROBABILITY).ln() } else { 0.0 }
}

/// Returns all modes of the chain as tracks.
pub(super) fn tracks(chain: &SightingChain) -> Vec<Track> {
    let stride = chain.u.len().div_ceil(MOST_SEARCHED).max(1);
    let (searched, others): (Vec<usize>, Vec<usize>) =
        (0..chain.u.len()).partition(|step| step.is_multiple_of(stride));
    let mut free: Vec<bool> = chain.sightings.iter().map(|s| s.step.is_multiple_of(stride)).collect();
    let mut found = searched_tracks(chain, &searched, &mut free);
    for step in others {
        let mut open: Vec<usize> =
            (0..chain.sightings.len()).filter(|at| chain.sightings[*at].step == step).collect();
        for track in &mut found {
            track.take_up(chain, step, &mut open);
        }
        found.extend(open.into_iter().map(|at| {
            let point = chain.sightings[at].point;
            let missed = (0..chain.u.len()).filter(|other| *other != step);
            let score = missed.map(|other| miss_score(chain, other, point.y)).sum();
            Track { sightings: vec![at], score, past: Past::start(point) }
        }));
    }
    found
}

/// Returns the modes of some records, those that are free, as tracks, the most probable first.
fn searched_tracks(chain: &SightingChain, steps: &[usize], free: &mut [bool]) -> Vec<Track> {
    let mut best: Vec<Option<Track>> =
        (0..free.len()).map(|start| free[start].then(|| follow((chain, steps), start, free))).collect();
    let mut found = Vec::new();
    loop {
        let top = best.iter().flatten().max_by(|a, b| {
            a.score
                .total_cmp(&b.score)
                .then(a.sightings.len().cmp(&b.sightings.len()))
                .then(b.sightings[0].cmp(&a.sightings[0]))
        });
        let Some(track) = top.cloned() else { return found };
        for s in &track.sightings {
            free[*s] = false;
        }
        for (start, entry) in best.iter_mut().enumerate() {
            if !free[start] {
                *entry = None;
            } else if entry.as_ref().is_some_and(|t| t.sightings.iter().any(|s| !free[*s])) {
                *entry = Some(follow((chain, steps), start, free));
            }
        }
        found.push(track);
    }
}

/// Returns the best track through some records that starts with a sighting.
fn follow((chain, steps): (&SightingChain, &[usize]), start: usize, free: &[bool]) -> Track {
    let first = &chain.sightings[start];
    let (before, after) = steps.split_at(steps.partition_point(|step| *step <= first.step));
    let before = before.iter().filter(|step| **step < first.step);
    let before: f64 = before.map(|step| miss_score(chain, *step, first.point.y)).sum();
    let mut kept = vec![Track { sightings: vec![start], score: before, past: Past::start(first.point) }];
    for &step in after {
        let mut next = Vec::new();
        for track in &kept {
            let prediction = track.past.predict(chain.u[step]);
            let reach = GATE * (prediction.variance + 0.05_f64.powi(2)).sqrt();
            let near =
                chain.sightings.iter().enumerate().filter(|(at, s)| {
                    s.step == step && free[*at] && (s.point.y - prediction.mean).abs() < reach
                });
            for (at, _) in near {
                next.extend(extended(chain, track, at));
            }
            next.push(Track {
                score: track.score + miss_score(chain, step, prediction.mean),
                ..track.clone()
            });
        }
        next.sort_by(|a, b| b.score.total_cmp(&a.score).then_with(|| a.sightings.cmp(&b.sightings)));
        next.truncate(KEPT_TRACKS);
        kept = next;
    }
    kept.swap_remove(0)
}

/// Returns the track extended by a sighting; `None` outside the gate.
fn extended(chain: &SightingChain, track: &Track, at: usize) -> Option<Track> {
    let sighting = &chain.sightings[at];
    let prediction = track.past.predict(sighting.point.u);
    let variance = prediction.variance + sighting.point.variance;
    let distance_squared = (sighting.point.y - prediction.mean).powi(2) / variance;
    if distance_squared > GATE * GATE {
        return None;
    }
    let members = track.members(chain);
    let frequency = -0.5 * (distance_squared + (TAU * variance).ln()) - chain.density(sighting.point.y).ln();
    let log_ratios = chain.damping_log_ratio(sighting, &members)
        + chain.amplitude_log_ratio(sighting, &members)
        + chain.sign_log_ratio(sighting, &members);
    let score = DETECTION_PROBABILITY.ln() + frequency + log_ratios;
    let mut next = track.clone();
    next.past.add(sighting.point, prediction);
    next.sightings.push(at);
    next.score += score;
    Some(next)
}

/// Counts the records whose band covers the track.
pub(super) fn expected(chain: &SightingChain, track: &Track) -> usize {
    let seen: Vec<usize> = track.sightings.iter().map(|s| chain.sightings[*s].step).collect();
    let covers = |step: &usize| {
        seen.contains(step) || miss_score(chain, *step, track.past.predict(chain.u[*step]).mean) < 0.0
    };
    (0..chain.u.len()).filter(covers).count()
}
