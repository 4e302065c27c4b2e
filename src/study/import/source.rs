//! Files to import: tables or universal files.

use std::io::{ErrorKind, Read};
use std::path::Path;

use file_access::{MOST_TABLE_BYTES, open_file, read_file};

use crate::{StudyError, StudyResult};
use measurement::import::decoded;

/// Extensions of tables, and of files that are tables unless their first line is that of a universal file.
const OF_TABLES: [&str; 2] = ["csv", "tsv"];
const OF_EITHER: [&str; 4] = ["txt", "dat", "asc", "prn"];

/// Whether a file is a table, by its extension and, where that leaves it open, by its first line.
pub(super) fn is_table(path: &Path) -> bool {
    let is_one_of = |list: &[&str]| path.extension().is_some_and(|e| list.iter().any(|t| e.eq_ignore_ascii_case(t)));
    if is_one_of(&OF_TABLES) {
        return true;
    }
    let mut start = Vec::new();
    let read = open_file(path, u64::MAX).map(|file| file.take(4096).read_to_end(&mut start));
    let first = String::from_utf8_lossy(&start).lines().map(str::trim).find(|line| !line.is_empty()).map(str::to_string);
    is_one_of(&OF_EITHER) && matches!(read, Ok(Ok(_))) && first.as_deref() != Some("-1")
}

/// Reads the text of a table.
pub(super) fn table_text(path: &Path) -> StudyResult<String> {
    read_file(path, MOST_TABLE_BYTES).map(decoded).map_err(|e| unreadable(path, &e.into()))
}

/// Describes why a file cannot be read.
pub(super) fn unreadable(path: &Path, error: &std::io::Error) -> StudyError {
    let fault = match error.kind() {
        ErrorKind::NotFound => "there is no such file".to_string(),
        ErrorKind::PermissionDenied => "reading it is not permitted".into(),
        ErrorKind::InvalidData => "is not text in UTF-8".into(),
        _ if path.is_dir() => "is a folder; name a file".into(),
        _ => error.to_string(),
    };
    StudyError::input(path.display(), fault)
}
