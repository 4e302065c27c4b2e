//! What the data determine and what they do not.

use nalgebra::DMatrix;

use machine::{Parameter, Scale};

/// Certainty of the free parameters, in their unit intervals, near the best place.
#[derive(Debug, Clone, PartialEq)]
pub struct Certainty {
    /// Standard deviation of each place in its unit interval.
    pub sd: Vec<f64>,
    /// Whether the data narrow what counts of the plausible range at least fourfold.
    pub identifiable: Vec<bool>,
    /// Covariance of the places.
    pub covariance: DMatrix<f64>,
    /// Correlation matrix, row by row.
    pub correlation: Vec<Vec<f64>>,
}

impl Certainty {
    /// Of some coordinates alone, in this order.
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

/// The data determine a parameter if they shrink the standard deviation of its plausible range by this factor.
pub const NARROWING: f64 = 4.0;
/// Standard deviation of a number somewhere in the unit interval.
pub const RANGE_SD: f64 = 0.288_675_134_594_812_9;

/// Largest factor of a logarithmic range that counts where its narrowing is judged.
const COUNTED: f64 = 3.0;

/// Share of a parameter's range that counts where its narrowing is judged: all of a linear one, a factor of three of a logarithmic one. Narrowed fourfold, its
/// 95 % interval lies within about ±16 %. A stiffness known worse is not good enough to predict with, however wide its range was.
pub fn counted(parameter: &Parameter) -> f64 {
    match parameter.scale {
        Scale::Linear => 1.0,
        Scale::Logarithmic => (COUNTED.ln() / (parameter.upper / parameter.lower).ln()).min(1.0),
    }
}

/// Certainty from the information JᵀJ of weighted residuals at a place, with the plausible ranges as prior knowledge: their standard
/// deviation is 1/√12 of their width, so that what the data do not see keeps the width of its range. `misfit` multiplies the variance of
/// the data: χ² per degree of freedom where that is above 1. `counted` is the share of each range that counts, 1 beyond its end.
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
    fn what_is_not_seen_keeps_its_range() {
        let result = certainty(&DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1e4, 0.0])), 1.0, &[]);
        assert!((result.sd[0] - 0.01).abs() < 1e-5);
        assert!((result.sd[1] - RANGE_SD).abs() < 1e-9);
        assert_eq!(result.identifiable, [true, false]);
    }

    #[test]
    fn a_sum_alone_leaves_both_open_and_fully_correlated() {
        let result = certainty(&(DMatrix::from_element(2, 2, 1.0) * 1e6), 1.0, &[]);
        assert_eq!(result.identifiable, [false, false]);
        assert!(result.correlation[0][1] < -0.99);
    }
}
