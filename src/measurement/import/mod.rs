//! Import of FRFs from universal files and CSV tables, with explicit conversion to SI.

mod csv;
mod frf;
mod label;
mod record;
mod write;

pub use csv::frf_from_csv;
pub use frf::ImportedFrf;
pub use record::{frfs_from_universal, is_of_frf};
pub use write::{Placement, set_files};
