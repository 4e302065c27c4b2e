//! Differential evolution.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use numeric::random::{latin_hypercube, normal};

/// Length of the success history (SHADE's H).
const HISTORY: usize = 6;
/// Differential evolution on the unit cube: current-to-pbest/1/bin with an archive and success-history adaptation of scale and crossover.
///
/// Trials of a generation are drawn sequentially and evaluated in bulk; selection follows after the whole generation. A search that is
/// serialised between generations and restored continues with identical results.
///
/// # Source  Tanabe and Fukunaga, IEEE CEC 2013, 71–78 (SHADE).
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
}

/// A place to evaluate, with the cost above which its exact value is irrelevant.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Place in the unit cube.
    pub place: Vec<f64>,
    /// Cost of the member that the trial replaces if it is not worse.
    pub limit: f64,
}

impl DifferentialEvolution {
    /// Creates a search with `size` members in `dimension` coordinates. It has converged when the costs of all members lie within `spread`
    /// of the best, relative to it.
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
        }
    }

    /// Returns the best cost after each generation.
    pub fn trace(&self) -> &[f64] {
        &self.trace
    }

    /// Returns the number of cost evaluations.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
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
        // Drawn and not used: searches keep the random numbers that follow.
        self.other_than(&[target, a]);
        let share = self.generator.random_range(2.0 / self.size as f64..=0.2_f64.max(2.0 / self.size as f64 + 1e-9));
        let count = ((share * self.size as f64).round() as usize).clamp(1, self.size);
        let leader = ranking[self.generator.random_range(0..count)];
        let second = self.generator.random_range(0..self.size + self.archive.len());
        let here = &self.members[target].0;
        let minus = if second < self.size { &self.members[second].0 } else { &self.archive[second - self.size] };
        let plus = &self.members[a].0;
        let mutant: Vec<f64> =
            (0..self.dimension).map(|d| here[d] + scale * (self.members[leader].0[d] - here[d]) + scale * (plus[d] - minus[d])).collect();
        let forced = self.generator.random_range(0..self.dimension);
        let here = &self.members[target].0;
        let mut place = Vec::with_capacity(self.dimension);
        for d in 0..self.dimension {
            let cross = self.generator.random::<f64>() < crossover || d == forced;
            let x = if cross { mutant[d] } else { here[d] };
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

    /// Returns the best member and its cost.
    pub fn leader(&self) -> &(Vec<f64>, f64) {
        &self.members[self.best()]
    }

    /// Whether the costs of all members lie within the spread of the best.
    pub fn has_converged(&self) -> bool {
        let best = self.leader().1;
        let worst = self.members.iter().map(|m| m.1).fold(f64::NEG_INFINITY, f64::max);
        worst - best <= self.spread * best.abs().max(f64::MIN_POSITIVE)
    }

    /// Draws and evaluates the first population, unless there is one.
    pub fn begin(&mut self, cost: &(impl Fn(&Trial) -> f64 + Sync)) {
        if self.members.is_empty() {
            let places = latin_hypercube(self.size, self.dimension, &mut self.generator);
            let first: Vec<Trial> = places.into_iter().map(|place| Trial { place, limit: f64::INFINITY }).collect();
            let costs = self.costs(&first, cost);
            self.members = first.into_iter().map(|trial| trial.place).zip(costs).collect();
        }
    }

    fn costs(&mut self, trials: &[Trial], cost: &(impl Fn(&Trial) -> f64 + Sync)) -> Vec<f64> {
        self.evaluations += trials.len() as u64;
        trials.par_iter().map(cost).collect()
    }

    /// Makes one generation.
    pub fn evolve(&mut self, cost: &(impl Fn(&Trial) -> f64 + Sync)) {
        let mut ranking: Vec<usize> = (0..self.size).collect();
        ranking.sort_by(|a, b| self.members[*a].1.total_cmp(&self.members[*b].1));
        let mut controls = Vec::with_capacity(self.size);
        let mut trials = Vec::with_capacity(self.size);
        for target in 0..self.size {
            let (scale, crossover) = self.controls();
            trials.push(Trial { place: self.trial(target, &ranking, scale, crossover), limit: self.members[target].1 });
            controls.push((scale, crossover));
        }
        let costs = self.costs(&trials, cost);
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
        self.trace.push(self.leader().1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rastrigin's function with its minimum 0 at 0.3 in every coordinate.
    fn rastrigin(trial: &Trial) -> f64 {
        let term = |x: &f64| {
            let y = 6.0 * (x - 0.3);
            y * y + 10.0 - 10.0 * (std::f64::consts::TAU * y).cos()
        };
        trial.place.iter().map(term).sum()
    }

    /// Continues a search by a number of generations.
    fn searched(mut search: DifferentialEvolution, generations: usize, cost: fn(&Trial) -> f64) -> DifferentialEvolution {
        search.begin(&cost);
        for _ in 0..generations {
            if !search.has_converged() {
                search.evolve(&cost);
            }
        }
        search
    }

    fn run(seed: u64) -> (Vec<f64>, f64) {
        searched(DifferentialEvolution::new(4, 40, 1e-12, seed), 600, rastrigin).leader().clone()
    }

    #[test]
    fn a_search_finds_the_lowest_of_many_minima() {
        let (place, cost) = run(1);
        assert!(cost < 1e-6, "{cost}");
        assert!(place.iter().all(|x| (x - 0.3).abs() < 1e-3), "{place:?}");
    }

    #[test]
    fn a_restored_search_continues_with_identical_results() {
        let whole = searched(DifferentialEvolution::new(4, 40, 1e-12, 5), 60, rastrigin);
        let half = searched(DifferentialEvolution::new(4, 40, 1e-12, 5), 23, rastrigin);
        let text = serde_json::to_string(&half).unwrap();
        let rest = searched(serde_json::from_str(&text).unwrap(), 37, rastrigin);
        assert_eq!(rest.members, whole.members);
        assert_eq!((rest.trace(), rest.evaluations()), (whole.trace(), whole.evaluations()));
    }

    #[test]
    fn costs_above_the_limit_need_not_be_exact() {
        let bounded = |trial: &Trial| {
            let cost = rastrigin(trial);
            if cost <= trial.limit { cost } else { trial.limit * 1.5 + 1.0 }
        };
        let search = || DifferentialEvolution::new(4, 40, 1e-12, 9);
        assert_eq!(searched(search(), 80, bounded).members, searched(search(), 80, rastrigin).members);
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
