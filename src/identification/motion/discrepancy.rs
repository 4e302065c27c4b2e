//! Systematic part of the residual of a force fit.

use nalgebra::{DMatrix, DVector};

use super::marginal::{Channel, Marginal, folded};
use dynamics::inverse_dynamics::MotionSignal;
use numeric::statistics::extremes;

/// Number of half-waves of a smooth function over the range of its variable.
const HALF_WAVES: usize = 8;
/// Least share of a function that is independent of the fitted columns.
const INDEPENDENT: f64 = 1e-3;

/// Computes the share of the squared residual that smooth functions of velocity and of acceleration explain.
///
/// Noise does not know the motion. Forces that the machine lacks are functions of it: friction by direction
/// and speed, inertia, compliance.
pub(super) fn systematic_share(found: &Marginal, motions: &[&MotionSignal], channels: &[Channel]) -> f64 {
    let whole = found.residual.norm_squared();
    let mut left = found.residual.clone();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let variables: [fn(&MotionSignal) -> &Vec<f64>; 2] = [|m| &m.velocity_m_s, |m| &m.acceleration_m_s2];
    for variable in variables {
        let (low, high) = extremes(motions.iter().copied().flat_map(variable));
        for n in 1..=HALF_WAVES {
            let wave = |x: &f64| {
                (std::f64::consts::PI * n as f64 * (x - low) / (high - low).max(f64::MIN_POSITIVE)).cos()
            };
            let rows = |m: &&MotionSignal| {
                let mut all =
                    m.thinned(&variable(m).iter().map(wave).collect::<Vec<f64>>()).unwrap_or_default();
                all.resize(m.load.len() * (1 + m.extra_channels.len()), 0.0);
                all
            };
            let column: Vec<f64> = motions.iter().flat_map(rows).collect();
            let mut column = folded(&DMatrix::from_column_slice(column.len(), 1, &column), channels)
                .column(0)
                .into_owned();
            let length = column.norm();
            column -= &found.basis * found.basis.tr_mul(&column);
            for other in &basis {
                let along = other.dot(&column);
                column.axpy(-along, other, 1.0);
            }
            let own = column.norm();
            if own > INDEPENDENT * length {
                column /= own;
                let along = column.dot(&left);
                left.axpy(-along, &column, 1.0);
                basis.push(column);
            }
        }
    }
    if whole > 0.0 { 1.0 - left.norm_squared() / whole } else { 0.0 }
}
