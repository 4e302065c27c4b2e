//! Selection of an effect from a screening and its null simulations: significance, and the effects
//! indistinguishable from the best.

use super::candidate::Ranked;
use super::null_distribution::MotionNullDistribution;
use super::screening::MotionScreening;
use machine::Effect;
use numeric::distribution::t_quantile;

/// Largest p-value of a significant effect.
pub(super) const ALPHA: f64 = 0.005;
/// Gain that leaves so little that a larger p-value suffices, and that p-value.
pub(super) const NEARLY_ALL: f64 = 0.8;
pub(super) const RARE: f64 = 0.05;
/// Largest shortfall of the gain of an equally good effect, as a share of the best gain. Then the wider share
/// where left-out parts do not distinguish the two, and the level of that test (1), one-sided.
const EQUIVALENT: f64 = 0.1;
const POSSIBLY_EQUIVALENT: f64 = 0.3;
const ONE_SIDED: f64 = 0.9;
/// Largest prediction error of a rival over that of the best, regardless of that test.
const COMPARABLE: f64 = 3.0;
/// A rival by its fit without nuisance parameters: least gain over the best gain, least factor between their
/// shares of the misfit, and least share of the misfit.
const WITHOUT_NUISANCES: (f64, f64, f64) = (0.5, 2.0, 0.2);

/// A screening with its null distribution.
pub(super) struct SelectionStep {
    pub screening: MotionScreening,
    pub ranked: Vec<Ranked>,
    pub null: MotionNullDistribution,
    /// Whether extra measuring points were recorded.
    pub extra_points: bool,
    /// Whether inertia causes only a small share of the force.
    pub slow: bool,
    /// A nuisance parameter of implausible size, and that size in standard deviations.
    pub implausible: Option<(String, f64)>,
}

impl SelectionStep {
    pub fn id(&self, at: usize) -> &str {
        &self.screening.candidates[self.ranked[at].candidate].id
    }

    /// Returns the effect or released parameter that a ranked candidate adds to the model of the screening;
    /// for a free function its id.
    pub fn last_effect(&self, at: usize) -> &str {
        let candidate = &self.screening.candidates[self.ranked[at].candidate];
        candidate.hypothesis.as_ref().and_then(|h| h.effects.last()).unwrap_or(&candidate.id)
    }

    /// Returns the index of the best effect or released parameter among the ranked.
    pub fn best_effect(&self) -> Option<usize> {
        self.ranked.iter().position(|r| self.screening.candidates[r.candidate].free.is_none())
    }

    /// Whether the best effect is significant and gains the least that counts for it, given by its index
    /// among the ranked.
    pub fn significant(&self, least: impl Fn(usize) -> f64) -> bool {
        self.best_effect().is_some_and(|at| {
            let (gain, p) = (self.ranked[at].gain, self.null.p_value(&self.ranked[at]));
            (gain >= least(at) && p < ALPHA) || (self.extra_points && gain >= NEARLY_ALL && p < RARE)
        })
    }

    /// Returns the indices of the effects indistinguishable from the best, the best first. They explain as
    /// much with nuisance parameters or without, or only an extra measuring point distinguishes them.
    /// `reduction` gives the share of the misfit that the joint fit with an effect explains.
    pub fn indistinguishable(&self, effects: &[Effect], reduction: impl Fn(usize) -> f64) -> Vec<usize> {
        let Some(best) = self.best_effect() else { return Vec::new() };
        let most = &self.ranked[best];
        let equivalent = |r: &Ranked| {
            let losses: f64 = r.left_out.iter().sum::<f64>() / most.left_out.iter().sum::<f64>();
            // Where the prediction error is small, a small share of the gain is a large share of the error.
            let close = most.gain - r.gain <= EQUIVALENT * most.gain && losses < 1.0 + POSSIBLY_EQUIVALENT;
            close
                || (most.gain - r.gain <= POSSIBLY_EQUIVALENT * most.gain
                    && losses < COMPARABLE
                    && !is_surely_larger(&r.left_out, &most.left_out))
        };
        let known = self.confusable(effects, self.id(best));
        // A look-alike that explains nothing of these records does not look like it here.
        let confusable = |at: usize| self.ranked[at].gain > 0.0 && known.iter().any(|id| id == self.id(at));
        let without_nuisances = |at: usize| {
            let (share, times, least) = WITHOUT_NUISANCES;
            let gains =
                self.ranked[at].gain > share * most.gain && self.null.p_value(&self.ranked[at]) < ALPHA;
            gains && reduction(at) > (times * reduction(best)).max(least)
        };
        (best..self.ranked.len())
            .filter(|at| {
                self.screening.candidates[self.ranked[*at].candidate].free.is_none()
                    && (equivalent(&self.ranked[*at]) || confusable(*at) || without_nuisances(*at))
            })
            .collect()
    }

    /// Returns the effects that cannot be distinguished from an effect without an extra measuring point or
    /// acceleration, where these records lack it.
    fn confusable(&self, effects: &[Effect], id: &str) -> Vec<String> {
        let Some(effect) = effects.iter().find(|e| e.id == id) else { return Vec::new() };
        let lists =
            [(&effect.confusable_with, !self.extra_points), (&effect.confusable_with_slow, self.slow)];
        lists.into_iter().filter(|(_, is_lacking)| *is_lacking).flat_map(|(ids, _)| ids).cloned().collect()
    }

    /// Returns those of them that these records do not identify.
    pub fn confusable_unidentifiable(&self, effects: &[Effect], id: &str) -> Vec<String> {
        let unidentifiable =
            |other: &String| self.screening.candidates.iter().any(|c| c.unidentifiable && c.id == *other);
        self.confusable(effects, id).into_iter().filter(unidentifiable).collect()
    }

    /// Returns the free function with the largest reduction of the prediction error.
    pub fn best_free(&self) -> Option<&Ranked> {
        self.ranked.iter().find(|r| self.screening.candidates[r.candidate].free.is_some())
    }
}

/// Whether squared prediction errors of left-out parts are larger than others of the same parts, beyond the
/// scatter of their differences.
///
/// # Source  Student's test of paired differences, with one degree of freedom fewer than parts.
fn is_surely_larger(errors: &[f64], others: &[f64]) -> bool {
    let differences: Vec<f64> = errors.iter().zip(others).map(|(a, b)| a - b).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let spread = (differences.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt();
    !(mean < t_quantile(ONE_SIDED, differences.len().saturating_sub(1)) * spread)
}

/// Moves the effect with the fewest parameters to the front of those whose prediction error is within a few
/// percent of the best.
pub(super) fn simplest_first(
    screening: &MotionScreening,
    null: &MotionNullDistribution,
    ranked: &mut [Ranked],
) {
    let added = |r: &Ranked| {
        screening.candidates[r.candidate]
            .hypothesis
            .as_ref()
            .map(|h| h.added.len())
            .filter(|_| null.p_value(r) < ALPHA)
    };
    let Some(best) = ranked.iter().position(|r| added(r).is_some()) else { return };
    let reach = 1.0 - (1.0 + EQUIVALENT) * (1.0 - ranked[best].gain);
    let close = ranked.iter().enumerate().skip(best).filter(|(_, r)| r.gain >= reach && added(r).is_some());
    if let Some(at) = close.min_by_key(|(_, r)| added(r)).map(|(at, _)| at) {
        ranked[best..=at].rotate_right(1);
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use numeric::random::normal;

    /// Of errors with one mean, one tenth appears larger, whatever the number of parts.
    #[test]
    fn limit_equal_errors_appear_larger_at_the_level_of_the_test() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        for parts in [3, 6, 12, 40] {
            let draws = 20_000;
            let mut errors = || (0..parts).map(|_| 5.0 + normal(&mut random)).collect::<Vec<f64>>();
            let larger = (0..draws).filter(|_| is_surely_larger(&errors(), &errors())).count();
            assert!(
                (larger as f64 / f64::from(draws) - (1.0 - ONE_SIDED)).abs() < 0.007,
                "{larger} of {draws} with {parts} parts"
            );
        }
    }
}
