//! Model of smooth modes: ln f of a mode as a Gaussian process of the nut position.
//!
//! With u the position over the measured travel (0 to 1), the covariance of ln f is
//!
//! ```text
//!   k(u, u') = level² + slope² (u−½)(u'−½) + bend² exp(−(u−u')²/2ℓ²)   + (jitter² + (s_f/f)²) δ
//! ```
//!
//! On the published bench (Tian et al.) modes shift by 1 to 8 % over the travel; slope and bend allow about
//! that and little more.
//!
//! # Source  Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapters 2 and 5
//!   (leave-one-out, Eq. 5.12).

use nalgebra::{DMatrix, DVector};

/// Standard deviation of the level of ln f (1): large, as the level is unknown.
const LEVEL: f64 = 3.0;
/// Standard deviation of the linear change of ln f over the travel (1).
const SLOPE: f64 = 0.06;
/// Standard deviation of the smooth bend of ln f (1).
const BEND: f64 = 0.045;
/// Correlation length of the bend, as a share of the travel (1).
const LENGTH: f64 = 0.45;
/// Standard deviation of ln f in addition to that of the fit (1), for records at positions.
pub(super) const JITTER: f64 = 0.003;
/// The same for records without position: other responses, repeats, other days.
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

/// Returns the covariance of the process without noise.
fn covariance(u: f64, v: f64) -> f64 {
    let distance = (u - v) / LENGTH;
    LEVEL * LEVEL + SLOPE * SLOPE * (u - 0.5) * (v - 0.5) + BEND * BEND * (-0.5 * distance * distance).exp()
}

/// Points of a track for predicting the next: with the rows of the Cholesky factor of their covariance, and
/// whitened values.
#[derive(Debug, Clone, Default)]
pub(super) struct Past {
    points: Vec<TrackPoint>,
    rows: Vec<Vec<f64>>,
    whitened: Vec<f64>,
}

/// Prediction of ln f, with the row that extends the Cholesky factor if the point is added.
pub(super) struct TrackPrediction {
    pub mean: f64,
    /// Variance of the process at the position, without the noise of the new point.
    pub variance: f64,
    row: Vec<f64>,
}

impl Past {
    /// Predicts ln f at a position from the points so far (at least one).
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

    /// Starts a track with its first point.
    pub fn start(point: TrackPoint) -> Self {
        let own = (covariance(point.u, point.u) + point.variance).sqrt();
        Self { points: vec![point], rows: vec![vec![own]], whitened: vec![0.0] }
    }
}

/// Returns the errors of predicting each point from all others: of ln f, and over their standard deviation.
pub(super) fn leave_one_out(points: &[TrackPoint]) -> Option<Vec<(f64, f64)>> {
    let n = points.len();
    if n < 2 {
        return None;
    }
    let mean = points.iter().map(|p| p.y).sum::<f64>() / n as f64;
    let matrix = DMatrix::from_fn(n, n, |i, j| {
        covariance(points[i].u, points[j].u) + if i == j { points[i].variance } else { 0.0 }
    });
    let inverse = matrix.cholesky()?.inverse();
    let weighted = &inverse * DVector::from_fn(n, |i, _| points[i].y - mean);
    Some((0..n).map(|i| (weighted[i] / inverse[(i, i)], weighted[i] / inverse[(i, i)].sqrt())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_sequential_prediction_is_leave_one_out_of_the_last() {
        let points: Vec<TrackPoint> = [(0.0, 1.0), (0.2, 1.01), (0.7, 1.04), (1.0, 1.02)]
            .iter()
            .map(|(u, y)| TrackPoint { u: *u, y: *y, variance: 1e-5 })
            .collect();
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
