//! Errors of writing result documents.

use std::io;
use std::path::Path;

use thiserror::Error;

/// Why a document or a result folder cannot be written; the message names the path and the correction.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A document has no JSON form (an error of the program).
    #[error("cannot write the document as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A path is not suitable, or another run writes there.
    #[error("{path}: {fault}")]
    Target {
        /// File or folder.
        path: String,
        /// What was found and what to do.
        fault: String,
    },
    /// The operating system refuses the writing.
    #[error("{path}: cannot be written: {source}")]
    Unwritable {
        /// File or folder.
        path: String,
        /// Reason.
        source: io::Error,
    },
}

impl ReportError {
    pub(super) fn target(path: &Path, fault: impl Into<String>) -> Self {
        ReportError::Target { path: path.display().to_string(), fault: fault.into() }
    }

    /// Adds the path to an error of writing.
    pub(super) fn unwritable(path: &Path) -> impl Fn(io::Error) -> Self + '_ {
        move |source| ReportError::Unwritable { path: path.display().to_string(), source }
    }
}
