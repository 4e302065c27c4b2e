//! Writes documents atomically: to a temporary name, which is then renamed.

use std::fs;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use file_access::{create_exclusive, escape_json};
use serde::Serialize;

use super::claim::{Claim, held_files, make_folder, remove_folders};
use super::error::ReportError;

/// Formats a document as JSON text with a line end.
///
/// A number that is not finite becomes null. Hidden characters are escaped, so that the text can be shown in
/// a terminal.
///
/// # Errors  a map's key is no text (an error of the program).
pub fn to_json<T: Serialize>(document: &T) -> Result<String, ReportError> {
    Ok(escape_json(serde_json::to_string_pretty(document)? + "\n"))
}

/// A result folder.
#[derive(Debug, Clone)]
pub struct OutputFolder {
    path: PathBuf,
    /// Lock on the folder, shared by all copies.
    _claim: Option<Arc<Claim>>,
}

impl OutputFolder {
    /// Checks that the folder can be made, or files written into it. Makes nothing yet.
    ///
    /// # Errors  the name is that of a file, or writing is not permitted.
    pub fn prepare(path: &Path) -> Result<Self, ReportError> {
        let cannot_write = |e: std::io::Error| {
            let fault = match e.kind() {
                std::io::ErrorKind::PermissionDenied => {
                    "writing there is not permitted; name another folder".to_string()
                }
                std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotADirectory => {
                    "is a file; name a folder".into()
                }
                _ => e.to_string(),
            };
            ReportError::target(path, fault)
        };
        if path.is_file() {
            return Err(ReportError::target(path, "is a file; name a folder"));
        }
        // The folder is made with its first file. Until then the nearest existing folder must accept a file.
        let near = path
            .ancestors()
            .find(|p| p.exists())
            .filter(|p| !p.as_os_str().is_empty())
            .unwrap_or(Path::new("."));
        if near.is_file() {
            return Err(ReportError::target(near, "is a file; name a folder"));
        }
        create_exclusive(&near.join("jointid"))
            .and_then(|(_, probe)| fs::remove_file(probe))
            .map_err(cannot_write)?;
        Ok(OutputFolder { path: path.into(), _claim: None })
    }

    /// As [`OutputFolder::prepare`], for one run only: until the folder is dropped, another run that claims
    /// it is refused.
    ///
    /// The folder is made, and removed again if nothing is written into it.
    ///
    /// # Errors  as [`OutputFolder::prepare`]; another run has claimed it.
    pub fn claim(path: &Path) -> Result<Self, ReportError> {
        let folder = Self::prepare(path)?;
        Ok(OutputFolder { _claim: Some(Arc::new(Claim::new(path)?)), ..folder })
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file atomically. Returns its path.
    ///
    /// # Errors  the disk is full, or writing is not permitted.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<PathBuf, ReportError> {
        self.write_all([(name, content)])?;
        Ok(self.file(name))
    }

    /// Returns the path of a file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes files that belong together, all or none: each to a temporary name, and all are renamed at the
    /// end. A link of a file's name is replaced, not followed.
    ///
    /// # Errors  the disk is full; writing is not permitted; a name leads out of the folder, also by a link.
    pub fn write_all<N: AsRef<str>, C: AsRef<[u8]>>(
        &self,
        files: impl IntoIterator<Item = (N, C)>,
    ) -> Result<(), ReportError> {
        let mut batch = Batch::default();
        for (name, content) in files {
            let target = self.inside(name.as_ref())?;
            batch.add(&target, content.as_ref()).map_err(ReportError::unwritable(&target))?;
        }
        batch.rename()
    }
}

impl OutputFolder {
    /// Returns the path of a file to write.
    ///
    /// # Errors  the name leads out of the folder.
    fn inside(&self, name: &str) -> Result<PathBuf, ReportError> {
        let target = self.path.join(name);
        let parts: Vec<Component<'_>> = Path::new(name).components().collect();
        if parts.is_empty() || !parts.iter().all(|part| matches!(part, Component::Normal(_))) {
            return Err(ReportError::target(
                &target,
                "leads out of the result folder; name a file inside it",
            ));
        }
        let mut folder = self.path.clone();
        for part in &parts[..parts.len() - 1] {
            folder.push(part);
            if folder.is_symlink() {
                return Err(ReportError::target(
                    &folder,
                    "is a link, and files are written into the result folder only; remove it",
                ));
            }
        }
        Ok(target)
    }
}

/// Files under temporary names. Those that are not renamed are removed on drop.
#[derive(Default)]
struct Batch {
    /// Temporary and final path of each file.
    files: Vec<(PathBuf, PathBuf)>,
    /// Folders made for them.
    made: Vec<PathBuf>,
}

impl Batch {
    fn add(&mut self, target: &Path, content: &[u8]) -> std::io::Result<()> {
        self.made.extend(make_folder(target.parent().unwrap_or(Path::new("")))?);
        let (mut file, temporary) = create_exclusive(target)?;
        held_files().insert(temporary.clone());
        self.files.push((temporary, target.into()));
        file.write_all(content).and_then(|()| file.sync_all())
    }

    fn rename(mut self) -> Result<(), ReportError> {
        // Checks all targets before any file is replaced.
        if let Some((_, folder)) =
            self.files.iter().find(|(_, target)| target.is_dir() && !target.is_symlink())
        {
            return Err(ReportError::target(
                folder,
                "is a folder, but a file of this name is to be written; remove it",
            ));
        }
        let mut held = held_files();
        while let Some((temporary, target)) = self.files.first() {
            fs::rename(temporary, target).map_err(ReportError::unwritable(target))?;
            held.remove(temporary);
            self.files.remove(0);
        }
        self.made.clear();
        Ok(())
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        for (temporary, _) in &self.files {
            held_files().remove(temporary);
            let _ = fs::remove_file(temporary);
        }
        remove_folders(&self.made);
    }
}
