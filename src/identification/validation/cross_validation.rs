//! Figures of a set of which everything is fitted: each position (or record) predicted by a fit without it.

use crate::objective::{FrfGap, ObjectiveError, PositionPrediction};
use crate::{Identification, IdentificationSettings, identify};
use machine::Machine;
use measurement::FitSet;
use optimizer::Control;

/// Predictions of what each fit left out, in the order of the set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CrossValidation {
    /// Modes.
    pub modes: Vec<PositionPrediction>,
    /// FRFs.
    pub frfs: Vec<FrfGap>,
}

/// Fits everything but one position (for FRFs without one: but one record) after another, from the best place of all, and predicts what was
/// left out. `None` where there are fewer than two of them, or where it was stopped.
///
/// # Errors  as [`identify`].
pub fn cross_validation(
    machine: &Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    found: &Identification,
    control: &Control,
) -> Result<Option<CrossValidation>, ObjectiveError> {
    let parts = fit.leave_one_out(plan.frf.is_some());
    if parts.len() < 2 {
        return Ok(None);
    }
    let plan = IdentificationSettings { near: Some(found.place.clone()), repeats: 1, bootstrap: 0, profile: false, ..plan.clone() };
    let mut all = CrossValidation::default();
    for (kept, rest) in parts {
        let part = identify(machine, &kept, &rest, &plan, control)?;
        if control.stopped() {
            return Ok(None);
        }
        // Each fit has its own gain; amplitudes are told with that of all.
        let gain = part.gain.gain / found.gain.gain;
        let mut modes = part.held_out;
        for deviation in modes.iter_mut().flat_map(|p| &mut p.deviations) {
            if let Some(peak) = &mut deviation.predicted {
                peak.amplitude *= gain;
            }
        }
        all.modes.extend(modes);
        all.frfs.extend(part.held_out_frfs);
    }
    all.frfs.sort_by_key(|g| g.frf);
    Ok(Some(all))
}
