//! Folders and files of measurement sets.

use std::fs;
use std::path::{Path, PathBuf};

use super::SimulatorError;

/// Creates a folder inside another one unless it exists.
pub fn create_folder(parent: &Path, name: &str) -> Result<PathBuf, SimulatorError> {
    let path = parent.join(name);
    fs::create_dir_all(&path).map_err(|source| SimulatorError::Write { path: path.display().to_string(), source })?;
    Ok(path)
}

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> Result<(), SimulatorError> {
    fs::write(path, text).map_err(|source| SimulatorError::Write { path: path.display().to_string(), source })
}

/// Formats names as the elements of a TOML list.
pub fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}
