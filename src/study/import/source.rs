//! Files to import: tables or universal files.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use file_access::{MOST_STREAM_BYTES, MOST_TABLE_BYTES, open_file, read_file, read_unchanged};

use crate::{StudyError, StudyResult};
use measurement::import::decoded;
use universal_files::UniversalError;

/// Extensions of tables, and of files that are tables unless their first line is that of a universal file.
const OF_TABLES: [&str; 2] = ["csv", "tsv"];
const OF_EITHER: [&str; 4] = ["txt", "dat", "asc", "prn"];

/// Whether a file is a table, by its extension and, where that leaves it open, by its first line.
pub(super) fn is_table(path: &Path) -> bool {
    let is_one_of =
        |list: &[&str]| path.extension().is_some_and(|e| list.iter().any(|t| e.eq_ignore_ascii_case(t)));
    is_one_of(&OF_TABLES) || (is_one_of(&OF_EITHER) && first_line(path).is_some_and(|line| line != "-1"))
}

/// Returns the first line with text at the start of a file, empty where there is none; `None` where the file
/// cannot be read.
fn first_line(path: &Path) -> Option<String> {
    let mut start = Vec::new();
    open_file(path, u64::MAX).ok()?.take(4096).read_to_end(&mut start).ok()?;
    Some(
        String::from_utf8_lossy(&start)
            .lines()
            .map(str::trim)
            .find(|line| !line.is_empty())
            .unwrap_or_default()
            .to_string(),
    )
}

/// Reads the text of a table.
pub(super) fn table_text(path: &Path) -> StudyResult<String> {
    read_file(path, MOST_TABLE_BYTES)
        .map(decoded)
        .map_err(|fault| StudyError::input(path.display(), fault.to_string()))
}

/// Opens a universal file.
pub(super) fn open_universal(path: &Path) -> StudyResult<File> {
    open_file(path, MOST_STREAM_BYTES).map_err(|fault| StudyError::input(path.display(), fault.to_string()))
}

/// Reads a universal file that does not change meanwhile.
pub(super) fn read_universal<T>(
    path: &Path,
    read: impl FnOnce(File) -> Result<T, UniversalError>,
) -> StudyResult<T> {
    let refused = |fault: String| StudyError::input(path.display(), fault);
    read_unchanged(path, MOST_STREAM_BYTES, read)
        .map_err(|fault| refused(fault.to_string()))?
        .map_err(|fault| refused(fault.to_string()))
}
