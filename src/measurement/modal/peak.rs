//! Peaks of the fitted |H| in the measured quantity.

use num_complex::Complex64;

use super::model::ModalModel;

/// Points of the first look around a mode.
const LOOK: usize = 81;
/// Half-widths of the mode looked at on either side.
const REACH: f64 = 2.5;

/// Frequency (rad/s) of the local maximum of |H|·ω^p next to a pole inside `band`; `None` where the mode makes none.
///
/// The maximum is looked for within 2.5 half-widths of the pole (and not beyond half the way to the next pole), then refined by
/// golden section.
pub(super) fn maximum(model: &ModalModel, pole: Complex64, omega_power: i32, band: (f64, f64)) -> Option<f64> {
    let size = |omega: f64| model.at(omega).norm() * omega.powi(omega_power);
    let half_way = |other: Complex64| 0.5 * (pole.im + other.im);
    let others = || model.terms.iter().map(|t| t.pole).filter(|p| *p != pole);
    let below = others().filter(|p| p.im < pole.im).map(half_way).fold(band.0, f64::max);
    let above = others().filter(|p| p.im > pole.im).map(half_way).fold(band.1, f64::min);
    let from = (pole.im + REACH * pole.re).max(below);
    let to = (pole.im - REACH * pole.re).min(above);
    if !(to > from) {
        return None;
    }
    let step = (to - from) / (LOOK - 1) as f64;
    let sizes: Vec<f64> = (0..LOOK).map(|k| size(from + step * k as f64)).collect();
    let top = (1..LOOK - 1)
        .filter(|k| sizes[*k] > sizes[k - 1] && sizes[*k] >= sizes[k + 1])
        .min_by(|a, b| (from + step * *a as f64 - pole.im).abs().total_cmp(&(from + step * *b as f64 - pole.im).abs()))?;
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
