//! Null distribution of the reduction of χ²: simulated data of the machine itself, with tolerances and noise.
//!
//! Each draw has small discrepancies from the description (journals of other lengths, every nuisance
//! parameter off by its standard deviation) and the noise of the lines. Most draws are linear about the
//! nominal fit: residuals are projected on the directions that each candidate can explain. In a few, the
//! nominal machine and the leading candidate are fitted in full. The largest statistic over all candidates
//! has the distribution of a correct verdict «none», so that its share of larger draws is a p-value corrected
//! for the number of candidates.

use nalgebra::DVector;
use num_complex::Complex64;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::data_kind::DataKind;
use super::evidence::{Domain, DomainObjective};
use super::fit::{Fitted, Fitter, TRUST_RADIUS, coordinates_of, read_back, start_of};
use super::hypothesis::Hypothesis;
use super::model_discrepancy::{extreme_discrepancies, sample_discrepancy, sample_prior};
use super::null_directions::{Directions, Projection, generator, linear_draws};
use super::policy::{LEAST_SCALE, MODE_VARIANCE, Policy, SQUARED_SCALE};
use identification::Place;
use identification::objective::{FrfObjective, FrfRecord, FrfSettings, ObjectiveError};
use long_work::Control;
use numeric::distribution::monte_carlo_p_value;
use numeric::parallel::OrFirstError;
use numeric::random::normal;
use numeric::statistics::{median, quantile, root_mean_square};
use optimizer::{LeastSquares, Polished, least_squares_within};

/// Number of linear draws: the least p-value is 0.0005.
const LINEAR_DRAWS: usize = 2000;
/// Steps of the fit of a draw, and relative decrease of χ² per step at which it ends.
const STEPS: (u64, f64) = (30, 1e-3);
/// Lines per FRF on which a draw is fitted from several starts.
const LINES: usize = 100;
/// Directions of the leading candidate of a draw whose amplitudes are compared as starts of its fit.
const FOLLOWED: usize = 5;
/// Restarts of a draw that fits badly, and their standard deviation about the drawn coordinates in the unit
/// interval of a parameter.
const RESTARTS: usize = 12;
const RESTART_SD: f64 = 0.08;
/// Quantile of the normal distribution that nine of ten draws exceed, negated.
const NINE_OF_TEN: f64 = 1.2816;

/// Returns the least scale of a candidate with a number of added parameters.
pub(super) fn least_scale(data: DataKind, added: usize) -> f64 {
    let added = added.max(1) as f64;
    if data == DataKind::Modes { LEAST_SCALE * added } else { LEAST_SCALE.max(SQUARED_SCALE * added * added) }
}

/// Returns the excess: a misfit over the median of those of null simulations, at least 1; 1 without
/// simulations.
pub(crate) fn excess(misfit: f64, simulated: &[f64]) -> f64 {
    let usual = median(simulated.iter().copied()).unwrap_or(misfit);
    (misfit / usual).max(1.0)
}

/// Null distribution of the reduction of χ².
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NullDistribution {
    /// Scale of the reduction of χ² by each candidate, by id.
    pub scales: Vec<(String, f64)>,
    /// Largest statistic (reduction of χ² over its scale) of each linear draw, in rising order.
    pub largest: Vec<f64>,
    /// The same of each draw in which machine and leading candidate were fitted in full, in rising order;
    /// empty for modes.
    pub fitted: Vec<f64>,
    /// χ² per compared number of each draw with a fitted machine, in rising order.
    pub misfit: Vec<f64>,
    /// Root mean square change of ln H from which on an effect would be significant in nine of ten tests, by id: for
    /// changes of a form that is typical of it. Effects that the parameters of the machine take up have none, and
    /// those of modes.
    #[serde(default)]
    pub seen_from: Vec<(String, f64)>,
}

impl NullDistribution {
    /// Returns the distribution by χ² tables: as many degrees of freedom as each candidate adds, and the
    /// largest over all candidates.
    pub(super) fn from_tables(candidates: &[(&Hypothesis, &Fitted)], seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let added: Vec<usize> = candidates.iter().map(|(h, _)| h.added.len().max(1)).collect();
        let mut one =
            |count: usize| (0..count).map(|_| normal(&mut random).powi(2)).sum::<f64>() / count as f64;
        let mut largest: Vec<f64> =
            (0..LINEAR_DRAWS).map(|_| added.iter().map(|count| one(*count)).fold(0.0, f64::max)).collect();
        largest.sort_by(f64::total_cmp);
        let scales = candidates.iter().zip(&added).map(|((h, _), count)| (h.id(), *count as f64)).collect();
        NullDistribution { scales, largest, ..Default::default() }
    }

    /// Returns the scale of a candidate; the least scale for a candidate without simulations.
    pub fn scale(&self, id: &str) -> f64 {
        self.scales.iter().find(|(known, _)| known == id).map_or(LEAST_SCALE, |s| s.1)
    }

    /// Returns the excess of a misfit.
    pub fn excess(&self, misfit: f64) -> f64 {
        excess(misfit, &self.misfit)
    }

    /// Whether a misfit is larger than in each draw.
    pub fn exceeds(&self, misfit: f64) -> bool {
        self.misfit.last().is_some_and(|largest| misfit > *largest)
    }

    /// Returns the factor on linear draws: full fits may end in minima that linear draws do not have, and
    /// then reduce χ² more.
    pub fn factor(&self) -> f64 {
        let [linear, fitted] = [&self.largest, &self.fitted].map(|all| median(all.iter().copied()));
        fitted.zip(linear).map_or(1.0, |(fitted, linear)| fitted / linear).max(1.0)
    }

    /// Returns the least statistic that is significant.
    fn least_significant(&self, policy: &Policy) -> f64 {
        let rarer = quantile(self.largest.iter().copied(), 1.0 - policy.alpha).unwrap_or(0.0);
        self.factor() * rarer
    }

    /// Returns the p-value of a statistic among the largest ones of the linear draws.
    pub fn p_value(&self, statistic: f64) -> f64 {
        let factor = self.factor();
        let larger = self.largest.len() - self.largest.partition_point(|x| factor * x < statistic);
        monte_carlo_p_value(larger, self.largest.len())
    }
}

/// Simulates the null distribution: linear draws around the nominal fit with the reduction of χ² by each
/// candidate, and a number of draws that are fitted in full.
///
/// # Errors  as [`DomainObjective::new`].
pub fn simulate(
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    base: &Fitted,
    candidates: &[(&Hypothesis, &Fitted)],
    draws: usize,
    seed: u64,
    control: &Control,
) -> Result<NullDistribution, ObjectiveError> {
    let objective = fitter.objective(nominal)?;
    let place = coordinates_of(&objective, base);
    let here = objective.rows(&place);
    let projection = Projection::at(&objective, &place);
    let objectives = candidates
        .iter()
        .map(|(hypothesis, _)| fitter.objective(hypothesis))
        .collect::<Result<Vec<_>, _>>()?;
    let of = |((hypothesis, end), objective): (&(&Hypothesis, &Fitted), &DomainObjective<'_>)| match control
        .stopped()
    {
        true => Directions::none(),
        false => Directions::of(&projection, objective, hypothesis, base, end, &here),
    };
    let directions: Vec<Directions> = candidates.par_iter().zip(&objectives).map(of).collect();
    if control.stopped() {
        return Ok(NullDistribution::default());
    }
    let noise = noise_of(&objective, &here, place.len());
    // Discrepancies change the machine with tolerances as stated, and tolerances absorb them there: a fit
    // that lacks an effect may have moved them far.
    let mut stated = place.clone();
    for (unit, parameter) in
        stated.iter_mut().zip(objective.free().iter().map(|i| &nominal.machine.parameters[*i]))
    {
        if parameter.is_tolerance() {
            *unit = parameter.to_unit(parameter.start);
        }
    }
    stated[objective.nut_coordinates().start..].fill(0.5);
    let stated_projection = Projection::at(&objective, &stated);
    let changes = |machines: [machine::Machine; 2]| -> Result<DVector<f64>, ObjectiveError> {
        let rows = |machine| -> Result<DVector<f64>, ObjectiveError> {
            let discrepant = Hypothesis { machine, ..nominal.clone() };
            Ok(fitter.objective(&discrepant)?.rows(&stated))
        };
        let [least, largest] = machines;
        Ok(stated_projection.apply(&(rows(largest)? - rows(least)?)))
    };
    let discrepancies = match fitter.domain {
        Domain::Frf(_) => {
            extreme_discrepancies(&nominal.machine).into_par_iter().map(changes).or_first_error()?
        }
        Domain::Modes(_) => Vec::new(),
    };
    let gains = linear_draws(&directions, &noise, &discrepancies, LINEAR_DRAWS, seed);
    let count = gains.len().max(1) as f64;
    let means: Vec<f64> =
        (0..candidates.len()).map(|c| gains.iter().map(|g| g[c]).sum::<f64>() / count).collect();
    let is_frf = matches!(objective, DomainObjective::Frf(_));
    // Where the noise of lines is below their weights, the scales are smaller.
    let scales_at = |variance: f64| -> Vec<f64> {
        let of = |(mean, (hypothesis, _)): (&f64, &(&Hypothesis, &Fitted))| {
            mean.max(variance * least_scale(fitter.domain.kind(), hypothesis.added.len()))
        };
        means.iter().zip(candidates).map(of).collect()
    };
    let expected = scales_at(objective.noise_share().min(1.0));
    let full = FullFits {
        fitter,
        nominal,
        base,
        candidates,
        objectives: &objectives,
        directions: &directions,
        scales: &expected,
    };
    let step = control.steps("null simulations", draws);
    let ids: Vec<String> = candidates.iter().map(|(hypothesis, _)| hypothesis.id()).collect();
    let key = format!("{} {}", fitter.cache_key("null", nominal, std::slice::from_ref(base)), ids.join(" "));
    let one = |draw: usize| -> Option<(usize, f64, f64)> {
        let mut random = generator(seed, draw);
        match (&objective, fitter.domain) {
            (DomainObjective::Frf(objective), Domain::Frf(settings)) => {
                full.of(objective, settings, random, control)
            }
            _ => {
                let left = projection.apply(&noise.map(|sd| sd * normal(&mut random)));
                Some((0, 0.0, left.norm_squared() / objective.observations() as f64))
            }
        }
    };
    let drawn: Vec<(usize, f64, f64)> = (0..draws)
        .into_par_iter()
        .filter(|_| !control.stopped())
        .filter_map(|draw| control.cached(&format!("{key} {draw} {seed}"), || one(draw)))
        .inspect(|_| step())
        .collect();
    let mut misfit: Vec<f64> = drawn.iter().map(|d| d.2).collect();
    misfit.sort_by(f64::total_cmp);
    let freedom = objective.observations().saturating_sub(objective.unknowns(nominal)).max(1) as f64;
    let usual = median(misfit.iter().copied());
    let scales =
        scales_at(usual.map_or(1.0, |median| median * objective.observations() as f64 / freedom).min(1.0));
    let mut largest: Vec<f64> =
        gains.iter().map(|g| g.iter().zip(&scales).map(|(g, s)| g / s).fold(0.0, f64::max)).collect();
    largest.sort_by(f64::total_cmp);
    let is_fitted = is_frf && !candidates.is_empty();
    let mut fitted: Vec<f64> =
        drawn.iter().filter(|_| is_fitted).map(|(c, gain, _)| gain / scales[*c]).collect();
    fitted.sort_by(f64::total_cmp);
    let mut null = NullDistribution { largest, fitted, misfit, ..Default::default() };
    null.scales = ids.iter().cloned().zip(scales).collect();
    let seen = |at: usize| {
        let DomainObjective::Frf(objective) = &objectives[at] else { return None };
        let trial = directions[at].typical.as_ref()?;
        let needed = null.least_significant(Policy::of(fitter.domain.kind())) * null.scales[at].1;
        let change = change_of(&objectives[at], objective, (candidates[at].0, base), &trial.added);
        Some((ids[at].clone(), change * (needed.sqrt() + NINE_OF_TEN) / trial.left))
    };
    let seen_from = (0..candidates.len()).into_par_iter().filter_map(seen).collect();
    Ok(NullDistribution { seen_from, ..null })
}

/// Returns the root mean square change of ln H, per component, by parameters that a hypothesis adds to a fit.
fn change_of(
    extended: &DomainObjective<'_>,
    objective: &FrfObjective<'_>,
    (hypothesis, base): (&Hypothesis, &Fitted),
    added: &[f64],
) -> f64 {
    let of = |added: &[f64]| {
        objective.residuals_at(&coordinates_of(extended, &start_of(hypothesis, base, added))).concat()
    };
    let change = of(added).into_iter().zip(of(&[])).map(|(with, without)| (with - without).norm_sqr() / 2.0);
    root_mean_square(change.map(f64::sqrt)).unwrap_or(0.0)
}

/// Returns the standard deviation of each row of an objective in a draw, from the rows and the number of
/// coordinates of the nominal fit.
fn noise_of(objective: &DomainObjective<'_>, here: &DVector<f64>, coordinates: usize) -> DVector<f64> {
    match objective {
        DomainObjective::Frf(objective) => {
            let mut noise = objective.noise_of_rows();
            noise.resize(here.len(), 1.0);
            DVector::from_vec(noise)
        }
        // Draws scatter by the weights or, if larger, by the residual.
        DomainObjective::Modes(_) => {
            let (least, largest) = MODE_VARIANCE;
            let variance = here.norm_squared() / here.len().saturating_sub(coordinates).max(1) as f64;
            DVector::from_element(here.len(), variance.clamp(least, largest).sqrt())
        }
    }
}

/// Draws whose machine and leading candidate are fitted in full.
struct FullFits<'f, 's> {
    fitter: &'f Fitter<'s>,
    nominal: &'f Hypothesis,
    base: &'f Fitted,
    candidates: &'f [(&'f Hypothesis, &'f Fitted)],
    objectives: &'f [DomainObjective<'f>],
    directions: &'f [Directions],
    /// Expected scale of the reduction of χ² by each candidate.
    scales: &'f [f64],
}

impl FullFits<'_, '_> {
    /// Returns the leading candidate of a draw, its reduction of χ², and the misfit of the machine per
    /// compared number.
    fn of(
        &self,
        objective: &FrfObjective<'_>,
        settings: FrfSettings,
        random: Xoshiro256PlusPlus,
        control: &Control,
    ) -> Option<(usize, f64, f64)> {
        let (by, drawn) =
            redraw_machine(self.fitter, self.nominal, self.base, settings, &mut random.clone())?;
        let data = objective.shifted(&by);
        let machine = fit_drawn(&data, &drawn, Some(random), control);
        let misfit = machine.normal.chi_square / data.observations() as f64;
        let place = Place(machine.place);
        let residuals = data.rows(&place);
        let statistic: Vec<f64> = self
            .directions
            .iter()
            .zip(self.scales)
            .map(|(d, scale)| d.reduction(&residuals) / scale)
            .collect();
        let leading = (0..statistic.len()).max_by(|a, b| statistic[*a].total_cmp(&statistic[*b]));
        let Some((leading, DomainObjective::Frf(own))) =
            leading.and_then(|c| Some((c, self.objectives.get(c)?)))
        else {
            return Some((0, 0.0, misfit));
        };
        let fitted = read_back(&DomainObjective::Frf(data), self.base, &place, machine.normal.chi_square);
        let hypothesis = self.candidates[leading].0;
        let own = own.shifted(&by);
        let few = own.curvature_sampled(LINES);
        let starts = self.directions[leading].best(&residuals, FOLLOWED).into_iter();
        let starts = starts
            .map(|added| coordinates_of(&self.objectives[leading], &start_of(hypothesis, &fitted, added)));
        let cost = |start: &Place| few.normal(start).cost_after_step(TRUST_RADIUS);
        let best = starts.map(|start| (cost(&start), start)).min_by(|a, b| a.0.total_cmp(&b.0));
        let end =
            best.map_or(f64::INFINITY, |(_, start)| fit_drawn(&own, &start, None, control).normal.chi_square);
        Some((leading, (fitted.chi_square - end).max(0.0), misfit))
    }
}

/// Fits drawn data on few lines, then on all. With random numbers, a fit that ends high is restarted around
/// the start.
fn fit_drawn(
    data: &FrfObjective<'_>,
    start: &Place,
    random: Option<Xoshiro256PlusPlus>,
    control: &Control,
) -> Polished {
    let few = data.curvature_sampled(LINES);
    let end = |from: &[f64]| least_squares_within(&few, from, &[], STEPS, control.stop());
    let mut best = end(start);
    // A draw that fits worse than the weights of the lines allow may have ended outside its valley, which
    // would look like a missing effect.
    if let Some(mut random) = random.filter(|_| best.normal.chi_square > few.observations() as f64) {
        let varied = data.free.len();
        for _ in 0..RESTARTS {
            let near = start
                .iter()
                .enumerate()
                .map(|(at, x)| if at < varied { x + RESTART_SD * normal(&mut random) } else { *x });
            let other = end(&near.map(|x| x.clamp(0.0, 1.0)).collect::<Vec<f64>>());
            if other.normal.chi_square < best.normal.chi_square {
                best = other;
            }
        }
    }
    least_squares_within(data, &best.place, &[], STEPS, control.stop())
}

/// Returns a machine of the same kind: tolerances and discrepancies of a hypothesis and its fit are drawn anew; what
/// it adds stays.
pub(super) fn redrawn(
    hypothesis: &Hypothesis,
    fitted: &Fitted,
    random: &mut Xoshiro256PlusPlus,
) -> (Hypothesis, Fitted) {
    let mut drawn = fitted.clone();
    for (at, parameter) in hypothesis.machine.parameters.iter().enumerate() {
        if let Some(value) = sample_prior(parameter, random).filter(|_| !hypothesis.added.contains(&at)) {
            drawn.units[at] = parameter.to_unit(value);
        }
    }
    let machine = sample_discrepancy(&hypothesis.machine, random);
    (Hypothesis { machine, ..hypothesis.clone() }, drawn)
}

/// Returns the changes of the logarithms of measured FRFs that simulate a measurement of a machine of the same
/// kind as a fit, and the coordinates of that measurement.
fn redraw_machine(
    fitter: &Fitter<'_>,
    hypothesis: &Hypothesis,
    base: &Fitted,
    settings: FrfSettings,
    random: &mut Xoshiro256PlusPlus,
) -> Option<(Vec<Vec<Complex64>>, Place)> {
    let (machine, drawn) = redrawn(hypothesis, base, random);
    let objective = fitter.objective(&machine).ok()?;
    let place = set_up_again(&objective, &drawn, random);
    let DomainObjective::Frf(simulated) = objective else { return None };
    let noise = |record: &FrfRecord, line: usize| noise_at(record.noise(), line, settings, random);
    Some((simulated_changes(&simulated, &place, noise)?, place))
}

/// Returns the coordinates of a new measurement of a machine: nut positions and channels off by their standard
/// deviations.
pub(super) fn set_up_again(
    machine: &DomainObjective<'_>,
    fitted: &Fitted,
    random: &mut Xoshiro256PlusPlus,
) -> Place {
    let mut place = coordinates_of(machine, fitted);
    let known_within = machine.nut_coordinates().start..place.len();
    // One standard deviation is a twentieth of the coordinate's range.
    place[known_within].iter_mut().for_each(|u| *u = 0.5 + normal(random) / 20.0);
    place
}

/// Draws the noise of a line; one whose standard deviation is unknown has the model error.
pub(super) fn noise_at(
    deviations: &[Option<f64>],
    line: usize,
    settings: FrfSettings,
    random: &mut Xoshiro256PlusPlus,
) -> Complex64 {
    let sd = deviations[line].unwrap_or(settings.model_error);
    Complex64::new(sd * normal(random), sd * normal(random))
}

/// Returns the changes of the logarithms of measured FRFs that replace them by those of a machine at given
/// coordinates, with the noise of each line; `None` where one is not finite.
pub(super) fn simulated_changes(
    simulated: &FrfObjective<'_>,
    place: &Place,
    mut noise: impl FnMut(&FrfRecord, usize) -> Complex64,
) -> Option<Vec<Vec<Complex64>>> {
    let of = |(residuals, record): (&Vec<Complex64>, &FrfRecord)| {
        residuals.iter().enumerate().map(|(line, r)| noise(record, line) - r).collect()
    };
    let by: Vec<Vec<Complex64>> =
        simulated.residuals_at(place).iter().zip(simulated.records()).map(of).collect();
    by.iter().flatten().all(|z| z.re.is_finite() && z.im.is_finite()).then_some(by)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// p-values count the draws that were made, and no statistic is rarer than one in all of them.
    #[test]
    fn limit_p_values_count_draws() {
        let largest = (1..=999).map(|x| f64::from(x) / 100.0).collect();
        let mut null = NullDistribution { largest, fitted: vec![2.0; 40], ..Default::default() };
        // The median of full fits is below that of the linear draws, 5: these count as they are.
        for (statistic, p) in [(0.0, 1.0), (5.0, 0.501), (9.99, 0.002), (10.0, 0.001), (1e9, 0.001)] {
            assert!(
                (null.p_value(statistic) - p).abs() < 1e-12,
                "{statistic}: {} instead of {p}",
                null.p_value(statistic)
            );
        }
        // Full fits that reduce χ² twice as much double all statistics of the linear draws.
        null.fitted = vec![10.0; 40];
        assert!((null.p_value(10.0) - 0.501).abs() < 1e-12);
        assert!((null.p_value(19.98) - 0.002).abs() < 1e-12);
        null.largest.clear();
        assert_eq!(null.p_value(1e9), 1.0);
    }

    /// A misfit counts against the median of the draws, for FRFs and motion records alike.
    #[test]
    fn limit_an_excess_is_relative_to_the_median_draw() {
        let simulated = [1.0, 2.0, 4.0, 40.0];
        assert_eq!([3.0, 6.0, 0.5].map(|misfit| excess(misfit, &simulated)), [1.0, 2.0, 1.0]);
        assert_eq!(excess(7.0, &[]), 1.0);
    }
}
