//! Measurement sets from and to files of other programs.

mod contents;
mod export;
mod imported;
mod place;
mod request;
mod source;

pub use contents::{FileContents, list_contents};
pub use export::{ExportedSet, export};
pub use imported::{ImportedSet, import};
pub use request::ImportRequest;
