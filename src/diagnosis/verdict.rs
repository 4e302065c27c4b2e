//! The words of a verdict, of FRFs and of motions alike.

/// Kinds of verdicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerdictKind {
    /// Model and data agree within what ordinary nuisances and noise leave.
    None,
    /// One effect, or one combination, explains the gap.
    Effect,
    /// Several explain it, and the data cannot tell them apart.
    Ambiguous,
    /// Something is missing, but no effect of the library.
    Unknown,
    /// A frozen parameter is wrong.
    WrongParameter,
    /// A record contradicts the others.
    Measurement,
    /// The data are too few to say anything.
    Insufficient,
}

impl VerdictKind {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            VerdictKind::None => "none",
            VerdictKind::Effect => "effect",
            VerdictKind::Ambiguous => "ambiguous",
            VerdictKind::Unknown => "unknown",
            VerdictKind::WrongParameter => "wrong-parameter",
            VerdictKind::Measurement => "measurement",
            VerdictKind::Insufficient => "insufficient",
        }
    }

    /// Whether it names what explains the gap: effects, or a parameter that was frozen.
    pub fn explains(self) -> bool {
        matches!(self, VerdictKind::Effect | VerdictKind::Ambiguous | VerdictKind::WrongParameter)
    }
}

/// The verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Kind.
    pub kind: VerdictKind,
    /// Effects or combinations; empty for the kinds that name none.
    pub effects: Vec<String>,
    /// Why, in a sentence or two.
    pub reason: String,
    /// What to measure next.
    pub next: Option<String>,
}

impl Verdict {
    /// The effect that it names first.
    pub fn first_effect(&self) -> Option<&str> {
        self.effects.first().and_then(|names| names.split('+').next())
    }
}

/// Where nothing could be tried.
pub(super) fn nothing_fitted(before: f64) -> Verdict {
    let reason = format!("no candidate could be fitted; the misfit is {before:.1} times that of the middle null");
    Verdict { kind: VerdictKind::Unknown, effects: Vec::new(), reason, next: None }
}

/// The interface of an id such as «rotor:stiffness».
pub(super) fn named(id: &str) -> &str {
    id.rsplit_once(':').map_or(id, |(interface, _)| interface)
}

/// The effect that a combination was made with last.
pub(super) fn last_of(id: &str) -> &str {
    id.rsplit('+').next().unwrap_or(id)
}

/// A share of nulls, as it is told.
pub(super) fn p_value_text(p_value: f64) -> String {
    match p_value {
        p if p < 1e-4 => "p < 0.0001".into(),
        p if p < 0.01 => format!("p = {p:.4}"),
        p => format!("p = {p:.2}"),
    }
}
