//! Directions of the whitened residuals that candidates can explain, and the law of what they reduce on
//! linear draws.
//!
//! About the nominal fit a draw is v = e + Σ u·c: noise e of the lines and of the priors, and discrepancies u
//! of the description with their changes c. A candidate's reduction of χ² along a unit direction d,
//! orthogonal to nominal and nuisance parameters, is (d·v)². The products d·e of all directions are jointly
//! normal with covariance DᵀΣD, so that a draw costs one product with a triangular matrix.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::amplitudes::amplitudes;
use super::evidence::DomainObjective;
use super::fit::{Fitted, coordinates_of, start_of};
use super::hypothesis::Hypothesis;
use identification::Place;
use machine::Parameter;
use numeric::random::normal;

/// Least share of a change, orthogonal to the nominal and nuisance parameters, that counts as an independent
/// direction. A change of a number that has a tolerance is orthogonal to the fit of that number only by its
/// prior: of 4000 lines with weights of 1 %, a mass with a tolerance of 1 % keeps a share of 1/√4000 = 0.016.
/// What nominal parameters produce exactly keeps 10⁻⁶, the regularisation of the projection.
const LEAST_INDEPENDENT: f64 = 1e-4;
/// Norm of a change of whitened residuals that is none.
const LEAST_CHANGE: f64 = 1e-9;
/// Cosine from which on two directions of a candidate count as one: the reduction along the omitted one is
/// larger by 4 % at most.
const SAME_DIRECTION: f64 = 0.98;
/// Draws that are computed together.
const BATCH: usize = 100;
/// Share of the largest variance of a product that is added to all: directions of several candidates may
/// depend on each other.
const REGULARISATION: f64 = 1e-9;

/// Projection orthogonal to nominal and nuisance parameters, to first order, the latter within their priors.
pub(super) struct Projection {
    slopes: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Projection {
    pub fn at(objective: &DomainObjective<'_>, place: &Place) -> Projection {
        Projection::of(objective.slopes(place))
    }

    fn of(slopes: DMatrix<f64>) -> Projection {
        let mut information = slopes.tr_mul(&slopes);
        let largest = (0..information.nrows()).map(|d| information[(d, d)]).fold(f64::MIN_POSITIVE, f64::max);
        for d in 0..information.nrows() {
            information[(d, d)] += 1e-12 * largest + 1e-9;
        }
        let size = information.nrows();
        let inverse = information.try_inverse().unwrap_or_else(|| DMatrix::zeros(size, size));
        Projection { slopes, inverse }
    }

    pub fn apply(&self, change: &DVector<f64>) -> DVector<f64> {
        change - &self.slopes * (&self.inverse * self.slopes.tr_mul(change))
    }
}

/// Directions in which a candidate changes the whitened residuals, orthogonal to nominal and nuisance
/// parameters.
pub(super) struct Directions {
    /// Changes by amplitudes all over the candidate's range, with the coordinates of its own parameters that
    /// make them.
    each: Vec<(Vec<f64>, DVector<f64>)>,
    /// Basis of small changes about the end of its fit, orthonormal there.
    about_end: Vec<DVector<f64>>,
    /// Of all these amplitudes the one of which nominal and nuisance parameters leave the median share.
    pub typical: Option<Trial>,
}

/// A change by given coordinates of a candidate's own parameters.
pub(super) struct Trial {
    pub added: Vec<f64>,
    /// Norm of the change of the whitened residuals orthogonal to nominal and nuisance parameters.
    pub left: f64,
    /// Its share in the norm of the change.
    share: f64,
}

impl Directions {
    /// Computes the directions from the end of a candidate's fit and from amplitudes all over its range.
    pub fn of(
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
        let its_own: Vec<usize> = known
            .enumerate()
            .filter(|(_, i)| hypothesis.added.contains(i))
            .map(|(at, _)| first + at)
            .collect();
        let rows =
            |start: &Fitted| objective.rows(&coordinates_of(objective, start)).remove_rows_at(&its_own);
        // The candidate's own end, with the nominal parameters of the base: the direction of its amplitude
        // there.
        let at_end: Vec<f64> = hypothesis.added.iter().map(|i| end.units[*i]).collect();
        let mut each: Vec<(Vec<f64>, DVector<f64>)> = Vec::new();
        let own: Vec<&Parameter> = hypothesis.added.iter().map(|i| &described[*i]).collect();
        let mut trials: Vec<Trial> = Vec::new();
        for added in std::iter::once(at_end).chain(amplitudes(&own)) {
            let change = rows(&start_of(hypothesis, base, &added)) - here;
            if change.norm() <= LEAST_CHANGE {
                continue;
            }
            let Some((direction, left)) = independent(projection, &change) else {
                trials.push(Trial { added, left: 0.0, share: 0.0 });
                continue;
            };
            trials.push(Trial { added: added.clone(), left, share: left / change.norm() });
            if each.iter().all(|(_, other)| other.dot(&direction).abs() < SAME_DIRECTION) {
                each.push((added, direction));
            }
        }
        let about_end =
            about_end(objective, hypothesis, end, &its_own).iter().map(|d| projection.apply(d)).collect();
        trials.sort_by(|a, b| a.share.total_cmp(&b.share));
        let middle = trials.len() / 2;
        let typical = trials.into_iter().nth(middle).filter(|trial| trial.left > 0.0);
        Directions { each, about_end, typical }
    }

    /// Directions of a candidate that is not computed, after a stop.
    pub fn none() -> Self {
        Directions { each: Vec::new(), about_end: Vec::new(), typical: None }
    }

    fn count(&self) -> usize {
        self.each.len() + self.about_end.len()
    }

    fn all(&self) -> impl Iterator<Item = &DVector<f64>> {
        self.each.iter().map(|(_, d)| d).chain(&self.about_end)
    }

    /// Returns the largest reduction of χ² along one direction, or by all small changes jointly, from the
    /// products of residuals and directions.
    fn gain(&self, products: &[f64]) -> f64 {
        let (each, about_end) = products.split_at(self.each.len());
        each.iter().map(|x| x * x).fold(about_end.iter().map(|x| x * x).sum(), f64::max)
    }

    /// Returns the reduction of χ² of given residuals.
    pub fn reduction(&self, residuals: &DVector<f64>) -> f64 {
        self.gain(&self.all().map(|d| d.dot(residuals)).collect::<Vec<f64>>())
    }

    /// Returns the coordinates of the candidate's own parameters along whose directions the reduction of χ²
    /// is largest, the best first.
    pub fn best(&self, residuals: &DVector<f64>, most: usize) -> Vec<&[f64]> {
        let mut found: Vec<(f64, &[f64])> =
            self.each.iter().map(|(added, d)| (d.dot(residuals).abs(), added.as_slice())).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().take(most).map(|(_, added)| added).collect()
    }
}

/// Returns the unit direction of a change orthogonal to nominal and nuisance parameters, and its length; `None` where
/// these produce the change as well.
fn independent(projection: &Projection, change: &DVector<f64>) -> Option<(DVector<f64>, f64)> {
    let projected = projection.apply(change);
    let (size, left) = (change.norm(), projected.norm());
    (size > LEAST_CHANGE && left > LEAST_INDEPENDENT * size).then(|| (projected / left, left))
}

/// Returns an orthonormal basis of the changes by a candidate's own parameters about the end of its fit,
/// orthogonal to all other parameters there. Near that end a shift of a resonance by less than its width is
/// linear. A small effect reduces χ² also by relieving the priors of other parameters.
fn about_end(
    objective: &DomainObjective<'_>,
    hypothesis: &Hypothesis,
    end: &Fitted,
    its_own: &[usize],
) -> Vec<DVector<f64>> {
    let slopes = objective.slopes(&coordinates_of(objective, end)).remove_rows_at(its_own);
    let added: Vec<usize> = (0..objective.free().len())
        .filter(|column| hypothesis.added.contains(&objective.free()[*column]))
        .collect();
    let others = Projection::of(slopes.clone().remove_columns_at(&added));
    let mut span: Vec<DVector<f64>> = Vec::new();
    for column in added {
        let change = slopes.column(column).into_owned();
        let own = span.iter().fold(others.apply(&change), |left, d| &left - d * d.dot(&left));
        let size = own.norm();
        if size > LEAST_INDEPENDENT * change.norm() && size > LEAST_CHANGE {
            span.push(own / size);
        }
    }
    span
}

/// Returns the random numbers of a draw: each has its own, so that draws do not depend on the order in which
/// they are made.
pub(crate) fn generator(seed: u64, draw: usize) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9E37_79B9).wrapping_add(draw as u64))
}

/// Returns the reduction of χ² by each candidate on linear draws. `noise` is the standard deviation of each
/// whitened residual, priors included; `discrepancies` are the changes of the residuals over the whole range
/// of each discrepancy, which is uniform.
pub(super) fn linear_draws(
    directions: &[Directions],
    noise: &DVector<f64>,
    discrepancies: &[DVector<f64>],
    draws: usize,
    seed: u64,
) -> Vec<Vec<f64>> {
    let all: Vec<&DVector<f64>> = directions.iter().flat_map(Directions::all).collect();
    if all.is_empty() {
        return vec![vec![0.0; directions.len()]; draws];
    }
    let scaled = DMatrix::from_fn(all.len(), noise.len(), |d, row| all[d][row] * noise[row]);
    let mut covariance = &scaled * scaled.transpose();
    let largest = covariance.diagonal().max();
    (0..all.len()).for_each(|d| covariance[(d, d)] += REGULARISATION * largest);
    let Some(factor) = covariance.cholesky().map(|c| c.l()) else { return Vec::new() };
    let shifts: Vec<DVector<f64>> = discrepancies
        .iter()
        .map(|c| DVector::from_iterator(all.len(), all.iter().map(|d| d.dot(c))))
        .collect();
    let batch = |from: usize| {
        let mut random = generator(seed, from);
        let count = BATCH.min(draws - from);
        let mut products = &factor * DMatrix::from_fn(all.len(), count, |_, _| normal(&mut random));
        let gains = products.column_iter_mut().map(|mut column| {
            for shift in &shifts {
                column.axpy(random.random_range(-0.5..0.5), shift, 1.0);
            }
            let mut from = 0;
            let gains = directions.iter().map(|d| {
                let own = from..from + d.count();
                from = own.end;
                d.gain(&column.as_slice()[own])
            });
            gains.collect()
        });
        gains.collect::<Vec<Vec<f64>>>()
    };
    (0..draws.div_ceil(BATCH)).into_par_iter().flat_map_iter(|at| batch(at * BATCH)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number that lines determine far better than its tolerance, changed by an effect: the effect relieves
    /// its prior, and nothing else. An effect that does what a number without a tolerance does has no
    /// direction.
    #[test]
    fn limit_a_change_of_a_number_with_a_tolerance_relieves_its_prior() {
        let lines = 100_000;
        let change = |prior: f64| {
            DVector::from_fn(lines + 1, |row, _| if row < lines { 1.0 + (row as f64).sin() } else { prior })
        };
        let projection = Projection::of(DMatrix::from_columns(&[change(1.0)]));
        let (direction, _) = independent(&projection, &change(0.0)).unwrap();
        assert!(direction[lines].abs() > 0.999, "{}", direction[lines]);
        assert!(independent(&Projection::of(DMatrix::from_columns(&[change(0.0)])), &change(0.0)).is_none());
    }

    /// Gains of linear draws are those of draws written out: each direction's is the square of a normal
    /// number, jointly with all others.
    #[test]
    fn limit_linear_draws_have_the_law_of_projected_noise() {
        let rows = 40;
        let direction =
            |phase: f64| DVector::from_fn(rows, |row, _| (0.3 * row as f64 + phase).sin()).normalize();
        let one = Directions {
            each: vec![(vec![0.0], direction(0.0)), (vec![1.0], direction(0.4))],
            about_end: Vec::new(),
            typical: None,
        };
        let other =
            Directions { each: Vec::new(), about_end: vec![direction(0.2), direction(1.5)], typical: None };
        let noise = DVector::from_fn(rows, |row, _| 0.5 + 0.02 * row as f64);
        let change = 4.0 * direction(0.7);
        let directions = [one, other];
        let draws = 20_000;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        let written_out: Vec<Vec<f64>> = (0..draws)
            .map(|_| {
                let left = DVector::from_fn(rows, |row, _| noise[row] * normal(&mut random))
                    + &change * random.random_range(-0.5..0.5);
                directions.iter().map(|d| d.reduction(&left)).collect()
            })
            .collect();
        let linear = linear_draws(&directions, &noise, &[change], draws, 1);
        for candidate in 0..2 {
            for level in [0.5, 0.9, 0.99] {
                let of = |all: &[Vec<f64>]| {
                    numeric::statistics::quantile(all.iter().map(|gains| gains[candidate]), level).unwrap()
                };
                let (found, expected) = (of(&linear), of(&written_out));
                assert!(
                    (found / expected - 1.0).abs() < 0.08,
                    "{candidate} at {level}: {found} instead of {expected}"
                );
            }
        }
    }
}
