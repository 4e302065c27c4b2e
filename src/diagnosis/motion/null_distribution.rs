//! Null distribution of motions: the reduction of the prediction error by candidates where no effect is
//! missing.

use super::candidate::{Ranked, strength};
use super::screening::NullDraw;
use crate::null_distribution::excess;
use numeric::distribution::monte_carlo_p_value;
use numeric::statistics::quantile;

/// Null distribution. Candidates differ in what they gain by chance: a wave of any period gains much, others
/// little. Hence −ln(1 − gain) is divided by the 90 % quantile of each candidate, and the largest ratio of a
/// draw represents the whole library.
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
    /// Squared prediction error of the machine as described at left-out parts of each draw, in rising order.
    pub misfit: Vec<f64>,
}

/// Least scale of a candidate.
const LEAST_SCALE: f64 = 0.01;
/// Least ratio of a candidate's −ln(1 − gain) to its largest in any draw that counts as significant
/// regardless of other candidates.
const BEYOND: f64 = 1.25;

impl MotionNullDistribution {
    /// Builds the distribution from its draws. `free` marks free functions.
    pub(super) fn new(draws: &[NullDraw], free: &[bool]) -> Self {
        let of = |at: usize| draws.iter().map(move |draw| draw.gains[at]);
        let scales: Vec<f64> =
            (0..free.len()).map(|at| quantile(of(at), 0.9).unwrap_or(0.0).max(LEAST_SCALE)).collect();
        let most: Vec<f64> = (0..free.len()).map(|at| of(at).fold(0.0, f64::max)).collect();
        let largest = |of_free: bool| {
            let largest_ratio = |draw: &NullDraw| {
                let ratios = draw
                    .gains
                    .iter()
                    .zip(&scales)
                    .zip(free)
                    .filter(|(_, free)| **free == of_free)
                    .map(|((g, s), _)| g / s);
                ratios.fold(0.0, f64::max)
            };
            let mut all: Vec<f64> = draws.iter().map(largest_ratio).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let (effects, free) = (largest(false), largest(true));
        let mut misfit: Vec<f64> = draws.iter().map(|draw| draw.misfit).collect();
        misfit.sort_by(f64::total_cmp);
        MotionNullDistribution { scales, most, effects, free, misfit }
    }

    /// Returns the statistic of a candidate: −ln(1 − gain) over its scale.
    pub fn statistic(&self, ranked: &Ranked) -> f64 {
        strength(ranked.gain) / self.scales[ranked.candidate]
    }

    /// Returns the excess of a misfit.
    pub fn excess(&self, misfit: f64) -> f64 {
        excess(misfit, &self.misfit)
    }

    /// Returns the share of draws in which some effect gains as much; the least possible share where a
    /// candidate clearly exceeds its own largest gain.
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
            return monte_carlo_p_value(0, all.len());
        }
        let statistic = own / self.scales[ranked.candidate];
        monte_carlo_p_value(all.len() - all.partition_point(|x| *x < statistic), all.len())
    }
}
