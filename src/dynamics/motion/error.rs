//! Errors of a simulation in time.

use thiserror::Error;

use crate::model::ModelError;

/// Why a motion cannot be simulated; the text gives the remedy.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MotionError {
    /// The machine has no drive.
    #[error("the machine has no drive; describe one as [drive]")]
    NoDrive,
    /// The matrices of the machine cannot be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A point on which a part acts has no inertia.
    #[error("{part} acts on point «{point}», which has no inertia; give it one")]
    Massless {
        /// The part that acts on it.
        part: String,
        /// The point.
        point: String,
    },
    /// Invalid settings or reference.
    #[error("{0}")]
    Input(String),
    /// Events follow each other without end.
    #[error(
        "at {time_s} s more than {count} events fall into one period of the velocity loop; «{last}» keeps switching"
    )]
    Endless {
        /// Time (s).
        time_s: f64,
        /// Number of events.
        count: usize,
        /// Joint that changed last.
        last: String,
    },
    /// A part of the machine changes too fast for the period of the loops.
    #[error(
        "at {time_s} s {within} needs more than {count} steps: {part} makes the machine change faster than can be followed; check that number"
    )]
    TooFast {
        /// Time (s).
        time_s: f64,
        /// What needs the steps.
        within: &'static str,
        /// Largest number of steps.
        count: usize,
        /// Configuration key of the part, with its number where one alone is to blame.
        part: String,
    },
}
