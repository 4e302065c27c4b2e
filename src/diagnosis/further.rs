//! What is missing beside the chosen effects: a further effect, or one that describes one of them in more detail.

use super::data_fault::Fault;
use super::fit::{Fitted, Fitter};
use super::hypothesis::Hypothesis;
use super::null_distribution::{LEAST_SCALE, NullDistribution};
use super::parsimony::is_located_only;
use super::ranking::{EQUIVALENT, TriedEffect};
use super::screening::{Candidate, Screening, Status, hypotheses};
use super::search::{Effort, search};
use super::thresholds::Thresholds;
use identification::objective::ObjectiveError;
use machine::{Effect, Machine};
use optimizer::Control;

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
    pub fn further(&self, chosen: &(Hypothesis, Fitted), beside: Screening) -> Result<Option<(Hypothesis, Fitted)>, ObjectiveError> {
        let DecisionInputs { fitter, limits, screening, null, count, seed, control, tried, .. } = self;
        let Some((gain, (hypothesis, fitted))) = best(beside, self.effects, |chi_square| EQUIVALENT * null.excess(chi_square / count))
        else {
            return Ok(None);
        };
        let after = null.excess(fitted.chi_square / count);
        let last = hypothesis.effects.last().unwrap_or_default();
        // An effect without a reduction of its own has no scale in null simulations.
        let scale = if tried.iter().any(|t| t.candidate.id == last && t.statistic > 0.0) { null.scale(last) } else { LEAST_SCALE };
        let statistic = gain / scale / after;
        let least = if after <= limits.continue_from { limits.next_share.0 } else { limits.next_share.1 };
        let much = gain >= least * chosen.1.chi_square && gain >= limits.form_error * screening.base.chi_square;
        if !much || statistic < LEAST_STATISTIC || null.p_value(statistic) >= limits.alpha {
            return Ok(None);
        }
        if limits.calibrated {
            let own = hypothesis.added.len() - chosen.0.added.len();
            let effort = Effort { located: (LOCATIONS, own), searches: 1, seed: *seed };
            let (_, generic) = search(fitter, chosen.0.clone(), vec![chosen.1.clone()], (Vec::new(), Vec::new()), effort, control)?;
            if is_located_only(own, fitted.chi_square, &generic, EQUIVALENT * after) {
                return Ok(None);
            }
        }
        Ok(Some((hypothesis, fitted)))
    }
}

/// Fits what may be missing beside the chosen effects. The search may also find a deeper minimum of the chosen machine.
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
    Ok(search(fitter, chosen.0.clone(), vec![chosen.1.clone()], (apply, Vec::new()), effort, control)?.0)
}

/// Returns the candidate with the largest gain, and its gain. Where an effect and one that refines a chosen effect explain as much within a margin, which
/// depends on their χ², it is the latter, which claims less.
fn best(beside: Screening, effects: &[Effect], margin: impl Fn(f64) -> f64) -> Option<(f64, (Hypothesis, Fitted))> {
    let known = Effect::unrefined(effects, &beside.nominal.effects).len();
    let fitted = beside.candidates.into_iter().filter(|c| c.status == Status::Tried).filter_map(|c| Some((c.gain, c.fitted?)));
    let refines = |hypothesis: &Hypothesis| Effect::unrefined(effects, &hypothesis.effects).len() == known;
    let counted =
        |(gain, (hypothesis, fit)): &(f64, (Hypothesis, Fitted))| gain + if refines(hypothesis) { margin(fit.chi_square) } else { 0.0 };
    fitted.max_by(|a, b| counted(a).total_cmp(&counted(b)))
}
