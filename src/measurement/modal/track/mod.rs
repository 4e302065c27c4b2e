//! Modes followed over records: a real mode appears at all positions and moves smoothly, a peak without regularity is spurious.
//!
//! # Source
//!
//! Tian et al. (multi-position receptance coupling), Section 4.1: "with the worktable position change, the natural frequencies of the
//! system is roughly the same, or changes in a small range in a certain rule … The peaks beyond the four frequencies of the FRF has no
//! regularity". A mode may miss at a node (their third at l4).

mod evidence;
mod observation;
mod options;
mod process;
mod record;
mod search;

pub use evidence::TrackEvidence;
pub use options::TrackOptions;
pub use record::TrackRecord;

use super::noise::median;
use super::{FittedMode, ModalError};
use observation::SightingChain;

/// Passes over a chain, each with the density of chance finds that the one before left.
const ROUNDS: usize = 4;

/// A mode over records.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedMode {
    /// Place in rising frequency, from 1, over regular and irregular modes.
    pub order: usize,
    /// Whether it is a real mode by the rule.
    pub regular: bool,
    /// Median natural frequency (Hz).
    pub frequency_hz: f64,
    /// Record and mode (indices) of each sighting, in order of position.
    pub sightings: Vec<(usize, usize)>,
    /// Why.
    pub evidence: TrackEvidence,
}

/// Follows modes over records.
///
/// Regular modes found in a first pass are taken out of the density of chance finds of the second.
///
/// # Errors  no records; a position that is not finite
pub fn track(records: &[TrackRecord], options: &TrackOptions) -> Result<Vec<TrackedMode>, ModalError> {
    if records.is_empty() {
        return Err(ModalError::NoRecords);
    }
    let mut placed = Vec::new();
    let mut unplaced = Vec::new();
    for (at, record) in records.iter().enumerate() {
        match record.nut_m {
            Some(nut_m) if nut_m.is_finite() => placed.push((nut_m, at)),
            Some(nut_m) => return Err(ModalError::Position { record: record.name.to_owned(), nut_m }),
            None => unplaced.push(at),
        }
    }
    placed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut modes = Vec::new();
    for order in [placed.into_iter().map(|(_, at)| at).collect(), unplaced] {
        modes.extend(over_chain(records, order, options));
    }
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz).then_with(|| a.sightings.cmp(&b.sightings)));
    for (at, mode) in modes.iter_mut().enumerate() {
        mode.order = at + 1;
    }
    Ok(modes)
}

/// Tracks of one chain.
fn over_chain(records: &[TrackRecord], order: Vec<usize>, options: &TrackOptions) -> Vec<TrackedMode> {
    let mut chain = SightingChain::of(records, order);
    let mut tracks = search::tracks(&chain);
    let mode_of = |chain: &SightingChain, s: usize| {
        let sighting = &chain.sightings[s];
        (chain.records[sighting.step], sighting.mode)
    };
    let modes_of = |chain: &SightingChain, track: &search::Track| -> Vec<&FittedMode> {
        track.sightings.iter().map(|s| mode_of(chain, *s)).map(|(record, mode)| &records[record].modes[mode]).collect()
    };
    for _ in 0..ROUNDS {
        let irregular: usize =
            tracks.iter().filter(|t| !evidence::judge(&chain, t, &modes_of(&chain, t), options).0).map(|t| t.sightings.len()).sum();
        chain.set_clutter(irregular);
        tracks = search::tracks(&chain);
    }
    let mut found = Vec::new();
    for track in &tracks {
        let modes = modes_of(&chain, track);
        let (regular, evidence) = match (chain.records.len(), modes.as_slice()) {
            (1, [mode]) => evidence::alone(mode, options),
            _ => evidence::judge(&chain, track, &modes, options),
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
