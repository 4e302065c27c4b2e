//! Errors of building an objective.

use thiserror::Error;

use dynamics::model::ModelError;
use machine::MachineError;

/// Why an objective cannot be built.
#[derive(Debug, Error)]
pub enum ObjectiveError {
    /// The machine does not permit the operating condition.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// The model of the machine cannot be built.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The measurements are insufficient or do not match the machine.
    #[error("{0}")]
    Data(String),
    /// A setting does not match the machine.
    #[error("{key} {given}: {fault}")]
    Setting {
        /// Name of the setting: `freeze`.
        key: &'static str,
        /// The setting as given.
        given: String,
        /// What was found and what to write.
        fault: String,
    },
}

impl ObjectiveError {
    /// Returns the name of the faulty setting, where a setting is at fault.
    pub fn setting(&self) -> Option<&'static str> {
        match self {
            ObjectiveError::Setting { key, .. } => Some(key),
            _ => None,
        }
    }
}
