//! What the data determine and what they do not.

use nalgebra::{DMatrix, DVector};

/// Certainty of the free parameters, in their unit intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Certainty {
    /// Standard deviation of each place in its unit interval.
    pub sd: Vec<f64>,
    /// Whether the data narrow the plausible range at least fourfold.
    pub identifiable: Vec<bool>,
    /// Correlation matrix, row by row.
    pub correlation: Vec<Vec<f64>>,
}

/// The data determine a parameter if they shrink the standard deviation of its plausible range by this factor.
pub const NARROWING: f64 = 4.0;
/// Standard deviation of a number somewhere in the unit interval.
const RANGE_SD: f64 = 0.288_675_134_594_812_9;
/// Step of the central differences in the unit interval.
const STEP: f64 = 2e-4;

/// Certainty from weighted residuals around a place, with the plausible ranges as prior knowledge: their standard deviation is
/// 1/√12 of their width, so that what the data do not see keeps the width of its range. `misfit` multiplies the variance of the data:
/// χ² per degree of freedom where that is above 1.
pub fn certainty(place: &[f64], misfit: f64, mut residuals: impl FnMut(&[f64]) -> Vec<f64>) -> Certainty {
    let count = place.len();
    let rows = residuals(place).len();
    let mut jacobian = DMatrix::<f64>::zeros(rows, count);
    for column in 0..count {
        let shifted = |by: f64| {
            let mut other = place.to_vec();
            other[column] = (other[column] + by).clamp(0.0, 1.0);
            other
        };
        let (low, high) = (shifted(-STEP), shifted(STEP));
        let width = high[column] - low[column];
        let difference = DVector::from_vec(residuals(&high)) - DVector::from_vec(residuals(&low));
        jacobian.set_column(column, &(difference / width));
    }
    let mut information = jacobian.transpose() * &jacobian / misfit;
    for d in 0..count {
        information[(d, d)] += 1.0 / (RANGE_SD * RANGE_SD);
    }
    let covariance = information.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count) * (RANGE_SD * RANGE_SD));
    let sd: Vec<f64> = (0..count).map(|d| covariance[(d, d)].max(0.0).sqrt()).collect();
    let identifiable = sd.iter().map(|s| *s <= RANGE_SD / NARROWING).collect();
    let correlation = (0..count).map(|i| (0..count).map(|j| covariance[(i, j)] / (sd[i] * sd[j])).collect()).collect();
    Certainty { sd, identifiable, correlation }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_seen_keeps_its_range() {
        let result = certainty(&[0.4, 0.6], 1.0, |x| vec![(x[0] - 0.4) / 0.01]);
        assert!((result.sd[0] - 0.01).abs() < 1e-5);
        assert!((result.sd[1] - RANGE_SD).abs() < 1e-9);
        assert_eq!(result.identifiable, [true, false]);
    }

    #[test]
    fn a_sum_alone_leaves_both_open_and_fully_correlated() {
        let result = certainty(&[0.5, 0.5], 1.0, |x| vec![(x[0] + x[1] - 1.0) / 0.001]);
        assert_eq!(result.identifiable, [false, false]);
        assert!(result.correlation[0][1] < -0.99);
    }
}
