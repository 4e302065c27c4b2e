//! Null distribution of motions: the reduction of the prediction error by candidates where no effect is missing.

use super::screening::Ranked;
use numeric::statistics::quantile;

/// Null distribution. Candidates differ in what they gain by chance: a wave of any period gains much, others little. Hence −ln(1 − gain) is divided
/// by the 90 % quantile of each candidate, and the largest ratio of a draw represents the whole library.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionNullDistribution {
    /// 90 % quantile of −ln(1 − gain) of each candidate.
    pub scales: Vec<f64>,
    /// Largest −ln(1 − gain) of each candidate in any draw.
    pub most: Vec<f64>,
    /// Largest ratio of −ln(1 − gain) to its scale over all effects, of each draw, in rising order.
    pub effects: Vec<f64>,
    /// The same over all free functions.
    pub free: Vec<f64>,
}

/// Least scale of a candidate.
const LEAST_SCALE: f64 = 0.01;
/// Least ratio of a candidate's −ln(1 − gain) to its largest in any draw that counts as significant regardless of other candidates.
const BEYOND: f64 = 1.25;

impl MotionNullDistribution {
    /// Builds the distribution from the −ln(1 − gain) of every candidate in each draw. `free` marks free functions.
    pub(super) fn new(gains: &[Vec<f64>], free: &[bool]) -> Self {
        let of = |at: usize| gains.iter().map(move |g| g[at]);
        let scales: Vec<f64> = (0..free.len()).map(|at| quantile(of(at), 0.9).unwrap_or(0.0).max(LEAST_SCALE)).collect();
        let most: Vec<f64> = (0..free.len()).map(|at| of(at).fold(0.0, f64::max)).collect();
        let largest = |of_free: bool| {
            let largest_ratio = |g: &Vec<f64>| {
                let ratios = g.iter().zip(&scales).zip(free).filter(|(_, free)| **free == of_free).map(|((g, s), _)| g / s);
                ratios.fold(0.0, f64::max)
            };
            let mut all: Vec<f64> = gains.iter().map(largest_ratio).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let (effects, free) = (largest(false), largest(true));
        MotionNullDistribution { scales, most, effects, free }
    }

    /// Returns the share of draws in which some effect gains as much; the least possible share where a candidate clearly exceeds its own largest
    /// gain.
    pub fn p_value(&self, ranked: &Ranked) -> f64 {
        self.p_value_among(&self.effects, ranked)
    }

    /// Returns the same share for free functions.
    pub fn p_value_free(&self, ranked: &Ranked) -> f64 {
        self.p_value_among(&self.free, ranked)
    }

    fn p_value_among(&self, all: &[f64], ranked: &Ranked) -> f64 {
        let own = strength(ranked.gain);
        if own > BEYOND * self.most[ranked.candidate].max(LEAST_SCALE) {
            return 1.0 / (all.len() + 1) as f64;
        }
        share_above(all, own / self.scales[ranked.candidate])
    }
}

/// Returns −ln(1 − gain): ln of the loss of the machine over that with a candidate.
pub(super) fn strength(gain: f64) -> f64 {
    -(1.0 - gain.clamp(0.0, 1.0)).max(1e-12).ln()
}

fn share_above(sorted: &[f64], gain: f64) -> f64 {
    let above = sorted.len() - sorted.partition_point(|x| *x < gain);
    (above + 1) as f64 / (sorted.len() + 1) as f64
}
