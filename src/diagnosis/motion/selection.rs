//! A survey beside its nulls: what is no accident, and what the best cannot be told from.

use super::diagnosis::{ALPHA, NEARLY_ALL, RARE};
use super::null_distribution::MotionNullDistribution;
use super::screening::{MotionScreening, Ranked};
use machine::Effect;

/// Share of the best gain within which another explains as much; a wider share where parts left out do not tell the two apart (90 %, one-sided).
const ALIKE: f64 = 0.1;
const PERHAPS: f64 = 0.3;
const APART: f64 = 1.36;
/// What another may leave of parts left out over what the best leaves: with more it is no rival, however few parts say so.
const COMPARABLE: f64 = 3.0;
/// Share of the best gain from which another is a rival whose fit without what is ordinary takes more of the misfit than the best one's, and how many
/// times as much; and the least share that counts.
const BY_ITSELF: (f64, f64, f64) = (0.5, 2.0, 0.2);

/// A survey with what nulls show of it.
pub(super) struct SelectionStep {
    pub survey: MotionScreening,
    pub ranked: Vec<Ranked>,
    pub null: MotionNullDistribution,
    /// Further points were recorded.
    pub further: bool,
    /// Inertia takes next to no force.
    pub slow: bool,
    /// What is ordinarily wrong that is not enough by far, and how many standard deviations of it would be.
    pub stretched: Option<(String, f64)>,
}

impl SelectionStep {
    pub fn id(&self, at: usize) -> &str {
        &self.survey.candidates[self.ranked[at].candidate].id
    }

    /// The best effect or release, by its place among the ranked.
    pub fn best_effect(&self) -> Option<usize> {
        self.ranked.iter().position(|r| self.survey.candidates[r.candidate].free.is_none())
    }

    /// Whether the best effect is no accident, and gains the least that counts of it.
    pub fn significant(&self, least: impl Fn(&str) -> f64) -> bool {
        self.best_effect().is_some_and(|at| {
            let (gain, p) = (self.ranked[at].gain, self.null.p_value(&self.ranked[at]));
            (gain >= least(self.id(at)) && p < ALPHA) || (self.further && gain >= NEARLY_ALL && p < RARE)
        })
    }

    /// Places of the effects that explain as much as the best, beside what is ordinarily wrong or by themselves, or are known to be told from it by a further
    /// point alone; the best first. `takes` is the share of the misfit that the fit of everything with one takes.
    pub fn class(&self, effects: &[Effect], takes: impl Fn(usize) -> f64) -> Vec<usize> {
        let Some(best) = self.best_effect() else { return Vec::new() };
        let most = &self.ranked[best];
        let alike = |r: &Ranked| {
            let behind: Vec<f64> = r.left_out.iter().zip(&most.left_out).map(|(a, b)| a - b).collect();
            let count = behind.len() as f64;
            let mean = behind.iter().sum::<f64>() / count;
            let spread = (behind.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt();
            let losses: f64 = r.left_out.iter().sum::<f64>() / most.left_out.iter().sum::<f64>();
            // Where little is left, a small share of the gain is much of what is left.
            let close = most.gain - r.gain <= ALIKE * most.gain && losses < 1.0 + PERHAPS;
            close || (most.gain - r.gain <= PERHAPS * most.gain && losses < COMPARABLE && mean < APART * spread)
        };
        let known = self.confusable(effects, self.id(best));
        let like = |at: usize| known.iter().any(|id| id == self.id(at));
        let by_itself = |at: usize| {
            let (share, times, least) = BY_ITSELF;
            let gains = self.ranked[at].gain > share * most.gain && self.null.p_value(&self.ranked[at]) < ALPHA;
            gains && takes(at) > (times * takes(best)).max(least)
        };
        (best..self.ranked.len())
            .filter(|at| {
                self.survey.candidates[self.ranked[*at].candidate].free.is_none()
                    && (alike(&self.ranked[*at]) || like(*at) || by_itself(*at))
            })
            .collect()
    }

    /// What an effect is known not to be told from without what these records lack: a further point, or acceleration.
    fn confusable(&self, effects: &[Effect], id: &str) -> Vec<String> {
        let Some(effect) = effects.iter().find(|e| e.id == id) else { return Vec::new() };
        let lists = [(&effect.confusable_with, !self.further), (&effect.confusable_with_slow, self.slow)];
        lists.into_iter().filter(|(_, lacks)| *lacks).flat_map(|(ids, _)| ids).cloned().collect()
    }

    /// The same of which these records show nothing of their own.
    pub fn confusable_unseen(&self, effects: &[Effect], id: &str) -> Vec<String> {
        let unseen = |other: &String| self.survey.candidates.iter().any(|c| c.unseen && c.id == *other);
        self.confusable(effects, id).into_iter().filter(unseen).collect()
    }

    /// The free shape that leaves least.
    pub fn best_free(&self) -> Option<&Ranked> {
        self.ranked.iter().find(|r| self.survey.candidates[r.candidate].free.is_some())
    }
}

/// Of effects that leave as much as the best but for a few percent, the one with the fewest parameters comes first.
pub(super) fn simplest_first(survey: &MotionScreening, null: &MotionNullDistribution, ranked: &mut [Ranked]) {
    let added = |r: &Ranked| survey.candidates[r.candidate].hypothesis.as_ref().map(|h| h.added.len()).filter(|_| null.p_value(r) < ALPHA);
    let Some(best) = ranked.iter().position(|r| added(r).is_some()) else { return };
    let reach = 1.0 - (1.0 + ALIKE) * (1.0 - ranked[best].gain);
    let close = ranked.iter().enumerate().skip(best).filter(|(_, r)| r.gain >= reach && added(r).is_some());
    if let Some(at) = close.min_by_key(|(_, r)| added(r)).map(|(at, _)| at) {
        ranked[best..=at].rotate_right(1);
    }
}
