//! Studies: identification, validation, comparison, diagnosis and planning for a machine and its measurements, and the documents of their results.

mod error;
mod settings;
mod stamp;
mod study;

pub use error::{StudyError, StudyResult};
pub use settings::{ObjectiveKind, Settings};
pub use study::{Sources, Study};
