//! Identification from modes or whole FRFs: estimates, and predictions for held-out positions.

use super::doubt::Doubt;
use super::estimate::{Wider, estimate};
use super::place::Place;
use super::posterior::{of_frfs, of_modes};
use super::result::{Identification, derived_estimates};
use super::settings::IdentificationSettings;
use super::tolerance::{
    ToleranceEstimate, estimates as tolerance_estimates, mode_columns as tolerance_columns,
};
use crate::objective::{FrfObjective, ModeObjective, ObjectiveError, free_parameters, loop_parameters};
use long_work::Control;
use machine::{FitRule, Machine};
use measurement::{FitSet, HoldOutSet};
use numeric::halton::halton_point;

/// Identifies a machine's free parameters from the modes or FRFs to fit, and predicts those held out.
///
/// Without a free parameter it evaluates the objective at the start values.
///
/// # Errors  as [`ModeObjective::new`] and [`FrfObjective::new`].
pub fn identify(
    machine: &Machine,
    fit: &FitSet<'_>,
    held_out: &HoldOutSet<'_>,
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<Identification, ObjectiveError> {
    // Machine and set are the same for the whole run. Positions, FRFs and plan distinguish its
    // identifications.
    let control = &control.within(&format!("{:?} {:?} {plan:?}", fit.positions(), fit.frfs()));
    match plan.frf {
        Some(settings) => {
            // Tolerances are fitted along with parameters, not alone.
            let of_drive = loop_parameters(machine, fit.set(), fit.frfs());
            let is_free =
                !free_parameters(machine, &plan.frozen, &of_drive, |rule| rule != FitRule::Never)?.is_empty();
            let (fitted, settings) = match plan.tolerances && is_free {
                true => (
                    machine.with_tolerances(&fit.set().nuts_m())?,
                    settings.with_tolerances(&fit.set().tolerance),
                ),
                false => (machine.clone(), settings),
            };
            let objective = FrfObjective::new(&fitted, fit, settings, &plan.frozen)?;
            let mut found = estimate(&objective, |_| Ok(None), &fitted, plan, control)?;
            found.estimates.truncate(machine.parameters.len());
            found.derived = derived_estimates(&found);
            // An unknown gain is one of the fitted coordinates.
            found.gain.count = if objective.estimates_gain() { objective.observations() / 2 } else { 0 };
            found.channels = objective.channels_at(&found.place);
            found.tolerances = tolerance_estimates(&objective, fit.set(), &found.place, &found.sd);
            found.warnings.extend(
                found
                    .tolerances
                    .iter()
                    .filter_map(|t| t.warning("if it is right, run diagnose to find a missing effect")),
            );
            let moved: Vec<Doubt> = found.tolerances.iter().filter_map(ToleranceEstimate::doubt).collect();
            found = found.doubted(moved);
            let validation =
                FrfObjective::held_out(&fitted, held_out, settings.as_stated())?.calibrated(&found.channels);
            found.fitted_frfs = objective.gaps_at(&found.place);
            let minima: Vec<Place> = found.basins.iter().map(|basin| basin.place.clone()).collect();
            found.posterior = (plan.profile && is_free && !minima.is_empty())
                .then(|| of_frfs(&objective, fit, minima, (found.misfit(), found.correlation_factor)));
            found.held_out_frfs = validation.gaps(&found.values, found.gain.gain);
            Ok(found)
        }
        None => {
            let objective = ModeObjective::new(machine, fit, plan.settings, &plan.frozen)?;
            let validation =
                ModeObjective::held_out(machine, held_out, plan.settings, Some(objective.band_hz))?;
            let wider = |place: &Place| wider_modes(machine, fit, plan, (&objective, place));
            let mut found = estimate(&objective, wider, machine, plan, control)?;
            found.derived = derived_estimates(&found);
            found.fitted = objective.predict(&found.values);
            found.gain = objective.amplitude_fit(&found.fitted);
            found.held_out = validation.predict(&found.values);
            if objective.is_likelihood()
                && plan.profile
                && !found.basins.is_empty()
                && !objective.free.is_empty()
            {
                let minima: Vec<Place> = found.basins.iter().map(|basin| basin.place.clone()).collect();
                found.posterior =
                    Some(of_modes(machine, fit, plan, &found.values, (&minima, found.misfit()))?);
            }
            Ok(found)
        }
    }
}

/// Number of starts for parameters that modes hardly determine, spread over their ranges.
const STARTS: usize = 16;

/// Builds the mode objective on which intervals are computed, and its starts.
///
/// Parameters that only whole FRFs determine are free, too. Frequencies and amplitudes have the covariance
/// that tolerances cause.
fn wider_modes<'m>(
    machine: &'m Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    (objective, place): (&ModeObjective<'_>, &Place),
) -> Result<Wider<ModeObjective<'m>>, ObjectiveError> {
    if !plan.tolerances {
        return Ok(None);
    }
    let columns = tolerance_columns(machine, fit, plan, (objective, place))?;
    let wider = ModeObjective::with_all_free(machine, fit, plan.settings, &plan.frozen, &objective.free)?
        .correlated(&columns);
    let values = objective.parameters(place);
    let own: Vec<f64> =
        wider.free.iter().map(|i| machine.parameters[*i].to_unit(values[*i]).clamp(0.0, 1.0)).collect();
    // The fixed values may have led the other parameters into a wrong basin: parameters freed here start all
    // over their ranges.
    let (first, more) = (objective.free.len(), own.len() - objective.free.len());
    let elsewhere =
        (1..=STARTS).filter(|_| more > 0).map(|index| [&own[..first], &halton_point(index, more)].concat());
    let from = std::iter::once(own.clone()).chain(elsewhere).map(|place| wider.extended(&place)).collect();
    Ok(Some((wider, from)))
}
