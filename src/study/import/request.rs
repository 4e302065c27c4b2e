//! Request of an import.

use std::collections::BTreeMap;
use std::path::PathBuf;

use measurement::Quantity;

/// What to import, and what the files do not state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportRequest {
    /// Universal files (dataset 58, 58b) or tables (.csv, .tsv, .txt, .dat, .asc).
    pub files: Vec<PathBuf>,
    /// Names of the columns of all tables, in place of their headers.
    pub columns: Option<Vec<String>>,
    /// Whether any faulty part refuses its file; otherwise the sound parts are imported, and what is left out
    /// is named.
    pub strict: bool,
    /// Whether files that end inside their data are accepted.
    pub accept_truncated: bool,
    /// Measured quantity.
    pub quantity: Option<Quantity>,
    /// Position of all records.
    pub position: Option<String>,
    /// Pattern with {} for the position's name, in file names, ID lines or entities.
    pub pattern: Option<String>,
    /// Table that assigns records, with the columns record,position,response,excitation.
    pub map: Option<PathBuf>,
    /// Nut positions (m) by position.
    pub nut_m: BTreeMap<String, f64>,
    /// Response point of all records.
    pub response: Option<String>,
    /// Excitation point of all records.
    pub excitation: Option<String>,
    /// Number of averages of each FRF; required to use a coherence.
    pub averages: Option<u32>,
    /// Title of the set.
    pub title: String,
}
