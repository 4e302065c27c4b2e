//! Why a motion cannot be simulated.

use thiserror::Error;

use crate::model::ModelError;

/// Why a motion cannot be simulated; the text says what to write instead.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MotionError {
    /// The machine has no drive.
    #[error("the machine has no drive; describe one as [drive]")]
    NoDrive,
    /// Its matrices cannot be made.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A point that something acts on has no inertia.
    #[error("{part} acts on point «{point}», which has no inertia; give it one")]
    Massless {
        /// What acts on it.
        part: String,
        /// The point.
        point: String,
    },
    /// Settings or reference that cannot be used.
    #[error("{0}")]
    Input(String),
    /// Events follow each other without end.
    #[error("at {time_s} s more than {count} events fall into one period of the velocity loop; {last} changes without end")]
    Endless {
        /// When.
        time_s: f64,
        /// How many.
        count: usize,
        /// What changed last.
        last: String,
    },
}
