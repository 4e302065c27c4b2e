//! Differential evolution as an argmin solver.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use argmin::argmin_error;
use argmin::core::{
    CostFunction, Error, KV, PopulationState, Problem, Solver, SyncAlias, TerminationReason,
    TerminationStatus,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use numeric::random::{latin_hypercube, normal};

/// Length of the success history (SHADE's H).
const HISTORY: usize = 6;

/// Differential evolution on the unit cube: current-to-pbest/1/bin with an archive and success-history
/// adaptation of scale and crossover.
///
/// Trials of a generation are drawn sequentially and evaluated in bulk; selection follows after the whole
/// generation. A search that is serialised between generations and restored continues with identical results.
///
/// # Source  Tanabe and Fukunaga, IEEE CEC 2013, 71–78 (SHADE)
#[derive(Serialize, Deserialize)]
pub struct DifferentialEvolution {
    dimension: usize,
    size: usize,
    spread: f64,
    generator: Xoshiro256PlusPlus,
    members: Vec<(Vec<f64>, f64)>,
    archive: Vec<Vec<f64>>,
    history: Vec<(f64, f64)>,
    next_in_history: usize,
    trace: Vec<f64>,
    evaluations: u64,
    #[serde(skip)]
    stop: Arc<AtomicBool>,
    #[serde(skip)]
    watcher: Option<Observer>,
}

/// Callback that receives the search after every generation.
type Observer = Box<dyn FnMut(&DifferentialEvolution) + Send>;

/// A place to evaluate, with the cost above which its exact value is irrelevant.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Place in the unit cube.
    pub place: Vec<f64>,
    /// Cost of the member that the trial replaces if it is not worse.
    pub limit: f64,
}

impl DifferentialEvolution {
    /// Creates a search with `size` members in `dimension` coordinates. It has converged when the costs of
    /// all members lie within `spread` of the best, relative to it.
    pub fn new(dimension: usize, size: usize, spread: f64, seed: u64) -> Self {
        DifferentialEvolution {
            dimension,
            size: size.max(6),
            spread,
            generator: Xoshiro256PlusPlus::seed_from_u64(seed),
            members: Vec::new(),
            archive: Vec::new(),
            history: vec![(0.5, 0.5); HISTORY],
            next_in_history: 0,
            trace: Vec::new(),
            evaluations: 0,
            stop: Arc::default(),
            watcher: None,
        }
    }

    /// Returns the members, best first.
    pub fn population(&self) -> Vec<(Vec<f64>, f64)> {
        let mut members = self.members.clone();
        members.sort_by(|a, b| a.1.total_cmp(&b.1));
        members
    }

    /// Returns the best cost after each generation.
    pub fn trace(&self) -> &[f64] {
        &self.trace
    }

    /// Returns the number of cost evaluations.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Sets the callback that receives the search after every generation.
    pub fn with_watcher(mut self, watcher: impl FnMut(&DifferentialEvolution) + Send + 'static) -> Self {
        self.watcher = Some(Box::new(watcher));
        self
    }

    /// Sets the flag that ends the search after the current generation.
    pub fn with_stop_flag(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stop = stop;
        self
    }

    /// Draws scale and crossover of one trial.
    fn controls(&mut self) -> (f64, f64) {
        let (scale_mean, crossover_mean) = self.history[self.generator.random_range(0..HISTORY)];
        let crossover = (crossover_mean + 0.1 * normal(&mut self.generator)).clamp(0.0, 1.0);
        let mut scale = 0.0;
        while scale <= 0.0 {
            // Cauchy distribution.
            scale = scale_mean + 0.1 * (std::f64::consts::PI * (self.generator.random::<f64>() - 0.5)).tan();
        }
        (scale.min(1.0), crossover)
    }

    /// Draws a member other than those given.
    fn other_than(&mut self, taken: &[usize]) -> usize {
        loop {
            let index = self.generator.random_range(0..self.size);
            if !taken.contains(&index) {
                return index;
            }
        }
    }

    /// Forms a trial for the member `target`; `ranking` lists the members from best to worst.
    fn trial(&mut self, target: usize, ranking: &[usize], scale: f64, crossover: f64) -> Vec<f64> {
        let a = self.other_than(&[target]);
        // A draw without use: the sequence of random numbers is that of earlier results.
        self.other_than(&[target, a]);
        let least = 2.0 / self.size as f64;
        let share = self.generator.random_range(least..=0.2_f64.max(least + 1e-9));
        let count = ((share * self.size as f64).round() as usize).clamp(1, self.size);
        let leader = ranking[self.generator.random_range(0..count)];
        let second = self.generator.random_range(0..self.size + self.archive.len());
        let forced = self.generator.random_range(0..self.dimension);
        let (here, leader, plus) = (&self.members[target].0, &self.members[leader].0, &self.members[a].0);
        let minus = match second.checked_sub(self.size) {
            None => &self.members[second].0,
            Some(archived) => &self.archive[archived],
        };
        let mut place = Vec::with_capacity(self.dimension);
        for d in 0..self.dimension {
            let cross = self.generator.random::<f64>() < crossover || d == forced;
            let mutant = here[d] + scale * (leader[d] - here[d]) + scale * (plus[d] - minus[d]);
            let x = if cross { mutant } else { here[d] };
            // A violated bound is replaced by the midpoint between the member and the bound.
            place.push(if x < 0.0 {
                0.5 * here[d]
            } else if x > 1.0 {
                0.5 * (1.0 + here[d])
            } else {
                x
            });
        }
        place
    }

    /// Updates the success history by weighted means of the successful controls, after SHADE.
    fn learn(&mut self, successes: &[(f64, f64, f64)]) {
        let total: f64 = successes.iter().map(|s| s.2).sum();
        if !(total > 0.0) {
            return;
        }
        let crossover = successes.iter().map(|s| s.1 * s.2).sum::<f64>() / total;
        let squares: f64 = successes.iter().map(|s| s.0 * s.0 * s.2).sum();
        let firsts: f64 = successes.iter().map(|s| s.0 * s.2).sum();
        self.history[self.next_in_history] = (squares / firsts, crossover);
        self.next_in_history = (self.next_in_history + 1) % HISTORY;
    }

    fn best(&self) -> usize {
        (0..self.members.len()).min_by(|a, b| self.members[*a].1.total_cmp(&self.members[*b].1)).unwrap_or(0)
    }

    fn publish(&self, state: PopulationState<Vec<f64>, f64>) -> PopulationState<Vec<f64>, f64> {
        let (place, cost) = self.members[self.best()].clone();
        state.individual(place).cost(cost)
    }
}

impl<O> Solver<O, PopulationState<Vec<f64>, f64>> for DifferentialEvolution
where
    O: CostFunction<Param = Trial, Output = f64> + SyncAlias,
{
    fn name(&self) -> &str {
        "differential evolution"
    }

    fn init(
        &mut self,
        problem: &mut Problem<O>,
        state: PopulationState<Vec<f64>, f64>,
    ) -> Result<(PopulationState<Vec<f64>, f64>, Option<KV>), Error> {
        if self.dimension == 0 {
            return Err(argmin_error!(InvalidParameter, "there is no free coordinate to search"));
        }
        if self.members.is_empty() {
            let first: Vec<Trial> = latin_hypercube(self.size, self.dimension, &mut self.generator)
                .into_iter()
                .map(|place| Trial { place, limit: f64::INFINITY })
                .collect();
            let costs = problem.bulk_cost(&first)?;
            self.evaluations += costs.len() as u64;
            self.members = first.into_iter().map(|trial| trial.place).zip(costs).collect();
        }
        Ok((self.publish(state), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        state: PopulationState<Vec<f64>, f64>,
    ) -> Result<(PopulationState<Vec<f64>, f64>, Option<KV>), Error> {
        let mut ranking: Vec<usize> = (0..self.size).collect();
        ranking.sort_by(|a, b| self.members[*a].1.total_cmp(&self.members[*b].1));
        let mut controls = Vec::with_capacity(self.size);
        let mut trials = Vec::with_capacity(self.size);
        for target in 0..self.size {
            let (scale, crossover) = self.controls();
            trials.push(Trial {
                place: self.trial(target, &ranking, scale, crossover),
                limit: self.members[target].1,
            });
            controls.push((scale, crossover));
        }
        let costs = problem.bulk_cost(&trials)?;
        self.evaluations += costs.len() as u64;
        let mut successes = Vec::new();
        for (target, (trial, cost)) in trials.into_iter().zip(costs).enumerate() {
            let old = self.members[target].1;
            if cost <= old {
                let replaced = std::mem::replace(&mut self.members[target], (trial.place, cost));
                if cost < old {
                    successes.push((controls[target].0, controls[target].1, old - cost));
                    if self.archive.len() < self.size {
                        self.archive.push(replaced.0);
                    } else {
                        let slot = self.generator.random_range(0..self.archive.len());
                        self.archive[slot] = replaced.0;
                    }
                }
            }
        }
        self.learn(&successes);
        self.trace.push(self.members[self.best()].1);
        if let Some(mut watcher) = self.watcher.take() {
            watcher(self);
            self.watcher = Some(watcher);
        }
        Ok((self.publish(state), None))
    }

    fn terminate(&mut self, state: &PopulationState<Vec<f64>, f64>) -> TerminationStatus {
        if self.stop.load(Ordering::Relaxed) {
            return TerminationStatus::Terminated(TerminationReason::Interrupt);
        }
        let best = state.get_best_cost();
        let worst = self.members.iter().map(|m| m.1).fold(f64::NEG_INFINITY, f64::max);
        if worst - best <= self.spread * best.abs().max(f64::MIN_POSITIVE) {
            return TerminationStatus::Terminated(TerminationReason::SolverConverged);
        }
        TerminationStatus::NotTerminated
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argmin::core::Executor;

    struct Rastrigin;

    impl CostFunction for Rastrigin {
        type Param = Trial;
        type Output = f64;
        /// Rastrigin's function with its minimum 0 at 0.3 in every coordinate.
        fn cost(&self, trial: &Trial) -> Result<f64, Error> {
            Ok(trial
                .place
                .iter()
                .map(|x| {
                    let y = 6.0 * (x - 0.3);
                    y * y + 10.0 - 10.0 * (std::f64::consts::TAU * y).cos()
                })
                .sum())
        }
    }

    fn run(seed: u64) -> (Vec<f64>, f64) {
        let solver = DifferentialEvolution::new(4, 40, 1e-12, seed);
        let result = Executor::new(Rastrigin, solver).configure(|s| s.max_iters(600)).run().unwrap();
        (result.state.best_individual.clone().unwrap(), result.state.best_cost)
    }

    #[test]
    fn the_lowest_of_many_minima_is_found() {
        let (place, cost) = run(1);
        assert!(cost < 1e-6, "{cost}");
        assert!(place.iter().all(|x| (x - 0.3).abs() < 1e-3), "{place:?}");
    }

    #[test]
    fn a_restored_search_continues_with_identical_results() {
        let run = |solver: DifferentialEvolution, generations| {
            Executor::new(Rastrigin, solver).configure(|s| s.max_iters(generations)).run().unwrap()
        };
        let whole = run(DifferentialEvolution::new(4, 40, 1e-12, 5), 60).solver;
        let half = run(DifferentialEvolution::new(4, 40, 1e-12, 5), 23).solver;
        let text = serde_json::to_string(&half).unwrap();
        let rest = run(serde_json::from_str(&text).unwrap(), 37).solver;
        assert_eq!(rest.population(), whole.population());
        assert_eq!((rest.trace(), rest.evaluations()), (whole.trace(), whole.evaluations()));
    }

    /// Rastrigin's function that returns no exact cost above the limit.
    struct Bounded;

    impl CostFunction for Bounded {
        type Param = Trial;
        type Output = f64;
        fn cost(&self, trial: &Trial) -> Result<f64, Error> {
            let cost = Rastrigin.cost(trial)?;
            Ok(if cost <= trial.limit { cost } else { trial.limit * 1.5 + 1.0 })
        }
    }

    #[test]
    fn costs_above_the_limit_need_not_be_exact() {
        let run = |solver: DifferentialEvolution| {
            Executor::new(Bounded, solver).configure(|s| s.max_iters(80)).run().unwrap().solver
        };
        let bounded = run(DifferentialEvolution::new(4, 40, 1e-12, 9));
        let solver = DifferentialEvolution::new(4, 40, 1e-12, 9);
        let whole = Executor::new(Rastrigin, solver).configure(|s| s.max_iters(80)).run().unwrap().solver;
        assert_eq!(bounded.population(), whole.population());
    }

    #[test]
    fn the_same_seed_gives_the_same_bits_on_one_and_on_two_threads() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(7))
        };
        assert_eq!(on(1), on(2));
    }
}
