//! A case: facts with the figures that several rules compare.
//!
//! A figure that rests on facts which were not gathered yet is asked for: [`Need`].

use super::data_kind::DataKind;
use super::facts::{
    Beside, CandidateFacts, ContradictingHeldOut, Facts, Farthest, ImpedanceFacts, Model, Of, of,
};
use super::null_distribution::least_scale;
use super::policy::Policy;
use super::ranking::{Ranked, Ranking};
use super::verdict::{Verdict, with_first};
use machine::EffectIds;
use numeric::statistics::log_sum_exp;

/// Facts that a rule asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Need {
    /// Cross-validation losses of models.
    LeftOut(Vec<Model>),
    /// What is missing beside a model.
    Beside(Model),
    /// Generic impedances in the place of what a search, by its index, found at this index.
    Impedances(usize, usize),
    /// χ² of a candidate in the detail that the library has for it.
    Detail(usize),
    /// Predictive densities of held-out data.
    HeldOut(Vec<Model>),
    /// Share of the held-out gap that a model closes.
    Closed(Model),
    /// Occam factors of models.
    Occam(Vec<Model>),
    /// The number of the machine that a model moves farthest.
    Farthest(Model),
    /// Whether a candidate leaves the fault of a held-out record.
    FaultHeldOut(Model),
    /// Whether all records were measured at one position.
    OnePosition,
    /// A fault of the measuring chain of all records.
    Chain,
    /// Records at each other's positions.
    Exchanged,
    /// Held-out motion records that contradict the fitted ones beside a model.
    ContradictingHeldOut(Model),
    /// Records that contradict the others.
    Contradiction,
    /// Why records are not those of one passive machine.
    Mismatch,
}

/// A figure, or the facts that it needs.
pub(super) type Asked<T> = Result<T, Need>;

/// The model that explains the data best so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// The model.
    pub model: Model,
    /// Its χ².
    pub chi_square: f64,
    /// Its effects.
    pub effects: EffectIds,
    /// Those that describe no other of them in more detail.
    pub names: EffectIds,
    /// Number of parameters that it adds to the machine as described.
    pub added: usize,
}

/// How well the named model, or a set of models of which one is named, predicts held-out data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Confirmation {
    /// Logarithm of its predictive density over that of the nominal machine, and of a rival, in units of its
    /// misfit over null simulations.
    pub over_nominal: f64,
    pub over_rival: Option<f64>,
}

/// A case to be judged.
pub(super) struct Case<'f> {
    pub facts: &'f Facts,
    pub policy: &'f Policy,
    pub ranking: Ranking<'f>,
    /// Cross-validation loss of the nominal machine.
    pub nominal_loss: f64,
    /// Excess of the nominal machine.
    pub before: f64,
    /// The best candidate, where it is significant.
    pub significant: Option<Ranked>,
}

impl Chosen {
    /// Returns the machine as described.
    pub(super) fn nominal(facts: &Facts) -> Self {
        let none = EffectIds::default;
        Chosen {
            model: Model::Nominal,
            chi_square: facts.chi_square,
            effects: none(),
            names: none(),
            added: 0,
        }
    }

    /// Returns the model of a candidate, by its index.
    pub(super) fn candidate(candidate: &CandidateFacts, at: usize) -> Self {
        Chosen::with(candidate, Model::Candidate(at), &candidate.effects)
    }

    fn with(candidate: &CandidateFacts, model: Model, names: &[String]) -> Self {
        let [effects, names] = [&candidate.effects[..], names].map(combination);
        Chosen { model, chi_square: candidate.chi_square(), effects, names, added: candidate.added }
    }
}

/// Returns the combination of some ids.
fn combination(ids: &[String]) -> EffectIds {
    ids.iter().fold(EffectIds::default(), |all, id| all.with(id))
}

/// Returns a figure of a model, or asks for it.
fn asked<T>(all: &[Of<T>], model: Model, need: impl FnOnce(Model) -> Need) -> Asked<&T> {
    of(all, model).ok_or_else(|| need(model))
}

/// Whether held-out data decide what leads: null simulations do not bound the error of the model, which a fit may take up.
fn held_out_decide(facts: &Facts, policy: &Policy) -> bool {
    !policy.bounded && policy.calibrated && !facts.in_sample && facts.holds_out
}

/// Whether held-out data contradict a model: they are for certain predicted worse than by the one without its last
/// addition, though it fits better, with a χ².
fn is_contradicted((facts, policy): (&Facts, &Policy), models: [Model; 2], chi_square: f64) -> Asked<bool> {
    if !held_out_decide(facts, policy) {
        return Ok(false);
    }
    let [Some(before), Some(after)] = models.map(|model| of(&facts.held_out_loss, model)) else {
        return Err(Need::HeldOut(models.to_vec()));
    };
    Ok(*after > *before + 2.0 * policy.decisive * facts.excess(chi_square))
}

impl<'f> Case<'f> {
    /// Ranks the candidates of a case.
    pub fn new(facts: &'f Facts, policy: &'f Policy) -> Asked<Self> {
        let mut ranking = Self::ranked(facts, policy)?;
        let compared = ranking.compared();
        if compared.iter().any(|model| of(&facts.left_out, *model).is_none()) {
            return Err(Need::LeftOut(compared));
        }
        let nominal_loss = facts.left_out(Model::Nominal).unwrap_or(f64::MAX);
        if !facts.in_sample {
            let uses_held_out = facts.holds_out && policy.calibrated;
            let equal = if policy.calibrated { ranking.equal_fits() } else { Vec::new() };
            let asked = ranking.same.iter().chain(&equal).map(|at| Model::Candidate(ranking.tried[*at].at));
            let models: Vec<Model> = std::iter::once(Model::Nominal).chain(asked).collect();
            let is_missing = |model: &Model| {
                of(&facts.left_out, *model).is_none()
                    || (uses_held_out && of(&facts.held_out_loss, *model).is_none())
            };
            if models.len() > 2 && models.iter().any(is_missing) {
                let is_left_out = |model: &Model| of(&facts.left_out, *model).is_some();
                return Err(match models.iter().all(is_left_out) {
                    true => Need::HeldOut(models),
                    false => Need::LeftOut(models),
                });
            }
            let held_out = |model: Model| of(&facts.held_out_loss, model).filter(|_| uses_held_out).copied();
            if policy.calibrated {
                ranking.add_equal_fits(|ranked| held_out(Model::Candidate(ranked.at)));
            }
            let total = |model: Model| Some(facts.left_out(model)? + held_out(model).unwrap_or(0.0));
            let nominal = total(Model::Nominal).unwrap_or(f64::MAX);
            ranking.keep_predictive(nominal, |ranked| total(Model::Candidate(ranked.at)));
        }
        let before = facts.before();
        let mut case = Case { facts, policy, ranking, nominal_loss, before, significant: None };
        // Of equal fits those count that are significant.
        let is_significant = |at: &usize| case.is_significant(&case.ranking.tried[*at]);
        let significant: Vec<usize> = case.ranking.same.iter().copied().filter(is_significant).collect();
        if !significant.is_empty() {
            case.ranking.keep(significant);
            case.significant = case.ranking.tried.first().copied();
        }
        Ok(case)
    }

    /// Ranks the candidates. Where held-out data decide, of those rare in null simulations the first leads that they do not
    /// contradict; before it the first that closes more than half of their gap, since tolerances may take most of an effect.
    fn ranked(facts: &'f Facts, policy: &'f Policy) -> Asked<Ranking<'f>> {
        let mut ranking = Ranking::of(facts, policy);
        if !held_out_decide(facts, policy) {
            return Ok(ranking);
        }
        let is_rare = |t: &Ranked| {
            t.p_value < policy.alpha && facts.candidates[t.at].gain >= policy.least_share * facts.chi_square
        };
        let (mut first, mut closing) = (None, None);
        for (at, ranked) in ranking.tried.iter().enumerate().filter(|(_, ranked)| is_rare(ranked)) {
            let model = Model::Candidate(ranked.at);
            let chi_square = facts.candidates[ranked.at].chi_square();
            if is_contradicted((facts, policy), [Model::Nominal, model], chi_square)? {
                continue;
            }
            let closed = *asked(&facts.closed, model, Need::Closed)?;
            first = first.or(Some(at));
            closing = closing.or(closed.filter(|closed| *closed > 1.0 - policy.unexplained).map(|_| at));
        }
        if let Some(at) = closing.or(first) {
            ranking.lead_from(at);
        }
        Ok(ranking)
    }

    /// Whether a candidate is significant: rarer in null simulations than may be by chance, and not small. With an excess
    /// of one it must also improve the prediction of left-out positions.
    fn is_significant(&self, ranked: &Ranked) -> bool {
        let Policy { alpha, least_share, .. } = *self.policy;
        let loss = self.facts.left_out(Model::Candidate(ranked.at));
        let predicts = loss.is_none_or(|loss| loss < self.nominal_loss);
        let is_small = self.ranking.candidate(ranked).gain < least_share * self.facts.chi_square;
        !is_small && ranked.p_value < alpha && (predicts || self.before > 1.0)
    }

    /// Whether the misfit, or what it needs of a tolerance, asks for an explanation.
    pub fn needs_explanation(&self) -> Asked<bool> {
        let is_large = self.significant.is_some() || self.before > self.policy.excess;
        Ok(is_large || self.implausible(Model::Nominal)?.is_some())
    }

    /// Returns the best significant candidate.
    pub fn best(&self) -> Option<&'f CandidateFacts> {
        self.significant.as_ref().map(|best| self.ranking.candidate(best))
    }

    /// Whether the best effect leaves no more than null simulations do.
    pub fn agrees_with_best(&self) -> bool {
        self.best().is_some_and(|best| self.facts.excess(best.chi_square()) <= self.policy.excess)
    }

    /// Returns the interface of the best generic impedance.
    pub fn impedance_place(&self) -> &'f str {
        self.facts.best_impedance().map_or("?", |(_, best)| best.interface.as_str())
    }

    /// Returns the shape of the best generic impedance.
    pub fn impedance_shape(&self) -> &'f str {
        self.facts.best_impedance().map_or("impedance", |(_, best)| best.shape.as_str())
    }

    /// Returns the chosen model: the best candidate, with further effects, and what refines them, as long as
    /// each explains a significant share of the residual.
    pub fn chosen(&self) -> Asked<Chosen> {
        let best = self.ranking.tried[0];
        let candidate = self.ranking.candidate(&best);
        let mut chosen = Chosen::candidate(candidate, best.at);
        let continues = |chosen: &Chosen| self.facts.excess(chosen.chi_square) > self.policy.continue_from;
        while continues(&chosen) && chosen.names.len() < self.policy.most_effects {
            let search = self.facts.beside.iter().position(|beside| beside.of == chosen.model);
            let search = search.ok_or(Need::Beside(chosen.model))?;
            let beside = &self.facts.beside[search];
            chosen.chi_square = beside.chi_square;
            if beside.is_deeper {
                chosen.model = Model::Deeper(search);
            }
            if !continues(&chosen) {
                break;
            }
            let Some(at) = self.further(&chosen, (search, beside))? else { break };
            let more = &beside.candidates[at];
            chosen = Chosen::with(more, Model::With(search, at), &more.names);
        }
        Ok(chosen)
    }

    /// Returns the tolerance that a model moves farthest, if farther than tolerances are.
    pub fn implausible(&self, model: Model) -> Asked<Option<&'f Farthest>> {
        if self.policy.implausible == f64::MAX {
            return Ok(None);
        }
        Ok(self.farthest(model)?.filter(|farthest| farthest.deviation.abs() > self.policy.implausible))
    }

    /// Returns the index of what explains most of the residual beside the chosen effects, if significant.
    fn further(&self, chosen: &Chosen, (search, beside): (usize, &Beside)) -> Asked<Option<usize>> {
        for at in self.most_promising(chosen, beside) {
            if self.is_accepted(chosen, (search, at), &beside.candidates[at])? {
                return Ok(Some(at));
            }
        }
        Ok(None)
    }

    /// Returns the candidate with the largest gain. Where an effect and one that refines a chosen effect
    /// explain as much within what the data can tell, the latter comes first, which claims less, and the
    /// former second.
    fn most_promising(&self, chosen: &Chosen, beside: &Beside) -> Vec<usize> {
        let gain = |at: &usize| beside.candidates[*at].gain;
        let known = chosen.names.len();
        let fitted = (0..beside.candidates.len()).filter(|at| beside.candidates[*at].chi_square.is_some());
        let (detail, others): (Vec<usize>, Vec<usize>) =
            fitted.partition(|at| beside.candidates[*at].names.len() == known);
        let largest = |all: Vec<usize>| all.into_iter().max_by(|a, b| gain(a).total_cmp(&gain(b)));
        match (largest(detail), largest(others)) {
            (Some(detail), Some(other))
                if gain(&detail) + self.ranking.margin(beside.candidates[detail].chi_square())
                    >= gain(&other) =>
            {
                vec![detail, other]
            }
            (detail, other) => other.or(detail).into_iter().collect(),
        }
    }

    /// Whether a further addition explains a significant share of the residual, and more than an unnamed
    /// impedance does.
    fn is_accepted(
        &self,
        chosen: &Chosen,
        (search, at): (usize, usize),
        more: &CandidateFacts,
    ) -> Asked<bool> {
        let Case { facts, policy, .. } = self;
        let own = more.added - chosen.added;
        let after = facts.excess(more.chi_square());
        // An effect without a reduction of its own has no scale in null simulations.
        let is_scaled =
            self.ranking.tried.iter().any(|t| facts.candidates[t.at].id == more.id && t.statistic > 0.0);
        let scale = if is_scaled { facts.null.scale(&more.id) } else { least_scale(facts.data, own) };
        let statistic = more.gain / scale / after;
        let least = if after <= policy.continue_from { policy.next_share_last } else { policy.next_share };
        let is_much = more.gain >= least * chosen.chi_square;
        if !is_much || facts.null.p_value(statistic) >= policy.alpha {
            return Ok(false);
        }
        let models = [chosen.model, Model::With(search, at)];
        if is_contradicted((facts, policy), models, more.chi_square())? {
            return Ok(false);
        }
        if !policy.calibrated {
            return Ok(true);
        }
        let impedances = more.impedances.as_ref().ok_or(Need::Impedances(search, at))?;
        Ok(!self.is_located_only(own, more.chi_square(), impedances))
    }

    /// Whether a generic impedance accounts for what a further effect explains beside the first: with no more
    /// parameters than that effect adds it fits better, or it fits as well where each parameter that it saves
    /// counts as much as a difference that the data can tell. What is missing beside the first effect then
    /// has a place, but no name.
    fn is_located_only(&self, added: usize, chi_square: f64, impedances: &[ImpedanceFacts]) -> bool {
        let margin = self.ranking.margin(chi_square);
        let explains = |c: &ImpedanceFacts| {
            c.parameters <= added
                && c.chi_square + margin < chi_square + margin * (added - c.parameters) as f64
        };
        impedances.iter().any(explains)
    }

    /// Returns the combinations that the data cannot distinguish from the chosen one: alternatives of the
    /// first effect are alternatives in the combination, too.
    pub fn alternatives(&self, chosen: &Chosen) -> Asked<Vec<EffectIds>> {
        let is_detailed = chosen.effects.len() != chosen.names.len();
        let reach = chosen.chi_square + self.ranking.margin(chosen.chi_square);
        let mut found = Vec::new();
        for at in self.ranking.same.iter().map(|at| self.ranking.tried[*at].at) {
            let candidate = &self.facts.candidates[at];
            if candidate.released.is_some() || chosen.names.after_first().contains(&candidate.id) {
                continue;
            }
            // The chosen model may describe its effect in more detail: so may a rival.
            let is_rival = is_detailed
                && candidate.effects.first().map(String::as_str) != chosen.names.first()
                && candidate.chi_square() > reach;
            if !is_rival || candidate.chi_square_in_detail.ok_or(Need::Detail(at))? <= reach {
                found.push(with_first(&candidate.id, &chosen.names));
            }
        }
        if let Some(first) =
            self.facts.candidates.iter().find(|c| chosen.names.first() == Some(c.id.as_str()))
        {
            let more = first.resembles.iter().map(|id| with_first(id, &chosen.names));
            let more: Vec<EffectIds> = more.filter(|ids| !found.contains(ids)).collect();
            if !more.is_empty() && found.is_empty() {
                found.push(chosen.names.clone());
            }
            found.extend(more);
        }
        Ok(found)
    }

    /// Returns the cross-validation loss of the chosen model; `None` where it cannot be computed.
    pub fn loss(&self, chosen: &Chosen) -> Asked<Option<f64>> {
        asked(&self.facts.left_out, chosen.model, |model| Need::LeftOut(vec![model])).copied()
    }

    /// Returns a generic impedance that fits better than a chosen model and predicts left-out data far better; `None`
    /// where none does, or the candidates are judged by the fitted data alone.
    pub fn predicts_far_better(&self, chosen: &Chosen) -> Asked<Option<&'f ImpedanceFacts>> {
        let Policy { left_out_generic, shortfall, calibrated, .. } = *self.policy;
        let Some(loss) = self.loss(chosen)?.filter(|_| !self.facts.in_sample) else { return Ok(None) };
        // Modes give few numbers at left-out positions: allow a share of the improvement, as for effects.
        let of_improvement = if calibrated { 0.0 } else { shortfall };
        let margin = |own: f64| {
            self.ranking.margin(chosen.chi_square) + of_improvement * (self.nominal_loss - own).max(0.0)
        };
        let is_better = |(at, impedance): &(usize, &ImpedanceFacts)| {
            impedance.chi_square < chosen.chi_square
                && self
                    .facts
                    .left_out(Model::Impedance(*at))
                    .is_some_and(|own| own < left_out_generic * loss && own < loss - margin(own))
        };
        Ok(self.facts.impedances.iter().enumerate().find(is_better).map(|(_, impedance)| impedance))
    }

    /// Whether a model leaves the fault of a held-out record.
    pub fn leaves_held_out_fault(&self, model: Model) -> Asked<bool> {
        asked(&self.facts.fault_held_out_remains, model, Need::FaultHeldOut).copied()
    }

    /// Returns the held-out motion records that contradict the fitted ones beside a model.
    pub fn contradicting_held_out(&self, model: Model) -> Asked<&'f ContradictingHeldOut> {
        asked(&self.facts.contradicting_held_out, model, Need::ContradictingHeldOut)
    }

    /// Returns the share of the held-out gap that a model closes.
    pub fn closed(&self, model: Model) -> Asked<Option<f64>> {
        asked(&self.facts.closed, model, Need::Closed).copied()
    }

    /// Returns the number of the machine that a model moves farthest from its description.
    pub fn farthest(&self, model: Model) -> Asked<Option<&'f Farthest>> {
        Ok(asked(&self.facts.farthest, model, Need::Farthest)?.as_ref())
    }

    /// Returns the models of what a verdict names: the chosen one, and those of further single effects.
    pub fn named(&self, verdict: &Verdict, chosen: &Chosen) -> Vec<Model> {
        let is_named = |t: &&Ranked| {
            let id = EffectIds::single(&self.ranking.candidate(t).id);
            verdict.effects.iter().skip(1).any(|ids| *ids == id)
        };
        let others = self.ranking.tried.iter().filter(is_named).map(|t| Model::Candidate(t.at));
        std::iter::once(chosen.model).chain(others).collect()
    }

    /// Returns the generic impedance that fits best, where it fits better than the chosen model. Free functions of a
    /// motion are fitted without the machine's nonlinear parameters: the one that predicts left-out parts best, where
    /// it does so better.
    fn rival(&self, chosen: &Chosen) -> Asked<Option<Model>> {
        if self.facts.data != DataKind::Motion {
            let best = self.facts.best_impedance().filter(|(_, best)| best.chi_square < chosen.chi_square);
            return Ok(best.map(|(at, _)| Model::Impedance(at)));
        }
        let all: Vec<Model> = (0..self.facts.impedances.len()).map(Model::Impedance).collect();
        if all.iter().any(|model| of(&self.facts.left_out, *model).is_none()) {
            return Err(Need::LeftOut(all));
        }
        let own = self.loss(chosen)?.unwrap_or(f64::MAX);
        let losses = all.into_iter().filter_map(|model| Some((self.facts.left_out(model)?, model)));
        let best = losses.filter(|(loss, _)| *loss < own).min_by(|a, b| a.0.total_cmp(&b.0));
        Ok(best.map(|(_, model)| model))
    }

    /// Compares the named models with the nominal machine, and with a rival that fits better, at held-out
    /// data. Where one of several is named, each is as probable as the others, and the mean of their
    /// predictive densities counts. `None` where nothing is held out.
    ///
    /// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, §28: the evidence of a
    ///   hypothesis is the mean over its parts.
    pub fn confirmed(&self, verdict: &Verdict, chosen: &Chosen) -> Asked<Option<Confirmation>> {
        if !self.facts.holds_out {
            return Ok(None);
        }
        let rival = self.rival(chosen)?;
        let models: Vec<Model> =
            std::iter::once(Model::Nominal).chain(rival).chain(self.named(verdict, chosen)).collect();
        let losses: Option<Vec<f64>> =
            models.iter().map(|model| of(&self.facts.held_out_loss, *model).copied()).collect();
        let losses = losses.ok_or(Need::HeldOut(models))?;
        let excess = self.facts.excess(chosen.chi_square);
        let log_densities: Vec<f64> = losses.iter().map(|loss| -0.5 * loss / excess).collect();
        let (others, named) = log_densities.split_at(1 + usize::from(rival.is_some()));
        let over = |other: &f64| log_mean_exp(named) - other;
        Ok(Some(Confirmation { over_nominal: over(&others[0]), over_rival: others.get(1).map(over) }))
    }

    /// Whether held-out data speak for the named models for certain: they predict them better than the
    /// nominal machine, and no rival predicts them better.
    pub fn is_certain(&self, found: Confirmation) -> bool {
        let Policy { decisive, advantage, .. } = *self.policy;
        let allowed = decisive.max(advantage * found.over_nominal);
        found.over_nominal >= decisive && found.over_rival.is_none_or(|rival| rival >= -allowed)
    }
}

/// Computes ln of the mean of numbers given by their logarithms.
fn log_mean_exp(logarithms: &[f64]) -> f64 {
    log_sum_exp(logarithms) - (logarithms.len() as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_one_of_several_costs_at_most_their_number() {
        assert_eq!(log_mean_exp(&[-3000.0]), -3000.0);
        assert!((log_mean_exp(&[-3000.0, -3000.0, -3000.0]) + 3000.0).abs() < 1e-12);
        assert!((log_mean_exp(&[-3000.0, -3100.0]) + 3000.0 + 2.0_f64.ln()).abs() < 1e-12);
    }
}
