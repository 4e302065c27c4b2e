//! Mode objectives as sums of squares, with derivatives by central differences: peaks of |H| have no closed form.

use rayon::prelude::*;

use super::ModeObjective;
use crate::optimizer::{LeastSquares, Normal};

/// Step of the central differences in the unit interval.
const STEP: f64 = 2e-4;

/// A mode objective whose residuals count with weights, as in a bootstrap sample; without weights each counts once.
pub struct ModeSquares<'o, 'm> {
    objective: &'o ModeObjective<'m>,
    /// Weight of the square of each residual.
    weights: Option<Vec<f64>>,
}

impl<'o, 'm> ModeSquares<'o, 'm> {
    /// Of an objective; `weights` one for each residual of [`ModeObjective::residuals_at`].
    pub fn new(objective: &'o ModeObjective<'m>, weights: Option<Vec<f64>>) -> Self {
        ModeSquares { objective, weights }
    }

    fn weight(&self, row: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w.get(row).copied().unwrap_or(1.0))
    }
}

impl LeastSquares for ModeSquares<'_, '_> {
    fn dimension(&self) -> usize {
        self.objective.free.len() + usize::from(self.objective.estimates_gain())
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        self.objective.residuals_at(place).iter().enumerate().map(|(row, r)| self.weight(row) * r * r).sum()
    }

    fn normal(&self, place: &[f64]) -> Normal {
        let dimension = self.dimension();
        let here = self.objective.residuals_at(place);
        let columns: Vec<Vec<f64>> = (0..dimension)
            .into_par_iter()
            .map(|column| {
                let shifted = |by: f64| {
                    let mut other = place.to_vec();
                    other[column] = (other[column] + by).clamp(0.0, 1.0);
                    other
                };
                let (low, high) = (shifted(-STEP), shifted(STEP));
                let width = high[column] - low[column];
                let (from, to) = (self.objective.residuals_at(&low), self.objective.residuals_at(&high));
                to.iter().zip(&from).map(|(b, a)| (b - a) / width).collect()
            })
            .collect();
        let mut normal = Normal::zero(dimension);
        for (row, residual) in here.iter().enumerate() {
            let slopes: Vec<f64> = columns.iter().map(|c| c[row]).collect();
            normal.add(self.weight(row), *residual, &slopes);
        }
        normal.mirror();
        normal
    }
}
