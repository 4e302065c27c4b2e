//! Local polish by argmin's Nelder–Mead, kept inside the unit cube.

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::neldermead::NelderMead;

use super::Cost;

/// The cost scaled to O(1), with points outside the unit cube mirrored into it: argmin's Nelder–Mead knows no bounds and
/// takes its tolerance as absolute.
struct Scaled<'c, C: Cost> {
    cost: &'c C,
    scale: f64,
}

/// Mirrors a place at the faces of the unit cube.
fn mirrored(place: &[f64]) -> Vec<f64> {
    place
        .iter()
        .map(|x| {
            let folded = x.rem_euclid(2.0);
            if folded > 1.0 { 2.0 - folded } else { folded }
        })
        .collect()
}

impl<C: Cost> CostFunction for Scaled<'_, C> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, place: &Vec<f64>) -> Result<f64, Error> {
        let value = self.cost.at(&mirrored(place)) / self.scale;
        Ok(if value.is_finite() { value } else { f64::MAX })
    }
}

/// Improves a place by a simplex of this edge, until its costs differ by this share; gives place, cost and the number of evaluations.
pub(super) fn polish<C: Cost>(cost: &C, start: (&[f64], f64), (edge, spread): (f64, f64), iterations: u64) -> (Vec<f64>, f64, u64) {
    let (place, value) = start;
    let mut simplex = vec![place.to_vec()];
    for d in 0..place.len() {
        let mut corner = place.to_vec();
        corner[d] += if corner[d] > 0.5 { -edge } else { edge };
        simplex.push(corner);
    }
    let problem = Scaled { cost, scale: value.abs().max(1e-300) };
    let solver = NelderMead::new(simplex).with_sd_tolerance(spread);
    let run = solver.and_then(|solver| Executor::new(problem, solver).configure(|s| s.max_iters(iterations)).timer(false).run());
    match run {
        Ok(result) => {
            let evaluations = result.problem.counts.get("cost_count").copied().unwrap_or(0);
            match result.state.best_param {
                Some(best) => {
                    let best = mirrored(&best);
                    let best_cost = cost.at(&best);
                    if best_cost <= value { (best, best_cost, evaluations + 1) } else { (place.to_vec(), value, evaluations + 1) }
                }
                None => (place.to_vec(), value, evaluations),
            }
        }
        Err(_) => (place.to_vec(), value, 0),
    }
}
