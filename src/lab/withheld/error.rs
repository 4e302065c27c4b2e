//! Errors of sealed cases and of answers.

use thiserror::Error;

use report::ReportError;
use study::StudyError;

/// What to do about a folder whose seal is broken.
const REMEDY: &str = "generate the cases again into a new folder";

/// Why cases cannot be verified, or why a diagnosis is no answer.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum WithheldError {
    /// A sealed file or folder is missing, of another kind, or was changed.
    #[error("{path}: {fault}; {REMEDY}")]
    Seal {
        /// File or folder.
        path: String,
        /// What was found.
        fault: String,
    },
    /// A file or folder cannot be read.
    #[error("{path}: {fault}")]
    Unreadable {
        /// File or folder.
        path: String,
        /// Reason.
        fault: String,
    },
    /// A seal has no JSON form (an error of the program).
    #[error("{0}")]
    Document(String),
    /// A diagnosis failed, or its document is not that of the case.
    #[error("{0}")]
    Diagnosis(String),
}

impl From<ReportError> for WithheldError {
    fn from(error: ReportError) -> Self {
        WithheldError::Document(error.to_string())
    }
}

impl From<WithheldError> for StudyError {
    fn from(error: WithheldError) -> Self {
        StudyError::impossible(error)
    }
}
