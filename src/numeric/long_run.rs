//! Long-run covariance: the uncertainty of means of autocorrelated series.

use nalgebra::DMatrix;

/// Computes Σ_k (1 − |k|/(m+1)) Σ_t u_t·u_{t−k}ᵀ of scores u (one per row) with bandwidth m: the covariance
/// of their sum.
///
/// # Source  Newey and West, Econometrica 55 (1987) 703–708.
pub fn long_run_covariance(scores: &DMatrix<f64>, bandwidth: usize) -> DMatrix<f64> {
    let count = scores.nrows();
    (0..=bandwidth.min(count.saturating_sub(1))).fold(
        DMatrix::zeros(scores.ncols(), scores.ncols()),
        |sum, lag| {
            let product = scores.rows(lag, count - lag).transpose() * scores.rows(0, count - lag);
            let weight = 1.0 - lag as f64 / (bandwidth + 1) as f64;
            sum + if lag == 0 { product } else { weight * (&product + product.transpose()) }
        },
    )
}

/// Computes Andrews' bandwidth of scores (one per row), at most a third of their number.
///
/// # Source  Andrews, Econometrica 59 (1991) 817–858, AR(1) plug-in for Bartlett weights, with the largest
///   autocorrelation of the scores.
pub fn andrews_bandwidth(scores: &DMatrix<f64>) -> usize {
    let count = scores.nrows();
    let correlation = scores
        .column_iter()
        .map(|u| {
            let square = u.norm_squared();
            if square > 0.0 { u.rows(1, count - 1).dot(&u.rows(0, count - 1)) / square } else { 0.0 }
        })
        .fold(0.0_f64, f64::max)
        .min(0.97);
    let alpha = (2.0 * correlation / ((1.0 - correlation) * (1.0 + correlation))).powi(2);
    ((1.1447 * (alpha * count as f64).cbrt()).ceil() as usize).min(count / 3)
}
