//! Defines what an identification needs of its data: a coarse cost to search, a sum of squares to refine,
//! blocks to resample.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::place::Place;
use super::profile::CHI_SQUARE_95;
use crate::objective::{FrfObjective, ModeObjective, ModeSquares};
use long_work::Control;
use machine::ParameterValues;
use numeric::random::latin_hypercube;
use optimizer::{
    Cost, LeastSquares, Polished, SearchSettings, least_squares, least_squares_within, search, simplex,
};

/// Coarse simplex: edge length in the unit cube, and relative spread of the costs at which it stops.
const COARSE_SIMPLEX: (f64, f64) = (0.02, 1e-6);
/// Final simplex: edge length in the unit cube, and relative spread of the costs at which it stops.
const FINAL_SIMPLEX: (f64, f64) = (0.002, 1e-12);
/// Least-squares steps on coarse lines from every start, and the relative reduction of χ² at which they end.
const FIRST: (u64, f64) = (100, 1e-4);
/// Largest number of minima on coarse lines, those of the least χ², that are continued with the weights of
/// the data.
const CONTINUED: usize = 13;
/// Largest number of further steps on thinned lines, and the relative reduction of χ² at which they end.
const THIN: (u64, f64) = (80, 1e-6);
/// Largest number of steps on all data.
const STEPS: u64 = 200;
/// Largest number of least-squares steps from a nearby start.
pub(super) const POLISH: u64 = 100;

/// A minimum, found from some of the starts of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basin {
    /// Its coordinates.
    pub place: Place,
    /// χ², or the cost of an objective that is no likelihood.
    pub cost: f64,
    /// Number of spread starts that ended in it; 0 if it was met on the way of a profile.
    pub starts: usize,
}

/// Searches from a number of new spread starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Their ends on the data of [`Problem::coarse_misfit`]; those of hopeless starts are left out.
    pub ends: Vec<Basin>,
    /// Number of evaluations of the cost or its derivatives.
    pub evaluations: u64,
    /// Least cost after each generation or start.
    pub trace: Vec<f64>,
    /// Whether it ran to its end.
    pub complete: bool,
}

/// The misfit between data and a machine as a function of unit-cube coordinates: free parameters, tolerances
/// and, if unknown, the gain.
pub trait Problem: Sync {
    /// Number of starts in a round.
    const STARTS: usize;
    /// Largest number of starts for each time that the best minimum has to be found: the budget of a search.
    const STARTS_PER_FIND: usize;

    /// Returns the indices of the free parameters that are not tolerances: the first coordinates.
    fn free(&self) -> &[usize];
    /// Returns the indices of all parameters that are fitted, tolerances included: the first coordinates.
    fn varied(&self) -> &[usize] {
        self.free()
    }
    /// Returns the coordinate of the gain, if it is unknown.
    fn gain_column(&self) -> Option<usize>;
    /// Returns the number of real numbers compared.
    fn observations(&self) -> usize;
    /// Returns the machine's parameters at the given coordinates.
    fn values(&self, place: &Place) -> ParameterValues;
    /// Returns the gain at the given coordinates.
    fn gain_at(&self, place: &Place) -> f64;
    /// Searches from new spread starts.
    fn round(&self, seed: u64, control: &Control) -> Round;
    /// Refines the end of a round on all data. Returns also the number of evaluations.
    fn refined(&self, end: &Basin, control: &Control) -> (Basin, u64);
    /// Returns χ² per degree of freedom, at least 1, of a cost of the rounds.
    fn coarse_misfit(&self, cost: f64) -> f64;
    /// Returns the information JᵀJ about an end of a round, on its data; `None` where the cost is no
    /// likelihood.
    fn coarse_information(&self, place: &Place) -> Option<DMatrix<f64>>;
    /// Returns a start from coordinates of other data of the same set.
    /// Free parameters and tolerances of the description are kept; the data's own coordinates restart.
    fn start_near(&self, near: &Place) -> Place;
    /// Returns the problem with the variance of the data multiplied by a factor and priors unchanged; `None`
    /// without priors.
    fn with_inflated_variance(&self, variance: f64) -> Option<Self>
    where
        Self: Sized;
    /// Whether χ² is a likelihood.
    fn is_likelihood(&self) -> bool;
    /// Returns the variance inflation by correlation of neighbouring residuals; 1 for independent ones.
    fn correlation_factor(&self, place: &Place) -> f64;
    /// Returns the blocks of residuals of a bootstrap: rows of each block, and its position (or record).
    fn blocks(&self) -> Vec<(usize, usize)>;
    /// Calls `work` with χ² as a sum of squares. If given, `counts[block][row]` weights the rows.
    fn squares<T>(&self, counts: Option<&[Vec<f64>]>, work: impl FnOnce(&dyn LeastSquares) -> T) -> T
    where
        Self: Sized;

    /// Returns the information JᵀJ of all data about a point; `None` where the cost is no likelihood.
    fn information(&self, place: &Place) -> Option<DMatrix<f64>>
    where
        Self: Sized,
    {
        self.is_likelihood().then(|| self.squares(None, |squares| squares.normal(place).information))
    }
    /// Returns χ² per degree of freedom, at least 1, of a χ² of all data.
    fn misfit(&self, chi_square: f64) -> f64 {
        per_freedom(chi_square, self.observations(), self.free().len())
    }
    /// Returns the cost at given coordinates.
    fn cost(&self, place: &Place) -> f64
    where
        Self: Sized,
    {
        self.squares(None, |squares| squares.chi_square(place))
    }
    /// Runs least squares on all data from a nearby solution. Returns also the number of evaluations.
    fn polished_from(&self, near: &Place, control: &Control) -> (Basin, u64)
    where
        Self: Sized,
    {
        let found = self.squares(None, |squares| {
            least_squares(squares, &self.start_near(near), &[], POLISH, control.stop())
        });
        (Basin { place: Place(found.place), cost: found.normal.chi_square, starts: 1 }, found.evaluations)
    }
}

/// Returns χ² per degree of freedom, at least 1.
fn per_freedom(chi_square: f64, observations: usize, unknowns: usize) -> f64 {
    (chi_square / observations.saturating_sub(unknowns).max(1) as f64).max(1.0)
}

/// Returns the largest coordinate difference.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Smallest coordinate difference in the unit cube at which two points belong to different minima, where the
/// cost is no likelihood.
const MIN_DISTANCE: f64 = 0.02;

/// The surroundings of a minimum, which tell whether another point belongs to it.
pub struct Surroundings {
    /// The minimum.
    pub place: Place,
    /// Information there; `None` where the cost is no likelihood.
    pub information: Option<DMatrix<f64>>,
}

impl Surroundings {
    /// Whether the parabola about the minimum rises by at most `rise` to another point. Coordinates that the
    /// data do not determine thus do not separate minima. Where the cost is no likelihood, the point has to
    /// be near.
    pub fn hold(&self, other: &[f64], rise: f64) -> bool {
        let Some(information) = &self.information else { return distance(&self.place, other) < MIN_DISTANCE };
        let by = DVector::from_iterator(other.len(), self.place.iter().zip(other).map(|(a, b)| b - a));
        by.dot(&(information * &by)) <= rise
    }
}

impl Cost for ModeObjective<'_> {
    fn dimension(&self) -> usize {
        self.free.len()
    }

    fn at(&self, place: &[f64]) -> f64 {
        self.cost_at(place, f64::INFINITY)
    }

    fn at_most(&self, place: &[f64], limit: f64) -> f64 {
        self.cost_at(place, limit)
    }
}

impl Problem for ModeObjective<'_> {
    const STARTS: usize = 1;
    const STARTS_PER_FIND: usize = 4;

    fn free(&self) -> &[usize] {
        &self.free
    }
    fn gain_column(&self) -> Option<usize> {
        self.estimates_gain().then_some(self.free.len())
    }
    fn observations(&self) -> usize {
        self.observations()
    }
    fn values(&self, place: &Place) -> ParameterValues {
        self.parameters(place)
    }
    fn gain_at(&self, place: &Place) -> f64 {
        self.gain(place)
    }
    /// Runs a differential evolution, a coarse simplex from its best member, then least squares. A cost that
    /// is no sum of squares gets a second simplex instead.
    fn round(&self, seed: u64, control: &Control) -> Round {
        let found = search(self, SearchSettings::for_dimension(self.free.len(), seed), control);
        let (place, cost, spent) = simplex(self, (&found.place, found.cost), COARSE_SIMPLEX, control);
        let (end, last) = if self.is_likelihood() {
            let last = self.squares(None, |squares| {
                least_squares(squares, &self.extended(&place), &[], STEPS, control.stop())
            });
            let better = Cost::at(self, &last.place[..self.free.len()]);
            let end = if better <= cost {
                Basin { place: Place(last.place), cost: better, starts: 1 }
            } else {
                Basin { place: self.extended(&place), cost, starts: 1 }
            };
            (end, last.evaluations + 1)
        } else {
            let (place, cost, last) = simplex(self, (&place, cost), FINAL_SIMPLEX, control);
            (Basin { place: self.extended(&place), cost, starts: 1 }, last)
        };
        let evaluations = found.evaluations + spent + last;
        let complete = found.complete && !control.stopped();
        Round { ends: vec![end], evaluations, trace: found.trace, complete }
    }
    fn cost(&self, place: &Place) -> f64 {
        Cost::at(self, &place[..self.free.len()])
    }
    fn refined(&self, end: &Basin, _control: &Control) -> (Basin, u64) {
        (end.clone(), 0)
    }
    fn coarse_misfit(&self, cost: f64) -> f64 {
        Problem::misfit(self, cost)
    }
    fn coarse_information(&self, place: &Place) -> Option<DMatrix<f64>> {
        Problem::information(self, place)
    }
    fn with_inflated_variance(&self, _variance: f64) -> Option<Self> {
        None
    }
    fn start_near(&self, near: &Place) -> Place {
        self.extended(&near[..self.free.len().min(near.len())])
    }
    fn is_likelihood(&self) -> bool {
        self.is_likelihood()
    }
    fn correlation_factor(&self, _place: &Place) -> f64 {
        1.0
    }
    fn blocks(&self) -> Vec<(usize, usize)> {
        self.rows().into_iter().enumerate().map(|(at, rows)| (rows, at)).collect()
    }
    fn squares<T>(&self, counts: Option<&[Vec<f64>]>, work: impl FnOnce(&dyn LeastSquares) -> T) -> T {
        work(&ModeSquares::new(self, counts.map(|c| c.concat())))
    }
}

impl Problem for FrfObjective<'_> {
    const STARTS: usize = 64;
    const STARTS_PER_FIND: usize = 400;

    fn free(&self) -> &[usize] {
        &self.free[..self.own_count]
    }
    fn varied(&self) -> &[usize] {
        &self.free
    }
    fn gain_column(&self) -> Option<usize> {
        self.estimates_gain().then_some(self.free.len())
    }
    fn observations(&self) -> usize {
        self.observations()
    }
    fn values(&self, place: &Place) -> ParameterValues {
        self.parameters(place)
    }
    fn gain_at(&self, place: &Place) -> f64 {
        self.gain(place)
    }
    /// Runs least squares from a Latin hypercube of starts: first on coarse lines, where all lines have one
    /// weight and tolerances are held, so that valleys are wide and a step is cheap; then, from the best of
    /// them, on thinned lines with the weights of the data.
    fn round(&self, seed: u64, control: &Control) -> Round {
        let (coarse, thin) = (self.coarse(), self.thin());
        let starts =
            latin_hypercube(Self::STARTS, self.own_count, &mut Xoshiro256PlusPlus::seed_from_u64(seed));
        let step = control.steps("starts", starts.len());
        let mut near: Vec<Polished> = starts
            .par_iter()
            .map(|start| {
                let found = least_squares_within(coarse, &coarse.extended(start), &[], FIRST, control.stop());
                step();
                found
            })
            .collect();
        let observations = coarse.observations() as f64;
        let least = |best: &mut f64, found: &Polished| {
            *best = best.min(found.normal.chi_square / observations);
            Some(*best)
        };
        let trace = near.iter().scan(f64::INFINITY, least).collect();
        let first: u64 = near.iter().map(|n| n.evaluations).sum();
        near.sort_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square));
        // Starts that ended in one minimum are continued once. The variance of the data follows from χ².
        let mut minima: Vec<(Surroundings, f64, usize)> = Vec::new();
        for found in near {
            match minima.iter().position(|(minimum, rise, _)| minimum.hold(&found.place, *rise)) {
                Some(known) => minima[known].2 += 1,
                None if minima.len() < CONTINUED => {
                    let freedom = coarse.observations().saturating_sub(found.place.len()).max(1) as f64;
                    let rise = CHI_SQUARE_95 * (found.normal.chi_square / freedom);
                    minima.push((
                        Surroundings {
                            place: Place(found.place),
                            information: Some(found.normal.information),
                        },
                        rise,
                        1,
                    ));
                }
                None => {}
            }
        }
        let step = control.steps("minima", minima.len());
        let further: Vec<(Basin, u64)> = minima
            .par_iter()
            .map(|(minimum, _, starts)| {
                let found = least_squares_within(
                    thin,
                    &thin.extended(&minimum.place[..self.own_count]),
                    &[],
                    THIN,
                    control.stop(),
                );
                step();
                (
                    Basin { place: Place(found.place), cost: found.normal.chi_square, starts: *starts },
                    found.evaluations,
                )
            })
            .collect();
        let evaluations = first + further.iter().map(|f| f.1).sum::<u64>();
        let ends = further.into_iter().map(|f| f.0).collect();
        Round { ends, evaluations, trace, complete: !control.stopped() }
    }
    fn refined(&self, end: &Basin, control: &Control) -> (Basin, u64) {
        let found = least_squares(self, &end.place, &[], STEPS, control.stop());
        (
            Basin { place: Place(found.place), cost: found.normal.chi_square, starts: end.starts },
            found.evaluations,
        )
    }
    fn coarse_misfit(&self, cost: f64) -> f64 {
        per_freedom(cost, self.thin().observations(), self.own_count)
    }
    fn coarse_information(&self, place: &Place) -> Option<DMatrix<f64>> {
        Some(self.thin().normal(place).information)
    }
    fn with_inflated_variance(&self, variance: f64) -> Option<Self> {
        let lines: Vec<Vec<f64>> = self.lines().iter().map(|count| vec![1.0 / variance; *count]).collect();
        (self.has_priors() && variance > 1.0).then(|| self.resampled(&lines))
    }
    fn start_near(&self, near: &Place) -> Place {
        self.extended(&near[..self.free.len().min(near.len())])
    }
    fn is_likelihood(&self) -> bool {
        true
    }
    fn correlation_factor(&self, place: &Place) -> f64 {
        self.correlation_factor(place)
    }
    fn blocks(&self) -> Vec<(usize, usize)> {
        self.blocks()
    }
    fn squares<T>(&self, counts: Option<&[Vec<f64>]>, work: impl FnOnce(&dyn LeastSquares) -> T) -> T {
        match counts {
            None => work(self),
            Some(counts) => work(&self.resampled(counts)),
        }
    }
}
