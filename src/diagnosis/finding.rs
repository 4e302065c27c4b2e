//! What a rule found.

use super::case::{Asked, Case, Chosen};
use super::facts::FaultFacts;
use super::verdict::{Verdict, VerdictKind};

/// What a rule found: the figures that it compared where it does not hold, else a verdict with the model on
/// which it rests.
pub(super) enum Finding {
    Fails(String),
    Holds(Verdict, Chosen),
}
use Finding::{Fails, Holds};

/// Returns the verdict on the machine as described.
pub(super) fn on_nominal(case: &Case<'_>, verdict: Verdict) -> Asked<Finding> {
    Ok(Holds(verdict, Chosen::nominal(case.facts)))
}

pub(super) fn fails(figures: impl Into<String>) -> Asked<Finding> {
    Ok(Fails(figures.into()))
}

/// Returns the verdict that states a fault.
pub(super) fn at_fault(case: &Case<'_>, fault: &FaultFacts) -> Asked<Finding> {
    let kind = if fault.is_insufficient { VerdictKind::Insufficient } else { VerdictKind::Measurement };
    let next = Some(fault.next_measurement.clone());
    on_nominal(case, Verdict { faults: fault.ids.clone(), ..Verdict::new(kind, fault.reason.clone(), next) })
}

/// Returns the verdict «unknown» at the location of a generic impedance.
pub(super) fn unknown(case: &Case<'_>, reason: String) -> Verdict {
    Verdict::new(VerdictKind::Unknown, reason, Some(case.facts.data.next_at_location().to_string()))
}
