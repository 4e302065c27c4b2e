//! The rules of a verdict: one table, read from the top.
//!
//! The first of the deciding rules that holds gives the verdict. The overriding rules after them are then
//! tried in turn: each that holds replaces it.

use super::case::{Asked, Case, Chosen, Confirmation, Need};
use super::data_kind::DataKind;
use super::facts::{CandidateFacts, Facts, Farthest, ImpedanceFacts, Model};
use super::fault_rules::{
    chain_fault, contradicting_held_out, contradicting_record, exchanged_records, fault_held_out,
    fault_in_records, fault_of_all, one_position,
};
use super::finding::Finding::{self, Holds};
use super::finding::{fails, on_nominal, unknown};
use super::ranking::Ranked;
use super::verdict::{Verdict, VerdictKind, p_value_text, percent_text};

/// How a rule acts: it gives the verdict if none before it does, or replaces that of one before it.
pub(super) enum Act {
    Decides(fn(&Case<'_>) -> Asked<Finding>),
    Overrides(fn(&Case<'_>, (&Verdict, &Chosen)) -> Asked<Finding>),
}
use Act::{Decides, Overrides};

/// Name of a rule, its condition in words, and the function that compares it with the facts.
pub(super) type Rule = (&'static str, &'static str, Act);

/// All rules, in their order.
#[rustfmt::skip]
pub(super) const RULES: [Rule; 23] = [
    ("too-few-numbers", "no more numbers were measured than are unknown", Decides(too_few_numbers)),
    ("fault-in-records", "records show a fault by themselves", Decides(fault_in_records)),
    ("one-position", "all records agree as if measured at one position", Decides(one_position)),
    ("fault-held-out", "a held-out record is far off, with the best effect, too", Decides(fault_held_out)),
    ("fault-of-all", "a fault of the chain of all records explains what no effect does", Decides(fault_of_all)),
    ("exchanged-records", "two records agree at each other's positions", Decides(exchanged_records)),
    ("contradicting-record", "all other records agree without one, or one channel", Decides(contradicting_record)),
    ("unexplained", "no effect is significant, but an impedance is, or the misfit is huge", Decides(unexplained)),
    ("implausible-tolerance", "no effect is significant, but a tolerance is implausible", Decides(implausible_tolerance)),
    ("agrees", "no effect is significant", Decides(agrees)),
    ("released-parameter", "a released parameter explains as much as any effect", Decides(released_parameter)),
    ("released-with-effects", "a released parameter is the best candidate", Decides(released_with_effects)),
    ("impedance-as-simple", "an impedance explains as much with fewer parameters", Decides(impedance_as_simple)),
    ("effects-exhausted", "a combination of effects leaves too much", Decides(effects_exhausted)),
    ("little-reduced", "the effects leave much, and reduce χ² by too little", Decides(little_reduced)),
    ("impossible-number", "they leave much, and move a number beyond any tolerance", Decides(impossible_number)),
    ("impedance-better", "an impedance leaves clearly less than the effects", Decides(impedance_better)),
    ("predicts-worse", "the effects predict left-out data worse than they fit", Decides(predicts_worse)),
    ("explained", "an effect, or one of several, explains the data", Decides(explained)),
    ("held-out-disagrees", "held-out data do not speak for what is named", Overrides(held_out_disagrees)),
    ("half-unexplained", "half of the misfit and of the held-out gap is left", Overrides(half_unexplained)),
    ("contradicting-held-out", "held-out motion records contradict the fitted ones", Overrides(contradicting_held_out)),
    ("other-cause", "records are of several machines, or a fault of their chain is as likely", Overrides(other_cause)),
];

fn too_few_numbers(case: &Case<'_>) -> Asked<Finding> {
    let Facts { count, unknowns, .. } = case.facts;
    if *count > *unknowns as f64 {
        return fails(format!("{count} numbers for {unknowns} unknowns"));
    }
    let reason =
        format!("{count} numbers were measured for {unknowns} unknown parameters: any model would fit");
    let next = "measure more modes, more positions, or a whole FRF at each position";
    on_nominal(case, Verdict::new(VerdictKind::Insufficient, reason, Some(next.into())))
}

fn unexplained(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, policy, before, .. } = case;
    if let Some(best) = case.best() {
        return fails(format!("{} is", best.id));
    }
    let statistic = facts
        .best_impedance()
        .map_or(0.0, |(_, best)| best.gain / facts.null.widest_scale() / case.impedance_excess());
    let is_clear = statistic > policy.least_generic_statistic && facts.null.p_value(statistic) < policy.alpha;
    if facts.impedances.is_empty() || !(is_clear || *before > policy.huge_excess) {
        return fails(format!("statistic of the best impedance {statistic:.1}, misfit {before:.1} × null"));
    }
    let place = case.impedance_place();
    let reason = format!(
        "the misfit is {before:.1} times that of null simulations and no effect of the library explains it; a generic impedance at \
         {place} reduces χ² most"
    );
    on_nominal(case, unknown(case, reason))
}

fn implausible_tolerance(case: &Case<'_>) -> Asked<Finding> {
    if let Some(best) = case.best() {
        return fails(format!("{} is", best.id));
    }
    if case.policy.implausible == f64::MAX {
        return fails("tolerances of these data are judged by their own warnings");
    }
    match case.farthest(Model::Nominal)? {
        Some(Farthest { name, deviation }) if deviation.abs() > case.policy.implausible => {
            let reason = format!(
                "the misfit needs {name} at {deviation:+.1} of its standard deviations, and no effect of the library explains it"
            );
            on_nominal(case, unknown(case, reason))
        }
        Some(Farthest { name, deviation }) => fails(format!("{name} at {deviation:+.1} standard deviations")),
        None => fails("none is estimated"),
    }
}

fn agrees(case: &Case<'_>) -> Asked<Finding> {
    if let Some(best) = case.best() {
        return fails(format!("{} is", best.id));
    }
    let best = case.ranking.tried.iter().max_by(|a, b| a.statistic.total_cmp(&b.statistic));
    let is_worse = |t: &Ranked| {
        t.p_value < case.policy.alpha_predictive
            && case.facts.left_out(Model::Candidate(t.at)).is_some_and(|loss| loss >= case.nominal_loss)
    };
    let worse = format!("; it does not improve the prediction of left-out {}", case.facts.data.blocks());
    let remark = |t: &Ranked| {
        if is_worse(t) { worse.as_str() } else { "" }
    };
    let best = best.map_or("none".to_string(), |t| {
        format!("{}, {}{}", case.ranking.candidate(t).id, p_value_text(t.p_value), remark(t))
    });
    let reason = format!(
        "the residual is consistent with null simulations of this machine and layout (most significant candidate: {best})"
    );
    on_nominal(case, Verdict::new(VerdictKind::None, reason, None))
}

fn released_parameter(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, policy, ranking, .. } = case;
    let most = ranking.candidate(&ranking.tried[0]).gain;
    let explains = |candidate: &CandidateFacts| {
        (candidate.chi_square() <= (1.0 - policy.release_reduction) * facts.chi_square
            || facts.excess(candidate.chi_square()) <= policy.release_excess)
            && candidate.gain >= policy.release_share * most
    };
    let found = ranking.tried.iter().find_map(|t| {
        let candidate = ranking.candidate(t);
        Some((t, candidate, candidate.released.as_ref().filter(|_| explains(candidate))?))
    });
    let Some((ranked, candidate, statement)) = found else { return fails("none does") };
    let share = percent_text(100.0 * candidate.gain / facts.chi_square);
    let reason = format!("{statement} reduces χ² by {share}: no effect is needed");
    let chosen = Chosen::candidate(candidate, ranked.at);
    Ok(Holds(Verdict::wrong_parameter(&candidate.id, reason), chosen))
}

fn released_with_effects(case: &Case<'_>) -> Asked<Finding> {
    let best = case.ranking.candidate(&case.ranking.tried[0]);
    if best.released.is_none() {
        return fails(format!("{} is", best.id));
    }
    let chosen = case.chosen()?;
    let (after, names) = (case.facts.excess(chosen.chi_square), &chosen.names);
    let lacks = match names.len() {
        0 | 1 => String::new(),
        _ => format!(", and the model lacks {}", names.after_first().join(" and ")),
    };
    let reason = format!(
        "the frozen value of {} is wrong{lacks}; the remaining misfit is {after:.1} times that of null simulations",
        best.id
    );
    let next = Some(format!("identify without freezing {}, then diagnose again", best.id));
    Ok(Holds(Verdict::new(VerdictKind::WrongParameter, reason, next), chosen))
}

/// Returns the names of a chosen model with what describes them in more detail.
fn stated(chosen: &Chosen) -> String {
    let detail: Vec<&str> = chosen.effects.iter().filter(|id| !chosen.names.contains(id)).collect();
    if detail.is_empty() {
        chosen.names.to_string()
    } else {
        format!("{} with {}", chosen.names, detail.join(" and "))
    }
}

/// - Effects with more parameters than any generic impedance must fit better than each of them. None is named
///   where a generic impedance explains the whole residual.
/// - A single effect that explains the whole residual must fit as well as generic impedances with no more
///   parameters.
fn impedance_as_simple(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, policy, before, .. } = case;
    let chosen = case.chosen()?;
    let (after, margin) = (facts.excess(chosen.chi_square), case.ranking.margin(chosen.chi_square));
    let is_single = chosen.names.len() == 1;
    let is_flexible = chosen.added > policy.generic_parameters && (policy.calibrated || is_single);
    let of_gain = policy.least_improvement * (facts.chi_square - chosen.chi_square);
    let reach = chosen.chi_square + margin + policy.margin(of_gain, chosen.chi_square, after);
    let explains_all = |c: &ImpedanceFacts| {
        policy.calibrated && *before > policy.large_excess && facts.excess(c.chi_square) <= policy.explained
    };
    let explains_alone = policy.calibrated && is_single && after <= policy.large_excess;
    let comparison = |c: &ImpedanceFacts| {
        let is_better =
            explains_alone && c.parameters <= chosen.added && c.chi_square + margin < chosen.chi_square;
        match (is_better, is_flexible && (c.chi_square <= reach || explains_all(c))) {
            (true, _) => Some("fits better than"),
            (false, true) => Some("fits, with fewer parameters, as well as"),
            (false, false) => None,
        }
    };
    let matching = facts.impedances.iter().filter_map(|c| Some((c, comparison(c)?)));
    match matching.min_by(|(a, _), (b, _)| a.chi_square.total_cmp(&b.chi_square)) {
        None => fails(format!("χ² {:.0} with {} parameters", chosen.chi_square, chosen.added)),
        Some((ImpedanceFacts { interface, shape, .. }, comparison)) => {
            let reason = format!(
                "a generic {shape} at {interface} {comparison} {}: these data show that such an impedance is missing there, but do not identify \
                 the effect",
                stated(&chosen)
            );
            Ok(Holds(unknown(case, reason), chosen))
        }
    }
}

/// Returns the verdict that the best effects leave too much.
fn leaves_too_much(case: &Case<'_>, chosen: Chosen) -> Asked<Finding> {
    let after = case.facts.excess(chosen.chi_square);
    let moved = case.impossible_number_beside_much(&chosen)?.map_or(String::new(), |(name, deviation)| {
        format!(", although {name} moves by {deviation:+.0} of its standard deviations")
    });
    let worse = if case.predicts_worse(&chosen)? {
        format!(", and predicts left-out {} worse than it fits", case.facts.data.blocks())
    } else {
        String::new()
    };
    let reason = format!(
        "the best effect of the library, {}, leaves a misfit {after:.1} times that of null simulations{moved}{worse}; a generic impedance at \
         {} leaves {:.1} times",
        stated(&chosen),
        case.impedance_place(),
        case.impedance_excess()
    );
    Ok(Holds(unknown(case, reason), chosen))
}

fn effects_exhausted(case: &Case<'_>) -> Asked<Finding> {
    let (chosen, policy) = (case.chosen()?, case.policy);
    let (after, effects) = (case.facts.excess(chosen.chi_square), chosen.names.len());
    // Only the largest number ended the search for further effects: records of another machine need ever
    // more.
    let is_exhausted = policy.calibrated && effects == policy.most_effects && after > policy.excess;
    if is_exhausted || (effects > 1 && after > policy.combination_excess) {
        return leaves_too_much(case, chosen);
    }
    fails(format!("{} leaves {after:.1} × null", stated(&chosen)))
}

fn little_reduced(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, policy, .. } = case;
    let chosen = case.chosen()?;
    let after = facts.excess(chosen.chi_square);
    let is_matched = after >= policy.generic_better * case.impedance_excess();
    let least = if is_matched { policy.least_reduction } else { policy.least_reduction_unmatched };
    if after > policy.large_excess && chosen.chi_square > (1.0 - least) * facts.chi_square {
        return leaves_too_much(case, chosen);
    }
    let reduced = percent_text(100.0 * (1.0 - chosen.chi_square / facts.chi_square));
    fails(format!("reduced by {reduced}, {after:.1} × null left"))
}

fn impossible_number(case: &Case<'_>) -> Asked<Finding> {
    let chosen = case.chosen()?;
    match case.impossible_number_beside_much(&chosen)? {
        Some(_) => leaves_too_much(case, chosen),
        None => fails("none, or little is left"),
    }
}

fn impedance_better(case: &Case<'_>) -> Asked<Finding> {
    let (chosen, policy) = (case.chosen()?, case.policy);
    let (after, generic) = (case.facts.excess(chosen.chi_square), case.impedance_excess());
    if after > policy.doubtful_excess && generic < policy.generic_better * after {
        return leaves_too_much(case, chosen);
    }
    fails(format!("{generic:.1} for {after:.1} × null"))
}

fn predicts_worse(case: &Case<'_>) -> Asked<Finding> {
    let chosen = case.chosen()?;
    if case.predicts_worse(&chosen)? { leaves_too_much(case, chosen) } else { fails("they do not") }
}

fn explained(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, ranking, .. } = case;
    let (chosen, best) = (case.chosen()?, ranking.tried[0]);
    let share = |loss: f64| 100.0 * (1.0 - loss / case.nominal_loss).max(0.0);
    let predicted = case.loss(&chosen)?.map(share).filter(|share| *share > 0.0);
    let predicted = predicted.map_or(String::new(), |share| {
        format!(", and by {share:.0} % at {} left out of the fit", facts.data.blocks())
    });
    let gained = percent_text(100.0 * (1.0 - chosen.chi_square / facts.chi_square));
    let others: Vec<String> = ranking.tried[ranking.rejected.clone()]
        .iter()
        .filter_map(|t| {
            let loss = facts.left_out(Model::Candidate(t.at))?;
            Some(format!("{} ({:.0} %)", ranking.candidate(t).id, share(loss)))
        })
        .collect();
    let others = match others.len() {
        0 => String::new(),
        _ => format!("; rejected by cross-validation although they fit as well: {}", others.join(", ")),
    };
    let after = facts.excess(chosen.chi_square);
    let rest = if after > case.policy.continue_from {
        format!("; a misfit {after:.1} times that of null simulations remains")
    } else {
        String::new()
    };
    let reason = format!(
        "{} reduces χ² by {gained}{predicted} ({}){others}{rest}",
        stated(&chosen),
        p_value_text(best.p_value)
    );
    let alternatives = case.alternatives(&chosen)?;
    let explanations = if alternatives.len() < 2 { vec![chosen.names.clone()] } else { alternatives };
    let effects = ranking.same.iter().map(|at| ranking.candidate(&ranking.tried[*at]));
    let first = effects.into_iter().find(|candidate| candidate.released.is_none());
    let test = first.and_then(|candidate| candidate.discriminating_test.clone());
    let number = first.and_then(|candidate| {
        candidate.number.as_ref().filter(|_| matches!(&explanations[..], [only] if only.len() == 1))
    });
    let verdict = Verdict::naming(explanations, reason, test);
    Ok(Holds(number.map_or(verdict.clone(), |number| verdict.of_number(number)), chosen))
}

fn held_out_disagrees(case: &Case<'_>, (verdict, chosen): (&Verdict, &Chosen)) -> Asked<Finding> {
    if verdict.effects.is_empty() {
        return fails("no effect is named");
    }
    let named = case.named(verdict, chosen).len();
    let Some(found) = case.confirmed(verdict, chosen)? else { return fails("nothing is held out") };
    let Confirmation { over_nominal, over_rival } = found;
    // Of combinations the first alone is fitted: the others might be confirmed.
    if case.is_certain(found) || named < verdict.effects.len() {
        return fails(format!("ln of the density ratio {over_nominal:.1}"));
    }
    let effect = if named > 1 { "the named effects" } else { "the best effect" };
    let reason = match over_rival.filter(|_| over_nominal >= case.policy.decisive) {
        Some(rival) => format!(
            "a generic impedance predicts held-out data better than {effect} (ln of the density ratio {:.1})",
            -rival
        ),
        None => format!(
            "held-out data do not speak for {effect} for certain (ln of the density ratio {over_nominal:.1})"
        ),
    };
    let verdict = verdict.clone().unnamed(&reason, case.facts.data.next_to_confirm());
    Ok(Holds(Verdict { confirmed: Some(false), ..verdict }, chosen.clone()))
}

fn half_unexplained(case: &Case<'_>, (verdict, chosen): (&Verdict, &Chosen)) -> Asked<Finding> {
    let Case { facts, policy, before, .. } = case;
    let after = facts.excess(chosen.chi_square);
    let leaves_much = after > policy.excess || after - 1.0 > policy.unexplained * (before - 1.0);
    let is_inadequate =
        policy.calibrated && facts.null.exceeds(chosen.chi_square / facts.count) && leaves_much;
    if verdict.effects.is_empty() || !is_inadequate {
        return fails(format!("{after:.1} × null left of {before:.1}"));
    }
    let closed = case.named(verdict, chosen).into_iter().map(|model| case.closed(model));
    let closed = closed.collect::<Asked<Vec<Option<f64>>>>()?.into_iter().flatten().reduce(f64::max);
    if closed.is_some_and(|closed| closed >= 1.0 - policy.unexplained) {
        return fails("the held-out gap is closed");
    }
    let gap = if closed.is_some() { ", and more than half of the held-out gap" } else { "" };
    let reason = format!(
        "the best effect leaves a misfit {after:.1} times that of null simulations, {before:.1} times without it{gap}"
    );
    Ok(Holds(verdict.clone().unnamed(&reason, facts.data.next_at_location()), chosen.clone()))
}

/// Records of several machines have a large misfit that no model explains. A fault of the chain of all records
/// that explains as much as the named effect stands beside it.
fn other_cause(case: &Case<'_>, (verdict, chosen): (&Verdict, &Chosen)) -> Asked<Finding> {
    let Case { facts, policy, before, .. } = case;
    if verdict.kind != VerdictKind::Unknown && !verdict.kind.explains() {
        return fails("nothing is missing");
    }
    let after = facts.excess(chosen.chi_square);
    let is_unexplained = after > policy.excess && after - 1.0 > policy.unrelated * (before - 1.0);
    let mismatch = match facts.data == DataKind::Frf && is_unexplained {
        true => facts.mismatch.as_ref().ok_or(Need::Mismatch)?.found.as_ref(),
        false => None,
    };
    let possible = chain_fault(case)?.filter(|(_, is_certain)| !is_certain).map(|(chain, _)| chain);
    if mismatch.is_none() && (possible.is_none() || verdict.kind == VerdictKind::WrongParameter) {
        return fails("neither is so");
    }
    let mut other = verdict.clone();
    if let Some(found) = mismatch {
        other = other.unnamed(&found.reason, &found.next_measurement);
    }
    if let Some(chain) = possible {
        other = other.or_else(&chain.id, &chain.fault.reason, &chain.fault.next_measurement);
    }
    Ok(Holds(other, chosen.clone()))
}
