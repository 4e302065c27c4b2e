//! What identification asks of data: a coarse cost to search, a sum of squares to polish, samples to tell certainty.

use rayon::prelude::*;

use crate::objective::{COARSE_LINES, FrfObjective, ModeObjective, ModeSquares};
use optimizer::{Control, Cost, Found, LeastSquares, Polished, SearchSettings, least_squares, simplex};

/// Members of the last population that least squares starts from, and how far apart in some coordinate they are.
const STARTS: usize = 30;
const APART: f64 = 0.03;
/// Edge of a simplex and the relative spread of costs at which it ends: of one that only has to come near, and of the last.
const NEAR: (f64, f64) = (0.02, 1e-6);
const LAST: (f64, f64) = (0.002, 1e-12);
/// Most steps of least squares on some lines, and on all.
const THIN_STEPS: u64 = 80;
const STEPS: u64 = 200;

/// Data and a machine, as a function of the free parameters and, where it is unknown, the gain as a last coordinate.
pub trait Problem: Cost {
    /// Indices of the free parameters.
    fn free(&self) -> &[usize];
    /// Real numbers compared.
    fn observations(&self) -> usize;
    /// Parameters of the machine at a place.
    fn values(&self, place: &[f64]) -> Vec<f64>;
    /// The gain at a place.
    fn gain_at(&self, place: &[f64]) -> f64;
    /// How the global search is run, from its usual settings.
    fn settings(&self, usual: SearchSettings) -> SearchSettings;
    /// Ends a search: the place with the gain added, its cost and the evaluations spent.
    fn polish(&self, found: &Found, control: &Control) -> (Vec<f64>, f64, u64);
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
    fn polish(&self, found: &Found, control: &Control) -> (Vec<f64>, f64, u64) {
        let (place, cost, spent) = simplex(self, (&found.place, found.cost), NEAR, control);
        if self.is_likelihood() {
            let last = self.squares(None, |squares| least_squares(squares, &self.extended(&place), &[], STEPS, control.stop()));
            let better = Cost::at(self, &last.place[..self.free.len()]);
            let spent = spent + last.evaluations + 1;
            return if better <= cost { (last.place, better, spent) } else { (self.extended(&place), cost, spent) };
        }
        let (place, cost, last) = simplex(self, (&place, cost), LAST, control);
        (self.extended(&place), cost, spent + last)
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
        self.free.len()
    }

    fn at(&self, place: &[f64]) -> f64 {
        self.coarse(place)
    }
}

impl Problem for FrfObjective<'_> {
    fn free(&self) -> &[usize] {
        &self.free
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
    /// Least squares on some lines from several members, then on all lines from the best.
    fn polish(&self, found: &Found, control: &Control) -> (Vec<f64>, f64, u64) {
        let thin = self.thinned(COARSE_LINES);
        let mut starts: Vec<&Vec<f64>> = Vec::new();
        for member in &found.population {
            let apart = |other: &&Vec<f64>| member.iter().zip(*other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > APART;
            if starts.len() < STARTS && starts.iter().all(apart) {
                starts.push(member);
            }
        }
        let mut polished: Vec<Polished> =
            starts.par_iter().map(|start| least_squares(&thin, &thin.extended(start), &[], THIN_STEPS, control.stop())).collect();
        polished.sort_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square));
        let mut spent: u64 = polished.iter().map(|p| p.evaluations).sum();
        let start = polished.first().map_or_else(|| self.extended(&found.place), |p| p.place.clone());
        let last = least_squares(self, &start, &[], STEPS, control.stop());
        spent += last.evaluations;
        (last.place, last.normal.chi_square, spent)
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
