//! Errors of configurations.

use thiserror::Error;

/// An error in a configuration; the message names file, line or key, and the correction.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{path}: {fault}")]
    Unreadable {
        /// File.
        path: String,
        /// Reason.
        fault: String,
    },
    /// The file has a syntax error or a key or value of the wrong type.
    #[error("{path}, line {line}: {fault}")]
    Syntax {
        /// File.
        path: String,
        /// Line, from 1.
        line: usize,
        /// What was found and what to write.
        fault: String,
    },
    /// The content does not describe a valid machine.
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
        /// The override as given.
        given: String,
        /// What to write instead.
        fault: String,
    },
}
