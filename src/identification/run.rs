//! Identification from modes: search, repeats, certainty, predictions.

use crate::machine::Machine;
use crate::measurement::{FitSet, HoldOutSet};
use crate::objective::{AmplitudeFit, ModeObjective, ModeSettings, Objective, ObjectiveError, PositionPrediction};
use crate::optimizer::{Control, Cost, Found, SearchSettings, Strategy, search};

use super::uncertainty::{Certainty, certainty};

/// How an identification is run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Objective, weights, rods.
    pub settings: ModeSettings,
    /// Ids of parameters that keep their start values.
    pub frozen: Vec<String>,
    /// Seed of the first search; the others follow from it.
    pub seed: u64,
    /// Searches from different seeds.
    pub repeats: usize,
    /// Strategy of the differential evolution.
    pub strategy: Strategy,
}

impl Default for Plan {
    fn default() -> Self {
        Plan { settings: ModeSettings::default(), frozen: Vec::new(), seed: 1, repeats: 3, strategy: Strategy::CurrentToPbest }
    }
}

/// One search.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// Its seed.
    pub seed: u64,
    /// What it found.
    pub found: Found,
}

/// An identified parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Index in the machine.
    pub parameter: usize,
    /// Value in its unit.
    pub value: f64,
    /// 95 % interval; `None` for a parameter that was not fitted.
    pub interval95: Option<(f64, f64)>,
    /// Whether the data determine it; `None` for one that was not fitted.
    pub identifiable: Option<bool>,
    /// Lies at an end of its plausible range.
    pub at_bound: bool,
}

/// What an identification found.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// All parameters of the machine, in its order.
    pub estimates: Vec<Estimate>,
    /// Their values alone.
    pub values: Vec<f64>,
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
    /// Indices of the free parameters.
    pub free: Vec<usize>,
    /// Predictions where it was fitted.
    pub fitted: Vec<PositionPrediction>,
    /// Predictions where it was not.
    pub held_out: Vec<PositionPrediction>,
    /// Frequencies and amplitudes that were fitted.
    pub observations: usize,
    /// Ran to its end.
    pub complete: bool,
    /// What a person should know.
    pub warnings: Vec<String>,
}

impl Cost for ModeObjective<'_> {
    fn dimension(&self) -> usize {
        self.free.len()
    }

    fn at(&self, place: &[f64]) -> f64 {
        self.cost(&self.parameters(place))
    }
}

/// Range of an unknown gain.
pub const GAIN_RANGE: (f64, f64) = (1e-3, 1e3);
/// Distance from an end of the unit interval that counts as being there.
const AT_BOUND: f64 = 1e-3;

/// Identifies a machine's free parameters from the modes of the fit positions, and predicts the held-out ones.
///
/// # Errors  as [`ModeObjective::new`]; nothing is free.
pub fn identify(
    machine: &Machine,
    fit: &FitSet<'_>,
    held_out: &HoldOutSet<'_>,
    plan: &Plan,
    control: &Control,
) -> Result<Identification, ObjectiveError> {
    let objective = ModeObjective::new(machine, fit, plan.settings, &plan.frozen)?;
    let beyond = ModeObjective::held_out(machine, held_out, plan.settings, Some(objective.band_hz))?;
    if objective.free.is_empty() {
        return Err(ObjectiveError::Data("no parameter is left to identify; freeze fewer, or give one fit = \"always\"".into()));
    }
    let mut repeats: Vec<Repeat> = Vec::new();
    for repeat in 0..plan.repeats.max(1) {
        let seed = plan.seed.wrapping_add(1_000_003 * repeat as u64);
        let settings = SearchSettings { strategy: plan.strategy, ..SearchSettings::for_dimension(objective.free.len(), seed) };
        repeats.push(Repeat { seed, found: search(&objective, settings, control) });
        if control.stopped() {
            break;
        }
    }
    repeats.sort_by(|a, b| a.found.cost.total_cmp(&b.found.cost));
    let best = repeats[0].found.clone();
    let values = objective.parameters(&best.place);
    let fitted = objective.predict(&values);
    let gain = objective.amplitude_fit(&fitted);
    let unknowns = objective.free.len() + usize::from(objective.estimates_gain());
    let chi_square: f64 = objective.residuals(&fitted, gain.gain).iter().map(|r| r * r).sum();
    let freedom = objective.observations().saturating_sub(unknowns);
    let misfit = if freedom > 0 { (chi_square / freedom as f64).max(1.0) } else { 1.0 };
    // The gain is one unknown more: a last coordinate over its own range.
    let mut extended = best.place.clone();
    if objective.estimates_gain() {
        extended.push((gain.gain / GAIN_RANGE.0).ln() / (GAIN_RANGE.1 / GAIN_RANGE.0).ln());
    }
    let free_count = best.place.len();
    let certainty = certainty(&extended, misfit, |place| {
        let predictions = objective.predict(&objective.parameters(&place[..free_count]));
        let gain = place.get(free_count).map_or(gain.gain, |u| GAIN_RANGE.0 * (u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).exp());
        objective.residuals(&predictions, gain)
    });
    // Eq. 26 is no likelihood: its minimum tells no intervals.
    let tells = plan.settings.objective != Objective::Eq26;
    let gain_interval95 = (tells && extended.len() > free_count).then(|| {
        let half = 1.96 * certainty.sd[free_count] * (GAIN_RANGE.1 / GAIN_RANGE.0).ln();
        (gain.gain * (-half).exp(), gain.gain * half.exp())
    });
    let gain_identifiable = (tells && extended.len() > free_count).then(|| certainty.identifiable[free_count]);
    let mut warnings = Vec::new();
    if objective.observations() < unknowns {
        warnings.push(format!(
            "{} observations cannot determine {unknowns} unknowns: those the data do not see are marked not identifiable; fit more positions, or --freeze parameters",
            objective.observations()
        ));
    }
    let mut estimates: Vec<Estimate> = (0..machine.parameters.len())
        .map(|parameter| Estimate { parameter, value: values[parameter], interval95: None, identifiable: None, at_bound: false })
        .collect();
    for (free, &parameter) in objective.free.iter().enumerate() {
        let (u, sd) = (best.place[free], certainty.sd[free]);
        let description = &machine.parameters[parameter];
        let end = |x: f64| description.from_unit(x.clamp(0.0, 1.0));
        let at_bound = !(AT_BOUND..=1.0 - AT_BOUND).contains(&u);
        estimates[parameter] = Estimate {
            parameter,
            value: values[parameter],
            interval95: tells.then(|| (end(u - 1.96 * sd), end(u + 1.96 * sd))),
            identifiable: tells.then(|| certainty.identifiable[free] && !at_bound),
            at_bound,
        };
        if at_bound {
            let which = if u < 0.5 { ("lower", description.lower) } else { ("upper", description.upper) };
            let remedy =
                if certainty.identifiable[free] { "the data push it there: check range and model" } else { "the data do not determine it" };
            warnings
                .push(format!("{} lies at the {} end of its range, {:e} {}: {remedy}", description.id, which.0, which.1, description.unit));
        }
    }
    if misfit > 2.0 && tells {
        warnings.push(format!(
            "χ² is {chi_square:.1} for {freedom} degrees of freedom: model and data differ by more than the weights allow; intervals are widened by √{misfit:.2}"
        ));
    }
    let complete = !control.stopped() && repeats.len() == plan.repeats.max(1) && repeats.iter().all(|r| r.found.complete);
    let worst = repeats.last().map_or(best.cost, |r| r.found.cost);
    let agree = (complete && repeats.len() > 1).then(|| {
        let costs = worst - best.cost <= 1e-3 * best.cost.abs().max(1e-12);
        let seen = (0..free_count).filter(|i| certainty.identifiable[*i]);
        // Places of what the data see, within a tenth of their standard deviation or a thousandth of the range.
        let places =
            seen.into_iter().all(|i| repeats.iter().all(|r| (r.found.place[i] - best.place[i]).abs() <= (0.1 * certainty.sd[i]).max(1e-3)));
        costs && places
    });
    if agree == Some(false) {
        warnings.push(format!("the {} searches do not agree (cost {:.6} to {worst:.6}): raise --repeats", repeats.len(), best.cost));
    }
    Ok(Identification {
        estimates,
        gain,
        cost: best.cost,
        evaluations: repeats.iter().map(|r| r.found.evaluations).sum(),
        agree,
        certainty,
        free: objective.free.clone(),
        held_out: beyond.predict(&values),
        values,
        fitted,
        observations: objective.observations(),
        complete,
        chi_square,
        freedom,
        gain_interval95,
        gain_identifiable,
        repeats,
        warnings,
    })
}
