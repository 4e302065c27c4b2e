//! Reads and writes universal files (`.uff`, `.unv`): the functions of dataset 58 and their companion datasets.
//!
//! A file is a sequence of datasets. Lines with `    -1` in the first six columns frame each dataset; the line after the first of them holds
//! its number:
//!
//! | dataset | content | here |
//! |---|---|---|
//! | 58, 58b | function at a node: a spectrum, an FRF, a time history | [`UniversalRecord`], ASCII or binary, even or uneven abscissa |
//! | 151 | header of the file | [`FileHeader`] |
//! | 164 | units: SI = value in the file / factor | [`Units`], kept with every record they are in force for |
//! | 15, 2411 | nodes | [`Node`] |
//! | 82 | trace lines | [`TraceLine`] |
//! | others | | listed in [`Skipped`] |
//!
//! Real files violate the format in many ways. Each fault is either tolerated and reported in a [`Warning`] with its place, or refused
//! with a [`UniversalError`] that names place, finding and remedy. Nothing is guessed silently.
//!
//! ```text
//! file ─ source ─ frame ─┬─ header ─┬─ ascii ── number
//!  (read)  (bytes) (-1)  │          └─ layout ─ binary      -> Record
//!                        └─ companion                       -> Units, Node, …
//! ```
//!
//! # Memory
//!
//! [`UniversalReader`] holds one record at a time, [`UniversalReader::next_header`] only its header. No count in a header reserves more
//! memory than the remaining bytes of the file can fill.
//!
//! # Source
//!
//! The dataset pages 58, 58b, 151, 164, 15, 2411 and 82 of the Structural Dynamics Research Laboratory, University of Cincinnati
//! (format); files of real instruments (faults).

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
pub use file::{UniversalFile, read, read_headers, read_headers_path, read_path, read_path_sound, read_path_where, read_sound};
pub use kind::{ByteOrder, Encoding, OrdinateType, data_type, function_type};
pub use place::FilePlace;
pub use reader::{Dataset, UniversalReader};
pub use record::{NodeLocation, Ordinate, RecordAxis, RecordHeader, UniversalRecord};
pub use units::Units;
pub use warning::Warning;
pub use write::{UniversalWriter, Written};
pub use write_error::WriteError;
