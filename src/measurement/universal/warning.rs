//! The faults that reading survives.

use thiserror::Error;

use super::evidence::{AxisName, SizeEvidence};
use super::kind::OrdinateType;
use super::place::FilePlace;

/// A fault that was survived; the text says where, what was found and what was taken instead.
///
/// `Error` is implemented for its `Display` alone: a warning never stops the reading.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Warning {
    /// The byte count in the first line of a 58b is not the size of the payload.
    #[error("{place}: the first line counts {} payload bytes; taken {used}, by {evidence}", count_or_none(*found))]
    ByteCount {
        /// Where the dataset starts.
        place: FilePlace,
        /// What the first line says; none when it is blank or no number.
        found: Option<u64>,
        /// Bytes taken.
        used: u64,
        /// What decided.
        evidence: SizeEvidence,
    },
    /// The payload has the size of the other precision.
    #[error("{place}: declared {declared}, but the payload has the size of {used}; read as that, by {evidence}")]
    Precision {
        /// Where the dataset starts.
        place: FilePlace,
        /// Type in the header.
        declared: OrdinateType,
        /// Type read.
        used: OrdinateType,
        /// What decided.
        evidence: SizeEvidence,
    },
    /// Uneven double payload with an abscissa of 8 bytes, where the format has 4.
    #[error("{place}: the abscissa is stored in 8 bytes where the format has 4; read as 8, by {evidence}")]
    WideAbscissa {
        /// Where the dataset starts.
        place: FilePlace,
        /// What decided.
        evidence: SizeEvidence,
    },
    /// The number of values in the header is not the number of values there are.
    #[error("{place}: declares {declared} values, holds {found}; took {found}, by {evidence}")]
    ValueCount {
        /// Where the dataset starts.
        place: FilePlace,
        /// Count in the header.
        declared: u64,
        /// Values taken.
        found: u64,
        /// What decided.
        evidence: SizeEvidence,
    },
    /// The file ends inside the data.
    #[error("{place}: the file ends inside the data: {found} of {declared} values; the copy is incomplete, get the whole file")]
    Truncated {
        /// Where the dataset starts.
        place: FilePlace,
        /// Count in the header.
        declared: u64,
        /// Whole values read.
        found: u64,
    },
    /// The file ends inside a header; that record is missing.
    #[error("{place}: the file ends inside the header of a dataset, which is left out; get the whole file")]
    EndsInHeader {
        /// Where the file ends.
        place: FilePlace,
    },
    /// A dataset ends before its last line.
    #[error("{place}: dataset {dataset} ends {missing} lines too early; they are taken as blank")]
    ShortDataset {
        /// Where it ends.
        place: FilePlace,
        /// Dataset.
        dataset: u32,
        /// Lines missing.
        missing: usize,
    },
    /// The record declares no values and holds none.
    #[error("{place}: the record declares no values and holds none")]
    NoValues {
        /// Where the dataset starts.
        place: FilePlace,
    },
    /// More numbers in the last line than the count asks for.
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
    /// An exponent of three digits without its letter, `1.0-105`.
    #[error("{place}: an exponent has no letter, like 1.0-105 (first one here); read as 1.0E-105")]
    ExponentBare {
        /// First such number.
        place: FilePlace,
    },
    /// CR or LF between a binary payload and the closing sentinel.
    #[error("{place}: {bytes} stray line-end bytes between the binary payload and the closing -1; skipped")]
    StrayLineEnd {
        /// Where they stand.
        place: FilePlace,
        /// How many.
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
        /// How many.
        lines: u64,
    },
    /// A dataset has no closing sentinel before the end of the file.
    #[error("{place}: the dataset has no closing -1")]
    MissingClosing {
        /// Where it should stand.
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
    /// A line `    -1` among the data that ends nothing.
    #[error("{place}: a line -1 among the data that no dataset end follows (first one here); read as the value -1")]
    SentinelInData {
        /// First such line.
        place: FilePlace,
    },
    /// The first line of a 58b says that other than 11 header lines follow.
    #[error("{place}: says that {found} header lines follow; took 11")]
    HeaderLines {
        /// The line.
        place: FilePlace,
        /// What it says.
        found: i64,
    },
    /// A header line is not in the columns of the format.
    #[error("{place}: header line not in the columns of the format; read by its blanks")]
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
    /// Bytes beyond ASCII in a header line.
    #[error("{place}: characters beyond ASCII in the header; read as {read_as}")]
    NonAscii {
        /// The line.
        place: FilePlace,
        /// Encoding taken.
        read_as: &'static str,
    },
    /// An entity name that spells another node or direction than the fields beside it.
    #[error("{place}: entity name `{entity}` beside node {node}, direction {direction}; took node and direction, kept the name")]
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
    #[error("{place}: direction {direction} is none of 0, ±1…±6; kept as it is")]
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
        /// Which axis.
        axis: AxisName,
        /// A dataset 164 stands before the record.
        units_in_force: bool,
    },
    /// Negative abscissa values.
    #[error("{place}: {count} negative abscissa values, first {value} at index {index}")]
    NegativeAbscissa {
        /// Where the dataset starts.
        place: FilePlace,
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// How many.
        count: usize,
    },
    /// Abscissa values that repeat the one before.
    #[error("{place}: {count} abscissa values repeat the one before, first {value} at index {index}")]
    RepeatedAbscissa {
        /// Where the dataset starts.
        place: FilePlace,
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// How many.
        count: usize,
    },
    /// Abscissa values below the one before.
    #[error("{place}: {count} abscissa values are below the one before, first {value} at index {index}")]
    FallingAbscissa {
        /// Where the dataset starts.
        place: FilePlace,
        /// First of them, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// How many.
        count: usize,
    },
    /// The factors of a dataset 164 are not those of its units code.
    #[error("{place}: units code {code}, but {factor} factor {found} instead of {expected}; took the factor")]
    UnitsConflict {
        /// Where the dataset starts.
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
    /// More faults between datasets than are listed one by one.
    #[error("{count} further faults between datasets")]
    Further {
        /// How many.
        count: u64,
    },
}

fn count_or_none(count: Option<u64>) -> String {
    count.map_or_else(|| "no".to_owned(), |count| count.to_string())
}
