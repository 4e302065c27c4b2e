//! The rules of a verdict: one table, read from the top.
//!
//! The first of the deciding rules that holds gives the verdict. The overriding rules after them are then
//! tried in turn: each that holds replaces it.

use super::case::{Asked, Case, Chosen, Confirmation, Need};
use super::data_kind::DataKind;
use super::facts::{CandidateFacts, Facts, Farthest, Model};
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
pub(super) const RULES: [Rule; 19] = [
    ("too-few-numbers", "no more numbers were measured than are unknown", Decides(too_few_numbers)),
    ("fault-in-records", "records show a fault by themselves", Decides(fault_in_records)),
    ("one-position", "all records agree as if measured at one position", Decides(one_position)),
    ("fault-held-out", "a held-out record is far off, with the best effect, too", Decides(fault_held_out)),
    ("fault-of-all", "a fault of the chain of all records explains what no effect does", Decides(fault_of_all)),
    ("exchanged-records", "two records agree at each other's positions", Decides(exchanged_records)),
    ("contradicting-record", "all other records agree without one, or one channel", Decides(contradicting_record)),
    ("unexplained", "no effect is significant, but the misfit is not small", Decides(unexplained)),
    ("implausible-tolerance", "no effect is significant, but a tolerance is implausible", Decides(implausible_tolerance)),
    ("agrees", "no effect is significant", Decides(agrees)),
    ("released-parameter", "a released parameter explains the data as well as any effect", Decides(released_parameter)),
    ("released-with-effects", "a released parameter is the best candidate", Decides(released_with_effects)),
    ("impossible-number", "the effects leave much, and move a number beyond any tolerance", Decides(impossible_number)),
    ("impedance-predicts", "an impedance fits better and predicts left-out data far better", Decides(impedance_predicts)),
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
    if facts.impedances.is_empty() || *before <= policy.excess {
        return fails(format!("misfit {before:.1} × null"));
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
    let Some(Farthest { name, deviation }) = case.implausible(Model::Nominal)? else {
        return fails("none is");
    };
    let reason = format!(
        "the misfit needs {name} at {deviation:+.1} of its standard deviations, and no effect of the library explains it"
    );
    on_nominal(case, unknown(case, reason))
}

fn agrees(case: &Case<'_>) -> Asked<Finding> {
    if let Some(best) = case.best() {
        return fails(format!("{} is", best.id));
    }
    let best = case.ranking.tried.iter().max_by(|a, b| a.statistic.total_cmp(&b.statistic));
    let is_worse = |t: &Ranked| {
        t.p_value < case.policy.alpha
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
    let explains = |c: &&CandidateFacts| facts.excess(c.chi_square()) <= policy.excess;
    let found = ranking.tried[..ranking.same.len()].iter().find_map(|t| {
        let candidate = ranking.candidate(t);
        Some((t, candidate, Some(candidate).filter(explains)?.released.as_ref()?))
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

fn impossible_number(case: &Case<'_>) -> Asked<Finding> {
    let (chosen, policy) = (case.chosen()?, case.policy);
    let after = case.facts.excess(chosen.chi_square);
    if !policy.calibrated || after <= policy.huge_excess {
        return fails(format!("{after:.1} × null left"));
    }
    match case.farthest(chosen.model)? {
        Some(Farthest { name, deviation }) if deviation.abs() > policy.impossible => {
            let reason = format!(
                "{} leaves a misfit {after:.1} times that of null simulations, although {name} moves by {deviation:+.0} of its standard deviations",
                stated(&chosen)
            );
            Ok(Holds(unknown(case, reason), chosen))
        }
        _ => fails("none"),
    }
}

fn impedance_predicts(case: &Case<'_>) -> Asked<Finding> {
    let chosen = case.chosen()?;
    let Some(impedance) = case.predicts_far_better(&chosen)? else { return fails("none does") };
    let reason = format!(
        "a generic {} at {} fits better than {}, and predicts left-out {} far better: the misfit is {:.1} and {:.1} times that of null simulations",
        impedance.shape,
        impedance.interface,
        stated(&chosen),
        case.facts.data.blocks(),
        case.facts.excess(impedance.chi_square),
        case.facts.excess(chosen.chi_square)
    );
    Ok(Holds(unknown(case, reason), chosen))
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
            "a generic {} at {} predicts held-out data better than {effect} (ln of the density ratio {:.1})",
            case.impedance_shape(),
            case.impedance_place(),
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
    let is_unexplained = after > policy.excess && after - 1.0 > policy.unexplained * (before - 1.0);
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
