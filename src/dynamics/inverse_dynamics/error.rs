//! Errors of inverse dynamics in a motion or in the machine that predicts it.

use thiserror::Error;

/// Why inverse dynamics is not possible.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InverseError {
    /// The record is too short to be filtered.
    #[error("{path}: has {samples} samples, but filtering and thinning need at least {needed}; record for longer, or sample faster")]
    Short {
        /// File.
        path: String,
        /// Number of samples.
        samples: usize,
        /// Number of samples needed.
        needed: usize,
    },
    /// The machine has no drive.
    #[error("the machine has no [drive], so that no force moves it; describe one")]
    NoDrive,
    /// The parts of the machine move relative to each other.
    #[error(
        "the machine is not one rigid axis ({fault}): its force does not follow from one position; use --objective output-error, or a description \
         of one moving mass"
    )]
    NotRigid {
        /// The independent motion.
        fault: String,
    },
    /// A parameter that the records cannot identify next to the others.
    #[error("{why}")]
    Unidentifiable {
        /// Index of the parameter in the machine.
        parameter: usize,
        /// Reason in words.
        why: String,
    },
    /// The record has a force where the drive needs a torque, or the reverse.
    #[error("{path}: has column {given}, but the drive acts on «{point}», which needs {wanted}; write that column")]
    Load {
        /// File.
        path: String,
        /// Column of the record.
        given: &'static str,
        /// Column that the drive needs.
        wanted: &'static str,
        /// The driven point.
        point: String,
    },
    /// The records are not sufficient.
    #[error("{0}")]
    Data(String),
}
