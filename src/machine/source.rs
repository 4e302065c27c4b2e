//! Sources of numbers in a patch: a literal number, a parameter or a composed stiffness.

use schemars::JsonSchema;
use serde::Deserialize;

/// A number, a parameter by id, or a composed stiffness.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    rename = "Number",
    untagged,
    expecting = "expected a number, or the name of a parameter in quotes; for a stiffness also { contact = \"…\" }, { segment = \"…\" } or { series = […] }"
)]
pub enum NumberSource {
    /// Literal number.
    Number(f64),
    /// Parameter.
    Parameter(String),
    /// Stiffness of a contact.
    Contact(ContactNumber),
    /// Stiffness of a screw segment.
    Segment(SegmentNumber),
    /// Series of springs.
    Series(SeriesNumber),
    /// Another source multiplied by the parameter of that id.
    #[serde(skip)]
    Times(Box<NumberSource>, String),
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
    pub(super) series: Vec<NumberSource>,
    pub(super) times: Option<String>,
}

impl NumberSource {
    /// Returns the label for reports.
    pub(super) fn label(&self) -> String {
        match self {
            NumberSource::Number(number) => number.to_string(),
            NumberSource::Parameter(name)
            | NumberSource::Contact(ContactNumber { contact: name, .. })
            | NumberSource::Segment(SegmentNumber { segment: name, .. }) => name.clone(),
            NumberSource::Series(_) => "series".into(),
            NumberSource::Times(other, _) => other.label(),
        }
    }
}

impl Default for NumberSource {
    fn default() -> Self {
        NumberSource::Number(0.0)
    }
}
