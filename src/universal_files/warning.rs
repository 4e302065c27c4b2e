//! Tolerated faults.

use thiserror::Error;

use crate::evidence::{AxisName, SizeEvidence};
use crate::kind::OrdinateType;
use crate::place::FilePlace;

/// A tolerated fault; the text names place, finding and the value used.
///
/// `Error` is derived only for its `Display`: a warning never stops the reading.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{}{kind}", place.map_or_else(String::new, |place| format!("{place}: ")))]
pub struct Warning {
    /// Start of the dataset, the line, or the first of several places; `None` for faults at several.
    pub place: Option<FilePlace>,
    /// The fault.
    pub kind: WarningKind,
}

/// What a warning is about.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WarningKind {
    /// The byte count in the first line of a 58b is not the size of the payload.
    #[error("the first line states {} payload bytes; used {used}, by {evidence}", count_or_none(*found))]
    ByteCount {
        /// Count in the first line; `None` where it is blank or not a number.
        found: Option<u64>,
        /// Bytes used.
        used: u64,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// The payload has the size of the other precision.
    #[error("declared {declared}, but the payload has the size of {used}; read as {used}, by {evidence}")]
    Precision {
        /// Type in the header.
        declared: OrdinateType,
        /// Type read.
        used: OrdinateType,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// Uneven double payload with an abscissa of 8 bytes, where the format has 4, and no byte count that says so.
    #[error("the abscissa is stored in 8 bytes where the format has 4; read as 8, by {evidence}")]
    WideAbscissa {
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// The number of values in the header is not the number of values there are.
    #[error("declares {declared} values, holds {found}; used {found}, by {evidence}")]
    ValueCount {
        /// Count in the header.
        declared: u64,
        /// Values used.
        found: u64,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// The file ends inside the data.
    #[error(
        "the file ends inside the data: {found} of {declared} values; the copy is incomplete, get the whole file"
    )]
    Truncated {
        /// Count in the header.
        declared: u64,
        /// Whole values read.
        found: u64,
    },
    /// The file ends inside a header; that record is missing.
    #[error("the file ends inside the header of a dataset, which is dropped; get the whole file")]
    EndsInHeader,
    /// A dataset ends before its last line.
    #[error("dataset {dataset} ends {missing} lines too early; they are taken as blank")]
    ShortDataset {
        /// Dataset.
        dataset: u32,
        /// Lines missing.
        missing: usize,
    },
    /// The record declares no values and holds none.
    #[error("the record declares no values and holds none")]
    NoValues,
    /// More numbers in the last line than the count requires.
    #[error("{extra} more numbers in the last line than values declared (padding); dropped")]
    PaddedLine {
        /// Numbers dropped.
        extra: usize,
    },
    /// A Fortran `D` exponent in function data.
    #[error("exponents are written with D (first one here); read as E")]
    ExponentLetter,
    /// An exponent of three digits without its letter, such as `1.0-105`.
    #[error("an exponent has no letter, like 1.0-105 (first one here); read as 1.0E-105")]
    ExponentBare,
    /// CR or LF between a binary payload and the closing sentinel.
    #[error("{bytes} stray line-end bytes between the binary payload and the closing -1; skipped")]
    StrayLineEnd {
        /// Number of bytes.
        bytes: u64,
    },
    /// Blank lines among the data.
    #[error("blank line among the data; skipped")]
    BlankLine,
    /// Text between datasets.
    #[error("{lines} lines outside any dataset; skipped")]
    StrayText {
        /// Number of lines.
        lines: u64,
    },
    /// A dataset has no closing sentinel before the end of the file.
    #[error("the dataset has no closing -1")]
    MissingClosing,
    /// A dataset number follows a closing sentinel without an opening one.
    #[error("dataset number without an opening -1; read as a dataset")]
    MissingOpening,
    /// A sentinel outside columns 5 and 6.
    #[error("-1 outside columns 5 and 6; taken as the end of the dataset")]
    SentinelColumns,
    /// A line `    -1` among the data that does not end the dataset.
    #[error("a line -1 among the data without a dataset end after it (first one here); read as the value -1")]
    SentinelInData,
    /// The first line of a 58b states another number of header lines than 11.
    #[error("states that {found} header lines follow; used 11")]
    HeaderLines {
        /// Number found.
        found: i64,
    },
    /// A header line is not in the columns of the format.
    #[error("header line not in the columns of the format; split at its blanks")]
    HeaderColumns,
    /// Numeric fields of a header line are blank.
    #[error("blank numeric fields in the header line (first: {field}); read as 0")]
    BlankField {
        /// First blank field.
        field: &'static str,
    },
    /// A field filled with asterisks, since it is too narrow for its number.
    #[error("{field} is asterisks, since its field is too narrow; {taken}")]
    Overflown {
        /// The field.
        field: &'static str,
        /// What is taken instead.
        taken: &'static str,
    },
    /// Bytes beyond ASCII in a header line.
    #[error("characters beyond ASCII in the header; read as {read_as}")]
    NonAscii {
        /// Encoding used.
        read_as: &'static str,
    },
    /// An entity name that encodes another node or direction than the node and direction fields.
    #[error(
        "entity name `{entity}` contradicts node {node}, direction {direction}; used node and direction, kept the name"
    )]
    EntityConflict {
        /// The name.
        entity: String,
        /// Node field.
        node: i64,
        /// Direction field.
        direction: i64,
    },
    /// A direction code that the format does not have.
    #[error("direction {direction} is not one of 0, ±1…±6; kept")]
    UnknownDirection {
        /// The code.
        direction: i64,
    },
    /// A unit field is blank.
    #[error("the {axis} has no unit; {}", if *units_in_force { "dataset 164 is in force" } else { "no dataset 164 either: state the unit" })]
    BlankUnit {
        /// Axis.
        axis: AxisName,
        /// Whether a dataset 164 precedes the record.
        units_in_force: bool,
    },
    /// Negative abscissa values.
    #[error("{count} negative abscissa values, first {value} at index {index}")]
    NegativeAbscissa {
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Number of values.
        count: usize,
    },
    /// Abscissa values that repeat the one before.
    #[error("{count} abscissa values repeat the one before, first {value} at index {index}")]
    RepeatedAbscissa {
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Number of values.
        count: usize,
    },
    /// Abscissa values below the one before.
    #[error("{count} abscissa values are below the one before, first {value} at index {index}")]
    FallingAbscissa {
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Number of values.
        count: usize,
    },
    /// The factors of a dataset 164 are not those of its units code.
    #[error("units code {code}, but {factor} factor {found} instead of {expected}; used the factor")]
    UnitsConflict {
        /// Code.
        code: i64,
        /// Length or force.
        factor: &'static str,
        /// Factor in the file.
        found: f64,
        /// Factor of the code.
        expected: f64,
    },
    /// Faults between datasets beyond those listed one by one.
    #[error("{count} further faults between datasets")]
    Further {
        /// Number of faults.
        count: u64,
    },
}

impl WarningKind {
    /// Returns the warning of this fault at a place.
    pub(crate) fn at(self, place: FilePlace) -> Warning {
        Warning { place: Some(place), kind: self }
    }
}

fn count_or_none(count: Option<u64>) -> String {
    count.map_or_else(|| "no".to_owned(), |count| count.to_string())
}
