//! Thins curves of many lines to the visible detail.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use num_complex::Complex64;

/// The lines kept of a curve, and the deviation of the straight lines between them from those left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Thinned {
    /// Indices of the lines kept, in ascending order.
    pub kept: Vec<usize>,
    /// Largest deviation in ln|H| or in the phase (rad).
    pub deviation: f64,
}

struct Span {
    from: usize,
    to: usize,
    worst: usize,
    deviation: f64,
}

impl PartialEq for Span {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Span {}
impl PartialOrd for Span {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Span {
    fn cmp(&self, other: &Self) -> Ordering {
        self.deviation.total_cmp(&other.deviation).then(other.from.cmp(&self.from))
    }
}

/// Thins a curve to its ends and the lines that deviate most.
///
/// Each step keeps the line with the largest deviation from the straight line between its kept neighbours,
/// over ln f, in ln|H| and phase. It stops where no line deviates by more than `tolerance`, or where `most`
/// lines are kept. Peaks and antiresonances deviate most, so they are kept first, with their exact frequency
/// and height.
pub fn thin(frequency_hz: &[f64], values: &[Complex64], tolerance: f64, most: usize) -> Thinned {
    let count = frequency_hz.len().min(values.len());
    if count <= 2 {
        return Thinned { kept: (0..count).collect(), deviation: 0.0 };
    }
    let at: Vec<f64> = frequency_hz.iter().map(|f| f.max(f64::MIN_POSITIVE).ln()).collect();
    let size: Vec<f64> = values.iter().map(|h| h.norm().max(f64::MIN_POSITIVE).ln()).collect();
    let mut phase: Vec<f64> = values.iter().map(|h| h.arg()).collect();
    for i in 1..count {
        let turn = std::f64::consts::TAU;
        phase[i] -= turn * ((phase[i] - phase[i - 1]) / turn).round();
    }
    let span = |from: usize, to: usize| {
        let mut worst = (from, 0.0);
        for i in from + 1..to {
            let share = (at[i] - at[from]) / (at[to] - at[from]);
            let away = |y: &[f64]| (y[i] - y[from] - share * (y[to] - y[from])).abs();
            let deviation = away(&size).max(away(&phase));
            if deviation > worst.1 {
                worst = (i, deviation);
            }
        }
        Span { from, to, worst: worst.0, deviation: worst.1 }
    };
    let mut spans = BinaryHeap::from([span(0, count - 1)]);
    let mut kept = vec![0, count - 1];
    while let Some(widest) = spans.peek() {
        if widest.deviation <= tolerance || kept.len() >= most.max(2) {
            break;
        }
        let Some(Span { from, to, worst, .. }) = spans.pop() else { break };
        kept.push(worst);
        spans.push(span(from, worst));
        spans.push(span(worst, to));
    }
    kept.sort_unstable();
    Thinned { kept, deviation: spans.peek().map_or(0.0, |s| s.deviation) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resonator(f: f64) -> Complex64 {
        (0..4)
            .map(|k| {
                1.0 / Complex64::new(
                    (50.0 * 3.0_f64.powi(k)).powi(2) - f * f,
                    0.04 * 50.0 * 3.0_f64.powi(k) * f,
                )
            })
            .sum()
    }

    #[test]
    fn ten_thousand_lines_are_thinned_to_hundreds_with_all_peaks() {
        let f: Vec<f64> = (1..=10_000).map(|i| 0.2 * f64::from(i)).collect();
        let h: Vec<Complex64> = f.iter().map(|f| resonator(*f)).collect();
        let thinned = thin(&f, &h, 0.01, 1000);
        assert!(thinned.kept.len() < 400 && thinned.deviation <= 0.01, "{}", thinned.kept.len());
        let peak = (0..h.len()).max_by(|a, b| h[*a].norm().total_cmp(&h[*b].norm())).unwrap();
        let best = thinned.kept.iter().map(|i| h[*i].norm()).fold(0.0, f64::max);
        assert!(best > 0.99 * h[peak].norm());
        assert_eq!(thin(&f, &h, 0.0, 50).kept.len(), 50);
    }

    #[test]
    fn short_curves_are_kept() {
        assert!(thin(&[], &[], 0.01, 10).kept.is_empty());
        assert_eq!(thin(&[1.0, 2.0], &[Complex64::new(1.0, 0.0); 2], 0.01, 10).kept, [0, 1]);
    }
}
