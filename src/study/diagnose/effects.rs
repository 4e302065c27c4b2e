//! Candidate effects of a diagnosis, their status, and the verdict.

use std::collections::BTreeMap;

use super::DiagnosisRequest;
use crate::{MachineConfig, Study};
use diagnosis::{Status, Verdict};
use machine::{Data, Effect, Parameter};
use report::diagnosis::VerdictRow;
use report::vocabulary::{EffectStatus, VerdictKind};

/// Returns the requested candidates; of effects with one id the one for this kind of data.
pub fn choose_effects(request: &DiagnosisRequest, all: &[Effect], data: Data) -> Vec<Effect> {
    // What describes a requested effect in more detail goes with it.
    let is_requested = |e: &Effect| {
        request.effects.contains(&e.id) || e.refines.as_ref().is_some_and(|id| request.effects.contains(id))
    };
    let wanted =
        |e: &&Effect| (request.effects.is_empty() || is_requested(e)) && !request.exclude.contains(&e.id);
    Effect::for_data(all, data).filter(wanted).cloned().collect()
}

impl Study {
    /// Returns all that a diagnosis may name: the effects of the library, and stated numbers, which depend on the
    /// values of its chosen model.
    pub fn candidates(&self, chosen: &BTreeMap<String, f64>) -> Vec<Effect> {
        let MachineConfig { machine, effects, .. } = &self.config;
        let library: Vec<Effect> = Effect::for_data(effects, Data::Frf).cloned().collect();
        let numbers = diagnosis::named_numbers(machine, &self.set.nuts_m(), &library, chosen);
        [&effects[..], &numbers].concat()
    }
}

/// Returns a candidate's status as a word, and the reason why it was not fitted.
pub fn status_words(status: &Status) -> (EffectStatus, Option<String>) {
    match status {
        Status::Tried => (EffectStatus::Tried, None),
        Status::Failed(why) => (EffectStatus::Failed, Some(why.clone())),
        Status::NotApplicable(why) => (EffectStatus::NotApplicable, Some(why.clone())),
    }
}

/// Whether a verdict names an effect, alone or in a combination.
pub fn names_effect(verdict: &Verdict, id: &str) -> bool {
    verdict.effects.iter().any(|names| names.contains(id))
}

/// Returns a verdict as a row, with its location.
pub fn verdict_row(verdict: &Verdict, place: Option<String>) -> VerdictRow {
    VerdictRow {
        kind: match verdict.kind {
            diagnosis::VerdictKind::None => VerdictKind::None,
            diagnosis::VerdictKind::Effect => VerdictKind::Effect,
            diagnosis::VerdictKind::Ambiguous => VerdictKind::Ambiguous,
            diagnosis::VerdictKind::Unknown => VerdictKind::Unknown,
            diagnosis::VerdictKind::WrongParameter => VerdictKind::WrongParameter,
            diagnosis::VerdictKind::Measurement => VerdictKind::Measurement,
            diagnosis::VerdictKind::Insufficient => VerdictKind::Insufficient,
        },
        effects: verdict.effects.iter().map(ToString::to_string).collect(),
        faults: verdict.faults.clone(),
        rule: None,
        confirmed: verdict.confirmed,
        reason: verdict.reason.clone(),
        next_measurement: verdict.next_measurement.clone(),
        place,
        band_hz: None,
        phase: None,
        places: Vec::new(),
    }
}

/// Parameters of an effect with their values.
pub type Values<'p> = [(&'p Parameter, f64)];

/// Returns the units of an effect's parameters.
pub fn units(own: &Values<'_>) -> BTreeMap<String, String> {
    own.iter().map(|(p, _)| (p.id.clone(), p.unit.clone())).collect()
}

/// Returns the ids of an effect's parameters that lie at an end of their range.
pub fn at_bound(own: &Values<'_>) -> Vec<String> {
    own.iter().filter(|(p, value)| p.is_at_bound(*value)).map(|(p, _)| p.id.clone()).collect()
}
