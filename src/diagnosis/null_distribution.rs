//! Null distribution of the reduction of χ²: simulated data of the machine itself, with tolerances and noise, are screened in the same way.
//!
//! Each draw has small discrepancies from the description (journals of other lengths, every nuisance parameter off by its standard deviation) and the
//! noise of the lines. The nominal machine is fitted to it. Its residuals are projected on the directions that each candidate can explain. The
//! largest statistic over all candidates has the distribution of a correct verdict «none».

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evidence::{Domain, DomainObjective};
use super::fit::{Fitted, Fitter, amplitudes, coordinates_of, start_of};
use super::hypothesis::Hypothesis;
use super::model_discrepancy::{sample_discrepancy, sample_prior};
use identification::Place;
use identification::objective::{FrfSettings, ObjectiveError};
use numeric::distribution::normal_upper_tail;
use numeric::parallel::OrFirstError;
use numeric::random::normal;
use optimizer::{Control, least_squares_within};

/// Least share of a change, orthogonal to the nominal and nuisance parameters, that counts as an independent direction.
const LEAST_INDEPENDENT: f64 = 0.01;
/// Steps of the fit of a draw.
const STEPS: u64 = 30;
/// Lines per FRF on which a draw is fitted from several starts.
const LINES: usize = 100;
/// Restarts of a draw that fits badly, and their standard deviation about the drawn coordinates in the unit interval of a parameter.
const RESTARTS: usize = 12;
const RESTART_SD: f64 = 0.08;
/// Least scale of a reduction of χ², in units of that by noise alone per parameter; for modes per added parameter.
pub(super) const LEAST_SCALE: f64 = 3.0;
/// Factor of the squared number of added parameters in the least scale of FRFs. Null simulations are projected on single directions, while a fit
/// searches all directions jointly and, with a frequency among them, the whole band.
const SQUARED_SCALE: f64 = 0.6;

/// Returns the least scale of a candidate with a number of added parameters.
fn least_scale(objective: &DomainObjective<'_>, added: usize) -> f64 {
    let added = added.max(1) as f64;
    match objective {
        DomainObjective::Frf(_) => LEAST_SCALE.max(SQUARED_SCALE * added * added),
        DomainObjective::Modes(_) => LEAST_SCALE * added,
    }
}

/// Null distribution of the reduction of χ².
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NullDistribution {
    /// Scale of the reduction of χ² by each candidate, by id.
    pub scales: Vec<(String, f64)>,
    /// Largest statistic (reduction of χ² over its scale) of each draw, in rising order.
    pub largest: Vec<f64>,
    /// χ² per compared number of each draw, in rising order.
    pub misfit: Vec<f64>,
}

impl NullDistribution {
    /// Returns the distribution by χ² tables: as many degrees of freedom as each candidate adds, and the largest over all candidates.
    pub(super) fn from_tables(candidates: &[(&Hypothesis, &Fitted)], seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let added: Vec<usize> = candidates.iter().map(|(h, _)| h.added.len().max(1)).collect();
        let mut one = |count: usize| (0..count).map(|_| normal(&mut random).powi(2)).sum::<f64>() / count as f64;
        let mut largest: Vec<f64> = (0..2000).map(|_| added.iter().map(|count| one(*count)).fold(0.0, f64::max)).collect();
        largest.sort_by(f64::total_cmp);
        let scales = candidates.iter().zip(&added).map(|((h, _), count)| (h.id(), *count as f64)).collect();
        NullDistribution { scales, largest, misfit: Vec::new() }
    }

    /// Returns the scale of a candidate; the least scale for a candidate without simulations.
    pub fn scale(&self, id: &str) -> f64 {
        self.scales.iter().find(|(known, _)| known == id).map_or(LEAST_SCALE, |s| s.1)
    }

    /// Returns the excess: a misfit over the median of the draws, at least 1.
    pub fn excess(&self, misfit: f64) -> f64 {
        let median = median(&self.misfit).unwrap_or(misfit);
        (misfit / median).max(1.0)
    }

    /// Returns the share of draws whose largest statistic is at least as large, by a lognormal distribution beyond the draws.
    pub fn p_value(&self, statistic: f64) -> f64 {
        // Without draws, after a stop, nothing is significant.
        if self.largest.is_empty() { 1.0 } else { upper_tail(&self.largest, statistic) }
    }
}

/// Returns the median of numbers in rising order.
fn median(rising: &[f64]) -> Option<f64> {
    rising.get(rising.len() / 2).copied()
}

/// Returns the upper tail probability of a lognormal distribution with mean and standard deviation of the draws, widened for a small sample.
fn upper_tail(draws: &[f64], value: f64) -> f64 {
    let count = draws.len() as f64;
    let logs: Vec<f64> = draws.iter().map(|x| x.max(1e-6).ln()).collect();
    let mean = logs.iter().sum::<f64>() / count;
    let sd = (logs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt().max(0.1) * (1.0 + 1.0 / count).sqrt();
    let z = (value.max(1e-9).ln() - mean) / sd;
    // Student's t with count − 1 degrees of freedom, by its normal approximation (Abramowitz and Stegun, 26.7.8).
    let freedom = (count - 1.0).max(1.0);
    let normal = z * (1.0 - 0.25 / freedom) / (1.0 + z * z / (2.0 * freedom)).sqrt();
    normal_upper_tail(normal)
}

/// Directions in which a candidate changes the whitened residuals, orthogonal to nominal and nuisance parameters.
struct Directions {
    /// Changes by amplitudes all over the candidate's range.
    each: Vec<DVector<f64>>,
    /// Orthonormal basis of small changes about the end of its fit.
    about_end: Vec<DVector<f64>>,
}

impl Directions {
    /// Computes the directions from the end of a candidate's fit and from amplitudes all over its range.
    fn of(
        projection: &Projection,
        objective: &DomainObjective<'_>,
        hypothesis: &Hypothesis,
        base: &Fitted,
        end: &Fitted,
        here: &DVector<f64>,
    ) -> Directions {
        // Priors of the effect's own parameters have no row without the effect.
        let described = &hypothesis.machine.parameters;
        let first = objective.residuals(&coordinates_of(objective, end)).len();
        let known = objective.free().iter().filter(|i| described[**i].prior.is_some());
        let its_own: Vec<usize> = known.enumerate().filter(|(_, i)| hypothesis.added.contains(i)).map(|(at, _)| first + at).collect();
        let rows = |start: &Fitted| objective.rows(&coordinates_of(objective, start)).remove_rows_at(&its_own);
        let starts = amplitudes(hypothesis).into_iter().map(|added| start_of(hypothesis, base, &added));
        // The candidate's own end, with the nominal parameters of the base: the direction of its amplitude there.
        let added: Vec<f64> = hypothesis.added.iter().map(|i| end.units[*i]).collect();
        let each = starts
            .chain(std::iter::once(start_of(hypothesis, base, &added)))
            .filter_map(|start| {
                let change = rows(&start) - here;
                let size = change.norm();
                let projected = projection.apply(&change);
                let left = projected.norm();
                // A change that nominal parameters produce as well is not an independent direction.
                (size > 1e-9 && left > LEAST_INDEPENDENT * size).then(|| projected / left)
            })
            .collect();
        Directions { each, about_end: about_end(objective, hypothesis, end, &its_own) }
    }

    /// Returns the largest reduction of χ² along one direction, or by all small changes jointly.
    fn gain(&self, residuals: &DVector<f64>) -> f64 {
        let squared = |d: &DVector<f64>| d.dot(residuals).powi(2);
        self.each.iter().map(squared).fold(self.about_end.iter().map(squared).sum(), f64::max)
    }
}

/// Returns an orthonormal basis of the changes by a candidate's own parameters about the end of its fit, orthogonal to all other parameters there.
/// Near that end a shift of a resonance by less than its width is linear. A small effect reduces χ² also by relieving the priors of other parameters.
fn about_end(objective: &DomainObjective<'_>, hypothesis: &Hypothesis, end: &Fitted, its_own: &[usize]) -> Vec<DVector<f64>> {
    let slopes = objective.slopes(&coordinates_of(objective, end)).remove_rows_at(its_own);
    let added: Vec<usize> = (0..objective.free().len()).filter(|column| hypothesis.added.contains(&objective.free()[*column])).collect();
    let others = Projection::of(slopes.clone().remove_columns_at(&added));
    let mut span: Vec<DVector<f64>> = Vec::new();
    for column in added {
        let change = slopes.column(column).into_owned();
        let own = span.iter().fold(others.apply(&change), |left, d| &left - d * d.dot(&left));
        let size = own.norm();
        if size > LEAST_INDEPENDENT * change.norm() && size > 1e-9 {
            span.push(own / size);
        }
    }
    span
}

/// Projection orthogonal to nominal and nuisance parameters, to first order, the latter within their priors.
struct Projection {
    slopes: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Projection {
    fn at(objective: &DomainObjective<'_>, place: &Place) -> Projection {
        Projection::of(objective.slopes(place))
    }

    fn of(slopes: DMatrix<f64>) -> Projection {
        let mut information = slopes.transpose() * &slopes;
        let largest = (0..information.nrows()).map(|d| information[(d, d)]).fold(f64::MIN_POSITIVE, f64::max);
        for d in 0..information.nrows() {
            information[(d, d)] += 1e-12 * largest + 1e-9;
        }
        let size = information.nrows();
        let inverse = information.try_inverse().unwrap_or_else(|| DMatrix::zeros(size, size));
        Projection { slopes, inverse }
    }

    fn apply(&self, change: &DVector<f64>) -> DVector<f64> {
        change - &self.slopes * (&self.inverse * (self.slopes.transpose() * change))
    }
}

/// Simulates the null distribution: `draws` machines around the nominal fit, and the reduction of χ² by each candidate on them.
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
    let directions = candidates
        .par_iter()
        .map(|(hypothesis, end)| -> Result<Directions, ObjectiveError> {
            if control.stopped() {
                return Ok(Directions { each: Vec::new(), about_end: Vec::new() });
            }
            Ok(Directions::of(&projection, &fitter.objective(hypothesis)?, hypothesis, base, end, &here))
        })
        .or_first_error()?;
    let gains = |left: &DVector<f64>| -> Vec<f64> { directions.iter().map(|d| d.gain(left)).collect() };
    let step = control.steps("null simulations", draws);
    let one = |draw: usize| -> Option<(Vec<f64>, f64)> {
        let random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9E37_79B9).wrapping_add(draw as u64));
        match &objective {
            DomainObjective::Frf(objective) => {
                let Domain::Frf(settings) = fitter.domain else { return None };
                let (by, drawn) = redraw_machine(|h| fitter.objective(h).ok(), nominal, base, settings, usize::MAX, random.clone())?;
                let data = objective.shifted(&by);
                let few = data.curvature_sampled(LINES);
                let end = |from: &[f64]| least_squares_within(&few, from, &[], (STEPS, 1e-3), control.stop());
                let mut best = end(&drawn);
                // A draw that fits worse than the weights of the lines allow may have ended outside its valley, which would look like a missing
                // effect.
                if best.normal.chi_square > few.observations() as f64 {
                    let mut random = random;
                    let varied = objective.free.len();
                    for _ in 0..RESTARTS {
                        let near =
                            drawn.iter().enumerate().map(|(at, x)| if at < varied { x + RESTART_SD * normal(&mut random) } else { *x });
                        let other = end(&near.map(|x| x.clamp(0.0, 1.0)).collect::<Vec<f64>>());
                        if other.normal.chi_square < best.normal.chi_square {
                            best = other;
                        }
                    }
                }
                let fitted = least_squares_within(&data, &best.place, &[], (STEPS, 1e-3), control.stop());
                let misfit = fitted.normal.chi_square / data.observations() as f64;
                Some((gains(&data.rows(&Place(fitted.place))), misfit))
            }
            DomainObjective::Modes(_) => {
                let mut random = random;
                // Weights of modes represent the model error: draws scatter by the weights or, if larger, by the residual.
                let count = here.len();
                let spread = (here.norm_squared() / (count.saturating_sub(place.len()).max(1)) as f64).clamp(1.0, 2.5).sqrt();
                let noise = DVector::from_fn(count, |_, _| spread * normal(&mut random));
                let left = projection.apply(&noise);
                Some((gains(&left), left.norm_squared() / objective.observations() as f64))
            }
        }
    };
    let ids: Vec<String> = candidates.iter().map(|(hypothesis, _)| hypothesis.id()).collect();
    let key = format!("{} {}", fitter.cache_key("null", nominal, std::slice::from_ref(base)), ids.join(" "));
    let drawn: Vec<(Vec<f64>, f64)> = (0..draws)
        .into_par_iter()
        .filter(|_| !control.stopped())
        .filter_map(|draw| control.cached(&format!("{key} {draw} {seed}"), || one(draw)))
        .inspect(|_| step())
        .collect();
    let (gains, mut misfit): (Vec<Vec<f64>>, Vec<f64>) = drawn.into_iter().unzip();
    let count = gains.len().max(1) as f64;
    misfit.sort_by(f64::total_cmp);
    // Where the noise of lines is below their weights, the scales are smaller.
    let freedom = objective.observations().saturating_sub(objective.unknowns(nominal)).max(1) as f64;
    let variance = median(&misfit).map_or(1.0, |median| median * objective.observations() as f64 / freedom).min(1.0);
    let scales: Vec<(String, f64)> = candidates
        .iter()
        .enumerate()
        .map(|(c, (hypothesis, _))| {
            let mean = gains.iter().map(|g| g[c]).sum::<f64>() / count;
            (hypothesis.id(), mean.max(variance * least_scale(&objective, hypothesis.added.len())))
        })
        .collect();
    let mut largest: Vec<f64> = gains.iter().map(|g| g.iter().zip(&scales).map(|(g, (_, s))| g / s).fold(0.0, f64::max)).collect();
    largest.sort_by(f64::total_cmp);
    Ok(NullDistribution { scales, largest, misfit })
}

/// Returns the changes of the logarithms of measured FRFs that simulate a machine with random discrepancies around a fit and the noise of the lines,
/// and the drawn coordinates. `objective` builds that of a hypothesis on these FRFs. `lines` is the number of lines per record to which the objective is thinned; `usize::MAX` for all.
pub(super) fn redraw_machine(
    objective: impl for<'h> FnOnce(&'h Hypothesis) -> Option<DomainObjective<'h>>,
    hypothesis: &Hypothesis,
    base: &Fitted,
    settings: FrfSettings,
    lines: usize,
    mut random: Xoshiro256PlusPlus,
) -> Option<(Vec<Vec<Complex64>>, Place)> {
    let random = &mut random;
    let parameters = &hypothesis.machine.parameters;
    let mut units = base.units.clone();
    for (unit, parameter) in units.iter_mut().zip(parameters) {
        if let Some(value) = sample_prior(parameter, random) {
            *unit = parameter.to_unit(value);
        }
    }
    let discrepant = Hypothesis { machine: sample_discrepancy(&hypothesis.machine, random), ..hypothesis.clone() };
    let target = objective(&discrepant)?;
    let mut place = coordinates_of(&target, &Fitted { units, ..base.clone() });
    let known_within = target.nut_coordinates().start..place.len();
    // Nut positions and channels: one standard deviation is a twentieth of the coordinate's range.
    place[known_within].iter_mut().for_each(|u| *u = 0.5 + normal(random) / 20.0);
    let DomainObjective::Frf(simulated) = target else { return None };
    // Thin to the same lines as the objective that is shifted.
    let simulated = simulated.thinned(lines);
    let by: Vec<Vec<Complex64>> = simulated
        .residuals_at(&place)
        .iter()
        .zip(simulated.records())
        .map(|(r, record)| {
            let mut noise = |sd: f64| Complex64::new(sd * normal(random), sd * normal(random));
            r.iter().zip(record.noise()).map(|(r, sd)| -r + noise(sd.unwrap_or(settings.model_error))).collect()
        })
        .collect();
    by.iter().flatten().all(|z| z.re.is_finite() && z.im.is_finite()).then_some((by, place))
}
