//! Fitted nuisance parameters: priors from stated tolerances, and estimates.

use std::collections::BTreeMap;

use crate::doubt::of_moves;
use crate::objective::{Channel, Excitation, FrfObjective, FrfSettings, ModeObjective, ObjectiveError};
use crate::uncertainty::certainty;
use crate::{Doubt, IdentificationSettings, Place};
use machine::{Machine, Mechanism, ParameterValues, Prior};
use measurement::{ChannelTolerance, FitSet, MeasurementSet};
use optimizer::LeastSquares;

/// A quantity that the description or the measurement states with a tolerance, and its estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct ToleranceEstimate {
    /// Name of the quantity, for example «mass of table».
    pub name: String,
    /// Physical meaning.
    pub mechanism: Mechanism,
    /// Unit of value and prior; 1 for a relative change or a factor.
    pub unit: String,
    /// Value before the fit: mean, or median of a log-normal prior.
    pub mean: f64,
    /// Prior.
    pub prior: Prior,
    /// Estimate.
    pub value: f64,
    /// Posterior standard deviation: in the unit, or of the logarithm for a log-normal prior.
    pub sd: f64,
}

/// Move of an estimate, in standard deviations of such moves, above which it is a finding (1).
const FINDING: f64 = 3.0;
/// Least share of the variance of a prior by which the data must reduce it, for a move to say something (1).
const LEAST_REDUCTION: f64 = 0.1;

/// Returns a move from the centre of a normal prior in standard deviations of the moves of numbers that are
/// stated rightly: move and standard deviation left by the data in those of the prior.
fn standardised(deviation: f64, left: f64) -> f64 {
    deviation / (1.0 - left * left).max(LEAST_REDUCTION).sqrt()
}

impl ToleranceEstimate {
    /// Returns the deviation of the estimate from the stated value, in standard deviations of the prior.
    pub fn deviation(&self) -> f64 {
        self.prior.deviation(self.mean, self.value)
    }

    /// Returns the move of the estimate from the stated value, in standard deviations of the moves of numbers
    /// that are stated rightly.
    ///
    /// The estimate of a number that the data hardly determine stays near the stated value, so that a small
    /// move says much: for a normal prior of the variance 1 its variance is 1 − s², with s² the variance that
    /// the data leave. A log-normal number near zero may be determined there and not elsewhere, so that its
    /// moves count as they are.
    ///
    /// # Source  conflict of prior and data: Evans and Moshonov, Bayesian Analysis 1 (2006) 893–914.
    fn standardised_move(&self) -> f64 {
        match self.prior {
            Prior::Normal(sd) => standardised(self.deviation(), self.sd / sd),
            Prior::LogNormal(_) | Prior::Catalogue(..) => self.deviation(),
        }
    }

    /// Whether the estimate moved farther than that of a number that is stated rightly does.
    pub fn is_finding(&self) -> bool {
        self.standardised_move().abs() > FINDING
    }

    /// Returns the doubt that such a move casts on the fit.
    pub(super) fn doubt(&self) -> Option<Doubt> {
        let moved = self.standardised_move().abs();
        self.is_finding().then(|| Doubt::Tolerance(self.name.clone(), self.deviation(), moved))
    }

    /// Warns of such an estimate; `advice` says what follows.
    pub fn warning(&self, advice: &str) -> Option<String> {
        self.is_finding().then(|| {
            let estimate = match (self.mechanism.is_dimensionless(), self.mean) {
                (true, 0.0) => format!("the fit changes {} by {:+.2} %", self.name, 100.0 * self.value),
                (true, mean) => {
                    format!("the fit changes {} from {mean:.3e} to {:.3e}", self.name, self.value)
                }
                (false, mean) => format!(
                    "the fit changes {} from {mean:.3e} to {:.3e} {}",
                    self.name, self.value, self.unit
                ),
            };
            let times = self.deviation().abs();
            let moves = of_moves(times, self.standardised_move().abs());
            format!(
                "{estimate}, {times:.1} standard deviations{moves}: check this number of the description; {advice}"
            )
        })
    }
}

/// Returns what priors of parameters, such as catalogue values, cast doubt on a fit that contradicts them, and
/// warnings of these and of priors that do not act.
/// `sd` holds the standard deviation of each coordinate, the fitted parameters first.
pub(super) fn check_priors(
    machine: &Machine,
    (fitted, sd): (&[usize], &[f64]),
    values: &ParameterValues,
) -> (Vec<Doubt>, Vec<String>) {
    let of_parameter = |(column, &index): (usize, &usize)| {
        let (parameter, value) = (&machine.parameters[index], values[index]);
        let prior = parameter.prior.filter(|prior| matches!(prior, Prior::Catalogue(..)))?;
        let left = sd.get(column)? * parameter.deviation_slope(value)?;
        let deviation = prior.deviation(parameter.start, value);
        let moved = standardised(deviation, left).abs();
        (moved > FINDING).then(|| Doubt::Prior(parameter.id.clone(), deviation, moved))
    };
    let doubts: Vec<Doubt> = fitted.iter().enumerate().filter_map(of_parameter).collect();
    let contradicted = doubts.iter().map(|doubt| format!("{doubt}: check it, and the model"));
    let idle = idle_priors(machine, fitted, "these data do not fit it, and it keeps its start value");
    let notes = contradicted.chain(idle).collect();
    (doubts, notes)
}

/// Warns of priors of parameters other than these, which do not act in a fit; `why` says what the fit does instead.
pub fn idle_priors(machine: &Machine, acting: &[usize], why: &str) -> Vec<String> {
    let known = machine.parameters.iter().enumerate();
    let idle = known.filter(|(at, p)| matches!(p.prior, Some(Prior::Catalogue(..))) && !acting.contains(at));
    idle.map(|(_, p)| format!("parameter.{}.prior has no effect: {why}", p.id)).collect()
}

impl FrfSettings {
    /// Returns the settings with the tolerances of a set for nut positions, and for gains and delays of
    /// channels.
    #[must_use]
    pub fn with_tolerances(self, known: &ChannelTolerance) -> Self {
        FrfSettings { nut_sd_m: known.nut_m, channel_sd: (known.gain, known.delay_s), ..self }
    }
}

/// Estimates all nuisance parameters of an objective at the coordinates of its minimum.
pub fn tolerances_at(
    objective: &FrfObjective<'_>,
    set: &MeasurementSet,
    place: &Place,
) -> Vec<ToleranceEstimate> {
    let information = LeastSquares::normal(objective, place).information;
    estimates(objective, set, place, &certainty(&information, 1.0).sd)
}

/// Estimates all nuisance parameters of an objective at given coordinates, with the standard deviation of
/// each coordinate.
pub(super) fn estimates(
    objective: &FrfObjective<'_>,
    set: &MeasurementSet,
    place: &Place,
    sd: &[f64],
) -> Vec<ToleranceEstimate> {
    let machine = objective.machine();
    let values = objective.parameters(place);
    let described = objective.free.iter().enumerate().filter_map(|(column, &index)| {
        let parameter = &machine.parameters[index];
        let prior = parameter.prior.filter(|_| parameter.is_tolerance())?;
        let scale = if matches!(prior, Prior::Normal(_)) { 1.0 } else { values[index] };
        Some(ToleranceEstimate {
            name: parameter.name().into(),
            mechanism: parameter.mechanism,
            unit: parameter.unit.clone(),
            mean: parameter.start,
            prior,
            value: values[index],
            sd: sd[column] * parameter.unit_slope(values[index]) / scale,
        })
    });
    let known = &set.tolerance;
    let normal = |name: String, (mechanism, unit): (Mechanism, &str), prior: f64, value: f64, sd: f64| {
        ToleranceEstimate {
            name,
            mechanism,
            unit: unit.into(),
            mean: 0.0,
            prior: Prior::Normal(prior),
            value,
            sd,
        }
    };
    let mut columns = objective.nut_coordinates();
    let mut all: Vec<ToleranceEstimate> = described.collect();
    for (nut_m, shift_m) in objective.nuts_at(place) {
        let is_there = |p: &&measurement::Position| p.nut_m == Some(nut_m);
        let name =
            set.positions.iter().find(is_there).map_or_else(|| format!("{nut_m} m"), |p| p.name.clone());
        let sd = columns.next().map_or(0.0, |column| sd[column] * objective.span() * known.nut_m);
        all.push(normal(
            format!("nut position of {name}"),
            (Mechanism::Length, "m"),
            known.nut_m,
            shift_m,
            sd,
        ));
    }
    let first = objective.nut_coordinates().end;
    let channels = objective.channels_at(place);
    if sd.len() >= first + 2 * channels.len() {
        for (at, Channel { response, excitation, log_gain, delay_s }) in channels.iter().enumerate() {
            let channel = channel_name(&machine.points[*response].name, excitation.name(machine));
            let of = |column: usize, prior: f64| sd[first + 2 * at + column] * objective.span() * prior;
            let both = [
                normal(
                    format!("gain of {channel}"),
                    (Mechanism::Ratio, "1"),
                    known.gain,
                    *log_gain,
                    of(0, known.gain),
                ),
                normal(
                    format!("delay of {channel}"),
                    (Mechanism::Delay, "s"),
                    known.delay_s,
                    *delay_s,
                    of(1, known.delay_s),
                ),
            ];
            all.extend(both.into_iter().filter(|t| t.prior.sd() > 0.0));
        }
    }
    all
}

/// Step of the central differences for the effect of tolerances on modes, in standard deviations (1).
const STEP: f64 = 0.3;
/// Largest change of a weighted residual by one standard deviation of a tolerance (1). At and above it a mode
/// has lost its partner.
const MAX_CHANGE: f64 = 20.0;

/// Computes the change of the weighted residuals of modes by one standard deviation of each tolerance, about
/// given coordinates.
///
/// # Errors  as [`ModeObjective::new`].
pub fn mode_columns(
    machine: &Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    (objective, place): (&ModeObjective<'_>, &Place),
) -> Result<Vec<Vec<f64>>, ObjectiveError> {
    let gain = objective.gain(place);
    let toleranced = machine.with_tolerances(&fit.set().nuts_m())?;
    let own = objective.parameters(place);
    let tolerance_starts = toleranced.parameters.iter().skip(own.len()).map(|p| p.start);
    let values = ParameterValues(own.iter().copied().chain(tolerance_starts).collect());
    let mut columns = Vec::new();
    let described = ModeObjective::new(&toleranced, fit, plan.settings, &plan.frozen)?;
    for (index, parameter) in toleranced.parameters.iter().enumerate().skip(own.len()) {
        let Some(prior) = parameter.prior else { continue };
        let moved = |by: f64| {
            let mut other = values.clone();
            other[index] = prior.value(parameter.start, by).clamp(parameter.lower, parameter.upper);
            described.residuals(&described.predict(&other), gain)
        };
        columns.push(change(&moved(STEP), &moved(-STEP)));
    }
    let made = |fit: &FitSet<'_>| ModeObjective::new(machine, fit, plan.settings, &plan.frozen);
    columns.extend(nut_columns(fit, &made, &own, gain)?);
    Ok(columns)
}

/// Computes the change of the weighted residuals of modes by one standard deviation of each nut position, of
/// the objective that `made` builds, at given values and gain.
///
/// # Errors  those of `made`.
pub(super) fn nut_columns<'m>(
    fit: &FitSet<'_>,
    made: &dyn Fn(&FitSet<'_>) -> Result<ModeObjective<'m>, ObjectiveError>,
    values: &ParameterValues,
    gain: f64,
) -> Result<Vec<Vec<f64>>, ObjectiveError> {
    let nut_sd_m = fit.set().tolerance.nut_m;
    let has_nut = |p: &&usize| fit.set().positions[**p].nut_m.is_some() && nut_sd_m > 0.0;
    let of_position = |position: &usize| {
        let moved = |by: f64| -> Result<Vec<f64>, ObjectiveError> {
            let mut set = fit.set().clone();
            if let Some(nut_m) = &mut set.positions[*position].nut_m {
                *nut_m += by * nut_sd_m;
            }
            let there = made(&fit.in_version(&set))?;
            Ok(there.residuals(&there.predict(values), gain))
        };
        Ok(change(&moved(STEP)?, &moved(-STEP)?))
    };
    fit.positions().iter().filter(has_nut).map(of_position).collect()
}

/// Returns the change of residuals by one standard deviation, from those at [`STEP`] above and below.
fn change(up: &[f64], down: &[f64]) -> Vec<f64> {
    let change = up.iter().zip(down).map(|(a, b)| (a - b) / (2.0 * STEP));
    change.map(|x| if x.abs() < MAX_CHANGE { x } else { 0.0 }).collect()
}

/// Returns gain and delay of every channel found among estimated tolerances.
pub fn channels_of(machine: &Machine, values: &BTreeMap<String, f64>) -> Vec<Channel> {
    let excitations = || (0..machine.points.len()).map(Excitation::Point).chain([Excitation::Command]);
    let pairs = machine.points.iter().enumerate().flat_map(|(response, point)| {
        excitations().map(move |excitation| {
            (response, excitation, channel_name(&point.name, excitation.name(machine)))
        })
    });
    pairs
        .filter_map(|(response, excitation, name)| {
            let of = |what: &str| values.get(&format!("{what} of {name}")).copied();
            let (log_gain, delay_s) = (of("gain"), of("delay"));
            (log_gain.is_some() || delay_s.is_some()).then(|| Channel {
                response,
                excitation,
                log_gain: log_gain.unwrap_or(0.0),
                delay_s: delay_s.unwrap_or(0.0),
            })
        })
        .collect()
}

fn channel_name(response: &str, excitation: &str) -> String {
    format!("{response}/{excitation}")
}
