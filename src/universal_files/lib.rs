#![doc = include_str!("README.md")]
//!
//! # Modules
//!
//! ```text
//! file ─ source ─ frame ─┬─ header ─┬─ ascii ── number
//!  (read)  (bytes) (-1)  │          └─ layout ─ binary      -> Record
//!                        └─ companion                       -> Units, Node, …
//! ```

mod abscissa;
mod ascii;
mod binary;
mod check;
mod columns;
mod companion;
mod error;
mod evidence;
mod field;
mod file;
mod frame;
mod header;
mod kind;
mod layout;
mod number;
mod place;
mod point;
mod reader;
mod record;
mod source;
mod units;
mod walk;
mod warning;
mod write;
mod write_error;
mod write_field;
mod write_payload;

#[cfg(test)]
mod tests;

pub use abscissa::Abscissa;
pub use companion::{FileHeader, Node, Skipped, TraceLine};
pub use error::UniversalError;
pub use evidence::{AxisName, SizeEvidence};
pub use file::{UniversalFile, read, read_headers, read_sound, read_where};
pub use kind::{ByteOrder, Encoding, OrdinateType, data_type, function_type};
pub use place::FilePlace;
pub use reader::{Dataset, UniversalReader};
pub use record::{NodeLocation, Ordinate, RecordAxis, RecordHeader, UniversalRecord};
pub use units::Units;
pub use warning::{Warning, WarningKind};
pub use write::{UniversalWriter, Written};
pub use write_error::WriteError;
