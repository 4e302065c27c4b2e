//! Identification from modes or whole FRFs: estimates, and predictions for held-out positions.

use super::bootstrap::Bootstrap;
use super::combination::Combination;
use super::estimate::{Estimation, Wider, estimate};
use super::place::Place;
use super::posterior::{Posterior, of_frfs, of_modes};
use super::search::{Basin, SearchEffort};
use super::settings::{IdentificationSettings, Repeat};
use super::tolerance::{ToleranceEstimate, estimates as tolerance_estimates, mode_columns as tolerance_columns};
use super::uncertainty::{Certainty, Estimate};
use crate::objective::{
    AmplitudeFit, Channel, FrfGap, FrfObjective, ModeObjective, ObjectiveError, PositionPrediction, free_parameters, loop_parameters,
};
use dynamics::model::derived;
use long_work::Control;
use machine::{FitRule, Machine, Operating, ParameterValues};
use measurement::{FitSet, HoldOutSet};
use numeric::halton::halton_point;

/// A quantity derived from the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedEstimate {
    /// Name, with its unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// 95 % interval, to first order; `None` where χ² is no likelihood.
    pub interval95: Option<(f64, f64)>,
}

/// Result of an identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The machine as fitted: if tolerances were fitted, they follow its own parameters.
    pub machine: Machine,
    /// Estimates of all parameters of the machine as described, in its order.
    pub estimates: Vec<Estimate>,
    /// Values of all parameters of the machine as fitted.
    pub values: ParameterValues,
    /// Fitted nuisance parameters; empty where they are held fixed.
    pub tolerances: Vec<ToleranceEstimate>,
    /// Gain and delay of each measurement channel.
    pub channels: Vec<Channel>,
    /// Minima of χ² that the data cannot distinguish from the least one, the best first.
    pub basins: Vec<Basin>,
    /// Gain of the measured amplitudes.
    pub gain: AmplitudeFit,
    /// Least cost.
    pub cost: f64,
    /// Number of evaluations of all rounds.
    pub evaluations: u64,
    /// The rounds of the search, best first.
    pub repeats: Vec<Repeat>,
    /// How far the search went.
    pub effort: SearchEffort,
    /// Whether the best minimum was found as often as required; `None` where it had to be found once, or the search was stopped.
    pub agree: Option<bool>,
    /// Sum of the squared weighted residuals.
    pub chi_square: f64,
    /// Degrees of freedom: observations less unknowns.
    pub degrees_of_freedom: usize,
    /// 95 % interval of the gain, where it was estimated.
    pub gain_interval95: Option<(f64, f64)>,
    /// Whether the gain is identifiable, where it was estimated.
    pub gain_identifiable: Option<bool>,
    /// Uncertainty and identifiability of the free parameters, and last of the gain where it was estimated.
    pub certainty: Certainty,
    /// Derived quantities of the machine, at mid-stroke.
    pub derived: Vec<DerivedEstimate>,
    /// Combinations of parameters that the data determine better than the parameters themselves.
    pub combinations: Vec<Combination>,
    /// Results of the requested bootstraps.
    pub bootstraps: Vec<Bootstrap>,
    /// Variance inflation by correlation of neighbouring lines (1).
    pub correlation_factor: f64,
    /// Unit-cube coordinates of the best fit: free parameters, and last the gain where it was estimated.
    pub place: Place,
    /// Minima and covariance of all fitted coordinates; `None` where χ² is no likelihood.
    pub posterior: Option<Posterior>,
    /// Indices of the free parameters of the machine as described.
    pub free: Vec<usize>,
    /// Indices of all varied parameters, tolerances included: the first unit-cube coordinates.
    pub varied_parameters: Vec<usize>,
    /// Predicted modes of the fitted positions; empty for FRFs.
    pub fitted: Vec<PositionPrediction>,
    /// Predicted modes of the held-out positions; empty for FRFs.
    pub held_out: Vec<PositionPrediction>,
    /// Gaps of the fitted FRFs; empty for modes.
    pub fitted_frfs: Vec<FrfGap>,
    /// Gaps of the held-out FRFs; empty for modes.
    pub held_out_frfs: Vec<FrfGap>,
    /// Number of real numbers that were fitted.
    pub observations: usize,
    /// Whether the identification ran to its end.
    pub complete: bool,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl Identification {
    /// Returns χ² per degree of freedom; 1 without degrees of freedom.
    fn misfit(&self) -> f64 {
        if self.degrees_of_freedom > 0 { self.chi_square / self.degrees_of_freedom as f64 } else { 1.0 }
    }
}

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
    // Machine and set are the same for the whole run. Positions, FRFs and plan distinguish its identifications.
    let control = &control.within(&format!("{:?} {:?} {plan:?}", fit.positions(), fit.frfs()));
    match plan.frf {
        Some(settings) => {
            // Tolerances are fitted along with parameters, not alone.
            let of_drive = loop_parameters(machine, fit.set(), fit.frfs());
            let is_free = !free_parameters(machine, &plan.frozen, &of_drive, |rule| rule != FitRule::Never)?.is_empty();
            let (fitted, settings) = match plan.tolerances && is_free {
                true => (machine.with_tolerances(&fit.set().nuts_m())?, settings.with_tolerances(&fit.set().tolerance)),
                false => (machine.clone(), settings),
            };
            let objective = FrfObjective::new(&fitted, fit, settings, &plan.frozen)?;
            let estimation = estimate(&objective, |_| Ok(None), &fitted, plan, control)?;
            let (place, gain, sd) = (estimation.place.clone(), estimation.gain, estimation.sd.clone());
            // An unknown gain is one of the fitted coordinates.
            let gain = AmplitudeFit { gain, count: if objective.estimates_gain() { objective.observations() / 2 } else { 0 } };
            let mut found =
                identification(machine, &fitted, estimation, gain, &objective.free[..objective.own_count], objective.observations());
            found.varied_parameters.clone_from(&objective.free);
            found.channels = objective.channels_at(&place);
            found.tolerances = tolerance_estimates(&objective, fit.set(), &place, &sd);
            found
                .warnings
                .extend(found.tolerances.iter().filter_map(|t| t.warning("if it is right, run diagnose to find a missing effect")));
            let validation = FrfObjective::held_out(&fitted, held_out, settings.as_stated())?.calibrated(&found.channels);
            found.fitted_frfs = objective.gaps_at(&place);
            let minima: Vec<Place> = found.basins.iter().map(|basin| basin.place.clone()).collect();
            found.posterior = (plan.profile && is_free && !minima.is_empty())
                .then(|| of_frfs(&objective, fit, minima, (found.misfit(), found.correlation_factor)));
            found.held_out_frfs = validation.gaps(&found.values, gain.gain);
            Ok(found)
        }
        None => {
            let objective = ModeObjective::new(machine, fit, plan.settings, &plan.frozen)?;
            let validation = ModeObjective::held_out(machine, held_out, plan.settings, Some(objective.band_hz))?;
            let wider = |place: &Place| wider_modes(machine, fit, plan, (&objective, place));
            let estimation = estimate(&objective, wider, machine, plan, control)?;
            let fitted = objective.predict(&estimation.values);
            let gain = objective.amplitude_fit(&fitted);
            let held_out = validation.predict(&estimation.values);
            let mut found = identification(machine, machine, estimation, gain, &objective.free, objective.observations());
            (found.fitted, found.held_out) = (fitted, held_out);
            if objective.is_likelihood() && plan.profile && !found.basins.is_empty() && !objective.free.is_empty() {
                let minima: Vec<Place> = found.basins.iter().map(|basin| basin.place.clone()).collect();
                found.posterior = Some(of_modes(machine, fit, plan, &found.values, (&minima, found.misfit()))?);
            }
            Ok(found)
        }
    }
}

/// Number of starts for parameters that modes hardly determine, spread over their ranges.
const STARTS: usize = 16;

/// Builds the mode objective on which intervals are computed, and its starts.
///
/// Parameters that only whole FRFs determine are free, too. Frequencies and amplitudes have the covariance that tolerances cause.
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
    let wider = ModeObjective::with_all_free(machine, fit, plan.settings, &plan.frozen, &objective.free)?.correlated(&columns);
    let values = objective.parameters(place);
    let own: Vec<f64> = wider.free.iter().map(|i| machine.parameters[*i].to_unit(values[*i]).clamp(0.0, 1.0)).collect();
    // The fixed values may have led the other parameters into a wrong basin: parameters freed here start all over their ranges.
    let (first, more) = (objective.free.len(), own.len() - objective.free.len());
    let elsewhere = (1..=STARTS).filter(|_| more > 0).map(|index| [&own[..first], &halton_point(index, more)].concat());
    let from = std::iter::once(own.clone()).chain(elsewhere).map(|place| wider.extended(&place)).collect();
    Ok(Some((wider, from)))
}

fn identification(
    machine: &Machine,
    fitted: &Machine,
    estimation: Estimation,
    gain: AmplitudeFit,
    free: &[usize],
    observations: usize,
) -> Identification {
    let mut estimates = estimation.estimates.clone();
    estimates.truncate(machine.parameters.len());
    Identification {
        machine: fitted.clone(),
        derived: derived_estimates(fitted, &estimation, free),
        estimates,
        tolerances: Vec::new(),
        channels: Vec::new(),
        basins: estimation.basins,
        values: estimation.values,
        gain,
        cost: estimation.cost,
        evaluations: estimation.repeats.iter().map(|r| r.found.evaluations).sum(),
        repeats: estimation.repeats,
        effort: estimation.effort,
        agree: estimation.agree,
        chi_square: estimation.chi_square,
        degrees_of_freedom: estimation.freedom,
        gain_interval95: estimation.gain_interval95,
        gain_identifiable: estimation.gain_identifiable,
        certainty: estimation.certainty,
        combinations: estimation.combinations,
        bootstraps: estimation.bootstraps,
        correlation_factor: estimation.correlation_factor,
        place: estimation.place,
        posterior: None,
        free: free.to_vec(),
        varied_parameters: free.to_vec(),
        fitted: Vec::new(),
        held_out: Vec::new(),
        fitted_frfs: Vec::new(),
        held_out_frfs: Vec::new(),
        observations,
        complete: estimation.complete,
        warnings: estimation.warnings,
    }
}

/// Step of the central differences for intervals of derived quantities, in the unit interval (1).
const STEP: f64 = 1e-5;

fn derived_estimates(machine: &Machine, estimation: &Estimation, free: &[usize]) -> Vec<DerivedEstimate> {
    if machine.derived.is_empty() {
        return Vec::new();
    }
    let operating = Operating::at(machine.stroke_m().map(|s| 0.5 * s));
    let here = derived(machine, &estimation.values, &operating);
    // d(quantity)/d(coordinate), column by column.
    let moved = |column: usize, by: f64| {
        let parameter = &machine.parameters[free[column]];
        let mut values = estimation.values.clone();
        values[free[column]] = parameter.from_unit(estimation.place[column] + by);
        derived(machine, &values, &operating)
    };
    let (low, high): (Vec<_>, Vec<_>) = (0..free.len()).map(|c| (moved(c, -STEP), moved(c, STEP))).unzip();
    let has_intervals = estimation.estimates.iter().any(|e| e.interval95.is_some());
    machine
        .derived
        .iter()
        .enumerate()
        .filter_map(|(at, quantity)| {
            let value = here[at]?;
            let slopes: Option<Vec<f64>> = low.iter().zip(&high).map(|(low, high)| Some((high[at]? - low[at]?) / (2.0 * STEP))).collect();
            let interval95 = slopes.filter(|_| has_intervals).map(|slopes| {
                let covariance = &estimation.certainty.covariance;
                let variance: f64 =
                    (0..slopes.len()).map(|i| (0..slopes.len()).map(|j| slopes[i] * covariance[(i, j)] * slopes[j]).sum::<f64>()).sum();
                let half = 1.96 * variance.max(0.0).sqrt();
                (value - half, value + half)
            });
            Some(DerivedEstimate { name: quantity.name.clone(), value, interval95 })
        })
        .collect()
}
