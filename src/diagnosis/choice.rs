//! Choice of a verdict from the figures of all candidates.

use super::cross_validation::cross_validation;
use super::fit::{Ablation, Fitted, values_of};
use super::further::{DecisionInputs, beside};
use super::hypothesis::{Hypothesis, HypothesisKind};
use super::null_distribution::LEAST_SCALE;
use super::one_machine::impossible_number;
use super::parsimony::{NamedFit, more_parsimonious};
use super::ranking::{EQUIVALENT, SHORTFALL, TriedEffect};
use super::screening::Candidate;
use super::verdict::{
    NEXT_AT_LOCATION, Verdict, VerdictKind, frozen_text, impedance_of, p_value_text, percent_text, with_first,
};
use identification::objective::ObjectiveError;
use machine::{Effect, EffectIds};

/// Least statistic of a significant generic impedance, which has no scale of its own in null simulations.
const LEAST_GENERIC: f64 = 16.0;
/// Largest number of combined effects.
const MAX_EFFECTS: usize = 3;
/// Excess above which an effect is missing.
pub(super) const EXCESS: f64 = 2.0;
/// Excess above which an effect is missing even if no candidate is significant, and beside one that needs an
/// impossible machine.
const LARGE_EXCESS: f64 = 5.0;
/// Least share of χ² by which a released parameter must reduce it to be the only error.
const RELEASE_REDUCTION: f64 = 0.75;
/// Least share of χ² by which an effect must reduce it where a large excess remains: one that no generic
/// impedance matches, and any other.
const LEAST_REDUCTION: (f64, f64) = (0.4, 0.5);
/// Excess above which a named effect is compared with the best generic impedance.
const DOUBTFUL_EXCESS: f64 = 1.5;
/// Ratio of the excess of a generic impedance to that of the named effect below which the generic impedance
/// is the better explanation.
const GENERIC_BETTER: f64 = 0.7;
/// Largest cross-validation loss of a named effect over that of the nominal machine. Second, the ratio of the
/// loss of a better fitting generic impedance to that of the effect below which the generic impedance is the
/// better explanation.
const PREDICTION: (f64, f64) = (1.02, 0.65);
/// Largest excess with which a released parameter is the only error.
const RELEASE_EXCESS: f64 = 4.0;

/// Decides on a verdict, and returns the chosen model.
pub(super) fn decide(
    inputs: &DecisionInputs<'_, '_>,
) -> Result<(Verdict, (Hypothesis, Fitted)), ObjectiveError> {
    let DecisionInputs { limits, screening, tried, null, count, same, located, .. } = inputs;
    let nominal = (screening.nominal.clone(), screening.base.clone());
    let before = null.excess(screening.base.chi_square / count);
    let unknown =
        |reason: String| Verdict::new(VerdictKind::Unknown, reason, Some(NEXT_AT_LOCATION.to_string()));
    if *count <= inputs.unknowns as f64 {
        let reason = format!(
            "{count} numbers were measured for {} unknown parameters: any model would fit",
            inputs.unknowns
        );
        let next = Some("measure more modes, more positions, or a whole FRF at each position".to_string());
        return Ok((Verdict::new(VerdictKind::Insufficient, reason, next), nominal));
    }
    if let Some(fault) = inputs.faulty.filter(|fault| fault.is_certain()) {
        let (reason, next) = fault.fault_text(inputs.fitter.fit.set());
        let faults = fault.ids(inputs.fitter.fit.set());
        return Ok((Verdict { faults, ..Verdict::new(fault.verdict_kind(), reason, Some(next)) }, nominal));
    }
    // A generic impedance has no scale of its own in null simulations: it needs a clear reduction of χ².
    let generic = located
        .iter()
        .filter(|c| c.fitted.is_some())
        .min_by(|a, b| a.chi_square().total_cmp(&b.chi_square()));
    let generic_place = generic.and_then(impedance_of).map_or("?", |(interface, _)| interface);
    let generic_excess = generic.map_or(f64::INFINITY, |c| null.excess(c.chi_square() / count));
    let scale = null.scales.iter().map(|s| s.1).fold(3.0 * LEAST_SCALE, f64::max);
    let generic_statistic = generic.map_or(0.0, |c| c.gain / scale / generic_excess);
    if !inputs.significant {
        let clear = generic_statistic > LEAST_GENERIC && null.p_value(generic_statistic) < limits.alpha;
        if generic.is_some() && (clear || before > LARGE_EXCESS) {
            let reason = format!(
                "the misfit is {before:.1} times that of null simulations and no effect of the library explains it; a generic impedance at \
                 {generic_place} reduces χ² most"
            );
            return Ok((unknown(reason), nominal));
        }
        let best = tried.iter().max_by(|a, b| a.statistic.total_cmp(&b.statistic));
        let worse = |t: &TriedEffect| {
            t.p_value < limits.cv_alpha
                && t.candidate.left_out.is_some_and(|loss| loss >= inputs.nominal_loss)
        };
        let remark = |t: &TriedEffect| {
            if worse(t) { "; it does not improve the prediction of left-out positions" } else { "" }
        };
        let best = best.map_or("none".to_string(), |t| {
            format!("{}, {}{}", t.candidate.id, p_value_text(t.p_value), remark(t))
        });
        let reason = format!(
            "the residual is consistent with null simulations of this machine and layout (most significant candidate: {best})"
        );
        return Ok((Verdict::new(VerdictKind::None, reason, None), nominal));
    }
    let best = &tried[0];
    let release = tried.iter().find(|t| {
        let is = t.candidate.fitted.as_ref().is_some_and(|f| f.0.kind == HypothesisKind::Release);
        let clear = t.candidate.chi_square() <= (1.0 - RELEASE_REDUCTION) * screening.base.chi_square
            || null.excess(t.candidate.chi_square() / count) <= RELEASE_EXCESS;
        is && clear && t.candidate.gain >= 0.85 * best.candidate.gain
    });
    if let Some((found, (hypothesis, fitted))) = release.and_then(|t| Some((t, t.candidate.fitted.as_ref()?)))
    {
        let (id, parameter) = (&found.candidate.id, &hypothesis.machine.parameters[hypothesis.added[0]]);
        let estimate = values_of(hypothesis, fitted)[hypothesis.added[0]];
        let share = percent_text(100.0 * found.candidate.gain / screening.base.chi_square);
        let reason =
            format!("{} reduces χ² by {share}: no effect is needed", frozen_text(parameter, estimate));
        return Ok((Verdict::wrong_parameter(id, reason), (hypothesis.clone(), fitted.clone())));
    }
    let Some(mut chosen) = best.candidate.fitted.clone() else {
        let reason =
            format!("no candidate could be fitted; the misfit is {before:.1} times that of null simulations");
        return Ok((Verdict::new(VerdictKind::Unknown, reason, None), nominal));
    };
    let mut names = chosen.0.effects.clone();
    let excess = |chosen: &(Hypothesis, Fitted)| null.excess(chosen.1.chi_square / count);
    // Add effects, and what refines them, as long as each explains a significant share of the residual.
    let mut sought = inputs.beside.clone();
    while excess(&chosen) > limits.continue_from && names.len() < MAX_EFFECTS {
        let beside = match sought.take() {
            Some(sought) => sought,
            None => {
                beside(inputs.fitter, inputs.machine, inputs.effects, &chosen, inputs.seed, inputs.control)?
            }
        };
        chosen.1 = beside.base.clone();
        if excess(&chosen) <= limits.continue_from {
            break;
        }
        let Some(more) = inputs.further(&chosen, beside)? else { break };
        chosen = more;
        names = Effect::unrefined(inputs.effects, &chosen.0.effects);
    }
    let after = excess(&chosen);
    let detail: Vec<&str> = chosen.0.effects.iter().filter(|id| !names.contains(id)).collect();
    let is_detailed = !detail.is_empty();
    let stated =
        if is_detailed { format!("{names} with {}", detail.join(" and ")) } else { names.to_string() };
    let released =
        tried[same[0]].candidate.fitted.as_ref().is_some_and(|f| f.0.kind == HypothesisKind::Release);
    if released {
        let reason = format!(
            "the frozen value of {} is wrong{}; the remaining misfit is {after:.1} times that of null simulations",
            best.candidate.id,
            if names.len() > 1 {
                format!(", and the model lacks {}", names.after_first().join(" and "))
            } else {
                String::new()
            }
        );
        let next = Some(format!("identify without freezing {}, then diagnose again", best.candidate.id));
        return Ok((Verdict::new(VerdictKind::WrongParameter, reason, next), chosen));
    }
    // Alternatives of the first effect are alternatives in the combination, too.
    let is_effect =
        |t: &&TriedEffect| t.candidate.fitted.as_ref().is_some_and(|f| f.0.kind == HypothesisKind::Effect);
    let mut alternatives: Vec<EffectIds> = Vec::new();
    for t in same
        .iter()
        .map(|at| &tried[*at])
        .filter(is_effect)
        .filter(|t| !names.after_first().contains(&t.candidate.id))
    {
        let rival = t
            .candidate
            .fitted
            .as_ref()
            .filter(|(hypothesis, _)| is_detailed && hypothesis.effects.first() != names.first());
        if rival.map_or(Ok(true), |rival| inputs.reaches(rival, &chosen.1))? {
            alternatives.push(with_first(&t.candidate.id, &names));
        }
    }
    let least = if after < GENERIC_BETTER * generic_excess { LEAST_REDUCTION.0 } else { LEAST_REDUCTION.1 };
    let little = chosen.1.chi_square > (1.0 - least) * screening.base.chi_square;
    // A named effect must predict left-out positions better than the nominal machine, and not much worse than
    // a better fitting generic impedance.
    let loss = match best.candidate.fitted.as_ref().is_some_and(|(_, fitted)| *fitted == chosen.1) {
        true => best.candidate.left_out,
        false => cross_validation(inputs.fitter, &chosen.0, &chosen.1, inputs.control).ok(),
    };
    let predicts_nothing = |loss: f64| loss > PREDICTION.0 * inputs.nominal_loss;
    let generic_predicts = |loss: f64| {
        // Modes give few numbers at left-out positions: allow a share of the improvement, as for effects.
        let margin = |own: f64| {
            EQUIVALENT * after
                + if limits.calibrated { 0.0 } else { SHORTFALL * (inputs.nominal_loss - own).max(0.0) }
        };
        let predicts = |own: f64| own < PREDICTION.1 * loss && own < loss - margin(own);
        let better = |c: &Candidate| c.chi_square() < chosen.1.chi_square && c.left_out.is_some_and(predicts);
        located.iter().any(better)
    };
    let fails = loss.is_some_and(|loss| predicts_nothing(loss) || generic_predicts(loss))
        && !inputs.fitter.lacks(Ablation::InSample);
    let (gain, margin) = (screening.base.chi_square - chosen.1.chi_square, EQUIVALENT * after);
    let about = NamedFit {
        hypothesis: &chosen.0,
        fitted: &chosen.1,
        effects: names.len(),
        before,
        after,
        gain,
        margin,
    };
    if let Some((generic, comparison)) = more_parsimonious(&about, located, null, *count, *limits) {
        let (place, shape) = impedance_of(generic).unwrap_or(("?", "shape"));
        let reason = format!(
            "a generic {shape} at {place} {comparison} {stated}: these data show that such an impedance is missing there, but do not identify \
             the effect"
        );
        return Ok((unknown(reason), chosen));
    }
    // Only the largest number ended the search for further effects: records of another machine need ever
    // more.
    let exhausted = limits.calibrated && names.len() == MAX_EFFECTS && after > EXCESS;
    let several = exhausted || (names.len() > 1 && after > limits.combination_excess);
    let other = impossible_number(&chosen).filter(|_| limits.calibrated && after > LARGE_EXCESS);
    let is_inadequate = several || (after > limits.large_excess && little);
    if is_inadequate
        || other.is_some()
        || (after > DOUBTFUL_EXCESS && generic_excess < GENERIC_BETTER * after)
        || fails
    {
        let moved = |(name, deviation): (String, f64)| {
            format!(", although {name} moves by {deviation:+.0} of its standard deviations")
        };
        let fails = other.map(moved).unwrap_or_default()
            + if fails { ", and predicts left-out positions worse than it fits" } else { "" };
        let reason = format!(
            "the best effect of the library, {stated}, leaves a misfit {after:.1} times that of null simulations{fails}; a generic impedance at \
             {generic_place} leaves {generic_excess:.1} times"
        );
        return Ok((unknown(reason), chosen));
    }
    let share = |loss: f64| 100.0 * (1.0 - loss / inputs.nominal_loss).max(0.0);
    let predicted = loss.map(share).filter(|share| *share > 0.0);
    let predicted = predicted
        .map_or(String::new(), |share| format!(", and by {share:.0} % at positions left out of the fit"));
    let gained = percent_text(100.0 * (1.0 - chosen.1.chi_square / screening.base.chi_square));
    let others: Vec<String> = inputs
        .rejected
        .iter()
        .filter_map(|t| Some(format!("{} ({:.0} %)", t.candidate.id, share(t.candidate.left_out?))))
        .collect();
    let others = match others.len() {
        0 => String::new(),
        _ => format!("; rejected by cross-validation although they fit as well: {}", others.join(", ")),
    };
    let rest = if after > limits.continue_from {
        format!("; a misfit {after:.1} times that of null simulations remains")
    } else {
        String::new()
    };
    let reason =
        format!("{stated} reduces χ² by {gained}{predicted} ({}){others}{rest}", p_value_text(best.p_value));
    let explanations = if alternatives.len() < 2 { vec![names] } else { alternatives };
    let ids = same.iter().map(|at| tried[*at].candidate.id.as_str());
    Ok((Verdict::naming(explanations, reason, inputs.effects, ids), chosen))
}
