//! Tracking of modes over records: a mode appears at all positions and moves smoothly; other peaks are
//! spurious.
//!
//! # Source
//!
//! Tian et al. (multi-position receptance coupling), Section 4.1: "with the worktable position change, the
//! natural frequencies of the system is roughly the same, or changes in a small range in a certain rule … The
//! peaks beyond the four frequencies of the FRF has no regularity". A mode may be absent at a node (their
//! third at l4).

mod evidence;
mod observation;
mod process;
mod record;
mod search;

pub use evidence::TrackEvidence;
pub use record::TrackRecord;

use super::FittedMode;
use super::noise::median;
use observation::SightingChain;

/// Number of passes over a chain, each with the density of irregular modes from the previous one.
const ROUNDS: usize = 4;

/// A mode tracked over records.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedMode {
    /// Rank in rising frequency, from 1, among regular and irregular modes.
    pub order: usize,
    /// Whether the mode meets the criteria of a real mode.
    pub regular: bool,
    /// Median natural frequency (Hz).
    pub frequency_hz: f64,
    /// Record and mode (indices) of each sighting, in order of position.
    pub sightings: Vec<(usize, usize)>,
    /// Evidence for the decision.
    pub evidence: TrackEvidence,
}

/// Tracks modes over records.
///
/// Each pass excludes the regular modes of the previous one from the density of irregular modes.
pub fn track(records: &[TrackRecord]) -> Vec<TrackedMode> {
    let (mut placed, unplaced): (Vec<usize>, Vec<usize>) =
        (0..records.len()).partition(|at| records[*at].nut_m.is_some());
    placed.sort_by(|a, b| records[*a].nut_m.unwrap_or(0.0).total_cmp(&records[*b].nut_m.unwrap_or(0.0)));
    let mut modes = [placed, unplaced].map(|order| track_chain(records, order)).concat();
    modes.sort_by(|a, b| {
        a.frequency_hz.total_cmp(&b.frequency_hz).then_with(|| a.sightings.cmp(&b.sightings))
    });
    for (at, mode) in modes.iter_mut().enumerate() {
        mode.order = at + 1;
    }
    modes
}

/// Tracks the modes of one chain.
fn track_chain(records: &[TrackRecord], order: Vec<usize>) -> Vec<TrackedMode> {
    let mut chain = SightingChain::of(records, order);
    let mut tracks = search::tracks(&chain);
    let mode_of = |chain: &SightingChain, s: usize| {
        let sighting = &chain.sightings[s];
        (chain.records[sighting.step], sighting.mode)
    };
    let modes_of = |chain: &SightingChain, track: &search::Track| -> Vec<&FittedMode> {
        track
            .sightings
            .iter()
            .map(|s| mode_of(chain, *s))
            .map(|(record, mode)| &records[record].modes[mode])
            .collect()
    };
    for _ in 0..ROUNDS {
        let irregular: usize = tracks
            .iter()
            .filter(|t| !evidence::judge(&chain, t, &modes_of(&chain, t)).0)
            .map(|t| t.sightings.len())
            .sum();
        chain.set_clutter(irregular);
        tracks = search::tracks(&chain);
    }
    let mut found = Vec::new();
    for track in &tracks {
        let modes = modes_of(&chain, track);
        let (regular, evidence) = match (chain.records.len(), modes.as_slice()) {
            (1, [mode]) => evidence::judge_single(mode),
            _ => evidence::judge(&chain, track, &modes),
        };
        found.push(TrackedMode {
            order: 0,
            regular,
            frequency_hz: median(modes.iter().map(|m| m.frequency_hz).collect()),
            sightings: track.sightings.iter().map(|s| mode_of(&chain, *s)).collect(),
            evidence,
        });
    }
    found
}
