//! Measured natural frequencies next to a prediction, for the page.

use super::inputs::unchanged;
use crate::{Sources, Study, StudyResult};
use measurement::modal::{CurveOptions, FittedMode, fit_curve, with_curve_of};
use measurement::{Frf, MeasurementSet};
use report::document::IdentificationDocument;
use report::page::MeasuredMode;
use report::prediction::PredictionDocument;

/// Distance from a predicted natural frequency within which the mode of a measured FRF is sought, relative to
/// it (1).
const SOUGHT: f64 = 0.08;
/// Signal-to-noise ratio and contribution over the rest of H (1) above which a mode is drawn, as for the peaks
/// of a single record.
const LEAST_SIGNAL: f64 = 10.0;
const LEAST_PROMINENCE: f64 = 0.1;

/// Returns the measured natural frequencies of the set of an identification: those of its modes, else the
/// fitted modes of its FRFs near the predicted ones.
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
        sources,
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
    let seen = nearest.modes.iter().filter_map(|m| m.mode.frequency_hz);
    // Maxima of |H| are often those of noise: the modes of a fit are not.
    let fitted = with_curve_of(frf, |_| true, |curve| fit_curve(curve, &CurveOptions::default()));
    let modes: Vec<FittedMode> = fitted.map(|fit| fit.modes).unwrap_or_default();
    let mut found: Vec<f64> = seen.filter_map(|hz| mode_near(&modes, hz)).collect();
    found.dedup();
    found
}

/// Returns the frequency (Hz) of the clear mode that is nearest to a frequency.
fn mode_near(modes: &[FittedMode], frequency_hz: f64) -> Option<f64> {
    let distance = |mode: &&FittedMode| (mode.frequency_hz / frequency_hz).ln().abs();
    let clear = modes.iter().filter(|m| m.signal_to_noise > LEAST_SIGNAL && m.prominence > LEAST_PROMINENCE);
    let nearest = clear.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    (distance(&nearest) < SOUGHT).then_some(nearest.frequency_hz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::{Condition, FrfLine, Quantity};
    use num_complex::Complex64;
    use report::prediction::PredictionDocument;

    /// A mode at 100 Hz in noise of 20 % is marked at its fit, not at the highest line, and noise not at all.
    #[test]
    fn limit_marks_are_fitted_modes() {
        let scatter = |at: u32| 2.0 * ((f64::from(at) * 12.9898).sin().abs() * 43_758.545_3).fract() - 1.0;
        let line = |at: u32| {
            let frequency_hz = 40.0 + 0.25 * f64::from(at);
            let mode = 1.0 / Complex64::new(1.0 - (frequency_hz / 100.0).powi(2), 0.1 * frequency_hz / 100.0);
            let noise = 1.0 + 0.2 * Complex64::new(scatter(2 * at), scatter(2 * at + 1));
            FrfLine { frequency_hz, value: mode * noise, noise: None }
        };
        let frf = Frf {
            position: Some(0),
            record: None,
            response: "table".into(),
            excitation: "table".into(),
            quantity: Quantity::Receptance,
            condition: Condition::default(),
            averages: None,
            source: "test".into(),
            lines: (0..600).map(line).collect(),
            rejected: Vec::new(),
        };
        let mode = |hz: f64| {
            serde_json::json!({ "order": 1, "frequency_hz": hz, "damping_ratio": 0.05, "amplitude": 1.0,
            "frequency95": [hz, hz], "natural_hz": hz, "natural95": [hz, hz], "damping95": null, "amplitude95": null })
        };
        let predicted: PredictionDocument = serde_json::from_value(serde_json::json!({
            "schema": "jointid/prediction/1", "tool_version": "0", "seed": 1, "complete": true, "inputs": [], "warnings": [],
            "quantity": "receptance", "response": "table", "excitation": "table", "band_hz": [40.0, 190.0], "draws": 39, "minima": 1,
            "nut_sd_m": 0.001, "positions": { "p": { "nut_m": 0.5, "modes": [mode(103.0), mode(160.0)], "static_stiffness": null,
            "static_stiffness95": null } } })).unwrap();
        let set = MeasurementSet { frfs: vec![frf], ..MeasurementSet::none() };
        let found = at_position(&set, 0, &predicted, 0.5);
        assert!(found.len() == 1 && (found[0] - 100.0).abs() < 0.5, "{found:?}");
    }
}
