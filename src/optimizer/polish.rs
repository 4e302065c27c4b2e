//! Local optimisation by argmin's Nelder–Mead, restricted to the unit cube.

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::neldermead::NelderMead;

use super::Cost;
use long_work::Control;

/// Maximum number of simplex steps: a constant part and a part per coordinate.
const STEPS: u64 = 400;
const STEPS_PER_COORDINATE: u64 = 150;

/// The cost scaled to O(1), with points outside the unit cube mirrored into it. argmin's Nelder–Mead has no
/// bounds and uses an absolute tolerance.
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

/// Improves a place of known cost by a Nelder–Mead simplex of edge length `edge`, until the relative spread
/// of its costs is below `spread`. Returns place, cost and number of evaluations. It runs sequentially on one
/// thread.
pub fn simplex<C: Cost>(
    cost: &C,
    start: (&[f64], f64),
    (edge, spread): (f64, f64),
    control: &Control,
) -> (Vec<f64>, f64, u64) {
    let (place, value) = start;
    if control.stopped() {
        return (place.to_vec(), value, 0);
    }
    let mut corners = vec![place.to_vec()];
    for d in 0..place.len() {
        let mut corner = place.to_vec();
        corner[d] += if corner[d] > 0.5 { -edge } else { edge };
        corners.push(corner);
    }
    let problem = Scaled { cost, scale: value.abs().max(1e-300) };
    let most = STEPS + STEPS_PER_COORDINATE * place.len() as u64;
    let solver = NelderMead::new(corners).with_sd_tolerance(spread);
    let run = solver.and_then(|solver| {
        Executor::new(problem, solver).configure(|s| s.max_iters(most)).timer(false).run()
    });
    match run {
        Ok(result) => {
            let evaluations = result.problem.counts.get("cost_count").copied().unwrap_or(0);
            match result.state.best_param {
                Some(best) => {
                    let best = mirrored(&best);
                    let best_cost = cost.at(&best);
                    if best_cost <= value {
                        (best, best_cost, evaluations + 1)
                    } else {
                        (place.to_vec(), value, evaluations + 1)
                    }
                }
                None => (place.to_vec(), value, evaluations),
            }
        }
        Err(_) => (place.to_vec(), value, 0),
    }
}
