//! Linear least squares.

use nalgebra::{DMatrix, DVector};

/// Least independent share of a column's length; below it the column counts as a linear combination of the
/// previous ones.
const INDEPENDENT: f64 = 1e-9;

/// Linear least squares by QR, each column scaled to unit length.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearFit {
    /// Coefficients.
    pub coefficients: DVector<f64>,
    /// Residual y − X·c.
    pub residual: DVector<f64>,
}

impl LinearFit {
    /// Minimises |y − X·c|². `None` where columns are linearly dependent.
    pub fn new(columns: &DMatrix<f64>, y: &DVector<f64>) -> Option<Self> {
        Self::penalised(columns, &[], y, INDEPENDENT)
    }

    /// Minimises |y − X·c|² + Σ p_j·c_j², with additional rows √p_j below X. `None` where less than the share
    /// `independent` of a column's length, including its penalty row, is independent of the previous columns.
    pub fn penalised(
        columns: &DMatrix<f64>,
        penalty: &[f64],
        y: &DVector<f64>,
        independent: f64,
    ) -> Option<Self> {
        let lengths: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
        if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
            return None;
        }
        let (rows, penalties) = (columns.nrows(), penalty.len());
        let scaled = DMatrix::from_fn(rows + penalties, columns.ncols(), |i, j| match i.checked_sub(rows) {
            None => columns[(i, j)] / lengths[j],
            Some(at) if at == j => penalty[at].sqrt() / lengths[j],
            Some(_) => 0.0,
        });
        let right = DVector::from_iterator(
            rows + penalties,
            y.iter().copied().chain(std::iter::repeat_n(0.0, penalties)),
        );
        let qr = scaled.clone().qr();
        let r = qr.r();
        if (0..r.ncols()).any(|i| r[(i, i)].abs() < independent) {
            return None;
        }
        let solved = r.solve_upper_triangular(&(qr.q().transpose() * &right))?;
        let residual = (right - scaled * &solved).rows(0, rows).into_owned();
        let coefficients =
            DVector::from_iterator(solved.len(), solved.iter().zip(&lengths).map(|(x, l)| x / l));
        Some(LinearFit { coefficients, residual })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_penalised_fit_solves_the_normal_equations() {
        let columns = DMatrix::from_fn(40, 3, |i, j| [1.0, 1e4 * (0.3 * i as f64).sin(), 1e-3 * i as f64][j]);
        let y = DVector::from_fn(40, |i, _| (0.1 * (i * i) as f64).cos() + 2.0);
        for penalty in [[0.0, 0.0, 0.0], [3.0, 0.0, 1e-5]] {
            let found = LinearFit::penalised(&columns, &penalty, &y, 1e-9).unwrap();
            let normal =
                columns.tr_mul(&columns) + DMatrix::from_diagonal(&DVector::from_column_slice(&penalty));
            let expected = normal.lu().solve(&columns.tr_mul(&y)).unwrap();
            assert!(
                found.coefficients.iter().zip(&expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9),
                "{found:?} {expected}"
            );
            assert!((&found.residual - (&y - &columns * &expected)).norm() < 1e-9);
        }
        let twice = DMatrix::from_fn(40, 2, |i, j| columns[(i, 2)] * (1.0 + j as f64));
        assert_eq!(LinearFit::new(&twice, &y), None);
    }
}
