//! What can be wrong with a motion or with a machine that is to explain it.

use thiserror::Error;

/// Why inverse dynamics cannot be had.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InverseError {
    /// The record cannot be filtered.
    #[error("{path}: has {samples} samples, but filtering and thinning need at least {needed}; record for longer, or sample faster")]
    Short {
        /// File.
        path: String,
        /// Samples it has.
        samples: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The machine has no drive.
    #[error("the machine describes no [drive], so that no force moves it; describe one")]
    NoDrive,
    /// Its parts move against each other.
    #[error(
        "the machine is not one rigid axis ({fault}): its force does not follow from one position; use --objective output-error, or a description \
         of one moving mass"
    )]
    NotRigid {
        /// What moves.
        fault: String,
    },
    /// A parameter that records do not tell beside the others.
    #[error("{why}")]
    Unidentifiable {
        /// Index in the machine.
        parameter: usize,
        /// In words.
        why: String,
    },
    /// Force recorded for a torque, or the reverse.
    #[error("{path}: gives {given}, but the drive moves «{point}», which takes {wanted}; write that column")]
    Load {
        /// File.
        path: String,
        /// Column it has.
        given: &'static str,
        /// Column the drive asks for.
        wanted: &'static str,
        /// The driven point.
        point: String,
    },
    /// The records do not determine what is asked for.
    #[error("{0}")]
    Data(String),
}
