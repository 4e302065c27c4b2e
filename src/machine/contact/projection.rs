//! Least squares with few non-negative coefficients, and the inverse for their covariance.

/// A small symmetric matrix by rows.
pub(super) type Matrix<const N: usize> = [[f64; N]; N];

/// Inverts a symmetric positive definite matrix restricted to the rows and columns in use, 0 elsewhere;
/// `None` if it is singular to working precision.
///
/// The matrix is scaled to a unit diagonal, factored as L·Lᵀ and inverted column by column.
pub(super) fn inverse<const N: usize>(matrix: &Matrix<N>, used: [bool; N]) -> Option<Matrix<N>> {
    let mut scale = [0.0; N];
    for (index, scale) in scale.iter_mut().enumerate() {
        if used[index] {
            let diagonal = matrix[index][index];
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return None;
            }
            *scale = 1.0 / diagonal.sqrt();
        }
    }
    let mut lower = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            // A unit row replaces one that is not used.
            let entry = if used[i] && used[j] {
                matrix[i][j] * scale[i] * scale[j]
            } else {
                f64::from(u8::from(i == j))
            };
            let rest = entry - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = if i == j {
                if !(rest > 1e-13) {
                    return None;
                }
                rest.sqrt()
            } else {
                rest / lower[j][j]
            };
        }
    }
    let mut inverse = [[0.0; N]; N];
    for column in 0..N {
        if !used[column] {
            continue;
        }
        let mut x = [0.0; N];
        for i in 0..N {
            let unit = f64::from(u8::from(i == column));
            x[i] = (unit - (0..i).map(|k| lower[i][k] * x[k]).sum::<f64>()) / lower[i][i];
        }
        for i in (0..N).rev() {
            x[i] = (x[i] - (i + 1..N).map(|k| lower[k][i] * x[k]).sum::<f64>()) / lower[i][i];
        }
        for row in 0..N {
            inverse[row][column] = x[row] * scale[row] * scale[column];
        }
    }
    Some(inverse)
}

/// Solves weighted least squares Σ w·(y − Σ x_k·c_k)² with c ≥ 0; returns the coefficients and the sum of
/// squares.
///
/// With three coefficients all eight sets of positive ones are tried. The problem is convex, so the smallest
/// sum among the admissible sets is the minimum.
///
/// # Source  Lawson and Hanson, «Solving Least Squares Problems», ch. 23; enumeration replaces their search.
pub(super) fn non_negative<const N: usize>(rows: &[([f64; N], f64, f64)]) -> ([f64; N], f64) {
    least_squares(rows, |coefficient| coefficient >= 0.0)
}

/// Solves the same least squares with coefficients of either sign.
pub(super) fn unbounded<const N: usize>(rows: &[([f64; N], f64, f64)]) -> ([f64; N], f64) {
    least_squares(rows, |_| true)
}

fn least_squares<const N: usize>(
    rows: &[([f64; N], f64, f64)],
    is_admissible: fn(f64) -> bool,
) -> ([f64; N], f64) {
    let mut normal = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (x, y, weight) in rows {
        for i in 0..N {
            right[i] += weight * x[i] * y;
            for j in 0..N {
                normal[i][j] += weight * x[i] * x[j];
            }
        }
    }
    let squares = |c: &[f64; N]| {
        rows.iter()
            .map(|(x, y, weight)| weight * (y - x.iter().zip(c).map(|(x, c)| x * c).sum::<f64>()).powi(2))
            .sum::<f64>()
    };
    let mut best = ([0.0; N], squares(&[0.0; N]));
    for set in 1_usize..1 << N {
        let used = std::array::from_fn(|index| set >> index & 1 == 1);
        let Some(inverse) = inverse(&normal, used) else { continue };
        let coefficients: [f64; N] = std::array::from_fn(|i| (0..N).map(|j| inverse[i][j] * right[j]).sum());
        if coefficients.iter().all(|coefficient| is_admissible(*coefficient)) {
            let sum = squares(&coefficients);
            if sum < best.1 {
                best = (coefficients, sum);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_inverse_times_matrix_is_one() {
        let matrix = [[4e12, 2e5, 1e3], [2e5, 3.0, 1e-4], [1e3, 1e-4, 2e-6]];
        let inverse = inverse(&matrix, [true; 3]).unwrap();
        for (i, row) in inverse.iter().enumerate() {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| row[k] * matrix[k][j]).sum();
                let unit = f64::from(u8::from(i == j)) * 1.0;
                assert!((product - unit).abs() * (matrix[i][i] / matrix[j][j]).sqrt() < 1e-12);
            }
        }
        let part = super::inverse(&matrix, [true, false, true]).unwrap();
        let determinant = 4e12 * 2e-6 - 1e6;
        assert!((part[0][0] - 2e-6 / determinant).abs() < 1e-12 * part[0][0]);
        assert!((part[0][2] + 1e3 / determinant).abs() < 1e-12 * part[0][2].abs());
        assert_eq!(part[1], [0.0; 3]);
        assert!(super::inverse(&[[1.0, 1.0], [1.0, 1.0]], [true; 2]).is_none());
        assert!(super::inverse(&[[0.0, 0.0], [0.0, 1.0]], [true; 2]).is_none());
    }

    #[test]
    fn limit_free_minimum_is_found_and_a_negative_one_is_clipped() {
        let rows = |truth: [f64; 3]| -> Vec<([f64; 3], f64, f64)> {
            (0..12)
                .map(|index| {
                    let t = f64::from(index) / 11.0;
                    let x = [1.0, (-5.0 * t).exp(), t];
                    (x, x.iter().zip(truth).map(|(x, c)| x * c).sum(), 1.0 + t)
                })
                .collect()
        };
        let (found, squares) = non_negative(&rows([2.0, 3.0, 0.5]));
        assert!(
            found.iter().zip([2.0, 3.0, 0.5]).all(|(found, truth)| (found - truth).abs() < 1e-11)
                && squares < 1e-20
        );
        let data = rows([2.0, 3.0, -0.5]);
        let (found, squares) = non_negative(&data);
        assert!(found[2] == 0.0 && found[0] > 0.0);
        // Karush–Kuhn–Tucker: the gradient is zero where c > 0 and not negative where c = 0.
        for k in 0..3 {
            let gradient: f64 = data
                .iter()
                .map(|(x, y, w)| -2.0 * w * x[k] * (y - x.iter().zip(found).map(|(x, c)| x * c).sum::<f64>()))
                .sum();
            assert!(if found[k] > 0.0 { gradient.abs() < 1e-10 } else { gradient >= 0.0 });
        }
        assert!(squares > 0.0);
    }
}
