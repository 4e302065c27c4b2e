//! Saying it: result documents with their provenance, written whole or not at all, and tables for the
//! terminal.

pub mod certainty;
pub mod change;
mod claim;
mod content;
mod csv_cell;
pub mod diagnosis;
mod diagnosis_text;
pub mod document;
pub mod effects;
mod error;
mod friction;
pub mod hybrid;
mod identification;
pub mod loops;
mod loops_text;
pub mod motion;
mod motion_row;
mod motion_text;
mod null_row;
pub mod order;
pub mod page;
mod parameter;
mod plan;
pub mod prediction;
mod provenance;
pub mod record;
mod schema;
pub mod simulation;
mod simulation_text;
mod table;
mod terminal;
mod text_table;
pub mod vocabulary;
mod write;

pub use change::change_text;
pub use claim::release_claims;
pub use content::{UniqueKeys, content_fault, digest_of};
pub use csv_cell::csv_cell;
pub use diagnosis_text::{diagnosis_text, why_text};
pub use error::ReportError;
pub use file_access::{Existing, Run, printable, shortened};
pub use friction::friction_text;
pub use identification::{comparison_text, identification_text, validation_text};
pub use loops_text::{bode_text, hold_gains_text, hold_text};
pub use motion_text::{motion_csv, motion_summary};
pub use numeric::digest::digest;
pub use plan::plan_table;
pub use prediction::{predicted_frfs_csv, prediction_csv, prediction_text};
pub use schema::{SCHEMAS, schema};
pub use simulation_text::{frfs_csv, modes_text, sweep_text};
pub use table::{objectives_table, peaks_table};
pub use terminal::{brief_numbers, columns, width, wrapped};
pub use write::{EARLIER, OutputFolder, to_json};

#[cfg(test)]
mod tests;
