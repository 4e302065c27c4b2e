//! A whole search: differential evolution from a seed, then the polish.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{CostFunction, Error, Executor, KV, PopulationState, State};

use super::polish::polish;
use super::{Cost, DifferentialEvolution, Strategy};

/// Settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// How trials are made.
    pub strategy: Strategy,
    /// Members of the population.
    pub population: usize,
    /// Most generations.
    pub generations: u64,
    /// Relative spread of the costs at which the population has converged.
    pub spread: f64,
    /// Whether the best member is polished by Nelder and Mead's simplex.
    pub simplex: bool,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl SearchSettings {
    /// Settings that suit `dimension` unknowns.
    pub fn for_dimension(dimension: usize, seed: u64) -> Self {
        SearchSettings {
            strategy: Strategy::CurrentToPbest,
            population: (6 * dimension).max(24),
            generations: 400,
            spread: 1e-3,
            simplex: true,
            seed,
        }
    }
}

/// Told of the progress, asked whether to stop.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    watcher: Option<Arc<dyn Fn(u64, f64) + Send + Sync>>,
    listener: Option<Arc<dyn Fn(&str) + Send + Sync>>,
}

impl Control {
    /// Stops when `stop` is set; `watcher` is told the generation and the best cost.
    pub fn new(stop: Arc<AtomicBool>, watcher: Option<Arc<dyn Fn(u64, f64) + Send + Sync>>) -> Self {
        Control { stop, watcher, listener: None }
    }

    /// The same with a listener that is told which stage of a longer work begins.
    #[must_use]
    pub fn with_listener(self, listener: Arc<dyn Fn(&str) + Send + Sync>) -> Self {
        Control { listener: Some(listener), ..self }
    }

    /// A stage begins.
    pub fn begin(&self, stage: &str) {
        if let Some(listener) = &self.listener {
            listener(stage);
        }
    }

    /// The flag that stops it.
    pub fn stop(&self) -> &Arc<AtomicBool> {
        &self.stop
    }

    /// Whether it was asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Place in the unit cube.
    pub place: Vec<f64>,
    /// Cost there.
    pub cost: f64,
    /// Evaluations spent.
    pub evaluations: u64,
    /// Generations run.
    pub generations: u64,
    /// Best cost after each generation.
    pub trace: Vec<f64>,
    /// Places of the last population, best first.
    pub population: Vec<Vec<f64>>,
    /// Ran to its end, not stopped from outside.
    pub complete: bool,
}

/// The cost as argmin asks for it; what is not finite is as bad as can be.
struct Finite<'c, C: Cost> {
    cost: &'c C,
    stop: &'c AtomicBool,
}

impl<C: Cost> CostFunction for Finite<'_, C> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, place: &Vec<f64>) -> Result<f64, Error> {
        // Asked to stop: what is not evaluated is as bad as can be, and changes nothing.
        if self.stop.load(Ordering::Relaxed) {
            return Ok(f64::MAX);
        }
        let value = self.cost.at(place);
        Ok(if value.is_finite() { value } else { f64::MAX })
    }
}

struct Watch {
    control: Control,
    trace: Arc<std::sync::Mutex<Vec<f64>>>,
}

impl Observe<PopulationState<Vec<f64>, f64>> for Watch {
    fn observe_iter(&mut self, state: &PopulationState<Vec<f64>, f64>, _kv: &KV) -> Result<(), Error> {
        let best = state.get_best_cost();
        if let Ok(mut trace) = self.trace.lock() {
            trace.push(best);
        }
        if let Some(watcher) = &self.control.watcher {
            watcher(state.get_iter(), best);
        }
        Ok(())
    }
}

/// Searches the unit cube for the least cost.
pub fn search<C: Cost>(cost: &C, settings: SearchSettings, control: &Control) -> Found {
    let trace = Arc::new(std::sync::Mutex::new(Vec::new()));
    let solver = DifferentialEvolution::new(settings.strategy, cost.dimension(), settings.population, settings.spread, settings.seed)
        .stopping_when(Arc::clone(&control.stop));
    let watch = Watch { control: control.clone(), trace: Arc::clone(&trace) };
    let run = Executor::new(Finite { cost, stop: &control.stop }, solver)
        .configure(|state| state.max_iters(settings.generations).counting(true))
        .add_observer(watch, ObserverMode::Always)
        .timer(false)
        .run();
    let trace = trace.lock().map(|t| t.clone()).unwrap_or_default();
    let middle = vec![0.5; cost.dimension()];
    let Ok(result) = run else {
        let value = cost.at(&middle);
        return Found { place: middle, cost: value, evaluations: 1, generations: 0, trace, population: Vec::new(), complete: false };
    };
    let mut evaluations = result.problem.counts.get("cost_count").copied().unwrap_or(0);
    let generations = result.state.get_iter();
    let population = result.solver.population().into_iter().map(|m| m.0).collect();
    let mut place = result.state.best_individual.unwrap_or(middle);
    let mut best = result.state.best_cost;
    for edge in [0.02, 0.002] {
        if control.stopped() || !settings.simplex {
            break;
        }
        let (polished, value, spent) = polish(cost, (&place, best), edge, 400 + 150 * cost.dimension() as u64);
        (place, best) = (polished, value);
        evaluations += spent;
    }
    Found { place, cost: best, evaluations, generations, trace, population, complete: !control.stopped() }
}
