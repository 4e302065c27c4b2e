//! Tolerated faults.

use thiserror::Error;

use crate::evidence::{AxisName, SizeEvidence};
use crate::kind::OrdinateType;
use crate::place::FilePlace;

/// A tolerated fault; the text names place, finding and the value used.
///
/// `Error` is derived only for its `Display`: a warning never stops the reading.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Warning {
    /// The byte count in the first line of a 58b is not the size of the payload.
    #[error("{place}: the first line states {} payload bytes; used {used}, by {evidence}", count_or_none(*found))]
    ByteCount {
        /// Start of the dataset.
        place: FilePlace,
        /// Count in the first line; `None` where it is blank or not a number.
        found: Option<u64>,
        /// Bytes used.
        used: u64,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// The payload has the size of the other precision.
    #[error(
        "{place}: declared {declared}, but the payload has the size of {used}; read as {used}, by {evidence}"
    )]
    Precision {
        /// Start of the dataset.
        place: FilePlace,
        /// Type in the header.
        declared: OrdinateType,
        /// Type read.
        used: OrdinateType,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// Uneven double payload with an abscissa of 8 bytes, where the format has 4.
    #[error("{place}: the abscissa is stored in 8 bytes where the format has 4; read as 8, by {evidence}")]
    WideAbscissa {
        /// Start of the dataset.
        place: FilePlace,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// The number of values in the header is not the number of values there are.
    #[error("{place}: declares {declared} values, holds {found}; used {found}, by {evidence}")]
    ValueCount {
        /// Start of the dataset.
        place: FilePlace,
        /// Count in the header.
        declared: u64,
        /// Values used.
        found: u64,
        /// Evidence for the choice.
        evidence: SizeEvidence,
    },
    /// The file ends inside the data.
    #[error(
        "{place}: the file ends inside the data: {found} of {declared} values; the copy is incomplete, get the whole file"
    )]
    Truncated {
        /// Start of the dataset.
        place: FilePlace,
        /// Count in the header.
        declared: u64,
        /// Whole values read.
        found: u64,
    },
    /// The file ends inside a header; that record is missing.
    #[error("{place}: the file ends inside the header of a dataset, which is dropped; get the whole file")]
    EndsInHeader {
        /// Place of the end of the file.
        place: FilePlace,
    },
    /// A dataset ends before its last line.
    #[error("{place}: dataset {dataset} ends {missing} lines too early; they are taken as blank")]
    ShortDataset {
        /// Place of the end.
        place: FilePlace,
        /// Dataset.
        dataset: u32,
        /// Lines missing.
        missing: usize,
    },
    /// The record declares no values and holds none.
    #[error("{place}: the record declares no values and holds none")]
    NoValues {
        /// Start of the dataset.
        place: FilePlace,
    },
    /// More numbers in the last line than the count requires.
    #[error("{place}: {extra} more numbers in the last line than values declared (padding); dropped")]
    PaddedLine {
        /// The line.
        place: FilePlace,
        /// Numbers dropped.
        extra: usize,
    },
    /// A Fortran `D` exponent in function data.
    #[error("{place}: exponents are written with D (first one here); read as E")]
    ExponentLetter {
        /// First such number.
        place: FilePlace,
    },
    /// An exponent of three digits without its letter, such as `1.0-105`.
    #[error("{place}: an exponent has no letter, like 1.0-105 (first one here); read as 1.0E-105")]
    ExponentBare {
        /// First such number.
        place: FilePlace,
    },
    /// CR or LF between a binary payload and the closing sentinel.
    #[error("{place}: {bytes} stray line-end bytes between the binary payload and the closing -1; skipped")]
    StrayLineEnd {
        /// Place of the first.
        place: FilePlace,
        /// Number of bytes.
        bytes: u64,
    },
    /// Blank lines among the data.
    #[error("{place}: blank line among the data; skipped")]
    BlankLine {
        /// First of them.
        place: FilePlace,
    },
    /// Text between datasets.
    #[error("{place}: {lines} lines outside any dataset; skipped")]
    StrayText {
        /// First of them.
        place: FilePlace,
        /// Number of lines.
        lines: u64,
    },
    /// A dataset has no closing sentinel before the end of the file.
    #[error("{place}: the dataset has no closing -1")]
    MissingClosing {
        /// Expected place.
        place: FilePlace,
    },
    /// A dataset number follows a closing sentinel without an opening one.
    #[error("{place}: dataset number without an opening -1; read as a dataset")]
    MissingOpening {
        /// The dataset number's line.
        place: FilePlace,
    },
    /// A sentinel outside columns 5 and 6.
    #[error("{place}: -1 outside columns 5 and 6; taken as the end of the dataset")]
    SentinelColumns {
        /// The line.
        place: FilePlace,
    },
    /// A line `    -1` among the data that does not end the dataset.
    #[error(
        "{place}: a line -1 among the data without a dataset end after it (first one here); read as the value -1"
    )]
    SentinelInData {
        /// First such line.
        place: FilePlace,
    },
    /// The first line of a 58b states another number of header lines than 11.
    #[error("{place}: states that {found} header lines follow; used 11")]
    HeaderLines {
        /// The line.
        place: FilePlace,
        /// Number found.
        found: i64,
    },
    /// A header line is not in the columns of the format.
    #[error("{place}: header line not in the columns of the format; split at its blanks")]
    HeaderColumns {
        /// The line.
        place: FilePlace,
    },
    /// Numeric fields of a header line are blank.
    #[error("{place}: blank numeric fields in the header line (first: {field}); read as 0")]
    BlankField {
        /// The line.
        place: FilePlace,
        /// First blank field.
        field: &'static str,
    },
    /// A field filled with asterisks, since it is too narrow for its number.
    #[error("{place}: {field} is asterisks, since its field is too narrow; {taken}")]
    Overflown {
        /// The line.
        place: FilePlace,
        /// The field.
        field: &'static str,
        /// What is taken instead.
        taken: &'static str,
    },
    /// Bytes beyond ASCII in a header line.
    #[error("{place}: characters beyond ASCII in the header; read as {read_as}")]
    NonAscii {
        /// The line.
        place: FilePlace,
        /// Encoding used.
        read_as: &'static str,
    },
    /// An entity name that encodes another node or direction than the node and direction fields.
    #[error(
        "{place}: entity name `{entity}` contradicts node {node}, direction {direction}; used node and direction, kept the name"
    )]
    EntityConflict {
        /// The line.
        place: FilePlace,
        /// The name.
        entity: String,
        /// Node field.
        node: i64,
        /// Direction field.
        direction: i64,
    },
    /// A direction code that the format does not have.
    #[error("{place}: direction {direction} is not one of 0, ±1…±6; kept")]
    UnknownDirection {
        /// The line.
        place: FilePlace,
        /// The code.
        direction: i64,
    },
    /// A unit field is blank.
    #[error("{place}: the {axis} has no unit; {}", if *units_in_force { "dataset 164 is in force" } else { "no dataset 164 either: state the unit" })]
    BlankUnit {
        /// The line.
        place: FilePlace,
        /// Axis.
        axis: AxisName,
        /// Whether a dataset 164 precedes the record.
        units_in_force: bool,
    },
    /// Negative abscissa values.
    #[error("{place}: {count} negative abscissa values, first {value} at index {index}")]
    NegativeAbscissa {
        /// Start of the dataset.
        place: FilePlace,
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Number of values.
        count: usize,
    },
    /// Abscissa values that repeat the one before.
    #[error("{place}: {count} abscissa values repeat the one before, first {value} at index {index}")]
    RepeatedAbscissa {
        /// Start of the dataset.
        place: FilePlace,
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Number of values.
        count: usize,
    },
    /// Abscissa values below the one before.
    #[error("{place}: {count} abscissa values are below the one before, first {value} at index {index}")]
    FallingAbscissa {
        /// Start of the dataset.
        place: FilePlace,
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Number of values.
        count: usize,
    },
    /// The factors of a dataset 164 are not those of its units code.
    #[error("{place}: units code {code}, but {factor} factor {found} instead of {expected}; used the factor")]
    UnitsConflict {
        /// Start of the dataset.
        place: FilePlace,
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

fn count_or_none(count: Option<u64>) -> String {
    count.map_or_else(|| "no".to_owned(), |count| count.to_string())
}
