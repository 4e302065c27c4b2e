//! Ranking of the fitted candidates: their statistics, and which of them the data cannot distinguish.

use super::facts::{CandidateFacts, Facts, Model};
use super::policy::Policy;

/// A fitted candidate with its figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranked {
    /// Index among the candidates.
    pub at: usize,
    /// Reduction of χ² over its scale in null simulations and over the excess that the candidate leaves.
    pub statistic: f64,
    /// Share of null simulations whose largest statistic over all candidates is at least as large.
    pub p_value: f64,
}

/// Ranking of candidates by facts.
pub(super) struct Ranking<'f> {
    facts: &'f Facts,
    policy: &'f Policy,
    /// Fitted candidates, best first.
    pub tried: Vec<Ranked>,
    /// Indices of those that the data cannot distinguish from the best.
    pub same: Vec<usize>,
    /// Indices of those that fit as well but predict worse.
    pub rejected: std::ops::Range<usize>,
}

impl<'f> Ranking<'f> {
    /// Ranks the fitted candidates by χ² plus the cost of their parameters.
    pub fn of(facts: &'f Facts, policy: &'f Policy) -> Self {
        let is_fitted = |(_, candidate): &(usize, &CandidateFacts)| candidate.chi_square.is_some();
        let ranked = |(at, candidate): (usize, &CandidateFacts)| {
            let statistic =
                candidate.gain / facts.null.scale(&candidate.id) / facts.excess(candidate.chi_square());
            Ranked { at, statistic, p_value: facts.null.p_value(statistic) }
        };
        let tried = facts.candidates.iter().enumerate().filter(is_fitted).map(ranked).collect();
        let mut ranking = Ranking { facts, policy, tried, same: Vec::new(), rejected: 0..0 };
        let mut tried = std::mem::take(&mut ranking.tried);
        tried.sort_by(|a, b| ranking.criterion(a).total_cmp(&ranking.criterion(b)));
        // A fit that is hardly different from that of another effect comes first only if it is better by what
        // the data can tell.
        if let Some(best) = tried.first().filter(|best| ranking.candidate(best).is_limit) {
            let reach = ranking.criterion(best) + ranking.margin(ranking.candidate(best).chi_square());
            let is_near = |t: &Ranked| !ranking.candidate(t).is_limit && ranking.criterion(t) <= reach;
            if let Some(at) = tried.iter().position(is_near) {
                tried[..=at].rotate_right(1);
            }
        }
        ranking.tried = tried;
        ranking.set_apart();
        ranking
    }

    /// Moves those that the data cannot distinguish from the best to the front.
    fn set_apart(&mut self) {
        let same = self.indistinguishable();
        self.keep(same);
        let in_range = self.in_range();
        self.keep(in_range);
    }

    /// Leaves out the candidates before an index.
    pub fn lead_from(&mut self, at: usize) {
        if at > 0 {
            self.tried.drain(..at);
            self.set_apart();
        }
    }

    /// Returns the facts of a ranked candidate.
    pub fn candidate(&self, ranked: &Ranked) -> &'f CandidateFacts {
        &self.facts.candidates[ranked.at]
    }

    /// Returns the difference of χ² within which fits are indistinguishable from one with a χ².
    pub fn margin(&self, chi_square: f64) -> f64 {
        self.policy.equivalent * self.facts.excess(chi_square)
    }

    /// Returns χ² plus the cost of parameters; infinite for a candidate that does not reduce χ².
    fn criterion(&self, ranked: &Ranked) -> f64 {
        let candidate = self.candidate(ranked);
        if candidate.gain == 0.0 { f64::INFINITY } else { candidate.chi_square() + self.cost(ranked) }
    }

    /// Returns the number of parameters of a candidate. A fit that is hardly different from that of another effect counts
    /// one more.
    fn counted(&self, ranked: &Ranked) -> usize {
        self.candidate(ranked).added + usize::from(self.candidate(ranked).is_limit)
    }

    /// Returns what the parameters of a candidate cost in χ², in units of the misfit over null simulations: each as much
    /// as the difference within which fits are indistinguishable.
    ///
    /// # Source  for n = 8000 numbers, as FRFs have, the criterion of Schwarz, Annals of Statistics 6 (1978) 461–464:
    ///   χ² + k·ln n.
    fn cost(&self, ranked: &Ranked) -> f64 {
        let unit = self.facts.excess(self.candidate(ranked).chi_square());
        match self.policy.penalty {
            Some(penalty) => unit * penalty * self.facts.null.scale(&self.candidate(ranked).id),
            None => unit * self.counted(ranked) as f64 * self.policy.equivalent,
        }
    }

    /// Returns the indices of the candidates indistinguishable from the best, with no more parameters.
    fn indistinguishable(&self) -> Vec<usize> {
        let Some(first) = self.tried.first() else { return Vec::new() };
        let best = self.candidate(first);
        let (chi_square, excess) = (best.chi_square(), self.facts.excess(best.chi_square()));
        let of_model = self.policy.margin(self.policy.model_error * best.gain, chi_square, excess);
        let reach = self.criterion(first) + self.margin(chi_square) + of_model;
        let most = self.counted(first);
        let is_rival = |t: &Ranked| self.criterion(t) <= reach && self.counted(t) <= most;
        (0..self.tried.len()).filter(|at| is_rival(&self.tried[*at])).collect()
    }

    /// Moves what is kept as indistinguishable to the front.
    pub fn keep(&mut self, kept: Vec<usize>) {
        let others = (0..self.tried.len()).filter(|at| !kept.contains(at));
        let order: Vec<usize> = kept.iter().copied().chain(others).collect();
        (self.tried, self.same) =
            (order.iter().map(|at| self.tried[*at]).collect(), (0..kept.len()).collect());
    }

    /// Returns the indices of the candidates that the cost of their parameters ranks behind, though they fit as well as
    /// the best one.
    pub fn equal_fits(&self) -> Vec<usize> {
        let least = self.tried.iter().map(|t| self.candidate(t).chi_square()).fold(f64::INFINITY, f64::min);
        let fits = |at: &usize| {
            let candidate = self.candidate(&self.tried[*at]);
            !candidate.is_limit
                && candidate.gain > 0.0
                && candidate.chi_square() <= least + self.margin(least)
        };
        (0..self.tried.len()).filter(|at| !self.same.contains(at) && fits(at)).collect()
    }

    /// Adds to the set what fits as well as the best candidate and predicts held-out data decisively better than the first,
    /// by their losses.
    pub fn add_equal_fits(&mut self, held_out: impl Fn(&Ranked) -> Option<f64>) {
        let Some(first) = self.tried.first() else { return };
        let decisive = 2.0 * self.policy.decisive * self.facts.excess(self.candidate(first).chi_square());
        let is_worth = |at: &usize| {
            let losses = held_out(first).zip(held_out(&self.tried[*at]));
            losses.is_some_and(|(first, own)| own + decisive < first)
        };
        let more = self.equal_fits().into_iter().filter(is_worth);
        let all = self.same.iter().copied().chain(more).collect();
        self.keep(all);
        let in_range = self.in_range();
        self.keep(in_range);
    }

    /// Keeps, of equal fits, those that predict as well as the others. One is dropped whose predictive density is
    /// below that of another by the decisive factor and by more than a share of the other's improvement, which the
    /// error of the model may make, unless the other has parameters that cost as much. `loss` is that at left-out
    /// and, of FRFs, held-out data, `nominal` that of the nominal machine.
    pub fn keep_predictive(&mut self, nominal: f64, loss: impl Fn(&Ranked) -> Option<f64>) {
        let is_better = |ranked: &Ranked, own: f64, other: &Ranked| {
            let unit = self.facts.excess(self.candidate(other).chi_square());
            let cost = (self.cost(other) - self.cost(ranked)).max(0.0);
            loss(other).is_some_and(|loss| {
                let shortfall = self.policy.shortfall * (nominal - loss).max(0.0);
                let allowed = shortfall + 2.0 * self.policy.decisive * unit;
                loss + allowed + cost < own
            })
        };
        let all = || self.same.iter().map(|at| &self.tried[*at]);
        let stays = |at: &usize| {
            let ranked = &self.tried[*at];
            loss(ranked).is_none_or(|own| !all().any(|other| is_better(ranked, own, other)))
        };
        let (mut kept, dropped): (Vec<usize>, Vec<usize>) = self.same.iter().partition(|at| stays(at));
        let (count, all) = (kept.len(), self.same.len());
        kept.extend(dropped);
        self.keep(kept);
        self.same.truncate(count);
        self.rejected = count..all;
    }

    /// Returns the indistinguishable candidates without those that leave a joint at an end of its range which
    /// another of them moves beyond it: they need that joint to be as wrong, and something else besides.
    fn in_range(&self) -> Vec<usize> {
        let joints: Vec<&str> =
            self.same.iter().map(|at| self.candidate(&self.tried[*at]).id.as_str()).collect();
        let leaves = |at: &usize| {
            let candidate = self.candidate(&self.tried[*at]);
            candidate.at_end.iter().any(|id| joints.contains(&id.as_str()))
        };
        self.same.iter().copied().filter(|at| !leaves(at)).collect()
    }

    /// Returns the models whose cross-validation losses are compared: the nominal machine, the leading
    /// candidates, and generic impedances that fit better than one of these, which alone can explain the data
    /// better.
    pub fn compared(&self) -> Vec<Model> {
        let leading = &self.tried[..self.same.len().max(3).min(self.tried.len())];
        let worst =
            self.same.iter().map(|at| self.candidate(&self.tried[*at]).chi_square()).fold(0.0, f64::max);
        let impedances = self.facts.impedances.iter().enumerate().filter(|(_, c)| c.chi_square < worst);
        std::iter::once(Model::Nominal)
            .chain(leading.iter().map(|t| Model::Candidate(t.at)))
            .chain(impedances.map(|(at, _)| Model::Impedance(at)))
            .collect()
    }
}
