//! Global search with a stopping rule: new spread starts until the best minimum has been found often enough.

use rayon::prelude::*;

use super::contained::ends_of_contained;
use super::place::Place;
use super::problem::{Basin, Problem, Round, Surroundings};
use super::profile::CHI_SQUARE_95;
use super::settings::{IdentificationSettings, Repeat};
use crate::objective::{FrfObjective, ModeObjective};
use long_work::Control;
use optimizer::SearchResult;

/// How far the search went, and how often it found the best minimum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchEffort {
    /// Number of spread starts.
    pub starts: usize,
    /// Number of starts that ended in the best minimum.
    pub found: usize,
    /// Number of times that the best minimum had to be found.
    pub required: usize,
}

impl SearchEffort {
    /// Whether the best minimum was found as often as required.
    ///
    /// Had a deeper minimum attracted as many of the starts as the best one, all of them would have missed it
    /// with a probability of at most e^−`required`.
    ///
    /// # Source  (1 − q)ⁿ ≤ e^−qn with the share q = found/n of the best minimum; stopping by the estimated
    ///   share of unseen basins: Boender and
    /// Rinnooy Kan, Math. Program. 37 (1987) 59–80.
    pub fn is_enough(&self) -> bool {
        self.found >= self.required
    }
}

/// Result of a search: its rounds, best first, and its minima in rising order.
pub(super) struct Searched {
    pub rounds: Vec<Repeat>,
    pub minima: Vec<Basin>,
    pub effort: SearchEffort,
}

/// Largest number of minima that are refined on all data.
const MINIMA: usize = 12;
/// Largest χ² above the least one on thinned lines, relative to χ² per degree of freedom, at which a minimum
/// is refined on all data. Thinned lines carry less information than all lines: a minimum this far above the
/// least one cannot be the least on all lines.
const MARGIN: f64 = 40.0;
/// χ² per degree of freedom above which no fit is that of the machine, as with the modes of another one (1):
/// deviations of 14 standard deviations.
const HOPELESS: f64 = 200.0;
/// Number of times that the best of such minima has to be found. It guards the time of fits that doubts leave
/// without an identifiable value; with 1 a single start would do.
const FOUND_HOPELESS: usize = 2;

/// A minimum, and the cost there.
struct Centre {
    around: Surroundings,
    cost: f64,
}

impl Centre {
    fn holds(&self, other: &[f64], misfit: f64) -> bool {
        self.around.hold(other, CHI_SQUARE_95 * misfit)
    }
}

/// A minimum of the coarse data of the rounds and, once refined, the index of its minimum of all data.
struct Candidate {
    coarse: Centre,
    refined: Option<usize>,
    starts: usize,
}

/// Returns the number of starts that ended in a refined minimum.
fn starts_of(candidates: &[Candidate], refined: usize) -> usize {
    candidates.iter().filter(|c| c.refined == Some(refined)).map(|c| c.starts).sum()
}

/// Searches the unit cube by rounds of new spread starts until the best minimum was found `plan.repeats`
/// times, or the budget is spent; near a known solution by least squares alone. It ends with starts from the
/// machines that this one contains: a minimum that only these find counts as seldom found.
pub(super) fn searched<P: Problem>(
    problem: &P,
    (plan, contained): (&IdentificationSettings, &[Vec<Place>]),
    control: &Control,
) -> Searched {
    if let Some(near) = &plan.near {
        return polished_from_nearby(problem, near, plan, control);
    }
    let required = plan.repeats.max(1);
    let budget = (required * P::STARTS_PER_FIND).div_ceil(P::STARTS);
    let seed = |round: usize| plan.seed.wrapping_add(1_000_003 * round as u64);
    let mut rounds: Vec<(u64, Round)> = Vec::new();
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut refined: Vec<(Centre, u64)> = Vec::new();
    let mut effort = SearchEffort { starts: 0, found: 0, required };
    while rounds.len() < budget && !effort.is_enough() {
        let batch = (required - effort.found).div_ceil(P::STARTS).min(budget - rounds.len());
        let from = rounds.len();
        let new: Vec<(u64, Round)> = (from..from + batch)
            .into_par_iter()
            .map(|round| {
                (
                    seed(round),
                    control.cached(&format!("round {}", seed(round)), || problem.round(seed(round), control)),
                )
            })
            .collect();
        effort.starts += batch * P::STARTS;
        let limit = gather(problem, &mut candidates, new.iter().flat_map(|(_, round)| &round.ends));
        rounds.extend(new);
        if control.stopped() && !refined.is_empty() {
            break;
        }
        refine(problem, &mut candidates, &mut refined, limit, control);
        let best = best_of(&refined);
        effort.found = best.map_or(0, |best| starts_of(&candidates, best));
        // Where the model is not that of the data, the best of its misfits need not be found more often.
        let is_hopeless = best.is_some_and(|best| problem.misfit(refined[best].0.cost) > HOPELESS);
        if control.stopped() || (is_hopeless && effort.found >= FOUND_HOPELESS) {
            break;
        }
    }
    if !control.stopped() && !contained.is_empty() {
        for (end, evaluations) in
            control.cached("contained", || ends_of_contained(problem, contained, control))
        {
            let around = Surroundings { information: problem.information(&end.place), place: end.place };
            merge(problem, &mut refined, (Centre { around, cost: end.cost }, evaluations));
        }
        let best = best_of(&refined);
        effort.found = best.map_or(0, |best| starts_of(&candidates, best));
    }
    let basin = |(at, (centre, _)): (usize, &(Centre, u64))| {
        let (place, cost) = (centre.around.place.clone(), centre.cost);
        Basin { place, cost, starts: starts_of(&candidates, at) }
    };
    let mut minima: Vec<Basin> = refined.iter().enumerate().map(basin).collect();
    minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let spent: u64 = refined.iter().map(|(_, evaluations)| evaluations).sum();
    Searched { rounds: repeats(rounds, &candidates, &refined, spent, control), minima, effort }
}

/// Returns the index of the least of the refined minima.
fn best_of(refined: &[(Centre, u64)]) -> Option<usize> {
    (0..refined.len()).min_by(|a, b| refined[*a].0.cost.total_cmp(&refined[*b].0.cost))
}

/// Adds the ends of a round to the minima of the coarse data and returns the largest cost at which one of
/// these may be the least on all data.
fn gather<'e, P: Problem>(
    problem: &P,
    candidates: &mut Vec<Candidate>,
    ends: impl Iterator<Item = &'e Basin>,
) -> f64 {
    let mut ends: Vec<&Basin> = ends.collect();
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let least = candidates
        .iter()
        .map(|c| c.coarse.cost)
        .chain(ends.first().map(|end| end.cost))
        .fold(f64::INFINITY, f64::min);
    let misfit = problem.coarse_misfit(least);
    let limit = least + MARGIN * misfit;
    for end in ends.into_iter().filter(|end| end.cost <= limit) {
        match candidates.iter_mut().find(|c| c.coarse.holds(&end.place, misfit)) {
            Some(known) => known.starts += end.starts,
            None => {
                let around = Surroundings {
                    place: end.place.clone(),
                    information: problem.coarse_information(&end.place),
                };
                candidates.push(Candidate {
                    coarse: Centre { around, cost: end.cost },
                    refined: None,
                    starts: end.starts,
                });
            }
        }
    }
    limit
}

/// Searches once from spread starts for minima of χ² of FRFs on thinned lines, as
/// [`identify`](crate::identify) does. Returns those that may be the least on all lines, in rising order of
/// χ²; none without a free parameter.
pub fn frf_search_minima(objective: &FrfObjective<'_>, seed: u64, control: &Control) -> Vec<Place> {
    if objective.own_count == 0 {
        return Vec::new();
    }
    let round = control.cached(&format!("round {seed}"), || objective.round(seed, control));
    let mut candidates = Vec::new();
    gather(objective, &mut candidates, round.ends.iter());
    candidates.truncate(MINIMA);
    candidates.into_iter().map(|c| c.coarse.around.place).collect()
}

/// Searches once for the least cost of modes from spread starts, as [`identify`](crate::identify) does.
/// Returns coordinates and cost.
pub fn mode_search_end(objective: &ModeObjective<'_>, seed: u64, control: &Control) -> Option<(Place, f64)> {
    let round = objective.round(seed, control);
    round.ends.into_iter().map(|end| (end.place, end.cost)).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Refines the best candidates on all data. Those that end in one minimum share it.
fn refine<P: Problem>(
    problem: &P,
    candidates: &mut [Candidate],
    refined: &mut Vec<(Centre, u64)>,
    limit: f64,
    control: &Control,
) {
    let mut order: Vec<usize> =
        (0..candidates.len()).filter(|at| candidates[*at].coarse.cost <= limit).collect();
    order.sort_by(|a, b| candidates[*a].coarse.cost.total_cmp(&candidates[*b].coarse.cost));
    let open: Vec<usize> =
        order.into_iter().take(MINIMA).filter(|at| candidates[*at].refined.is_none()).collect();
    let step = control.steps("minima", open.len());
    let ends: Vec<(Centre, u64)> = open
        .par_iter()
        .map(|at| {
            let coarse = &candidates[*at].coarse;
            let end = Basin { place: coarse.around.place.clone(), cost: coarse.cost, starts: 0 };
            let (end, evaluations) =
                control.cached(&format!("minimum {end:?}"), || problem.refined(&end, control));
            let around = Surroundings { information: problem.information(&end.place), place: end.place };
            step();
            (Centre { around, cost: end.cost }, evaluations)
        })
        .collect();
    for (at, end) in open.into_iter().zip(ends) {
        candidates[at].refined = Some(merge(problem, refined, end));
    }
}

/// Adds an end on all data to the refined minima, unless it is one of these, and returns its index.
fn merge<P: Problem>(
    problem: &P,
    refined: &mut Vec<(Centre, u64)>,
    (centre, evaluations): (Centre, u64),
) -> usize {
    let misfit =
        problem.misfit(centre.cost.min(refined.iter().map(|r| r.0.cost).fold(f64::INFINITY, f64::min)));
    let is_known = |(other, _): &(Centre, u64)| {
        other.holds(&centre.around.place, misfit) || centre.holds(&other.around.place, misfit)
    };
    match refined.iter().position(is_known) {
        Some(known) => {
            refined[known].1 += evaluations;
            if centre.cost < refined[known].0.cost {
                refined[known].0 = centre;
            }
            known
        }
        None => {
            refined.push((centre, evaluations));
            refined.len() - 1
        }
    }
}

/// Returns the rounds with their best ends on all data, best first. The evaluations of the refinement are
/// those of the best round.
fn repeats(
    rounds: Vec<(u64, Round)>,
    candidates: &[Candidate],
    refined: &[(Centre, u64)],
    spent: u64,
    control: &Control,
) -> Vec<Repeat> {
    let on_all_data = |end: &Basin| {
        let known = candidates.iter().find(|c| c.coarse.holds(&end.place, 1.0)).and_then(|c| c.refined);
        known.map_or_else(
            || (end.place.0.clone(), end.cost),
            |at| (refined[at].0.around.place.0.clone(), refined[at].0.cost),
        )
    };
    let mut all: Vec<Repeat> = rounds
        .into_iter()
        .map(|(seed, round)| {
            let best = round.ends.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).map(on_all_data);
            let (place, cost) = best.unwrap_or((Vec::new(), f64::MAX));
            let Round { evaluations, trace, complete, .. } = round;
            Repeat {
                seed,
                found: SearchResult {
                    place,
                    cost,
                    evaluations,
                    trace,
                    complete: complete && !control.stopped(),
                },
            }
        })
        .collect();
    all.sort_by(|a, b| a.found.cost.total_cmp(&b.found.cost));
    if let Some(best) = all.first_mut() {
        best.found.evaluations += spent;
    }
    all
}

/// Runs least squares from a nearby solution, in place of a search.
fn polished_from_nearby<P: Problem>(
    problem: &P,
    near: &Place,
    plan: &IdentificationSettings,
    control: &Control,
) -> Searched {
    let (end, evaluations) = control.cached("polish", || problem.polished_from(near, control));
    let (place, cost, trace, complete) = (end.place.0.clone(), end.cost, Vec::new(), !control.stopped());
    let found = SearchResult { place, cost, evaluations, trace, complete };
    Searched {
        rounds: vec![Repeat { seed: plan.seed, found }],
        minima: vec![end],
        effort: SearchEffort { starts: 1, found: 1, required: 1 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine::ParameterValues;
    use nalgebra::DMatrix;
    use optimizer::LeastSquares;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Centre of a minimum, its costs on thinned lines and on all, and its share of rounds: every how many
    /// rounds end in it.
    type Well = ([f64; 2], f64, f64, u64);

    /// Minima of known costs. Rounds end near them; the data do not determine the second coordinate.
    struct Wells(Vec<Well>, AtomicUsize);

    impl Wells {
        fn of(wells: &[Well]) -> Self {
            Wells(wells.to_vec(), AtomicUsize::new(0))
        }

        fn around(&self, place: &Place) -> &Well {
            self.0
                .iter()
                .min_by(|a, b| (a.0[0] - place[0]).abs().total_cmp(&(b.0[0] - place[0]).abs()))
                .unwrap()
        }
    }

    impl Problem for Wells {
        const STARTS: usize = 1;
        const STARTS_PER_FIND: usize = 6;

        fn round(&self, seed: u64, _: &Control) -> Round {
            let round = seed / 1_000_003;
            let ([x, y], coarse, _, _) = self.0.iter().find(|well| round.is_multiple_of(well.3)).unwrap();
            let place = Place(vec![x + 1e-3 * (round as f64).sin(), y + 0.3 * (round as f64).cos()]);
            Round {
                ends: vec![Basin { place, cost: *coarse, starts: 1 }],
                evaluations: 10,
                trace: Vec::new(),
                complete: true,
            }
        }
        fn refined(&self, end: &Basin, _: &Control) -> (Basin, u64) {
            self.1.fetch_add(1, Ordering::Relaxed);
            let well = self.around(&end.place);
            (Basin { place: Place(vec![well.0[0], end.place[1]]), cost: well.2, starts: end.starts }, 1)
        }
        fn coarse_misfit(&self, _: f64) -> f64 {
            1.0
        }
        fn coarse_information(&self, _: &Place) -> Option<DMatrix<f64>> {
            Some(DMatrix::from_diagonal(&vec![1e4, 0.0].into()))
        }
        fn information(&self, place: &Place) -> Option<DMatrix<f64>> {
            self.coarse_information(place)
        }
        fn observations(&self) -> usize {
            1000
        }
        fn free(&self) -> &[usize] {
            &[0, 1]
        }
        fn gain_column(&self) -> Option<usize> {
            None
        }
        fn values(&self, _: &Place) -> ParameterValues {
            unreachable!("a search needs no values")
        }
        fn gain_at(&self, _: &Place) -> f64 {
            1.0
        }
        fn start_near(&self, near: &Place) -> Place {
            near.clone()
        }
        fn cost(&self, place: &Place) -> f64 {
            self.around(place).2
        }
        fn polished_from(&self, near: &Place, control: &Control) -> (Basin, u64) {
            self.refined(&Basin { place: near.clone(), cost: 0.0, starts: 1 }, control)
        }
        fn with_inflated_variance(&self, _: f64) -> Option<Self> {
            None
        }
        fn is_likelihood(&self) -> bool {
            true
        }
        fn correlation_factor(&self, _: &Place) -> f64 {
            1.0
        }
        fn blocks(&self) -> Vec<(usize, usize)> {
            Vec::new()
        }
        fn squares<T>(&self, _: Option<&[Vec<f64>]>, _: impl FnOnce(&dyn LeastSquares) -> T) -> T {
            unreachable!("the costs are given")
        }
    }

    fn search(wells: &Wells, repeats: usize) -> Searched {
        search_beside(wells, repeats, &[])
    }

    fn search_beside(wells: &Wells, repeats: usize, contained: &[Vec<Place>]) -> Searched {
        let plan = IdentificationSettings { seed: 0, repeats, ..IdentificationSettings::default() };
        searched(wells, (&plan, contained), &Control::default())
    }

    /// Thinned lines favour one minimum, all lines the other, in which every third round ends. Ends that
    /// differ where the data say nothing are one.
    #[test]
    fn a_search_ends_when_the_best_minimum_of_all_lines_was_found_often_enough() {
        let wells = Wells::of(&[([0.2, 0.5], 11.0, 30.0, 3), ([0.7, 0.5], 10.0, 31.0, 1)]);
        let found = search(&wells, 4);
        let minima: Vec<(f64, f64)> = found.minima.iter().map(|m| (m.place[0], m.cost)).collect();
        assert_eq!(minima, [(0.2, 30.0), (0.7, 31.0)]);
        assert_eq!((found.effort.found, found.effort.is_enough()), (4, true));
        assert_eq!(found.minima.iter().map(|m| m.starts).sum::<usize>(), found.effort.starts);
        assert!((10..=12).contains(&found.effort.starts), "{:?}", found.effort);
        assert_eq!(wells.1.load(Ordering::Relaxed), 2, "each minimum is refined once");
        assert_eq!((found.rounds.len(), found.rounds[0].found.cost), (found.effort.starts, 30.0));
    }

    #[test]
    fn a_search_without_enough_finds_ends_with_its_budget_and_says_so() {
        let found = search(&Wells::of(&[([0.2, 0.5], 11.0, 30.0, 40), ([0.7, 0.5], 10.0, 31.0, 1)]), 3);
        assert_eq!((found.effort.starts, found.effort.found, found.effort.is_enough()), (18, 1, false));
    }

    /// A minimum that spread starts do not find, and the fit of a smaller machine leads to: it is the result, and
    /// counts as found by none of the starts.
    #[test]
    fn a_search_ends_above_no_machine_that_this_one_contains() {
        // All rounds end in the first.
        let wells = Wells::of(&[([0.7, 0.5], 10.0, 31.0, 1), ([0.2, 0.5], 11.0, 20.0, 1)]);
        let ends = |contained: &[f64]| {
            let starts: Vec<Vec<Place>> = contained.iter().map(|x| vec![Place(vec![*x, 0.5])]).collect();
            let found = search_beside(&wells, 2, &starts);
            (found.minima[0].cost, found.minima.len(), found.effort.found)
        };
        assert_eq!((ends(&[]), ends(&[0.72]), ends(&[0.25])), ((31.0, 1, 2), (31.0, 1, 2), (20.0, 2, 0)));
    }

    /// A minimum that is far above the least one on thinned lines cannot be the least one on all.
    #[test]
    fn a_minimum_far_above_the_least_one_is_not_refined() {
        let wells = Wells::of(&[([0.2, 0.5], 10.0 + 1.1 * MARGIN, 5.0, 3), ([0.7, 0.5], 10.0, 31.0, 1)]);
        let found = search(&wells, 4);
        assert_eq!(found.minima.iter().map(|m| m.cost).collect::<Vec<f64>>(), [31.0]);
        assert_eq!(wells.1.load(Ordering::Relaxed), 1);
    }
}
