//! Tolerances beside which a force is fitted.

use nalgebra::{DMatrix, DVector, Dim, Dyn, Matrix, StorageMut};

/// What tolerances leave of a force: each adds its column, in units of its standard deviation, with a penalty.
///
/// The least of |r − N·b|² + v·|b|² over b is rᵀ·(1 + N·Nᵀ/v)⁻¹·r = |L·r|², with the symmetric root
/// L = 1 − U·(1 − √(v/(σ² + v)))·Uᵀ of the singular values σ and vectors U of N.
#[derive(Debug, Clone)]
pub struct Tolerances {
    /// Left singular vectors.
    directions: DMatrix<f64>,
    /// Share of each that is taken away (1).
    taken: DVector<f64>,
    /// Sizes of the tolerances, in standard deviations, for a force: (NᵀN + v)⁻¹·Nᵀ.
    sizes: DMatrix<f64>,
}

impl Tolerances {
    /// Builds them from columns (samples × tolerances, N or N·m) and the variance of the noise, corrected for its
    /// autocorrelation. `None` where the columns are no numbers.
    pub fn new(columns: &DMatrix<f64>, variance: f64) -> Option<Self> {
        // Few columns of many samples: the singular values follow from their products.
        let products = columns.tr_mul(columns).symmetric_eigen();
        let largest = products.eigenvalues.max();
        let kept: Vec<usize> =
            (0..columns.ncols()).filter(|at| products.eigenvalues[*at] > RESOLUTION * largest).collect();
        let vectors = products.eigenvectors.select_columns(&kept);
        let squares = products.eigenvalues.select_rows(&kept);
        let lengths = DMatrix::from_diagonal(&squares.map(|square| 1.0 / square.sqrt()));
        let directions = columns * &vectors * lengths;
        let taken = squares.map(|square| 1.0 - (variance / (square + variance)).sqrt());
        let within = DMatrix::from_diagonal(&squares.map(|square| square.sqrt() / (square + variance)));
        let sizes = vectors * within * directions.transpose();
        largest.is_finite().then_some(Tolerances { directions, taken, sizes })
    }

    /// Takes away what the tolerances account for.
    pub fn apply<C: Dim, S: StorageMut<f64, Dyn, C>>(&self, columns: &mut Matrix<f64, Dyn, C, S>) {
        let mut along = self.directions.tr_mul(&*columns);
        along.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.taken));
        *columns -= &self.directions * along;
    }

    /// Returns the sizes of the tolerances for a force, in standard deviations.
    pub fn sizes(&self, force: &DVector<f64>) -> DVector<f64> {
        &self.sizes * force
    }
}

/// Least share of the largest product of tolerances that is resolved (1): products of double precision.
const RESOLUTION: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;
    use numeric::linear_fit::LinearFit;

    /// What tolerances leave of a force has the least sum of squares with their penalty, and their sizes are those
    /// of that fit, also where two of them are the same.
    #[test]
    fn limit_tolerances_leave_what_a_penalised_fit_leaves() {
        let columns = DMatrix::from_fn(40, 4, |i, j| match j {
            3 => 2.0 * (0.3 * i as f64).sin(),
            j => (0.3 * (j + 1) as f64 * i as f64).sin(),
        });
        let force = DVector::from_fn(40, |i, _| (0.37 * i as f64).cos() + 0.02 * i as f64);
        let variance = 0.7;
        let tolerances = Tolerances::new(&columns, variance).unwrap();
        let fit = LinearFit::penalised(&columns, &[variance; 4], &force, 1e-12).unwrap();
        let least = fit.residual.norm_squared() + variance * fit.coefficients.norm_squared();
        let mut left = force.clone();
        tolerances.apply(&mut left);
        assert!((left.norm_squared() / least - 1.0).abs() < 1e-9);
        assert!((tolerances.sizes(&force) - fit.coefficients).norm() < 1e-9);
    }
}
