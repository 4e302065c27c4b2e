//! Scores of objectives by predictions for positions that were not fitted.

use crate::objective::{MISSING, Objective, ObjectiveError, PositionPrediction};
use crate::{IdentificationSettings, identify};
use long_work::Control;
use machine::Machine;
use measurement::FitSet;
use numeric::statistics::root_mean_square;

/// Prediction errors of an objective for positions that were left out.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectiveScore {
    /// Objective.
    pub objective: Objective,
    /// Root mean square of the relative frequency errors; a mode that is not predicted counts as [`MISSING`].
    pub frequency_error: f64,
    /// Root mean square of ln(predicted/measured amplitude), with the gain of the fitted positions.
    pub ln_amplitude_error: Option<f64>,
    /// Number of measured modes that were not predicted.
    pub missing: usize,
}

/// Returns the relative frequency errors of a prediction; `None` for a measured mode that is not predicted.
pub fn frequency_errors(prediction: &PositionPrediction) -> Vec<Option<f64>> {
    prediction
        .deviations
        .iter()
        .filter_map(|d| Some((d.observed?.frequency_hz?, d.pair())))
        .map(|(measured, pair)| pair.map(|(_, peak)| peak.frequency_hz / measured - 1.0))
        .collect()
}

/// Scores objectives by leave-one-out over the fitted positions. Held-out positions are not used.
///
/// # Errors  as [`identify`]; fewer than two positions.
pub fn leave_one_out(
    machine: &Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    objectives: &[Objective],
    control: &Control,
) -> Result<Vec<ObjectiveScore>, ObjectiveError> {
    let parts = fit.leave_one_out(false);
    if parts.len() < 2 {
        return Err(ObjectiveError::Data(
            "leave-one-out needs at least two positions to fit; name more positions".into(),
        ));
    }
    let mut scores = Vec::new();
    for &objective in objectives {
        let mut plan = plan.clone();
        plan.settings.objective = objective;
        let (mut frequency, mut amplitude, mut missing) = (Vec::new(), Vec::new(), 0);
        for (kept, rest) in &parts {
            let found = identify(machine, kept, rest, &plan, control)?;
            if !found.complete {
                // An incomplete fit is not scored.
                scores.sort_by(|a: &ObjectiveScore, b| a.frequency_error.total_cmp(&b.frequency_error));
                return Ok(scores);
            }
            for prediction in &found.held_out {
                for error in frequency_errors(prediction) {
                    missing += usize::from(error.is_none());
                    frequency.push(error.unwrap_or(MISSING));
                }
                if found.gain.count > 0 && objective != Objective::Frequencies {
                    amplitude.extend(prediction.deviations.iter().filter_map(|d| d.pair()).filter_map(
                        |(observed, peak)| {
                            Some((found.gain.gain * peak.amplitude / observed.amplitude?).ln())
                        },
                    ));
                }
            }
        }
        scores.push(ObjectiveScore {
            objective,
            frequency_error: root_mean_square(frequency).unwrap_or(0.0),
            ln_amplitude_error: root_mean_square(amplitude),
            missing,
        });
    }
    scores.sort_by(|a, b| a.frequency_error.total_cmp(&b.frequency_error));
    Ok(scores)
}
