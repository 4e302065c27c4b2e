//! Errors of inverse dynamics: faults of the records or of the machine description.

use thiserror::Error;

/// A fault that prevents inverse dynamics.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InverseError {
    /// The work was stopped before there was a result.
    #[error("stopped before there was a result")]
    Stopped,
    /// The record is too short for filtering and decimation.
    #[error("{path}: has {samples} samples; filtering and decimation need {needed}; record a longer motion")]
    Short {
        /// File of the record.
        path: String,
        /// Number of samples.
        samples: usize,
        /// Least number of samples.
        needed: usize,
    },
    /// The machine has no drive.
    #[error("the machine has no [drive], so that no force moves it; describe one")]
    NoDrive,
    /// The machine has more than one independent motion, or none that moves both drive and encoder.
    #[error(
        "the machine is not one rigid axis ({fault}): its force does not follow from one position; use the output-error objective, or a \
         description of one moving mass"
    )]
    NotRigid {
        /// Fault of the rigid-body motion, as a part of a sentence.
        fault: String,
    },
    /// The records do not identify a parameter in addition to the others.
    #[error("{why}")]
    Unidentifiable {
        /// Index of the parameter in the machine.
        parameter: usize,
        /// Complete message.
        why: String,
    },
    /// The record contains a force where the drive needs a torque, or the reverse.
    #[error(
        "{path}: has column {given}, but the drive acts on «{point}», which needs {wanted}; write that column"
    )]
    Load {
        /// File of the record.
        path: String,
        /// Column of the record with the load.
        given: &'static str,
        /// Column that the drive needs.
        wanted: &'static str,
        /// Name of the driven point.
        point: String,
    },
    /// A record has angles where the encoder reads a travel.
    #[error(
        "{path}: has column position_rad, but the encoder at «{point}» reads a travel; write position_m and command_m"
    )]
    Angle {
        /// File of the record.
        path: String,
        /// Name of the point at which the encoder is mounted.
        point: String,
    },
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
    /// Any other fault, as a complete message.
    #[error("{0}")]
    Data(String),
}

impl InverseError {
    /// Returns the name of the faulty setting, where a setting is at fault.
    pub fn setting(&self) -> Option<&'static str> {
        match self {
            InverseError::Setting { key, .. } => Some(key),
            _ => None,
        }
    }
}
