//! Numbers of a patch: written out, a parameter, or a stiffness made of something.

use schemars::JsonSchema;
use serde::Deserialize;

/// A number, a parameter by id, or a stiffness that is made of something.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    rename = "Number",
    untagged,
    expecting = "expected a number, or the name of a parameter in quotes; for a stiffness also { contact = \"…\" }, { segment = \"…\" } or { series = […] }"
)]
pub enum Source {
    /// Fixed.
    Number(f64),
    /// Parameter.
    Parameter(String),
    /// Stiffness of a contact.
    Contact(ContactNumber),
    /// Stiffness of a screw segment.
    Segment(SegmentNumber),
    /// Springs in series.
    Series(SeriesNumber),
    /// Another one times the parameter of that id.
    #[serde(skip)]
    Times(Box<Source>, String),
}

/// `{ contact = "name", times = "parameter" }`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactNumber {
    pub(super) contact: String,
    pub(super) times: Option<String>,
}

/// `{ segment = "name", times = "parameter" }`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentNumber {
    pub(super) segment: String,
    pub(super) times: Option<String>,
}

/// `{ series = [ … ], times = "parameter" }`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeriesNumber {
    pub(super) series: Vec<Source>,
    pub(super) times: Option<String>,
}

impl Source {
    /// What a person calls it.
    pub(super) fn label(&self) -> String {
        match self {
            Source::Number(number) => number.to_string(),
            Source::Parameter(name)
            | Source::Contact(ContactNumber { contact: name, .. })
            | Source::Segment(SegmentNumber { segment: name, .. }) => name.clone(),
            Source::Series(_) => "series".into(),
            Source::Times(other, _) => other.label(),
        }
    }
}

impl Default for Source {
    fn default() -> Self {
        Source::Number(0.0)
    }
}
