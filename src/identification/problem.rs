//! What identification asks of data: a coarse cost to search, a sum of squares to polish, samples to tell certainty.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::objective::{COARSE_LINES, FrfObjective, ModeObjective, ModeSquares};
use optimizer::{Control, Cost, Found, LeastSquares, Polished, SearchSettings, least_squares, least_squares_within, simplex};

/// Members of the last population that least squares starts from, and how far apart in some coordinate they are.
const STARTS: usize = 30;
const APART: f64 = 0.03;
/// Ends on some lines that are followed on all lines: at most so many, whose χ² is within this of the least. Of some lines χ² has less information than of
/// all; an end this far above the least one there cannot be the least of all.
const ENDS: usize = 4;
const NEARLY: f64 = 40.0;
/// Edge of a simplex and the relative spread of costs at which it ends: of one that only has to come near, and of the last.
const NEAR: (f64, f64) = (0.02, 1e-6);
const LAST: (f64, f64) = (0.002, 1e-12);
/// First steps of least squares on some lines, after which so many of the deepest go on; most steps then, and on all lines.
const FIRST_STEPS: u64 = 10;
const GOING_ON: usize = 10;
const THIN_STEPS: u64 = 80;
const STEPS: u64 = 200;

/// Where a search ended: the place with what is fitted along added, and its cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoundSide {
    pub place: Vec<f64>,
    pub cost: f64,
}

/// Data and a machine, as a function of the free parameters, then tolerances and, where it is unknown, the gain.
pub trait Problem: Cost {
    /// Indices of the free parameters that are no tolerances: the first coordinates of a place.
    fn free(&self) -> &[usize];
    /// Coordinate of the gain, where it is unknown.
    fn gain_column(&self) -> Option<usize>;
    /// Real numbers compared.
    fn observations(&self) -> usize;
    /// Parameters of the machine at a place.
    fn values(&self, place: &[f64]) -> Vec<f64>;
    /// The gain at a place.
    fn gain_at(&self, place: &[f64]) -> f64;
    /// How the global search is run, from its usual settings.
    fn settings(&self, usual: SearchSettings) -> SearchSettings;
    /// Ends a search: the deepest places found, the best first, and the evaluations spent.
    fn polish(&self, found: &Found, control: &Control) -> (Vec<BoundSide>, u64);
    /// A place of other data of the same set as a start here: free parameters and tolerances of the description as they are, what belongs to the data anew.
    fn restarted(&self, near: &[f64]) -> Vec<f64>;
    /// The same with the variance of the data so many times as large, what is known beforehand as it is; `None` where nothing is fitted along.
    fn weakened(&self, variance: f64) -> Option<Self>
    where
        Self: Sized;
    /// Whether χ² is a likelihood.
    fn is_likelihood(&self) -> bool;
    /// By how much neighbouring residuals that belong together enlarge the variance; 1 for independent ones.
    fn colour(&self, place: &[f64]) -> f64;
    /// Blocks of residuals of a bootstrap: rows of each, and the position (or record) it belongs to.
    fn blocks(&self) -> Vec<(usize, usize)>;
    /// Calls `work` with χ² as a sum of squares, rows counted `counts[block][row]` times where given.
    fn squares<T>(&self, counts: Option<&[Vec<f64>]>, work: impl FnOnce(&dyn LeastSquares) -> T) -> T
    where
        Self: Sized;
}

/// Where least squares leads from some places, the deepest first.
fn followed(squares: &FrfObjective<'_>, from: &[Vec<f64>], end: (u64, f64), control: &Control) -> Vec<Polished> {
    let mut ends: Vec<Polished> = from.par_iter().map(|place| least_squares_within(squares, place, &[], end, control.stop())).collect();
    ends.sort_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square));
    ends
}

/// Largest distance in any coordinate.
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
    fn values(&self, place: &[f64]) -> Vec<f64> {
        self.parameters(place)
    }
    fn gain_at(&self, place: &[f64]) -> f64 {
        self.gain(place)
    }
    fn settings(&self, usual: SearchSettings) -> SearchSettings {
        usual
    }
    /// A simplex from the best member comes near; what ends it is least squares, or where the cost is no sum of squares another simplex.
    fn polish(&self, found: &Found, control: &Control) -> (Vec<BoundSide>, u64) {
        let (place, cost, spent) = simplex(self, (&found.place, found.cost), NEAR, control);
        if self.is_likelihood() {
            let last = self.squares(None, |squares| least_squares(squares, &self.extended(&place), &[], STEPS, control.stop()));
            let better = Cost::at(self, &last.place[..self.free.len()]);
            let end = if better <= cost {
                BoundSide { place: last.place, cost: better }
            } else {
                BoundSide { place: self.extended(&place), cost }
            };
            return (vec![end], spent + last.evaluations + 1);
        }
        let (place, cost, last) = simplex(self, (&place, cost), LAST, control);
        (vec![BoundSide { place: self.extended(&place), cost }], spent + last)
    }
    fn weakened(&self, _variance: f64) -> Option<Self> {
        None
    }
    fn restarted(&self, near: &[f64]) -> Vec<f64> {
        self.extended(&near[..self.free.len().min(near.len())])
    }
    fn is_likelihood(&self) -> bool {
        self.is_likelihood()
    }
    fn colour(&self, _place: &[f64]) -> f64 {
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
        self.own
    }

    fn at(&self, place: &[f64]) -> f64 {
        self.coarse(place)
    }
}

impl Problem for FrfObjective<'_> {
    fn free(&self) -> &[usize] {
        &self.free[..self.own]
    }
    fn gain_column(&self) -> Option<usize> {
        self.estimates_gain().then_some(self.free.len())
    }
    fn observations(&self) -> usize {
        self.observations()
    }
    fn values(&self, place: &[f64]) -> Vec<f64> {
        self.parameters(place)
    }
    fn gain_at(&self, place: &[f64]) -> f64 {
        self.gain(place)
    }
    /// A large population for a few generations: the basins are enough, least squares finds their floors. (A longer run of fewer members
    /// gathers in one basin, which need not be the deepest.)
    fn settings(&self, usual: SearchSettings) -> SearchSettings {
        SearchSettings { spread: 0.05, generations: 30, population: 2 * usual.population, ..usual }
    }
    /// Least squares on some lines from several members, then on all lines from the deepest ends that are apart.
    fn polish(&self, found: &Found, control: &Control) -> (Vec<BoundSide>, u64) {
        let thin = self.thinned(COARSE_LINES);
        let mut starts: Vec<&Vec<f64>> = Vec::new();
        for member in &found.population {
            if starts.len() < STARTS && starts.iter().all(|other| distance(member, other) > APART) {
                starts.push(member);
            }
        }
        let begun: Vec<Vec<f64>> = starts.iter().map(|start| thin.extended(start)).collect();
        let near = followed(&thin, &begun, (FIRST_STEPS, 1e-3), control);
        let going_on: Vec<Vec<f64>> = near.iter().take(GOING_ON).map(|p| p.place.clone()).collect();
        let polished = followed(&thin, &going_on, (THIN_STEPS, 1e-6), control);
        let mut spent: u64 = near.iter().chain(&polished).map(|p| p.evaluations).sum();
        let least = polished.first().map_or(0.0, |p| p.normal.chi_square);
        let own = |place: &[f64]| place[..self.own].to_vec();
        let mut deepest: Vec<&Polished> = Vec::new();
        for end in polished.iter().filter(|p| p.normal.chi_square < least + NEARLY) {
            if deepest.len() < ENDS && deepest.iter().all(|other| distance(&own(&end.place), &own(&other.place)) > APART) {
                deepest.push(end);
            }
        }
        let all: Vec<Polished> = deepest.par_iter().map(|end| least_squares(self, &end.place, &[], STEPS, control.stop())).collect();
        spent += all.iter().map(|p| p.evaluations).sum::<u64>();
        let mut ends: Vec<BoundSide> = all.into_iter().map(|p| BoundSide { place: p.place, cost: p.normal.chi_square }).collect();
        ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        (ends, spent)
    }
    fn weakened(&self, variance: f64) -> Option<Self> {
        let lines: Vec<Vec<f64>> = self.lines().iter().map(|count| vec![1.0 / variance; *count]).collect();
        (self.has_priors() && variance > 1.0).then(|| self.resampled(&lines))
    }
    fn restarted(&self, near: &[f64]) -> Vec<f64> {
        self.extended(&near[..self.free.len().min(near.len())])
    }
    fn is_likelihood(&self) -> bool {
        true
    }
    fn colour(&self, place: &[f64]) -> f64 {
        self.colour(place)
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
