//! Measured natural frequencies next to a prediction, for the page.

use super::inputs::unchanged;
use crate::{Sources, Study, StudyResult};
use measurement::{Frf, MeasurementSet};
use report::document::IdentificationDocument;
use report::page::MeasuredMode;
use report::prediction::PredictionDocument;

/// Distance from a predicted natural frequency within which the maximum of a measured FRF is sought, relative
/// to it (1).
const SOUGHT: f64 = 0.08;

/// Returns the measured natural frequencies of the set of an identification: those of its modes, else the
/// maxima of its FRFs near the predicted ones.
///
/// # Errors  an input has changed since the identification.
pub(super) fn measured(
    identified: &IdentificationDocument,
    predicted: &PredictionDocument,
    sources: &Sources,
) -> StudyResult<Vec<MeasuredMode>> {
    let study = unchanged(
        Study::of_identification(identified, sources),
        &identified.stamp,
        ("identification", "identify"),
    )?;
    let set = study.measurements();
    let held_out = |name: &String| !identified.fit_positions.contains(name);
    let mut found = Vec::new();
    for (at, position) in set.positions.iter().enumerate() {
        let Some(nut_m) = position.nut_m else { continue };
        for frequency_hz in at_position(set, at, predicted, nut_m) {
            found.push(MeasuredMode {
                position: position.name.clone(),
                nut_m,
                frequency_hz,
                held_out: held_out(&position.name),
            });
        }
    }
    Ok(found)
}

fn at_position(set: &MeasurementSet, at: usize, predicted: &PredictionDocument, nut_m: f64) -> Vec<f64> {
    if let Some(table) = &set.modes {
        return table.positions[at].iter().filter_map(|mode| mode.frequency_hz).collect();
    }
    let own = |frf: &&Frf| {
        frf.position == Some(at)
            && frf.response == predicted.response
            && frf.excitation == predicted.excitation
    };
    let Some(frf) = set.frfs.iter().find(own) else { return Vec::new() };
    let distance =
        |p: &report::prediction::PredictedPosition| p.nut_m.map_or(f64::INFINITY, |x| (x - nut_m).abs());
    let Some(nearest) = predicted.positions.values().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    else {
        return Vec::new();
    };
    let seen = nearest.modes.iter().filter(|m| m.mode.amplitude.is_some());
    let mut found: Vec<f64> = seen.filter_map(|m| maximum_near(frf, m.mode.frequency_hz)).collect();
    found.dedup();
    found
}

/// Returns the frequency (Hz) of the largest |H| near a frequency, unless it lies at an end of the lines
/// sought.
fn maximum_near(frf: &Frf, frequency_hz: f64) -> Option<f64> {
    let lines: Vec<_> =
        frf.lines.iter().filter(|l| (l.frequency_hz / frequency_hz).ln().abs() < SOUGHT).collect();
    let top = (0..lines.len()).max_by(|a, b| lines[*a].value.norm().total_cmp(&lines[*b].value.norm()))?;
    (top > 0 && top + 1 < lines.len()).then(|| lines[top].frequency_hz)
}
