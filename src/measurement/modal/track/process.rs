//! What smooth means: the logarithm of a mode's frequency as a Gaussian process of the nut position.
//!
//! With u the position over the travel measured (0 to 1), the covariance of ln f is
//!
//! ```text
//!   k(u, u') = level² + slope² (u−½)(u'−½) + bend² exp(−(u−u')²/2ℓ²)   + (jitter² + (s_f/f)²) δ
//! ```
//!
//! The bench of the paper moves its modes by 1 to 8 % over its travel; slope and bend allow about that and little more.
//!
//! # Source  Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapters 2 and 5 (leave-one-out, Eq. 5.12).

use nalgebra::{DMatrix, DVector};

/// Standard deviation of the level of ln f: unknown.
const LEVEL: f64 = 3.0;
/// Standard deviation of the change of ln f over the travel.
const SLOPE: f64 = 0.06;
/// Standard deviation of the smooth bend of ln f.
const BEND: f64 = 0.045;
/// Length over which a bend remembers itself, as a share of the travel.
const LENGTH: f64 = 0.45;
/// Scatter of ln f beyond the deviation of the fit, for records at positions.
pub(super) const JITTER: f64 = 0.003;
/// The same for records without a position: other responses, repeats, other days.
pub(super) const JITTER_UNPLACED: f64 = 0.006;

/// A frequency at a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrackPoint {
    /// Position over the travel, 0 to 1.
    pub u: f64,
    /// ln f.
    pub y: f64,
    /// Variance of ln f, jitter included.
    pub variance: f64,
}

/// Covariance of the process without noise.
fn covariance(u: f64, v: f64) -> f64 {
    let apart = (u - v) / LENGTH;
    LEVEL * LEVEL + SLOPE * SLOPE * (u - 0.5) * (v - 0.5) + BEND * BEND * (-0.5 * apart * apart).exp()
}

/// Points seen so far, ready to predict the next: rows of the Cholesky factor of their covariance, and whitened values.
#[derive(Debug, Clone, Default)]
pub(super) struct Past {
    points: Vec<TrackPoint>,
    rows: Vec<Vec<f64>>,
    whitened: Vec<f64>,
}

/// A prediction of ln f, and what the factor grows by if it is taken.
pub(super) struct TrackPrediction {
    pub mean: f64,
    /// Variance of the process at the position, without the noise of the new point.
    pub variance: f64,
    row: Vec<f64>,
}

impl Past {
    /// Prediction at a position from the points so far; at least one.
    pub fn predict(&self, u: f64) -> TrackPrediction {
        let mut row = Vec::with_capacity(self.points.len() + 1);
        for (at, point) in self.points.iter().enumerate() {
            let known: f64 = row.iter().zip(&self.rows[at]).map(|(a, b): (&f64, &f64)| a * b).sum();
            row.push((covariance(u, point.u) - known) / self.rows[at][at]);
        }
        let reference = self.points.first().map_or(0.0, |p| p.y);
        let mean = reference + row.iter().zip(&self.whitened).map(|(a, b)| a * b).sum::<f64>();
        let variance = (covariance(u, u) - row.iter().map(|r| r * r).sum::<f64>()).max(0.0);
        TrackPrediction { mean, variance, row }
    }

    /// Adds a point that was predicted.
    pub fn add(&mut self, point: TrackPoint, prediction: TrackPrediction) {
        let own = (prediction.variance + point.variance).sqrt();
        self.whitened.push((point.y - prediction.mean) / own);
        let mut row = prediction.row;
        row.push(own);
        self.rows.push(row);
        self.points.push(point);
    }

    /// The first point of a track.
    pub fn start(point: TrackPoint) -> Self {
        let own = (covariance(point.u, point.u) + point.variance).sqrt();
        Self { points: vec![point], rows: vec![vec![own]], whitened: vec![0.0] }
    }
}

/// Errors of predicting each point from all others: relative (ln f), and over their standard deviation.
pub(super) fn leave_one_out(points: &[TrackPoint]) -> Option<Vec<(f64, f64)>> {
    let n = points.len();
    if n < 2 {
        return None;
    }
    let mean = points.iter().map(|p| p.y).sum::<f64>() / n as f64;
    let matrix = DMatrix::from_fn(n, n, |i, j| covariance(points[i].u, points[j].u) + if i == j { points[i].variance } else { 0.0 });
    let inverse = matrix.cholesky()?.inverse();
    let weighted = &inverse * DVector::from_fn(n, |i, _| points[i].y - mean);
    Some((0..n).map(|i| (weighted[i] / inverse[(i, i)], weighted[i] / inverse[(i, i)].sqrt())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_sequential_prediction_is_leave_one_out_of_the_last() {
        let points: Vec<TrackPoint> =
            [(0.0, 1.0), (0.2, 1.01), (0.7, 1.04), (1.0, 1.02)].iter().map(|(u, y)| TrackPoint { u: *u, y: *y, variance: 1e-5 }).collect();
        let mut past = Past::start(points[0]);
        for point in &points[1..3] {
            let prediction = past.predict(point.u);
            past.add(*point, prediction);
        }
        let last = past.predict(1.0);
        let expected = leave_one_out(&points).unwrap()[3].0;
        assert!((points[3].y - last.mean - expected).abs() < 1e-5, "{} {expected}", points[3].y - last.mean);
    }
}
