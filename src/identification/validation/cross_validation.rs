//! Cross-validation of a set without held-out data: each position (or record) is predicted by a fit without
//! it.

use crate::objective::{FrfGap, ObjectiveError, PositionPrediction};
use crate::{Identification, IdentificationSettings, identify};
use long_work::Control;
use machine::Machine;
use measurement::FitSet;

/// Predictions of the data that each fit left out, in the order of the set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CrossValidation {
    /// Modes.
    pub modes: Vec<PositionPrediction>,
    /// FRFs.
    pub frfs: Vec<FrfGap>,
}

/// Leaves out one position after another, fits the others and predicts it. FRFs without a position are left
/// out record by record.
///
/// Each fit starts from the best fit of all data. `None` for fewer than two positions (or records), or if
/// stopped.
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
    let plan = IdentificationSettings {
        near: Some(found.place.clone()),
        repeats: 1,
        bootstrap: 0,
        profile: false,
        ..plan.clone()
    };
    let mut all = CrossValidation::default();
    for (kept, rest) in parts {
        let part = identify(machine, &kept, &rest, &plan, control)?;
        if control.stopped() {
            return Ok(None);
        }
        // Each fit has its own gain; amplitudes are reported with the gain of the fit to all data.
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
