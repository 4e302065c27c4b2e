//! Errors in a description.

use thiserror::Error;

/// An error in a description; the message states the correction.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{part}: {fault}")]
pub struct MachineError {
    /// The part, for example `joint.nut.stiffness`.
    pub part: String,
    /// What was found and what to write instead.
    pub fault: String,
}

pub(super) fn fault(part: impl Into<String>, fault: impl Into<String>) -> MachineError {
    MachineError { part: part.into(), fault: fault.into() }
}

pub(super) fn listing<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "there are none".into() } else { format!("there are {}", names.join(", ")) }
}
