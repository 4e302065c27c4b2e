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
}
