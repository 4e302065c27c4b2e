//! The most probable tracks, one after the other.
//!
//! A track is scored by the probability of its modes as one smooth mode over that as chance finds. From every mode a track is
//! started and carried from record to record; at each, it may take a mode near its prediction or miss it. The few best
//! continuations are kept. The best track of all is taken out, and the search goes on with the modes left.
//!
//! # Source
//!
//! Sittler, IEEE Trans. Military Electronics 8 (1964), 125–139 (score); Reid, IEEE Trans. Automatic Control 24 (1979), 843–854
//! (several hypotheses kept).

use std::f64::consts::TAU;

use super::observation::{Sighting, SightingChain};
use super::process::Past;

/// Probability that a mode is seen at a position: it may have a node there, or hide in noise.
const SEEN: f64 = 0.85;
/// Continuations kept.
const KEPT: usize = 48;
/// A mode further than this many standard deviations from the prediction is not tried.
const GATE: f64 = 4.0;

/// A track.
#[derive(Debug, Clone)]
pub(super) struct Track {
    /// Indices of sightings, in order of position.
    pub sightings: Vec<usize>,
    /// ln of the probability ratio.
    pub score: f64,
    past: Past,
}

impl Track {
    fn members<'a>(&self, chain: &'a SightingChain) -> Vec<&'a Sighting> {
        self.sightings.iter().map(|s| &chain.sightings[*s]).collect()
    }
}

/// Price of a record that does not show the mode although its band covers it.
fn miss(chain: &SightingChain, step: usize, y: f64) -> f64 {
    let (low, high) = chain.band_hz[step];
    if (low.ln()..=high.ln()).contains(&y) { (1.0 - SEEN).ln() } else { 0.0 }
}

/// All modes of the chain as tracks, the most probable first.
pub(super) fn tracks(chain: &SightingChain) -> Vec<Track> {
    let mut free = vec![true; chain.sightings.len()];
    let mut best: Vec<Option<Track>> = (0..free.len()).map(|start| Some(follow(chain, start, &free))).collect();
    let mut found = Vec::new();
    loop {
        let top = best.iter().flatten().max_by(|a, b| {
            a.score.total_cmp(&b.score).then(a.sightings.len().cmp(&b.sightings.len())).then(b.sightings[0].cmp(&a.sightings[0]))
        });
        let Some(track) = top.cloned() else { return found };
        for s in &track.sightings {
            free[*s] = false;
        }
        for (start, entry) in best.iter_mut().enumerate() {
            if !free[start] {
                *entry = None;
            } else if entry.as_ref().is_some_and(|t| t.sightings.iter().any(|s| !free[*s])) {
                *entry = Some(follow(chain, start, &free));
            }
        }
        found.push(track);
    }
}

/// The best track that starts with a sighting.
fn follow(chain: &SightingChain, start: usize, free: &[bool]) -> Track {
    let first = &chain.sightings[start];
    let before: f64 = (0..first.step).map(|step| miss(chain, step, first.point.y)).sum();
    let mut kept = vec![Track { sightings: vec![start], score: before, past: Past::start(first.point) }];
    for step in first.step + 1..chain.u.len() {
        let mut next = Vec::new();
        for track in &kept {
            let prediction = track.past.predict(chain.u[step]);
            let reach = GATE * (prediction.variance + 0.05_f64.powi(2)).sqrt();
            let near = chain
                .sightings
                .iter()
                .enumerate()
                .filter(|(at, s)| s.step == step && free[*at] && (s.point.y - prediction.mean).abs() < reach);
            for (at, _) in near {
                next.extend(extended(chain, track, at));
            }
            next.push(Track { score: track.score + miss(chain, step, prediction.mean), ..track.clone() });
        }
        next.sort_by(|a, b| b.score.total_cmp(&a.score).then_with(|| a.sightings.cmp(&b.sightings)));
        next.truncate(KEPT);
        kept = next;
    }
    kept.swap_remove(0)
}

/// The track with one more sighting, where it lies within the gate.
fn extended(chain: &SightingChain, track: &Track, at: usize) -> Option<Track> {
    let sighting = &chain.sightings[at];
    let prediction = track.past.predict(sighting.point.u);
    let variance = prediction.variance + sighting.point.variance;
    let off = (sighting.point.y - prediction.mean).powi(2) / variance;
    if off > GATE * GATE {
        return None;
    }
    let members = track.members(chain);
    let frequency = -0.5 * (off + (TAU * variance).ln()) - chain.density(sighting.point.y).ln();
    let voices = chain.damping_voice(sighting, &members) + chain.amplitude_voice(sighting, &members) + chain.sign_voice(sighting, &members);
    let score = SEEN.ln() + frequency + voices;
    let mut next = track.clone();
    next.past.add(sighting.point, prediction);
    next.sightings.push(at);
    next.score += score;
    Some(next)
}

/// Records whose band covers the track, and how many there are.
pub(super) fn expected(chain: &SightingChain, track: &Track) -> usize {
    let seen: Vec<usize> = track.sightings.iter().map(|s| chain.sightings[*s].step).collect();
    let covers = |step: &usize| seen.contains(step) || miss(chain, *step, track.past.predict(chain.u[*step]).mean) < 0.0;
    (0..chain.u.len()).filter(covers).count()
}
