//! Errors of the highest resonance of FRFs: frequency, damping ratio and height.

use super::fit::{Fitted, values_of};
use super::hypothesis::Hypothesis;
use identification::objective::{FrfObjective, FrfSettings, ObjectiveError};
use measurement::HoldOutSet;
use numeric::statistics::root_mean_square;

/// Least ratio of a resonance to the higher of its neighbouring valleys.
const STANDS_OUT: f64 = 1.5;

/// Relative errors of the highest resonance, root mean square over FRFs; `None` where no FRF shows one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakErrors {
    /// Error of its frequency.
    pub frequency: f64,
    /// Error of its damping ratio, where both curves have half-power points.
    pub damping: Option<f64>,
    /// Error of its height: the peak compliance.
    pub height: f64,
}

/// Compares the highest resonance of held-out FRFs, predicted and measured.
///
/// # Errors  as [`FrfObjective::held_out`].
pub fn peak_errors(
    hypothesis: &Hypothesis,
    fitted: &Fitted,
    held_out: &HoldOutSet<'_>,
    settings: FrfSettings,
) -> Result<Option<PeakErrors>, ObjectiveError> {
    let objective = FrfObjective::held_out(&hypothesis.machine, held_out, settings)?;
    let values = values_of(hypothesis, fitted);
    let residuals = objective.residuals(&values, objective.best_gain(&values));
    let (mut frequencies, mut dampings, mut heights) = (Vec::new(), Vec::new(), Vec::new());
    for (residuals, record) in residuals.iter().zip(objective.records()) {
        let lines_hz = record.frequencies_hz();
        let measured = record.magnitudes();
        let predicted: Vec<f64> = measured.iter().zip(residuals).map(|(h, r)| h / r.re.exp()).collect();
        let Some(m) = highest(&measured) else { continue };
        // The same resonance need not be the highest one of the prediction.
        let distance = |at: &usize| (lines_hz[*at] / lines_hz[m]).ln().abs();
        let Some(p) = peaks(&predicted).min_by(|a, b| distance(a).total_cmp(&distance(b))) else { continue };
        frequencies.push(lines_hz[p] / lines_hz[m] - 1.0);
        heights.push(predicted[p] / measured[m] - 1.0);
        if let (Some(true_ratio), Some(ratio)) =
            (damping_ratio(&lines_hz, &measured, m), damping_ratio(&lines_hz, &predicted, p))
        {
            dampings.push(ratio / true_ratio - 1.0);
        }
    }
    let (damping, height) = (root_mean_square(dampings), root_mean_square(heights));
    Ok(root_mean_square(frequencies).zip(height).map(|(frequency, height)| PeakErrors {
        frequency,
        damping,
        height,
    }))
}

/// Returns the index of the highest inner maximum that stands out on both sides.
fn highest(magnitudes: &[f64]) -> Option<usize> {
    peaks(magnitudes).max_by(|a, b| magnitudes[*a].total_cmp(&magnitudes[*b]))
}

/// Returns the indices of the inner maxima that stand out on both sides.
fn peaks(magnitudes: &[f64]) -> impl Iterator<Item = usize> {
    let stands_out = move |at: usize| {
        let top = magnitudes[at];
        let least = |side: &mut dyn Iterator<Item = &f64>| {
            side.take_while(|h| **h <= top).fold(top, |low, h| low.min(*h))
        };
        let (left, right) =
            (least(&mut magnitudes[..at].iter().rev()), least(&mut magnitudes[at + 1..].iter()));
        top > STANDS_OUT * left.max(right)
    };
    let inner = 1..magnitudes.len().saturating_sub(1);
    let is_largest =
        |at: &usize| magnitudes[*at] >= magnitudes[at - 1] && magnitudes[*at] > magnitudes[at + 1];
    inner.filter(is_largest).filter(move |at| stands_out(*at))
}

/// Returns half of the half-power width over the frequency; `None` where a half-power point lies outside the
/// band or beyond another peak.
///
/// # Source  Δω/(2·ω_n) at |H|/√2, for light damping: Ewins, "Modal Testing", ch. 4.
fn damping_ratio(lines_hz: &[f64], magnitudes: &[f64], peak: usize) -> Option<f64> {
    let half = magnitudes[peak] / std::f64::consts::SQRT_2;
    let crossing = |low: usize, high: usize| {
        let share = (half - magnitudes[low]) / (magnitudes[high] - magnitudes[low]);
        lines_hz[low] + share * (lines_hz[high] - lines_hz[low])
    };
    let left = (1..=peak).rev().find(|at| magnitudes[at - 1] < half)?;
    let right = (peak..magnitudes.len() - 1).find(|at| magnitudes[at + 1] < half)?;
    Some((crossing(right, right + 1) - crossing(left - 1, left)) / (2.0 * lines_hz[peak]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns |H| of an oscillator in addition to a rigid-body line.
    fn magnitudes(lines_hz: &[f64], f0_hz: f64, ratio: f64) -> Vec<f64> {
        let of = |f: &f64| {
            let x = f / f0_hz;
            1.0 / ((1.0 - x * x).powi(2) + (2.0 * ratio * x).powi(2)).sqrt() + 20.0 / (f * f)
        };
        lines_hz.iter().map(of).collect()
    }

    #[test]
    fn limit_half_power_width_is_twice_the_damping_ratio() {
        let lines_hz: Vec<f64> = (1..4000).map(|k| 0.1 * f64::from(k)).collect();
        let h = magnitudes(&lines_hz, 150.0, 0.02);
        let peak = highest(&h).unwrap();
        assert!((lines_hz[peak] - 150.0).abs() < 0.2, "{}", lines_hz[peak]);
        let ratio = damping_ratio(&lines_hz, &h, peak).unwrap();
        assert!((ratio / 0.02 - 1.0).abs() < 0.02, "{ratio}");
    }

    #[test]
    fn a_falling_line_has_no_resonance() {
        let falling: Vec<f64> =
            (1..100).map(|k| (1.0 + 0.01 * f64::from(k % 2)) / f64::from(k * k)).collect();
        assert_eq!(highest(&falling), None);
    }
}
