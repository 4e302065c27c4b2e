//! Defines what an identification needs of its data: a coarse cost to search, a sum of squares to refine, blocks to resample.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::place::Place;
use crate::objective::{COARSE_LINES, FrfObjective, ModeObjective, ModeSquares};
use machine::ParameterValues;
use optimizer::{Control, Cost, LeastSquares, Polished, SearchResult, SearchSettings, least_squares, least_squares_within, simplex};

/// Largest number of members of the last population from which least squares starts.
const STARTS: usize = 30;
/// Smallest distance between two starts or two ends: largest coordinate difference in the unit cube.
const MIN_DISTANCE: f64 = 0.03;
/// Largest number of ends on thinned lines that least squares continues on all lines.
const CONTINUED_ENDS: usize = 4;
/// Largest χ² above the least one on thinned lines at which an end is continued. Thinned lines carry less information than all lines:
/// an end this far above the least one cannot be the least on all lines.
const CHI_SQUARE_MARGIN: f64 = 40.0;
/// Coarse simplex: edge length in the unit cube, and relative spread of the costs at which it stops.
const COARSE_SIMPLEX: (f64, f64) = (0.02, 1e-6);
/// Final simplex: edge length in the unit cube, and relative spread of the costs at which it stops.
const FINAL_SIMPLEX: (f64, f64) = (0.002, 1e-12);
/// Least-squares steps on thinned lines from every start.
const FIRST_STEPS: u64 = 10;
/// Number of results of the first steps, those with the least χ², that are continued on thinned lines.
const CONTINUED_STARTS: usize = 10;
/// Largest number of further steps on thinned lines.
const THIN_STEPS: u64 = 80;
/// Largest number of steps on all data.
const STEPS: u64 = 200;

/// The end of a search and its cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchEnd {
    pub place: Place,
    pub cost: f64,
}

/// The misfit between data and a machine as a function of unit-cube coordinates: free parameters, tolerances and, if unknown, the gain.
pub trait Problem: Cost {
    /// Returns the indices of the free parameters that are not tolerances: the first coordinates.
    fn free(&self) -> &[usize];
    /// Returns the coordinate of the gain, if it is unknown.
    fn gain_column(&self) -> Option<usize>;
    /// Returns the number of real numbers compared.
    fn observations(&self) -> usize;
    /// Returns the machine's parameters at the given coordinates.
    fn values(&self, place: &Place) -> ParameterValues;
    /// Returns the gain at the given coordinates.
    fn gain_at(&self, place: &Place) -> f64;
    /// Adapts the usual settings of the global search.
    fn settings(&self, usual: SearchSettings) -> SearchSettings;
    /// Refines the result of a search. Returns the deepest minima, the best first, and the number of evaluations.
    fn polish(&self, found: &SearchResult, control: &Control) -> (Vec<SearchEnd>, u64);
    /// Returns a start from coordinates of other data of the same set.
    /// Free parameters and tolerances of the description are kept; the data's own coordinates restart.
    fn start_near(&self, near: &Place) -> Place;
    /// Returns the problem with the variance of the data multiplied by a factor and priors unchanged; `None` without priors.
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
}

/// Runs least squares from several starts and sorts the results by rising χ².
fn least_squares_from(squares: &FrfObjective<'_>, from: &[Place], end: (u64, f64), control: &Control) -> Vec<Polished> {
    let mut ends: Vec<Polished> = from.par_iter().map(|place| least_squares_within(squares, place, &[], end, control.stop())).collect();
    ends.sort_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square));
    ends
}

/// Returns the largest coordinate difference.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
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
    fn settings(&self, usual: SearchSettings) -> SearchSettings {
        usual
    }
    /// Runs a coarse simplex from the best member, then least squares. A cost that is no sum of squares gets a second simplex instead.
    fn polish(&self, found: &SearchResult, control: &Control) -> (Vec<SearchEnd>, u64) {
        let (place, cost, spent) = simplex(self, (&found.place, found.cost), COARSE_SIMPLEX, control);
        if self.is_likelihood() {
            let last = self.squares(None, |squares| least_squares(squares, &self.extended(&place), &[], STEPS, control.stop()));
            let better = Cost::at(self, &last.place[..self.free.len()]);
            let end = if better <= cost {
                SearchEnd { place: Place(last.place), cost: better }
            } else {
                SearchEnd { place: self.extended(&place), cost }
            };
            return (vec![end], spent + last.evaluations + 1);
        }
        let (place, cost, last) = simplex(self, (&place, cost), FINAL_SIMPLEX, control);
        (vec![SearchEnd { place: self.extended(&place), cost }], spent + last)
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

impl Cost for FrfObjective<'_> {
    fn dimension(&self) -> usize {
        self.own_count
    }

    fn at(&self, place: &[f64]) -> f64 {
        self.coarse(place)
    }
}

impl Problem for FrfObjective<'_> {
    fn free(&self) -> &[usize] {
        &self.free[..self.own_count]
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
    /// Uses a large population for few generations: the search has to find the basins, least squares finds their minima.
    /// A longer run of fewer members converges to one basin, which need not be the deepest.
    fn settings(&self, usual: SearchSettings) -> SearchSettings {
        SearchSettings { spread: 0.05, generations: 30, population: 2 * usual.population, ..usual }
    }
    /// Runs least squares on thinned lines from several members, then on all lines from the deepest distinct ends.
    fn polish(&self, found: &SearchResult, control: &Control) -> (Vec<SearchEnd>, u64) {
        let thin = self.thinned(COARSE_LINES);
        let mut starts: Vec<&Vec<f64>> = Vec::new();
        for member in &found.population {
            if starts.len() < STARTS && starts.iter().all(|other| distance(member, other) > MIN_DISTANCE) {
                starts.push(member);
            }
        }
        let extended_starts: Vec<Place> = starts.iter().map(|start| thin.extended(start)).collect();
        let near = least_squares_from(&thin, &extended_starts, (FIRST_STEPS, 1e-3), control);
        let continued: Vec<Place> = near.iter().take(CONTINUED_STARTS).map(|p| Place(p.place.clone())).collect();
        let polished = least_squares_from(&thin, &continued, (THIN_STEPS, 1e-6), control);
        let mut spent: u64 = near.iter().chain(&polished).map(|p| p.evaluations).sum();
        let least = polished.first().map_or(0.0, |p| p.normal.chi_square);
        let own = |place: &[f64]| place[..self.own_count].to_vec();
        let mut deepest: Vec<&Polished> = Vec::new();
        for end in polished.iter().filter(|p| p.normal.chi_square < least + CHI_SQUARE_MARGIN) {
            if deepest.len() < CONTINUED_ENDS && deepest.iter().all(|other| distance(&own(&end.place), &own(&other.place)) > MIN_DISTANCE) {
                deepest.push(end);
            }
        }
        let all: Vec<Polished> = deepest.par_iter().map(|end| least_squares(self, &end.place, &[], STEPS, control.stop())).collect();
        spent += all.iter().map(|p| p.evaluations).sum::<u64>();
        let mut ends: Vec<SearchEnd> = all.into_iter().map(|p| SearchEnd { place: Place(p.place), cost: p.normal.chi_square }).collect();
        ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        (ends, spent)
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
