//! Closed vocabularies of the documents. Their words in JSON are also their words in text.

use std::fmt;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::de::value::StrDeserializer;
use serde::{Deserialize, Serialize};

use super::terminal::listed;

/// What a fit did with a position or record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Used in the fit.
    Fit,
    /// Predicted only.
    HeldOut,
}

impl Role {
    /// Returns the role of what was fitted or not.
    pub fn of(is_fitted: bool) -> Self {
        if is_fitted { Role::Fit } else { Role::HeldOut }
    }

    /// Returns its words in tables; in cross-validation what was fitted is left out of the fit that predicts
    /// it.
    pub fn label(self, leave_one_out: bool) -> &'static str {
        match (self, leave_one_out) {
            (Role::Fit, true) => "left out",
            (Role::Fit, false) => "fitted",
            (Role::HeldOut, _) => "held out",
        }
    }
}

/// What an identification minimises.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectiveKind {
    /// Weighted least squares of natural frequencies and ln(amplitude).
    #[default]
    LeastSquares,
    /// Eq. 26 of Tian et al. as printed.
    Eq26,
    /// Weighted least squares of natural frequencies only.
    Frequencies,
    /// Whole FRFs: complex logarithm of measured over predicted.
    Frf,
    /// Motion records: force that the rigid machine needs for the measured motion.
    InverseDynamics,
    /// Motion records: force of the closed loop, simulated from the command.
    OutputError,
}

/// Whether tolerances were fitted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ToleranceUse {
    /// They were fitted jointly with the parameters.
    Fit,
    /// They were held at their stated values.
    #[default]
    None,
}

/// Form of a prior distribution.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PriorKind {
    /// Normal distribution.
    #[default]
    Normal,
    /// Normal distribution of the logarithm.
    LogNormal,
    /// Normal distribution of sizes that have no sign.
    HalfNormal,
}

/// Kind of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataKind {
    /// Whole FRFs.
    Frf,
    /// Natural frequencies and amplitudes.
    Modes,
    /// Motion records.
    Motion,
}

/// Kind of a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
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

/// What became of a candidate of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EffectStatus {
    /// It was fitted.
    Tried,
    /// Its fit failed.
    Failed,
    /// It does not apply to the machine or the data.
    NotApplicable,
}

/// Quantity by which a misfit of motion records is divided into cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MisfitBy {
    /// Phase of the motion.
    Phase,
    /// Speed (m/s).
    SpeedMS,
    /// Position (m).
    PositionM,
}

/// Direction of the motion in a cell of the misfit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Against the positive axis.
    Backward,
    /// Both directions together.
    Both,
    /// Along the positive axis.
    Forward,
}

/// Writes words as they are in JSON.
macro_rules! written_as_in_json {
    ($($name:ty),*) => {$(
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.serialize(f)
            }
        }
    )*};
}

written_as_in_json!(Role, ObjectiveKind, VerdictKind, EffectStatus, Direction);

/// A word that a vocabulary lacks; its text names the words that there are.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct UnknownWord(String);

impl serde::de::Error for UnknownWord {
    fn custom<T: fmt::Display>(fault: T) -> Self {
        UnknownWord(fault.to_string())
    }

    fn unknown_variant(word: &str, known: &'static [&'static str]) -> Self {
        let known: Vec<String> = known.iter().map(ToString::to_string).collect();
        let what =
            if known.len() > 4 { format!("one of {}", known.join(", ")) } else { listed(&known, "or") };
        UnknownWord(format!("is «{word}»; write {what}"))
    }
}

/// Reads a word of a closed vocabulary.
///
/// # Errors
/// Names the word and those that there are.
pub fn word<T: DeserializeOwned>(text: &str) -> Result<T, UnknownWord> {
    T::deserialize(StrDeserializer::new(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuse_a_word_that_a_vocabulary_lacks() {
        assert_eq!(word::<Role>("hold").unwrap_err().to_string(), "is «hold»; write fit or held_out");
        assert_eq!(word::<DataKind>("uff").unwrap_err().to_string(), "is «uff»; write frf, modes or motion");
    }

    #[test]
    fn words_are_those_of_the_documents() {
        let json = |text: &str| serde_json::Value::from(text);
        assert_eq!(serde_json::to_value(MisfitBy::SpeedMS).unwrap(), json("speed_m_s"));
        assert_eq!(serde_json::to_value(MisfitBy::PositionM).unwrap(), json("position_m"));
        assert_eq!(serde_json::to_value(ObjectiveKind::Eq26).unwrap(), json("eq26"));
        assert_eq!(
            format!("{} {:>8}", VerdictKind::WrongParameter, Role::HeldOut),
            "wrong-parameter held_out"
        );
        assert_eq!(word::<ObjectiveKind>("inverse-dynamics"), Ok(ObjectiveKind::InverseDynamics));
    }
}
