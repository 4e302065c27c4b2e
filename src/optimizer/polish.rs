//! Local optimisation by the simplex of Nelder and Mead, restricted to the unit cube.

use super::Cost;
use long_work::Control;

/// Maximum number of simplex steps: a constant part and a part per coordinate.
const STEPS: u64 = 400;
const STEPS_PER_COORDINATE: u64 = 150;

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

/// Returns the place at a multiple of the way from one place to another.
fn along(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + (to - from) * share).collect()
}

/// A simplex: corners and their costs, in rising order.
struct Simplex<F: FnMut(&[f64]) -> f64> {
    corners: Vec<(Vec<f64>, f64)>,
    cost: F,
}

impl<F: FnMut(&[f64]) -> f64> Simplex<F> {
    fn new(corners: Vec<Vec<f64>>, mut cost: F) -> Self {
        let corners = corners.into_iter().map(|corner| (cost(&corner), corner)).map(|(cost, corner)| (corner, cost)).collect();
        let mut simplex = Simplex { corners, cost };
        simplex.sort();
        simplex
    }

    fn sort(&mut self) {
        self.corners.sort_by(|a, b| a.1.total_cmp(&b.1));
    }

    /// Returns the standard deviation of the costs.
    fn spread(&self) -> f64 {
        let count = self.corners.len() as f64;
        let mean = self.corners.iter().map(|corner| corner.1).sum::<f64>() / count;
        (1.0 / (count - 1.0) * self.corners.iter().map(|corner| (corner.1 - mean).powi(2)).sum::<f64>()).sqrt()
    }

    /// Reflects the worst corner at the others, expands or contracts the step, or shrinks the simplex.
    ///
    /// # Source  Nelder and Mead, Computer Journal 7 (1965) 308–313.
    fn step(&mut self) {
        let last = self.corners.len() - 1;
        let mut middle = self.corners[0].0.clone();
        for corner in &self.corners[1..last] {
            middle.iter_mut().zip(&corner.0).for_each(|(sum, x)| *sum += x);
        }
        middle.iter_mut().for_each(|sum| *sum *= 1.0 / last as f64);
        let (best, next_worst, (worst, worst_cost)) = (self.corners[0].1, self.corners[last - 1].1, self.corners[last].clone());
        let reflected: Vec<f64> = middle.iter().zip(&worst).map(|(middle, worst)| middle + (middle - worst)).collect();
        let reflected_cost = (self.cost)(&reflected);
        let better = if reflected_cost < best {
            let expanded = along(&middle, &reflected, 2.0);
            let cost = (self.cost)(&expanded);
            Some(if cost < reflected_cost { (expanded, cost) } else { (reflected, reflected_cost) })
        } else if reflected_cost < next_worst {
            Some((reflected, reflected_cost))
        } else {
            let is_outside = reflected_cost < worst_cost;
            let contracted = along(&middle, if is_outside { &reflected } else { &worst }, 0.5);
            let cost = (self.cost)(&contracted);
            let suffices = if is_outside { cost <= reflected_cost } else { cost < worst_cost };
            suffices.then_some((contracted, cost))
        };
        match better {
            Some(corner) => self.corners[last] = corner,
            None => {
                let best = self.corners[0].0.clone();
                for (corner, cost) in &mut self.corners[1..] {
                    *corner = along(&best, corner, 0.5);
                    *cost = (self.cost)(corner);
                }
            }
        }
        self.sort();
    }
}

/// Improves a place of known cost by a Nelder–Mead simplex of edge length `edge`, until the relative spread of its costs is below `spread`.
/// Returns place, cost and number of evaluations. It runs sequentially on one thread.
pub fn simplex<C: Cost>(cost: &C, start: (&[f64], f64), (edge, spread): (f64, f64), control: &Control) -> (Vec<f64>, f64, u64) {
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
    let (scale, mut evaluations) = (value.abs().max(1e-300), 0);
    // Places outside the unit cube are mirrored into it; the cost is scaled to O(1).
    let scaled = |place: &[f64]| {
        evaluations += 1;
        let value = cost.at(&mirrored(place)) / scale;
        if value.is_finite() { value } else { f64::MAX }
    };
    let mut simplex = Simplex::new(corners, scaled);
    let mut best = simplex.corners[0].clone();
    for _ in 0..STEPS + STEPS_PER_COORDINATE * place.len() as u64 {
        if simplex.spread() < spread {
            break;
        }
        simplex.step();
        if simplex.corners[0].1 < best.1 {
            best = simplex.corners[0].clone();
        }
    }
    let best = mirrored(&best.0);
    let best_cost = cost.at(&best);
    if best_cost <= value { (best, best_cost, evaluations + 1) } else { (place.to_vec(), value, evaluations + 1) }
}
