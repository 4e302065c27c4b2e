//! Starts of a search from the fits of machines that the machine contains.

use rayon::prelude::*;
use std::collections::BTreeMap;

use super::place::Place;
use super::problem::{Basin, Problem};
use long_work::Control;
use machine::Machine;
use numeric::halton::halton_point;

/// Number of trial places of the parameters that a smaller machine lacks, and of those that are followed. They guard
/// against ending above that machine; its own search guards against a wrong minimum of the rest. 24 places leave gaps
/// of a fifth of the range between two parameters; with half as many the effect may start beyond the reach of a
/// descent, and then ends above. Chosen, not calibrated.
const TRIALS: (usize, usize) = (24, 3);

/// Returns trial starts from each fit of a smaller machine, whose values are given by the names of parameters and
/// tolerances. What it lacks starts at the middle of its prior or range and all over its range.
pub(super) fn contained_starts(
    machine: &Machine,
    free: &[usize],
    fits: &[BTreeMap<String, f64>],
) -> Vec<Vec<Place>> {
    let trials = |known: &BTreeMap<String, f64>| {
        let parameter = |at: &usize| &machine.parameters[*at];
        let lacking = free.iter().filter(|at| !known.contains_key(parameter(at).name())).count();
        let start = |spread: Option<Vec<f64>>| {
            let mut spread = spread.map(Vec::into_iter);
            let unit = |at: &usize| {
                let own = known.get(parameter(at).name()).map(|value| parameter(at).to_unit(*value));
                let tried = || spread.as_mut().and_then(Iterator::next);
                own.or_else(tried)
                    .unwrap_or(parameter(at).to_unit(parameter(at).search_start()))
                    .clamp(0.0, 1.0)
            };
            Place(free.iter().map(unit).collect())
        };
        let all_over =
            (1..=TRIALS.0).filter(|_| lacking > 0).map(|index| start(Some(halton_point(index, lacking))));
        std::iter::once(start(None)).chain(all_over).collect()
    };
    fits.iter().map(trials).collect()
}

/// Follows the best of the trial starts from each smaller machine, and returns the best end of each.
pub(super) fn ends_of_contained<P: Problem>(
    problem: &P,
    starts: &[Vec<Place>],
    control: &Control,
) -> Vec<(Basin, u64)> {
    let end = |trials: &Vec<Place>| {
        let mut tried: Vec<(f64, &Place)> =
            trials.par_iter().map(|place| (problem.cost(&problem.start_near(place)), place)).collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        tried.truncate(TRIALS.1);
        let ends: Vec<(Basin, u64)> =
            tried.par_iter().map(|(_, place)| problem.polished_from(place, control)).collect();
        let spent = ends.iter().map(|(_, evaluations)| evaluations).sum();
        let best = ends.into_iter().map(|(end, _)| end).min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        Some((best, spent))
    };
    starts.iter().filter_map(end).collect()
}
