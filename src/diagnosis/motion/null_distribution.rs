//! What nulls show: how much candidates gain where nothing is missing.

use super::screening::Ranked;
use numeric::statistics::quantile;

/// What nulls show. Some candidates gain much by accident (a wave of any period), others little: −ln(1 − gain) is told in units of what each
/// gains in one null of ten, and the largest of a draw stands for the whole library.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionNullDistribution {
    /// −ln(1 − gain) of each candidate that nine nulls of ten stay below.
    pub scales: Vec<f64>,
    /// Largest −ln(1 − gain) of each candidate in any null.
    pub most: Vec<f64>,
    /// Largest −ln(1 − gain) of any effect over its scale, of each draw, rising.
    pub effects: Vec<f64>,
    /// The same of free shapes.
    pub free: Vec<f64>,
}

/// Least scale of a candidate.
const LEAST_SCALE: f64 = 0.01;
/// What a candidate must gain over the most that it gained in any null, to be no accident whatever others gained.
const BEYOND: f64 = 1.25;

impl MotionNullDistribution {
    /// Of gains (−ln(1 − gain)) of every candidate in each draw, and whether each is a free shape.
    pub(super) fn new(gains: &[Vec<f64>], free: &[bool]) -> Self {
        let of = |at: usize| gains.iter().map(move |g| g[at]);
        let scales: Vec<f64> = (0..free.len()).map(|at| quantile(of(at), 0.9).unwrap_or(0.0).max(LEAST_SCALE)).collect();
        let most: Vec<f64> = (0..free.len()).map(|at| of(at).fold(0.0, f64::max)).collect();
        let largest = |asked: bool| {
            let own = |g: &Vec<f64>| {
                let over = g.iter().zip(&scales).zip(free).filter(|(_, free)| **free == asked).map(|((g, s), _)| g / s);
                over.fold(0.0, f64::max)
            };
            let mut all: Vec<f64> = gains.iter().map(own).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let (effects, free) = (largest(false), largest(true));
        MotionNullDistribution { scales, most, effects, free }
    }

    /// Share of draws in which some effect gains as much; that of none where it gains clearly more than itself in any.
    pub fn p_value(&self, ranked: &Ranked) -> f64 {
        self.p_among(&self.effects, ranked)
    }

    /// The same of free shapes.
    pub fn p_value_free(&self, ranked: &Ranked) -> f64 {
        self.p_among(&self.free, ranked)
    }

    fn p_among(&self, all: &[f64], ranked: &Ranked) -> f64 {
        let own = strength(ranked.gain);
        if own > BEYOND * self.most[ranked.candidate].max(LEAST_SCALE) {
            return 1.0 / (all.len() + 1) as f64;
        }
        share_above(all, own / self.scales[ranked.candidate])
    }
}

/// ln of what the machine fails to foretell over what a candidate does.
pub(super) fn strength(gain: f64) -> f64 {
    -(1.0 - gain.clamp(0.0, 1.0)).max(1e-12).ln()
}

fn share_above(sorted: &[f64], gain: f64) -> f64 {
    let above = sorted.len() - sorted.partition_point(|x| *x < gain);
    (above + 1) as f64 / (sorted.len() + 1) as f64
}
