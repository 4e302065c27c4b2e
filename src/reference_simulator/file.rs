//! Folders and files of measurement sets.

use std::fs;
use std::path::{Path, PathBuf};

use super::TruthError;

/// A folder inside another, made where it is not there.
pub fn made_folder(parent: &Path, name: &str) -> Result<PathBuf, TruthError> {
    let path = parent.join(name);
    fs::create_dir_all(&path).map_err(|source| TruthError::Write { path: path.display().to_string(), source })?;
    Ok(path)
}

/// Writes a text.
pub fn put(path: &Path, text: &str) -> Result<(), TruthError> {
    fs::write(path, text).map_err(|source| TruthError::Write { path: path.display().to_string(), source })
}

/// Names as the elements of a list in TOML.
pub fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}
