//! The published part of a case.

use crate::motion::belief::Belief;
use crate::motion::run::Log;

/// One record.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name.
    pub name: String,
    /// Recorded channels, every millisecond.
    pub log: Log,
}

/// An axis description and its records, without any part of the label.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Neutral name.
    pub name: String,
    /// The engineer's description.
    pub belief: Belief,
    /// Records.
    pub records: Vec<Record>,
    /// Names of the fitted records; the others are held out.
    pub fit: Vec<String>,
    /// The held-out records without noise, random motor force, jitter and rounding. They serve the evaluation
    /// and are not published.
    pub quiet: Vec<Record>,
    /// Parameters that the case declares known and keeps at their start values.
    pub freeze: Vec<String>,
    /// A second measurement of the same axis with more records.
    pub follow_up: Option<Box<Case>>,
}

impl Record {
    /// Returns the path of the record inside its set.
    pub fn file(&self) -> String {
        format!("motion/{}.csv", self.name)
    }
}
