//! Identification from modes or from whole FRFs: estimates, and predictions where nothing was fitted.

use super::bootstrap::Bootstrap;
use super::combination::Combination;
use super::estimate::{Basin, Estimate, Estimation, Wider, estimate};
use super::settings::{IdentificationSettings, Repeat};
use super::tolerance::{ToleranceEstimate, estimates as tolerance_estimates, mode_columns as tolerance_columns};
use super::uncertainty::Certainty;
use crate::objective::{AmplitudeFit, Channel, FrfGap, FrfObjective, ModeObjective, ObjectiveError, PositionPrediction};
use dynamics::model::derived;
use machine::{Machine, Operating};
use measurement::{FitSet, HoldOutSet};
use numeric::halton::halton_point;
use optimizer::Control;

/// A quantity that follows from the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedEstimate {
    /// Name, with its unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// 95 % interval, to first order; `None` where χ² is no likelihood.
    pub interval95: Option<(f64, f64)>,
}

/// What an identification found.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The machine as it was fitted: with its tolerances as parameters behind its own, where they were fitted along.
    pub machine: Machine,
    /// All parameters of the machine as described, in its order.
    pub estimates: Vec<Estimate>,
    /// Values of all parameters of the machine as it was fitted.
    pub values: Vec<f64>,
    /// Tolerances that were fitted along; empty where they are held.
    pub tolerances: Vec<ToleranceEstimate>,
    /// Gain and delay of each measuring channel.
    pub channels: Vec<Channel>,
    /// Minima of χ² that the data do not tell from the least, the best first.
    pub basins: Vec<Basin>,
    /// Gain of the measured amplitudes.
    pub gain: AmplitudeFit,
    /// Least cost.
    pub cost: f64,
    /// Evaluations of all repeats.
    pub evaluations: u64,
    /// The repeats, best first.
    pub repeats: Vec<Repeat>,
    /// Whether the repeats agree on the cost within 0.1 % and on what the data see; `None` for fewer than two.
    pub agree: Option<bool>,
    /// Sum of the squared weighted residuals.
    pub chi_square: f64,
    /// Observations less unknowns.
    pub freedom: usize,
    /// 95 % interval of the gain, where it was estimated.
    pub gain_interval95: Option<(f64, f64)>,
    /// Whether the data determine the gain, where it was estimated.
    pub gain_identifiable: Option<bool>,
    /// Certainty of the free parameters, and last of the gain where it was estimated.
    pub certainty: Certainty,
    /// Quantities the machine reports, at mid-stroke.
    pub derived: Vec<DerivedEstimate>,
    /// Combinations that the data determine better than the parameters alone.
    pub combinations: Vec<Combination>,
    /// Bootstraps asked for.
    pub bootstraps: Vec<Bootstrap>,
    /// By how much the correlation of neighbouring lines widens the variance.
    pub colour: f64,
    /// Best place of the free parameters in the unit cube, and last of the gain where it was estimated.
    pub place: Vec<f64>,
    /// Indices of the free parameters of the machine as described.
    pub free: Vec<usize>,
    /// Indices of all parameters that were varied, tolerances among them: the first coordinates of a place.
    pub varied: Vec<usize>,
    /// Modes predicted where they were fitted; empty for FRFs.
    pub fitted: Vec<PositionPrediction>,
    /// Modes predicted where they were not; empty for FRFs.
    pub held_out: Vec<PositionPrediction>,
    /// Gaps of the FRFs fitted; empty for modes.
    pub fitted_frfs: Vec<FrfGap>,
    /// Gaps of the FRFs held out; empty for modes.
    pub held_out_frfs: Vec<FrfGap>,
    /// Frequencies and amplitudes that were fitted.
    pub observations: usize,
    /// Ran to its end.
    pub complete: bool,
    /// What a person should know.
    pub warnings: Vec<String>,
}

/// Identifies a machine's free parameters from the modes or FRFs to be fitted, and predicts those held out.
///
/// # Errors  as [`ModeObjective::new`] and [`FrfObjective::new`]; nothing is free.
pub fn identify(
    machine: &Machine,
    fit: &FitSet<'_>,
    held_out: &HoldOutSet<'_>,
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<Identification, ObjectiveError> {
    // Machine and set are those of the whole run; what differs between identifications of it names the part.
    let control = &control.within(&format!("{:?} {:?} {plan:?}", fit.positions, fit.frfs));
    match plan.frf {
        Some(settings) => {
            let (fitted, settings) = match plan.tolerances {
                true => (machine.with_tolerances(&fit.set.nuts_m())?, settings.with_tolerances(&fit.set.tolerance)),
                false => (machine.clone(), settings),
            };
            let objective = FrfObjective::new(&fitted, fit, settings, &plan.frozen)?;
            let estimation = estimate(&objective, |_| Ok(None), &fitted, plan, control)?;
            let (place, gain, sd) = (estimation.place.clone(), estimation.gain, estimation.sd.clone());
            // The gain stands among the parameters where it is unknown.
            let gain = AmplitudeFit { gain, count: if objective.estimates_gain() { objective.observations() / 2 } else { 0 } };
            let mut found = identification(machine, &fitted, estimation, gain, &objective.free[..objective.own], objective.observations());
            found.varied.clone_from(&objective.free);
            found.channels = objective.channels_at(&place);
            found.tolerances = tolerance_estimates(&objective, fit.set, &place, &sd);
            found.warnings.extend(found.tolerances.iter().filter_map(ToleranceEstimate::warning));
            let beyond = FrfObjective::held_out(&fitted, held_out, settings.as_stated())?.calibrated(&found.channels);
            found.fitted_frfs = objective.gaps_at(&place);
            found.held_out_frfs = beyond.gaps(&found.values, gain.gain);
            Ok(found)
        }
        None => {
            let objective = ModeObjective::new(machine, fit, plan.settings, &plan.frozen)?;
            let beyond = ModeObjective::held_out(machine, held_out, plan.settings, Some(objective.band_hz))?;
            let wider = |place: &[f64]| wider_modes(machine, fit, plan, (&objective, place));
            let estimation = estimate(&objective, wider, machine, plan, control)?;
            let fitted = objective.predict(&estimation.values);
            let gain = objective.amplitude_fit(&fitted);
            let held_out = beyond.predict(&estimation.values);
            let mut found = identification(machine, machine, estimation, gain, &objective.free, objective.observations());
            (found.fitted, found.held_out) = (fitted, held_out);
            Ok(found)
        }
    }
}

/// Beginnings of what modes say little of.
const BEGINNINGS: usize = 16;

/// Modes with all free that whole FRFs would determine, and with the covariance that tolerances give to frequencies and amplitudes, about a place.
fn wider_modes<'m>(
    machine: &'m Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    (objective, place): (&ModeObjective<'_>, &[f64]),
) -> Result<Wider<ModeObjective<'m>>, ObjectiveError> {
    if !plan.tolerances {
        return Ok(None);
    }
    let columns = tolerance_columns(machine, fit, plan, (objective, place))?;
    let wider = ModeObjective::with_all_free(machine, fit, plan.settings, &plan.frozen, &objective.free)?.correlated(&columns);
    let values = objective.parameters(place);
    let own: Vec<f64> = wider.free.iter().map(|i| machine.parameters[*i].to_unit(values[*i]).clamp(0.0, 1.0)).collect();
    // What was held may have led the others into a wrong basin: it begins all over its range, too.
    let (first, more) = (objective.free.len(), own.len() - objective.free.len());
    let elsewhere = (1..=BEGINNINGS).filter(|_| more > 0).map(|index| [&own[..first], &halton_point(index, more)].concat());
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
        cost: estimation.repeats[0].found.cost,
        evaluations: estimation.repeats.iter().map(|r| r.found.evaluations).sum(),
        repeats: estimation.repeats,
        agree: estimation.agree,
        chi_square: estimation.chi_square,
        freedom: estimation.freedom,
        gain_interval95: estimation.gain_interval95,
        gain_identifiable: estimation.gain_identifiable,
        certainty: estimation.certainty,
        combinations: estimation.combinations,
        bootstraps: estimation.bootstraps,
        colour: estimation.colour,
        place: estimation.place,
        free: free.to_vec(),
        varied: free.to_vec(),
        fitted: Vec::new(),
        held_out: Vec::new(),
        fitted_frfs: Vec::new(),
        held_out_frfs: Vec::new(),
        observations,
        complete: estimation.complete,
        warnings: estimation.warnings,
    }
}

/// Step in the unit interval of the differences by which intervals of derived quantities are told.
const STEP: f64 = 1e-5;

fn derived_estimates(machine: &Machine, estimation: &Estimation, free: &[usize]) -> Vec<DerivedEstimate> {
    if machine.derived.is_empty() {
        return Vec::new();
    }
    let operating = Operating::at(machine.stroke_m().map(|s| 0.5 * s));
    let here = derived(machine, &estimation.values, &operating);
    // d(quantity)/d(place), column by column.
    let moved = |column: usize, by: f64| {
        let parameter = &machine.parameters[free[column]];
        let mut values = estimation.values.clone();
        values[free[column]] = parameter.from_unit(estimation.place[column] + by);
        derived(machine, &values, &operating)
    };
    let (low, high): (Vec<_>, Vec<_>) = (0..free.len()).map(|c| (moved(c, -STEP), moved(c, STEP))).unzip();
    let tells = estimation.estimates.iter().any(|e| e.interval95.is_some());
    machine
        .derived
        .iter()
        .enumerate()
        .filter_map(|(at, quantity)| {
            let value = here[at]?;
            let slopes: Option<Vec<f64>> = low.iter().zip(&high).map(|(low, high)| Some((high[at]? - low[at]?) / (2.0 * STEP))).collect();
            let interval95 = slopes.filter(|_| tells).map(|slopes| {
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
