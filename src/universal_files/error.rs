//! Faults that stop the reading of a record.

use std::io;

use thiserror::Error;

use crate::place::FilePlace;

/// Reason why a record or a file is refused; the text names place, finding and remedy.
#[derive(Debug, Error)]
pub enum UniversalError {
    /// The file cannot be read.
    #[error("reading the universal file: {0}")]
    Io(#[from] io::Error),
    /// Not a universal file.
    #[error(
        "no dataset found: a universal file has a line `    -1`, then a line with a dataset number; is this another format?"
    )]
    NoDataset,
    /// Lines end in CR alone.
    #[error("lines end in a bare CR, without LF; convert the line ends to LF or CR LF")]
    BareCarriageReturn,
    /// A header ends before its last line.
    #[error(
        "{place}: the header of dataset {dataset} ends here, {missing} lines too early; export the record again"
    )]
    ShortHeader {
        /// Place of the end.
        place: FilePlace,
        /// Dataset.
        dataset: u32,
        /// Lines missing.
        missing: usize,
    },
    /// The file ends inside a header.
    #[error("{place}: the file ends inside the header of dataset {dataset}; get the whole file")]
    EndsInHeader {
        /// Place of the end.
        place: FilePlace,
        /// Dataset.
        dataset: u32,
    },
    /// A header field has unexpected content.
    #[error("{place}: {field} is `{found}`; {expected}")]
    Field {
        /// The line.
        place: FilePlace,
        /// Name of the field.
        field: &'static str,
        /// Text found.
        found: String,
        /// Expected content.
        expected: &'static str,
    },
    /// Floating point other than IEEE.
    #[error(
        "{place}: the payload is in {format} floating point, which is not read; export with IEEE floating point (code 2) or as ASCII"
    )]
    FloatFormat {
        /// The line.
        place: FilePlace,
        /// Name of the format.
        format: String,
    },
    /// The size of a binary payload cannot be determined.
    #[error(
        "{place}: payload size unclear: {count} values make {expected} bytes, the first line states {}, the next -1 or the file's end \
         follows after {distance}; correct type, spacing or count, or export the record again",
        header_bytes.map_or_else(|| "nothing".to_owned(), |bytes| bytes.to_string())
    )]
    PayloadSize {
        /// Start of the dataset.
        place: FilePlace,
        /// Number of values declared.
        count: u64,
        /// Bytes by type × spacing × count.
        expected: u64,
        /// Bytes by the first line.
        header_bytes: Option<u64>,
        /// Bytes to the next closing sentinel or the end of the file.
        distance: u64,
    },
    /// A value is NaN or infinite.
    #[error(
        "{place}: value {index} is {found}; a missing value cannot be used: export again or cut the record before it"
    )]
    NotFinite {
        /// Place of the value.
        place: FilePlace,
        /// Index among the values, from 0.
        index: u64,
        /// Text found.
        found: String,
    },
    /// Text among the data that is not a number.
    #[error("{place}, column {column}: `{found}` is not a number; write a number such as 1.5E-03")]
    NotANumber {
        /// The line.
        place: FilePlace,
        /// Column, from 1.
        column: usize,
        /// Text found.
        found: String,
    },
    /// Data continue after the declared values.
    #[error(
        "{place}: the {declared} values declared end above, but `{found}` follows instead of -1; correct the count or the ordinate type"
    )]
    DataGoOn {
        /// The line.
        place: FilePlace,
        /// Count in the header.
        declared: u64,
        /// Start of what follows.
        found: String,
    },
    /// As many numbers as another type or spacing would need.
    #[error(
        "{place}: {found} numbers for {declared} values of {needed} numbers each; type or spacing in the header does not fit the data: \
         correct record 7"
    )]
    NumbersPerValue {
        /// Start of the dataset.
        place: FilePlace,
        /// Numbers found.
        found: u64,
        /// Count in the header.
        declared: u64,
        /// Numbers per value by type and spacing.
        needed: usize,
    },
    /// Fewer values than declared, and a line among them is shorter than the others.
    #[error(
        "{place}: fewer numbers in this line than in the first ({found} for {expected}), and values are missing: a blank field shifts all that follow"
    )]
    ShortLine {
        /// The line.
        place: FilePlace,
        /// Numbers in it.
        found: usize,
        /// Numbers in the first line.
        expected: usize,
    },
    /// Datasets so short that the memory for them exceeds the file size.
    #[error("{place}: thousands of {what} with almost no content; this is not a measured file")]
    TooManySmall {
        /// Place reached.
        place: FilePlace,
        /// Kind of dataset or entry.
        what: &'static str,
    },
    /// A line that is too long.
    #[error("{place}: a line of more than {limit} bytes; this is not a text dataset")]
    LineTooLong {
        /// The line.
        place: FilePlace,
        /// Longest line read.
        limit: usize,
    },
}
