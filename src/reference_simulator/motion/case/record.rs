//! What a case gives away.

use crate::motion::belief::Belief;
use crate::motion::run::Log;

/// One record.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name.
    pub name: String,
    /// What was recorded, every millisecond.
    pub log: Log,
}

/// An axis, its records, and nothing of what is behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name; says nothing.
    pub name: String,
    /// What the engineer believes.
    pub belief: Belief,
    /// Records.
    pub records: Vec<Record>,
    /// Names of the records to fit; the others are held out.
    pub fit: Vec<String>,
    /// The held-out records as they would be without noise, unrest, jitter and rounding: to judge by, never given away.
    pub quiet: Vec<Record>,
    /// Parameters that the user declares known and keeps at their start values.
    pub freeze: Vec<String>,
    /// A second measurement of the same axis with more records.
    pub follow_up: Option<Box<Case>>,
}

impl Record {
    /// File of the record inside its set.
    pub fn file(&self) -> String {
        format!("motion/{}.csv", self.name)
    }
}
