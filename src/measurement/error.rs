//! What can be wrong with a measurement set.

use thiserror::Error;

/// What is wrong with a measurement set: the file, the line or key, what was found and what to write instead.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeasurementError {
    /// A fault at a line of a file.
    #[error("{path}, line {line}: {fault}")]
    Line {
        /// File.
        path: String,
        /// Line, from 1.
        line: u64,
        /// What was found and the mend.
        fault: String,
    },
    /// A fault of a file.
    #[error("{path}: {fault}")]
    File {
        /// File.
        path: String,
        /// What was found and the mend.
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
}
