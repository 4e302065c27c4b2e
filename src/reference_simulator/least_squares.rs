//! Damped Gauss–Newton steps to a least sum of squares with quadratic penalties.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::Result;
use super::parallel::in_order;

/// Whitened residuals at a point.
pub type Residuals<'r> = dyn Fn(&[f64]) -> Result<Vec<f64>> + Sync + 'r;

/// Step of numerical derivatives: a thousandth of a standard deviation.
const STEP: f64 = 1e-3;
/// Largest step of one coordinate, in standard deviations.
const LONGEST: f64 = 3.0;
/// Largest number of steps, and of trials of one step.
const MOST: (usize, usize) = (25, 8);
/// A step that gains less ends the search: absolute, and relative to the cost.
const GAIN: (f64, f64) = (0.05, 1e-3);

/// A minimum.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Sum of squares and penalties.
    pub cost: f64,
    /// Point.
    pub point: Vec<f64>,
}

/// Minimises |r(u)|² + Σ penalty·u² from a start.
///
/// # Errors  the residuals have no value at the start.
pub fn minimum(residuals: &Residuals<'_>, penalties: &[f64], start: Vec<f64>) -> Result<Minimum> {
    let cost_of = |residual: &DVector<f64>, point: &[f64]| {
        residual.norm_squared()
            + point.iter().zip(penalties).map(|(value, penalty)| penalty * value * value).sum::<f64>()
    };
    let mut point = start;
    let mut residual = DVector::from_vec(residuals(&point)?);
    let mut cost = cost_of(&residual, &point);
    let mut damping = 1e-3;
    for _ in 0..MOST.0 {
        // Beside the best point so far may lie one without a response.
        let Ok(slopes) = slopes_at(residuals, &point, &residual) else { break };
        let mut normal = slopes.tr_mul(&slopes);
        let mut downhill = -slopes.tr_mul(&residual);
        for (index, penalty) in penalties.iter().enumerate() {
            normal[(index, index)] += penalty;
            downhill[index] -= penalty * point[index];
        }
        let before = cost;
        for _ in 0..MOST.1 {
            let mut damped = normal.clone();
            for index in 0..point.len() {
                damped[(index, index)] += damping * (1.0 + normal[(index, index)]);
            }
            damping *= 8.0;
            let Some(mut change) = Cholesky::new(damped).map(|factors| factors.solve(&downhill)) else {
                continue;
            };
            let largest = change.amax();
            if largest > LONGEST {
                change *= LONGEST / largest;
            }
            let moved: Vec<f64> =
                point.iter().zip(change.iter()).map(|(value, change)| value + change).collect();
            // A point without a response is no minimum.
            let Ok(there) = residuals(&moved) else { continue };
            let there = DVector::from_vec(there);
            let value = cost_of(&there, &moved);
            if value < cost {
                (point, residual, cost) = (moved, there, value);
                damping = (damping / 80.0).max(1e-9);
                break;
            }
        }
        if before - cost < GAIN.0.max(GAIN.1 * before) {
            break;
        }
    }
    Ok(Minimum { cost, point })
}

fn slopes_at(residuals: &Residuals<'_>, point: &[f64], here: &DVector<f64>) -> Result<DMatrix<f64>> {
    let column = |index: usize| -> Result<DVector<f64>> {
        let mut moved = point.to_vec();
        moved[index] += STEP;
        Ok((DVector::from_vec(residuals(&moved)?) - here) / STEP)
    };
    Ok(DMatrix::from_columns(&in_order((0..point.len()).into_par_iter().map(column))?))
}
