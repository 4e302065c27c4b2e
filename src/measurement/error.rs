//! Faults of measurement sets.

use thiserror::Error;

/// A fault of a measurement set; the text names file, line or key, the finding and the remedy.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeasurementError {
    /// A fault at a line of a file.
    #[error("{path}, line {line}: {fault}")]
    Line {
        /// File.
        path: String,
        /// Line, from 1.
        line: u64,
        /// Finding and remedy.
        fault: String,
    },
    /// A fault of a file.
    #[error("{path}: {fault}")]
    File {
        /// File.
        path: String,
        /// Finding and remedy.
        fault: String,
    },
    /// A fault of a key of a file.
    #[error("{path}: {key}: {fault}")]
    Key {
        /// File.
        path: String,
        /// Key, for example `tolerance.gain`.
        key: String,
        /// Finding and remedy.
        fault: String,
    },
    /// A fault of one of several records of a file.
    #[error("{path}, record {record}: {fault}")]
    Record {
        /// File.
        path: String,
        /// Name of the record.
        record: String,
        /// Finding and remedy.
        fault: String,
    },
}

impl MeasurementError {
    pub(super) fn file(path: &str, fault: impl Into<String>) -> Self {
        MeasurementError::File { path: path.into(), fault: fault.into() }
    }

    pub(super) fn line(path: &str, line: u64, fault: impl Into<String>) -> Self {
        MeasurementError::Line { path: path.into(), line, fault: fault.into() }
    }

    pub(super) fn key(path: &str, key: impl Into<String>, fault: impl Into<String>) -> Self {
        MeasurementError::Key { path: path.into(), key: key.into(), fault: fault.into() }
    }

    pub(super) fn record(path: &str, record: &str, fault: impl Into<String>) -> Self {
        MeasurementError::Record { path: path.into(), record: record.into(), fault: fault.into() }
    }
}
