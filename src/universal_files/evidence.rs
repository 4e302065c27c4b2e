//! References in warnings: evidence of a payload size, and axis names.

use std::fmt;

/// Evidence that decides the payload size of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeEvidence {
    /// Type × spacing × number of values, all from the header.
    TypeAndCount,
    /// The byte count in the dataset's first line.
    HeaderBytes,
    /// The distance to the next closing `    -1`.
    NextSentinel,
    /// The distance to the end of the file.
    EndOfFile,
}

impl fmt::Display for SizeEvidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TypeAndCount => "type × spacing × number of values",
            Self::HeaderBytes => "the byte count in the first line",
            Self::NextSentinel => "the distance to the next -1",
            Self::EndOfFile => "the distance to the end of the file",
        })
    }
}

/// One of the four axes of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisName {
    /// Record 8.
    Abscissa,
    /// Record 9.
    Ordinate,
    /// Record 10.
    Denominator,
    /// Record 11.
    Z,
}

impl fmt::Display for AxisName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Abscissa => "abscissa",
            Self::Ordinate => "ordinate",
            Self::Denominator => "ordinate denominator",
            Self::Z => "z axis",
        })
    }
}
