//! The document of facts: everything on which the verdict of a diagnosis rests.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::effects::verdict_row;
use crate::{StudyError, StudyResult};
use diagnosis::{Facts, Policy, judge_without, verdict_by_evidence};
use file_access::{MOST_DOCUMENT_BYTES, read_text};
use report::diagnosis::VerdictRow;
use report::document::Stamp;
use report::vocabulary::VerdictKind;

/// `facts.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FactsDocument {
    /// Provenance.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// The verdict that was given.
    pub verdict: VerdictRow,
    /// The facts.
    pub facts: Facts,
}

impl FactsDocument {
    /// Schema of the document.
    const SCHEMA: &str = "jointid/facts/1";

    /// Reads facts.
    ///
    /// # Errors  the file cannot be read, is cut or of another version.
    pub fn read(path: &Path) -> StudyResult<Self> {
        let fault = |fault: String| StudyError::input(path.display(), fault);
        let text = read_text(path, MOST_DOCUMENT_BYTES).map_err(|error| fault(error.to_string()))?;
        let again = "write the facts of the diagnosis again";
        let found: Self = serde_json::from_str(&text)
            .map_err(|error| fault(format!("holds no facts: {error}; {again}")))?;
        if found.stamp.schema != Self::SCHEMA {
            return Err(fault(format!("has schema {}, not {}; {again}", found.stamp.schema, Self::SCHEMA)));
        }
        Ok(found)
    }

    /// Returns the numbers by which these facts are judged.
    pub fn policy(&self) -> &'static Policy {
        Policy::of(self.facts.data)
    }

    /// Judges the facts by the rules, without those of some names, and with given numbers. `None` where a rule needs
    /// facts that were not gathered.
    pub fn judge(&self, policy: &Policy, left_out: &[String]) -> Option<VerdictRow> {
        let judgement = judge_without(&self.facts, policy, left_out).ok()?;
        Some(VerdictRow { rule: Some(judgement.rule.into()), ..verdict_row(&judgement.verdict, None) })
    }

    /// Returns the verdict that probabilities would give in place of the rules; that of the rules where these find a
    /// fault of records, or too few data. `None` where the facts lack what probabilities rest on.
    pub fn by_evidence(&self) -> Option<VerdictRow> {
        match self.verdict.kind {
            VerdictKind::Measurement | VerdictKind::Insufficient | VerdictKind::WrongParameter => {
                Some(self.verdict.clone())
            }
            _ => Some(verdict_row(&verdict_by_evidence(&self.facts)?, None)),
        }
    }
}
