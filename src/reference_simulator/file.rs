//! Folders and files of measurement sets.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::{Result, SimulatorError};

/// Creates a folder inside another one unless it exists.
pub fn create_folder(parent: &Path, name: &str) -> Result<PathBuf> {
    let path = parent.join(name);
    if path.is_symlink() {
        let source = std::io::Error::new(ErrorKind::AlreadyExists, "is a link; remove it");
        return Err(SimulatorError::Write { path: path.display().to_string(), source });
    }
    fs::create_dir_all(&path).map_err(|source| SimulatorError::Write { path: path.display().to_string(), source })?;
    Ok(path)
}

/// Writes a text file. An existing file or link of that name is removed first, not written to.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    let removed = match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    };
    let created = removed.and_then(|()| fs::OpenOptions::new().write(true).create_new(true).open(path));
    created
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|source| SimulatorError::Write { path: path.display().to_string(), source })
}

/// Formats names as the elements of a TOML list.
pub fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}
