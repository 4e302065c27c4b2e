//! What is missing beside the chosen effects: a further effect, or one that describes one of them in more
//! detail.

use super::data_fault::Fault;
use super::fit::{Fitted, Fitter, IMPROVEMENT};
use super::hypothesis::Hypothesis;
use super::null_distribution::{NullDistribution, least_scale};
use super::parsimony::is_located_only;
use super::ranking::{EQUIVALENT, TriedEffect};
use super::screening::{Candidate, Screening, Status, hypotheses, is_plausible};
use super::search::{Effort, search};
use super::thresholds::Thresholds;
use identification::objective::ObjectiveError;
use long_work::Control;
use machine::{Effect, Machine};

/// Least statistic of a significant effect.
pub(super) const LEAST_STATISTIC: f64 = 2.5;
/// Number of generic impedances that locate a discrepancy.
pub(super) const LOCATIONS: usize = 5;

/// What a decision is made from.
pub(super) struct DecisionInputs<'e, 's> {
    pub fitter: &'e Fitter<'s>,
    pub limits: Thresholds,
    pub machine: &'e Machine,
    pub effects: &'e [Effect],
    pub screening: &'e Screening,
    /// What may be missing beside the best candidate, where that was sought.
    pub beside: Option<Screening>,
    pub tried: &'e [TriedEffect],
    pub null: &'e NullDistribution,
    pub count: f64,
    pub unknowns: usize,
    pub significant: bool,
    pub same: &'e [usize],
    /// Candidates that fit as well but are rejected by cross-validation.
    pub rejected: &'e [TriedEffect],
    pub located: &'e [Candidate],
    pub faulty: Option<Fault>,
    pub nominal_loss: f64,
    pub seed: u64,
    pub control: &'e Control,
}

impl DecisionInputs<'_, '_> {
    /// Returns the chosen machine with what explains most of its residual, if significant, and the fit.
    pub fn further(
        &self,
        chosen: &(Hypothesis, Fitted),
        beside: Screening,
    ) -> Result<Option<(Hypothesis, Fitted)>, ObjectiveError> {
        for (gain, more) in
            best(beside, self.effects, |chi_square| EQUIVALENT * self.null.excess(chi_square / self.count))
        {
            if self.is_accepted(chosen, gain, &more)? {
                return Ok(Some(more));
            }
        }
        Ok(None)
    }

    /// Whether a further addition with its gain explains a significant share of the residual, and more than
    /// an unnamed impedance does.
    fn is_accepted(
        &self,
        chosen: &(Hypothesis, Fitted),
        gain: f64,
        (hypothesis, fitted): &(Hypothesis, Fitted),
    ) -> Result<bool, ObjectiveError> {
        let DecisionInputs { fitter, limits, screening, null, count, seed, control, tried, .. } = self;
        let own = hypothesis.added.len() - chosen.0.added.len();
        let after = null.excess(fitted.chi_square / count);
        let last = hypothesis.effects.last().unwrap_or_default();
        // An effect without a reduction of its own has no scale in null simulations.
        let is_scaled = tried.iter().any(|t| t.candidate.id == last && t.statistic > 0.0);
        let scale =
            if is_scaled { null.scale(last) } else { least_scale(&fitter.objective(hypothesis)?, own) };
        let statistic = gain / scale / after;
        let least = if after <= limits.continue_from { limits.next_share.0 } else { limits.next_share.1 };
        let much =
            gain >= least * chosen.1.chi_square && gain >= limits.form_error * screening.base.chi_square;
        if !much || statistic < LEAST_STATISTIC || null.p_value(statistic) >= limits.alpha {
            return Ok(false);
        }
        if limits.calibrated {
            let effort = Effort { located: (LOCATIONS, own), searches: 1, seed: *seed };
            let (_, generic) = search(
                fitter,
                chosen.0.clone(),
                vec![chosen.1.clone()],
                (Vec::new(), Vec::new()),
                effort,
                control,
            )?;
            if is_located_only(own, fitted.chi_square, &generic, EQUIVALENT * after) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a candidate explains the data as well as the chosen model, which describes its effect in more
    /// detail: in the detail that the library has for it.
    pub fn reaches(&self, rival: &(Hypothesis, Fitted), chosen: &Fitted) -> Result<bool, ObjectiveError> {
        let reach = chosen.chi_square + EQUIVALENT * self.null.excess(chosen.chi_square / self.count);
        if rival.1.chi_square <= reach {
            return Ok(true);
        }
        let detail: Vec<Effect> = self
            .effects
            .iter()
            .filter(|e| e.refines.as_ref().is_some_and(|id| rival.0.effects.contains(id)))
            .cloned()
            .collect();
        if detail.is_empty() {
            return Ok(false);
        }
        let found = beside(self.fitter, self.machine, &detail, rival, self.seed, self.control)?;
        Ok(found.candidates.iter().map(Candidate::chi_square).fold(found.base.chi_square, f64::min) <= reach)
    }
}

/// Fits what may be missing beside the chosen effects. The search may also find a deeper minimum of the
/// chosen machine, which then was found once.
pub(super) fn beside(
    fitter: &Fitter<'_>,
    machine: &Machine,
    effects: &[Effect],
    chosen: &(Hypothesis, Fitted),
    seed: u64,
    control: &Control,
) -> Result<Screening, ObjectiveError> {
    let others: Vec<Effect> = effects.iter().filter(|e| !chosen.0.effects.contains(&e.id)).cloned().collect();
    let (apply, _) = hypotheses(fitter, machine, &chosen.0, &others, &[]);
    // Only the best candidate counts: how often a search found it is not asked.
    let effort = Effort { located: (0, 0), searches: 1, seed };
    let mut found =
        search(fitter, chosen.0.clone(), vec![chosen.1.clone()], (apply, Vec::new()), effort, control)?.0;
    let is_deeper = found.base.chi_square < chosen.1.chi_square - IMPROVEMENT;
    found.base = match is_deeper && is_plausible(&chosen.0, &found.base) {
        true => Fitted { found: 1, ..found.base },
        false => chosen.1.clone(),
    };
    for candidate in &mut found.candidates {
        candidate.gain = (found.base.chi_square - candidate.chi_square()).max(0.0);
    }
    Ok(found)
}

/// Returns the candidate with the largest gain, and its gain. Where an effect and one that refines a chosen
/// effect explain as much within a margin, which depends on their χ², the latter comes first, which claims
/// less, and the former second.
fn best(
    beside: Screening,
    effects: &[Effect],
    margin: impl Fn(f64) -> f64,
) -> Vec<(f64, (Hypothesis, Fitted))> {
    let known = Effect::unrefined(effects, &beside.nominal.effects).len();
    let fitted = beside
        .candidates
        .into_iter()
        .filter(|c| c.status == Status::Tried)
        .filter_map(|c| Some((c.gain, c.fitted?)));
    let refines = |hypothesis: &Hypothesis| Effect::unrefined(effects, &hypothesis.effects).len() == known;
    let (detail, others): (Vec<_>, Vec<_>) = fitted.partition(|(_, (hypothesis, _))| refines(hypothesis));
    let largest = |all: Vec<(f64, (Hypothesis, Fitted))>| all.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    match (largest(detail), largest(others)) {
        (Some(detail), Some(other)) if detail.0 + margin(detail.1.1.chi_square) >= other.0 => {
            vec![detail, other]
        }
        (detail, other) => other.or(detail).into_iter().collect(),
    }
}
