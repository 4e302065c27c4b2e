//! Rules that find a fault of records.

use super::case::{Asked, Case, Chosen, Need};
use super::data_kind::DataKind;
use super::facts::{ChainFacts, FaultFacts, Model};
use super::finding::Finding::{self, Holds};
use super::finding::{at_fault, fails};
use super::verdict::{Verdict, VerdictKind};

pub(super) fn fault_in_records(case: &Case<'_>) -> Asked<Finding> {
    match &case.facts.fault_in_records {
        // What agrees with the machine lacks nothing, with or without a resonance.
        Some(fault) if case.needs_explanation()? || !fault.is_insufficient => at_fault(case, fault),
        _ => fails("none does"),
    }
}

pub(super) fn one_position(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, policy, before, ranking, .. } = case;
    if !case.needs_explanation()? || facts.fault_in_records.is_some() {
        return fails(format!("misfit {before:.1} times that of null simulations"));
    }
    let Some(found) = &facts.one_position.as_ref().ok_or(Need::OnePosition)?.found else {
        return fails("they differ by more than noise and a factor");
    };
    let margin = ranking.margin(found.chi_square);
    let explains = facts.excess(found.chi_square) <= policy.reach(*before)
        && found.chi_square + margin <= found.chi_square_at_own
        && case
            .best()
            .is_none_or(|best| found.chi_square <= best.chi_square() + ranking.margin(best.chi_square()));
    if explains { at_fault(case, &found.fault) } else { fails(format!("χ² {:.0} there", found.chi_square)) }
}

pub(super) fn fault_held_out(case: &Case<'_>) -> Asked<Finding> {
    let Some(fault) = &case.facts.fault_held_out else { return fails("none is") };
    // A record that agrees with the others once an effect is included is not faulty.
    let remains = match &case.significant {
        None => true,
        Some(best) => case.leaves_held_out_fault(Model::Candidate(best.at))?,
    };
    if remains { at_fault(case, fault) } else { fails("the best effect restores it") }
}

/// Returns the fault of the measuring chain of all records that explains the misfit of the nominal machine:
/// the corrected data agree with it, and no effect explains the data as they are with as few parameters.
/// Second, whether it is certain: where the records agree nearly as they are, only if no effect explains as
/// much. Every chain has some corner far from its band, and small effects resemble it.
pub(super) fn chain_fault<'f>(case: &Case<'f>) -> Asked<Option<(&'f ChainFacts, bool)>> {
    let Case { facts, policy, before, .. } = *case;
    if !case.needs_explanation()? {
        return Ok(None);
    }
    let Some(chain) = &facts.chain.as_ref().ok_or(Need::Chain)?.found else { return Ok(None) };
    if facts.excess(chain.chi_square) > policy.reach(before) {
        return Ok(None);
    }
    let (explains, is_certain) = match case.best() {
        // Null simulations that do not bound the error of the model leave that, and tolerances take much of a fault.
        None if !policy.bounded => {
            let margin = case.ranking.margin(chain.chi_square);
            let halves = facts.excess(chain.chi_square) - 1.0 <= policy.unexplained * (before - 1.0);
            let is_needed = case.implausible(Model::Nominal)?.is_some();
            ((halves || is_needed) && chain.chi_square + margin <= facts.chi_square, true)
        }
        None => (chain.chi_square <= policy.restored * facts.chi_square, true),
        // Of two explanations that the data cannot tell apart, the simpler one is named.
        Some(best) => {
            let (chi_square, margin) = (best.chi_square(), case.ranking.margin(best.chi_square()));
            let is_better = chain.chi_square <= chi_square - margin;
            let is_simpler = chain.parameters < best.added && chain.chi_square <= chi_square + margin;
            (is_better || is_simpler, is_better || before > policy.agrees)
        }
    };
    Ok(explains.then_some((chain, is_certain)))
}

pub(super) fn fault_of_all(case: &Case<'_>) -> Asked<Finding> {
    match chain_fault(case)? {
        Some((chain, true)) => at_fault(case, &chain.fault),
        Some((chain, false)) => fails(format!("{} explains no more than the best effect", chain.id)),
        None => fails("none does"),
    }
}

/// Whether records may be faulty: neither the best effect nor a fault of their chain accounts for the misfit.
pub(super) fn records_may_be_faulty(case: &Case<'_>) -> Asked<bool> {
    Ok(case.needs_explanation()? && !case.agrees_with_best() && chain_fault(case)?.is_none())
}

pub(super) fn exchanged_records(case: &Case<'_>) -> Asked<Finding> {
    let Case { facts, policy, before, .. } = case;
    if !records_may_be_faulty(case)? {
        return fails("the misfit is small, or accounted for");
    }
    let pairs = facts.exchanged.as_ref().ok_or(Need::Exchanged)?;
    let agrees = |chi_square: f64| {
        chi_square <= policy.restored * facts.chi_square && facts.excess(chi_square) <= policy.reach(*before)
    };
    match pairs.iter().find(|pair| agrees(pair.chi_square)) {
        Some(pair) => at_fault(case, &pair.fault),
        None => fails("no pair does"),
    }
}

pub(super) fn contradicting_record(case: &Case<'_>) -> Asked<Finding> {
    if !records_may_be_faulty(case)? {
        return fails("the misfit is small, or accounted for");
    }
    match &case.facts.contradiction.as_ref().ok_or(Need::Contradiction)?.found {
        Some(found) if case.facts.null.excess(found.rest) <= case.policy.agrees => {
            at_fault(case, &found.fault)
        }
        _ => fails("they do not"),
    }
}

/// Held-out motion records that contradict the fitted ones are the verdict where nothing else is, or where they do
/// not confirm what is; else they are stated beside it.
pub(super) fn contradicting_held_out(
    case: &Case<'_>,
    (verdict, chosen): (&Verdict, &Chosen),
) -> Asked<Finding> {
    if case.facts.data != DataKind::Motion || !case.facts.holds_out {
        return fails("these data are none, or nothing is held out");
    }
    let found = case.contradicting_held_out(chosen.model)?;
    let (fault, stands) = match verdict.kind {
        VerdictKind::None => (&found.fault, false),
        VerdictKind::Measurement | VerdictKind::Insufficient => (&None, false),
        _ => (&found.beyond_effects, verdict.confirmed != Some(false) && verdict.kind.explains()),
    };
    let Some(FaultFacts { ids, reason, next_measurement, .. }) = fault else { return fails("none does") };
    let (faults, next) = (ids.clone(), Some(next_measurement.clone()));
    let stated = match (stands, verdict.kind) {
        (true, _) => {
            let reason = format!("{}; {reason}", verdict.reason);
            Verdict { faults, reason, ..verdict.clone() }
        }
        (_, VerdictKind::None) => {
            Verdict { faults, ..Verdict::new(VerdictKind::Measurement, reason.clone(), next) }
        }
        _ => {
            let reason = format!("{reason}; besides, {}", verdict.reason);
            Verdict { faults, ..Verdict::new(VerdictKind::Measurement, reason, next) }
        }
    };
    Ok(Holds(stated, chosen.clone()))
}
