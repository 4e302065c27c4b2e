//! Studies: identification, validation, comparison, diagnosis and planning for a machine and its measurements, and the documents of their results.

pub mod blind_check;
mod convergence;
mod document_rows;
mod error;
mod friction;
mod hybrid;
mod identified;
mod motion_records;
mod settings;
mod stamp;
mod study;

pub use convergence::convergence;
pub use error::{StudyError, StudyResult};
pub use friction::{FrictionRequest, friction};
pub use hybrid::{HybridRequest, hybrid};
pub use identified::{check_identification, read_identification};
pub use machine::contact::StribeckNoise;
pub use optimizer::{Control, Progress, Watcher};
pub use settings::{ObjectiveKind, Settings};
pub use study::{Sources, Study};
