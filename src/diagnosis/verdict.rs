//! Verdicts on FRFs and on motion records.

use machine::{EffectIds, Parameter};

/// Kind of a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerdictKind {
    /// Model and data agree within tolerances and noise.
    None,
    /// One effect, or one combination of effects, explains the gap.
    Effect,
    /// Several effects explain the gap, and the data cannot distinguish them.
    Ambiguous,
    /// An effect is missing, but none of the library explains it.
    Unknown,
    /// A frozen parameter is wrong.
    WrongParameter,
    /// A record contradicts the others.
    Measurement,
    /// The data are too few for a diagnosis.
    Insufficient,
}

impl VerdictKind {
    /// Whether the verdict names an explanation of the gap: effects or a parameter that was frozen.
    pub fn explains(self) -> bool {
        self.names_effects() || self == VerdictKind::WrongParameter
    }

    /// Whether the verdict names effects, one or several of which one is missing.
    pub fn names_effects(self) -> bool {
        matches!(self, VerdictKind::Effect | VerdictKind::Ambiguous)
    }
}

/// Result of a diagnosis in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Kind of the verdict.
    pub kind: VerdictKind,
    /// Combinations of effects, each an explanation of its own; empty for kinds that name none.
    pub effects: Vec<EffectIds>,
    /// Ids of faults of the measuring chain, `id@record` where one record is concerned.
    pub faults: Vec<String>,
    /// Whether held-out data speak for the named explanation for certain, `false` also where that leaves
    /// none; `None` where nothing is named or held out.
    pub confirmed: Option<bool>,
    /// Reason, in one or two sentences.
    pub reason: String,
    /// Proposed next measurement.
    pub next_measurement: Option<String>,
}

impl Verdict {
    /// Returns a verdict that names no effect.
    pub(super) fn new(kind: VerdictKind, reason: String, next_measurement: Option<String>) -> Verdict {
        Verdict { kind, effects: Vec::new(), faults: Vec::new(), confirmed: None, reason, next_measurement }
    }

    /// Returns the verdict «wrong-parameter» on a parameter that was frozen, for a reason.
    pub(super) fn wrong_parameter(id: &str, reason: String) -> Verdict {
        Verdict::new(VerdictKind::WrongParameter, reason, Some(format!("identify without freezing {id}")))
    }

    /// Returns the verdict «effect» on one explanation, «ambiguous» on several, for a reason. `test` tells the
    /// first of them from the others.
    pub(super) fn naming(explanations: Vec<EffectIds>, reason: String, test: Option<String>) -> Verdict {
        let [_, others @ ..] = explanations.as_slice() else {
            return Verdict::new(VerdictKind::Unknown, reason, None);
        };
        if others.is_empty() {
            return Verdict { effects: explanations, ..Verdict::new(VerdictKind::Effect, reason, None) };
        }
        let others: Vec<String> = others.iter().map(EffectIds::to_string).collect();
        let reason = format!("{reason}; these data cannot distinguish it from {}", others.join(", "));
        Verdict { effects: explanations, ..Verdict::new(VerdictKind::Ambiguous, reason, test) }
    }

    /// Returns the verdict «wrong-parameter» on a number of the description, with its statement.
    pub(super) fn of_number(self, statement: &str) -> Verdict {
        let reason = format!("{statement}. {}", self.reason);
        Verdict { kind: VerdictKind::WrongParameter, reason, ..self }
    }

    /// Returns the verdict «unknown» in place of a name, for a reason that is added.
    pub(super) fn unnamed(self, reason: &str, next_measurement: &str) -> Verdict {
        Verdict {
            kind: VerdictKind::Unknown,
            effects: Vec::new(),
            confirmed: None,
            reason: format!("{reason} ({})", self.reason),
            next_measurement: Some(next_measurement.into()),
            ..self
        }
    }

    /// Returns the verdict «ambiguous» where something else explains as much as the named effects: its id, a
    /// reason and the next measurement. Where no effect is named, the reason of «unknown» states it.
    pub(super) fn or_else(self, id: &str, text: &str, next: &str) -> Verdict {
        let next = next.to_string();
        if self.kind.names_effects() {
            let effects = self.effects.into_iter().chain([EffectIds::single(id)]).collect();
            let reason =
                format!("{}; these data cannot distinguish it from another cause: {text}", self.reason);
            return Verdict {
                kind: VerdictKind::Ambiguous,
                effects,
                reason,
                next_measurement: Some(next),
                ..self
            };
        }
        if self.kind != VerdictKind::Unknown {
            return self;
        }
        let next = self.next_measurement.map_or(next.clone(), |own| format!("{own}; or {next}"));
        Verdict {
            reason: format!("{}; a possible cause: {text}", self.reason),
            next_measurement: Some(next),
            ..self
        }
    }

    /// Returns the first effect that the verdict names.
    pub fn first_effect(&self) -> Option<&str> {
        self.effects.first().and_then(EffectIds::first)
    }
}

/// Describes a parameter that was frozen, and its estimate.
pub(super) fn frozen_text(Parameter { id, start, unit, .. }: &Parameter, estimate: f64) -> String {
    format!("{id} was frozen at {start:.4e} {unit}; its estimate {estimate:.4e}")
}

/// Returns a combination of effects with another first one.
pub(super) fn with_first(id: &str, names: &EffectIds) -> EffectIds {
    names.after_first().iter().fold(EffectIds::single(id), |all, more| all.with(more))
}

/// Formats a p-value for a verdict.
pub(super) fn p_value_text(p_value: f64) -> String {
    match p_value {
        p if p < 0.01 => format!("p = {p:.4}"),
        p => format!("p = {p:.2}"),
    }
}

/// Writes a percentage: two decimals below 1 %.
pub(crate) fn percent_text(percent: f64) -> String {
    if percent.abs() < 0.95 { format!("{percent:.2} %") } else { format!("{percent:.0} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fault of the measuring chain that explains as much as an effect is a second name beside one, and
    /// stated where none is named.
    #[test]
    fn another_cause_is_stated_whether_an_effect_is_named_or_not() {
        let with =
            |verdict: Verdict| verdict.or_else("low-pass", "low pass at 5 kHz", "measure one record again");
        let of = |kind, effects| Verdict { effects, ..Verdict::new(kind, "it is so".into(), None) };
        let named = with(of(VerdictKind::Effect, vec![EffectIds::single("screw-lead")]));
        assert_eq!(
            (named.kind, named.effects.len(), named.reason.contains("low pass at 5 kHz")),
            (VerdictKind::Ambiguous, 2, true)
        );
        let unnamed = with(of(VerdictKind::Unknown, Vec::new()));
        assert_eq!(
            (unnamed.kind, unnamed.effects.len(), unnamed.next_measurement.as_deref()),
            (VerdictKind::Unknown, 0, Some("measure one record again"))
        );
        assert_eq!(unnamed.reason, "it is so; a possible cause: low pass at 5 kHz");
        assert_eq!(with(of(VerdictKind::None, Vec::new())).reason, "it is so");
    }
}
