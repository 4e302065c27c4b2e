//! Global search by differential evolution from a seed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use argmin::core::{CostFunction, Error, Executor};
use serde::{Deserialize, Serialize};

use super::differential_evolution::Trial;
use super::{Cost, DifferentialEvolution};
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

/// The cost as argmin requires it; values that are not finite are replaced by the largest number.
struct Finite<'c, C: Cost> {
    cost: &'c C,
    stop: &'c AtomicBool,
}

impl<C: Cost> CostFunction for Finite<'_, C> {
    type Param = Trial;
    type Output = f64;
    fn cost(&self, trial: &Trial) -> Result<f64, Error> {
        // After a stop request trials are not evaluated; the largest cost leaves the population unchanged.
        if self.stop.load(Ordering::Relaxed) {
            return Ok(f64::MAX);
        }
        let value = self.cost.at_most(&trial.place, trial.limit);
        Ok(if value.is_finite() { value } else { f64::MAX })
    }
}

/// Number of searches begun, which numbers concurrent searches.
static BEGUN: AtomicUsize = AtomicUsize::new(0);

/// Searches the unit cube for the minimum cost. A search that an earlier run has not finished continues from
/// its last population.
pub fn search<C: Cost>(cost: &C, settings: SearchSettings, control: &Control) -> SearchResult {
    let piece = format!("population {settings:?}");
    let mut states = control.states(&piece);
    let (reporter, most, number) =
        (control.clone(), settings.generations, BEGUN.fetch_add(1, Ordering::Relaxed));
    let solver = control
        .last_state(&piece)
        .unwrap_or_else(|| {
            DifferentialEvolution::new(cost.dimension(), settings.population, settings.spread, settings.seed)
        })
        .with_stop_flag(Arc::clone(control.stop()))
        .with_watcher(move |solver: &DifferentialEvolution| {
            let trace = solver.trace();
            let best = trace.last().copied().unwrap_or(f64::MAX);
            reporter.report(Progress::Generation { search: number, done: trace.len() as u64, most, best });
            // An interrupted generation is not kept.
            if !reporter.stopped() {
                states(solver);
            }
        });
    let remaining = settings.generations.saturating_sub(solver.trace().len() as u64);
    let run = Executor::new(Finite { cost, stop: control.stop() }, solver)
        .configure(|state| state.max_iters(remaining))
        .timer(false)
        .run();
    let middle = vec![0.5; cost.dimension()];
    let Ok(result) = run else {
        let value = cost.at(&middle);
        return SearchResult {
            place: middle,
            cost: value,
            evaluations: 1,
            trace: Vec::new(),
            complete: false,
        };
    };
    let evaluations = result.solver.evaluations();
    let trace = result.solver.trace().to_vec();
    let place = result.state.best_individual.unwrap_or(middle);
    let best = result.state.best_cost;
    control.report(Progress::Generation { search: number, done: most, most, best });
    SearchResult { place, cost: best, evaluations, trace, complete: !control.stopped() }
}
