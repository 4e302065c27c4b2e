//! Studies: identification, validation, comparison, diagnosis and planning for a machine and its measurements, and the documents of their results.

mod error;
mod identified;
mod settings;
pub mod simulation;
mod stamp;
mod study;

pub use dynamics::model::RodModel;
pub use error::{StudyError, StudyResult};
pub use identified::{check_identification, read_identification};
pub use measurement::Quantity;
pub use optimizer::{Control, Progress, Watcher};
pub use settings::{ObjectiveKind, Settings};
pub use study::{Sources, Study};
