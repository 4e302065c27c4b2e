//! Errors of writing universal files.

use std::io;

use thiserror::Error;

/// Reason why a dataset is not written. No part of it has reached the output, unless the output itself
/// failed.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The output fails.
    #[error("writing the universal file: {0}")]
    Io(#[from] io::Error),
    /// Abscissa and ordinate differ in length.
    #[error("{abscissa} abscissa values for {ordinate} ordinate values; give one for each")]
    Lengths {
        /// Abscissa values.
        abscissa: usize,
        /// Ordinate values.
        ordinate: usize,
    },
    /// A value is NaN or infinite.
    #[error("{what} {index} is {value}; the format has no missing values: remove the point")]
    NotFinite {
        /// Kind of value.
        what: &'static str,
        /// Its index, from 0.
        index: usize,
        /// Value given.
        value: f64,
    },
    /// A value beyond the range of single precision.
    #[error("value {index}, {value}, is beyond single precision; write the record in double precision")]
    BeyondSingle {
        /// Its index, from 0.
        index: usize,
        /// Value given.
        value: f64,
    },
    /// An integer that does not fit its columns.
    #[error("{field} {value} does not fit {width} columns")]
    TooWide {
        /// The field.
        field: &'static str,
        /// Value given.
        value: i64,
        /// Width of the field in columns.
        width: usize,
    },
    /// A unit factor that is not a positive number.
    #[error("{field} factor {value}; give file units per SI unit, above 0")]
    Factor {
        /// The factor.
        field: &'static str,
        /// Value given.
        value: f64,
    },
}
