//! The blind check of the diagnosis: cases are made and sealed, diagnosed by the public command, and only
//! then scored against their labels.

mod check;
mod closed_share;
mod diagnose_cases;
mod layouts;
mod make_cases;
mod own_cases;
mod page;
pub mod replay;
mod request;

pub use crate::withheld::{Seal, WithheldDocument, withheld_text};
pub use check::BlindCheck;
pub use diagnose_cases::CaseAnswers;
pub use layouts::{Arm, Layouts};
pub use page::page;
pub use request::{BlindCheckRequest, CaseCount, CaseOrigin, Program};
