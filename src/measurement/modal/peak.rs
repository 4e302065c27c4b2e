//! Peaks of the fitted |H| in the measured quantity.

use num_complex::Complex64;

use super::model::ModalModel;

/// Number of points of the first scan around a mode.
const SCAN_POINTS: usize = 81;
/// Range of the scan on either side of a mode, in its half-widths (1).
const SCAN_RANGE: f64 = 2.5;

/// Returns the frequency (rad/s) of the local maximum of |H|·ω^p next to a pole inside `band`; `None` where
/// the mode has no maximum.
///
/// The search covers 2.5 half-widths on either side of the pole, up to the midpoint to the next pole. Golden
/// section refines the maximum.
pub(super) fn maximum(
    model: &ModalModel,
    pole: Complex64,
    omega_power: i32,
    band: (f64, f64),
) -> Option<f64> {
    let size = |omega: f64| model.at(omega).norm() * omega.powi(omega_power);
    let half_way = |other: Complex64| 0.5 * (pole.im + other.im);
    let others = || model.terms.iter().map(|t| t.pole).filter(|p| *p != pole);
    let below = others().filter(|p| p.im < pole.im).map(half_way).fold(band.0, f64::max);
    let above = others().filter(|p| p.im > pole.im).map(half_way).fold(band.1, f64::min);
    let from = (pole.im + SCAN_RANGE * pole.re).max(below);
    let to = (pole.im - SCAN_RANGE * pole.re).min(above);
    if !(to > from) {
        return None;
    }
    let step = (to - from) / (SCAN_POINTS - 1) as f64;
    let sizes: Vec<f64> = (0..SCAN_POINTS).map(|k| size(from + step * k as f64)).collect();
    let top = (1..SCAN_POINTS - 1).filter(|k| sizes[*k] > sizes[k - 1] && sizes[*k] >= sizes[k + 1]).min_by(
        |a, b| {
            (from + step * *a as f64 - pole.im).abs().total_cmp(&(from + step * *b as f64 - pole.im).abs())
        },
    )?;
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (from + step * (top - 1) as f64, from + step * (top + 1) as f64);
    while high - low > 1e-9 * high {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if size(left) > size(right) {
            high = right;
        } else {
            low = left;
        }
    }
    Some(0.5 * (low + high))
}
