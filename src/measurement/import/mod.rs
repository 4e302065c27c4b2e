//! Import of FRFs from universal files and tables, with explicit conversion to SI.

mod axis;
mod coherence;
mod column;
mod frf;
mod imported_table;
mod layout;
mod place;
mod record;
mod table;
mod text;
mod unit;
mod write;

pub use frf::ImportedFrf;
pub(super) use imported_table::ImportedTable;
pub use record::{described, frfs_from_universal, is_of_frf};
pub use table::{TableRequest, described_table, frfs_from_table};
pub use text::decoded;
pub use write::{Placement, left_behind, set_files, set_of};

#[cfg(test)]
mod tests;
