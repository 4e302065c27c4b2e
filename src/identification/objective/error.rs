//! Why an objective cannot be made.

use thiserror::Error;

use dynamics::model::ModelError;
use machine::MachineError;

/// Why an objective cannot be made.
#[derive(Debug, Error)]
pub enum ObjectiveError {
    /// The machine and the operating condition do not go together.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// The machine cannot be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The measurements do not suffice or do not fit the machine.
    #[error("{0}")]
    Data(String),
}
