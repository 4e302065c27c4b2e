//! FRFs from files of other programs: universal files and tables in CSV, converted once and explicitly to SI.

mod csv;
mod frf;
mod label;
mod record;
mod write;

pub use csv::frf_from_csv;
pub use frf::ImportedFrf;
pub use record::{frfs_from_universal, is_of_frf};
pub use write::{Placement, set_files};
