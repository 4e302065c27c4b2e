//! What can be wrong with a configuration.

use thiserror::Error;

/// What is wrong with a configuration; the text names file, line or key, and the mend.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// It cannot be read.
    #[error("{path}: {fault}")]
    Unreadable {
        /// File.
        path: String,
        /// Reason.
        fault: String,
    },
    /// It is not what it should be.
    #[error("{path}, line {line}: {fault}")]
    Syntax {
        /// File.
        path: String,
        /// Line, from 1.
        line: usize,
        /// What was found and what to write.
        fault: String,
    },
    /// Its content makes no machine.
    #[error("{path}: {fault}")]
    Content {
        /// File.
        path: String,
        /// Key, what was found, what to write.
        fault: String,
    },
    /// An override cannot be applied.
    #[error("--set {given}: {fault}")]
    Override {
        /// As given.
        given: String,
        /// What to write.
        fault: String,
    },
}
