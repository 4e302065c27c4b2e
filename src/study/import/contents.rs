//! Contents of files, from their headers.

use std::path::PathBuf;

use super::source::{is_table, open_universal, table_text};
use crate::{StudyError, StudyResult};
use measurement::import::{TableRequest, described, described_table};
use universal_files::read_headers;

/// Contents of a file, from its headers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileContents {
    /// Text, one record per line.
    pub text: String,
    /// Warnings about the file.
    pub warnings: Vec<String>,
}

/// Lists the records of files: type, lines, range of frequency, places with directions, units, quantity.
///
/// # Errors  a file cannot be read.
pub fn list_contents(files: &[PathBuf]) -> StudyResult<Vec<FileContents>> {
    let mut all = Vec::new();
    for path in files {
        let mut text = String::new();
        let source = path.display();
        if is_table(path) {
            let found = described_table(&source.to_string(), &table_text(path)?, &TableRequest::default());
            let (described, warnings) = match found {
                Ok(described) => (described, Vec::new()),
                Err(fault) => ("a table that cannot be imported as it is".into(), vec![fault.to_string()]),
            };
            all.push(FileContents { text: format!("{source}: {described}\n"), warnings });
            continue;
        }
        let file =
            read_headers(open_universal(path)?).map_err(|e| StudyError::input(&source, e.to_string()))?;
        let counted =
            |count: usize, noun: &str| format!("{count} {noun}{}", if count == 1 { "" } else { "s" });
        let (functions, nodes) =
            (counted(file.functions.len(), "function"), counted(file.nodes.len(), "node"));
        text += &format!("{source}: {functions}, {nodes}, {}\n", counted(file.units.len(), "unit set"));
        for (at, header) in file.functions.iter().enumerate() {
            text += &format!("  {:>3}  {}\n", at + 1, described(header));
        }
        if !file.functions.is_empty() {
            text += "  averages: not stated, a universal file has no field for them\n";
        }
        for skipped in &file.skipped {
            text += &format!("  dataset {} is not read ({} ×)\n", skipped.number, skipped.times);
        }
        let warnings = file.warnings.iter().chain(file.functions.iter().flat_map(|f| &f.warnings));
        all.push(FileContents { text, warnings: warnings.map(ToString::to_string).collect() });
    }
    Ok(all)
}
