//! Global search by differential evolution from a seed.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use super::Cost;
use super::differential_evolution::{DifferentialEvolution, Trial};
use long_work::{Control, Progress};

/// Settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// Size of the population.
    pub population: usize,
    /// Maximum number of generations.
    pub generations: u64,
    /// Relative spread of the costs at which the population has converged.
    pub spread: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl SearchSettings {
    /// Returns settings suited to `dimension` unknowns.
    pub fn for_dimension(dimension: usize, seed: u64) -> Self {
        SearchSettings { population: (6 * dimension).max(24), generations: 400, spread: 1e-3, seed }
    }
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchResult {
    /// Place in the unit cube.
    pub place: Vec<f64>,
    /// Cost there.
    pub cost: f64,
    /// Number of cost evaluations.
    pub evaluations: u64,
    /// Best cost after each generation, or after each start of a search by many starts.
    pub trace: Vec<f64>,
    /// Whether it ran to its end without an external stop.
    pub complete: bool,
}

/// Number of searches begun, which numbers concurrent searches.
static BEGUN: AtomicUsize = AtomicUsize::new(0);

/// Searches the unit cube for the minimum cost. A search that an earlier run has not finished continues from its last population.
pub fn search<C: Cost>(cost: &C, settings: SearchSettings, control: &Control) -> SearchResult {
    let piece = format!("population {settings:?}");
    let mut keep = control.states(&piece);
    let (most, number) = (settings.generations, BEGUN.fetch_add(1, Ordering::Relaxed));
    let evaluate = |trial: &Trial| {
        // After a stop request trials are not evaluated; the largest cost leaves the population unchanged.
        let value = if control.stopped() { f64::MAX } else { cost.at_most(&trial.place, trial.limit) };
        if value.is_finite() { value } else { f64::MAX }
    };
    let begun = || DifferentialEvolution::new(cost.dimension(), settings.population, settings.spread, settings.seed);
    let mut evolution = control.last_state(&piece).unwrap_or_else(begun);
    evolution.begin(&evaluate);
    let (mut place, mut best) = evolution.leader().clone();
    while (evolution.trace().len() as u64) < most && !control.stopped() && !evolution.has_converged() {
        evolution.evolve(&evaluate);
        let (next, least) = evolution.leader();
        // Of equal members the first found counts.
        if *least < best {
            (place, best) = (next.clone(), *least);
        }
        control.report(Progress::Generation { search: number, done: evolution.trace().len() as u64, most, best: *least });
        // An interrupted generation is not kept.
        if !control.stopped() {
            keep(&evolution);
        }
    }
    control.report(Progress::Generation { search: number, done: most, most, best });
    let (evaluations, trace) = (evolution.evaluations(), evolution.trace().to_vec());
    SearchResult { place, cost: best, evaluations, trace, complete: !control.stopped() }
}
