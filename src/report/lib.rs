//! Saying it: result documents with their provenance, written whole or not at all, and tables for the terminal.

pub mod certainty;
mod claim;
pub mod diagnosis;
pub mod document;
pub mod effects;
mod error;
pub mod hybrid;
pub mod loops;
pub mod motion;
mod motion_row;
pub mod page;
pub mod record;
mod schema;
pub mod simulation;
mod table;
mod terminal;

mod write;

pub use error::ReportError;
pub use numeric::digest::digest;
pub use schema::{SCHEMAS, schema};
pub use table::{
    bootstrap_table, derived_table, frfs_table, gap_summary_table, gaps_table, moved_tolerances, objectives_table, parameters_table,
    peaks_table, plan_table, positions_table, summary_table,
};
pub use terminal::{columns, width, wrapped};
pub use write::{OutputFolder, to_json};
