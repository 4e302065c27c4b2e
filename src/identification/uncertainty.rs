//! Standard deviations, correlations and identifiability of the parameters.

use nalgebra::DMatrix;

use machine::{Parameter, Scale};

/// Linearised uncertainty of the free parameters about the best fit, in their unit intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Certainty {
    /// Standard deviation of each coordinate in its unit interval.
    pub sd: Vec<f64>,
    /// Whether the data narrow the reference width of the plausible range at least fourfold; see [`counted`].
    pub identifiable: Vec<bool>,
    /// Covariance of the coordinates.
    pub covariance: DMatrix<f64>,
    /// Correlation matrix, row by row.
    pub correlation: Vec<Vec<f64>>,
}

impl Certainty {
    /// Returns the uncertainty of some coordinates, in this order.
    pub(super) fn of(&self, columns: &[usize]) -> Self {
        let count = columns.len();
        Certainty {
            sd: columns.iter().map(|c| self.sd[*c]).collect(),
            identifiable: columns.iter().map(|c| self.identifiable[*c]).collect(),
            covariance: DMatrix::from_fn(count, count, |i, j| self.covariance[(columns[i], columns[j])]),
            correlation: columns.iter().map(|i| columns.iter().map(|j| self.correlation[*i][*j]).collect()).collect(),
        }
    }
}

/// A parameter is identifiable if the data reduce the standard deviation of its plausible range by this factor (1).
pub const NARROWING: f64 = 4.0;
/// Standard deviation of the uniform distribution on the unit interval, 1/√12.
pub const RANGE_SD: f64 = 0.288_675_134_594_812_9;

/// Reference width of a logarithmic range for identifiability, as a ratio upper/lower (1).
const COUNTED: f64 = 3.0;

/// Returns the reference width for identifiability as a share of a parameter's range.
///
/// It is the whole range on a linear scale, and a factor of three on a logarithmic scale. Narrowed fourfold, the 95 % interval lies within
/// about ±15 %. A stiffness known less well does not suffice for predictions, however wide its range is.
pub fn counted(parameter: &Parameter) -> f64 {
    match parameter.scale {
        Scale::Linear => 1.0,
        Scale::Logarithmic => (COUNTED.ln() / (parameter.upper / parameter.lower).ln()).min(1.0),
    }
}

/// Computes the uncertainty from the information JᵀJ of weighted residuals, with the plausible ranges as priors.
///
/// The prior standard deviation is 1/√12 of a range, so that a parameter without information keeps the width of its range. `misfit` (1)
/// multiplies the variance of the data: χ² per degree of freedom where that is above 1. `counted` holds the reference width of each range
/// as a share; missing entries are 1.
pub fn certainty(information: &DMatrix<f64>, misfit: f64, counted: &[f64]) -> Certainty {
    let count = information.nrows();
    let mut all = information / misfit;
    for d in 0..count {
        all[(d, d)] += 1.0 / (RANGE_SD * RANGE_SD);
    }
    let covariance = all.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count) * (RANGE_SD * RANGE_SD));
    let sd: Vec<f64> = (0..count).map(|d| covariance[(d, d)].max(0.0).sqrt()).collect();
    let share = |at: usize| counted.get(at).copied().unwrap_or(1.0);
    let identifiable = sd.iter().enumerate().map(|(at, s)| *s <= share(at) * RANGE_SD / NARROWING).collect();
    let correlation = (0..count).map(|i| (0..count).map(|j| covariance[(i, j)] / (sd[i] * sd[j])).collect()).collect();
    Certainty { sd, identifiable, covariance, correlation }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameter_without_information_keeps_its_range() {
        let result = certainty(&DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1e4, 0.0])), 1.0, &[]);
        assert!((result.sd[0] - 0.01).abs() < 1e-5);
        assert!((result.sd[1] - RANGE_SD).abs() < 1e-9);
        assert_eq!(result.identifiable, [true, false]);
    }

    #[test]
    fn determined_sum_leaves_both_parts_open_and_correlated() {
        let result = certainty(&(DMatrix::from_element(2, 2, 1.0) * 1e6), 1.0, &[]);
        assert_eq!(result.identifiable, [false, false]);
        assert!(result.correlation[0][1] < -0.99);
    }
}
