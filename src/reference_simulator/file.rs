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
    fs::create_dir_all(&path)
        .map_err(|source| SimulatorError::Write { path: path.display().to_string(), source })?;
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

/// Writes motion records, each by its name and its rows, and their manifest: its head, the fitted records if
/// any, and the files.
pub fn write_motions<'r>(
    folder: &Path,
    head: &str,
    fit: &[String],
    records: impl Iterator<Item = (&'r str, String)>,
) -> Result<()> {
    let motion = create_folder(folder, "motion")?;
    let mut manifest = head.to_owned();
    if !fit.is_empty() {
        manifest += &format!("\n[split]\nfit = [{}]\n", quoted(fit));
    }
    for (name, rows) in records {
        manifest += &format!("\n[[motion]]\nname = \"{name}\"\nfile = \"motion/{name}.csv\"\n");
        write_text(&motion.join(format!("{name}.csv")), &rows)?;
    }
    write_text(&folder.join("manifest.toml"), &manifest)
}

/// Formats names as the elements of a TOML list.
pub fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}
