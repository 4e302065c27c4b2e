//! The words of a configuration file for a number: written out, a parameter, or a stiffness made of something.

use schemars::JsonSchema;
use serde::Deserialize;

use machine::Source;

/// A number, a parameter by id, or a stiffness that is made of something.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, or the name of a parameter in quotes; for a stiffness also { contact = \"…\" }, { segment = \"…\" } or { series = […] }"
)]
pub enum Number {
    /// Fixed.
    Fixed(f64),
    /// Parameter.
    Named(String),
    /// Stiffness of a contact.
    Contact(ContactNumber),
    /// Stiffness of a screw segment.
    Segment(SegmentNumber),
    /// Springs in series.
    Series(SeriesNumber),
}

/// `{ contact = "name", times = "parameter" }`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactNumber {
    contact: String,
    times: Option<String>,
}

/// `{ segment = "name", times = "parameter" }`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentNumber {
    segment: String,
    times: Option<String>,
}

/// `{ series = [ … ], times = "parameter" }`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeriesNumber {
    series: Vec<Number>,
    times: Option<String>,
}

impl From<Number> for Source {
    fn from(number: Number) -> Self {
        let (source, times) = match number {
            Number::Fixed(x) => (Source::Number(x), None),
            Number::Named(id) => (Source::Parameter(id), None),
            Number::Contact(of) => (Source::Contact(of.contact), of.times),
            Number::Segment(of) => (Source::Segment(of.segment), of.times),
            Number::Series(of) => (Source::Series(of.series.into_iter().map(Source::from).collect()), of.times),
        };
        match times {
            None => source,
            Some(id) => Source::Times(Box::new(source), id),
        }
    }
}

/// A number that may be left out, which is 0 then.
pub fn source(number: Option<Number>) -> Source {
    number.map_or(Source::Number(0.0), Source::from)
}
