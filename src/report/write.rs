//! Writes documents atomically: to a temporary name, which is then renamed.

use std::fs;
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use file_access::{Existing, check_targets, create_exclusive, escape_json};
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

/// First bytes of every result document.
const DOCUMENT_BEGINS: &[u8] = b"{\n  \"schema\": \"jointid/";

/// Rule for result documents: those of an earlier run are replaced.
pub const EARLIER: Existing = Existing::Earlier("name another folder, or move it away");

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
        // The folder is made with its first file. Until then the nearest existing folder must accept a file.
        let near = path.ancestors().find(|p| p.symlink_metadata().is_ok()).unwrap_or(Path::new("."));
        if !near.is_dir() {
            let kind = if near.exists() { "is a file" } else { "is a link to nothing" };
            return Err(ReportError::target(near, format!("{kind}; name a folder")));
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

    /// Writes a file of its own, such as a cache, atomically; an existing one is replaced. Returns its path.
    ///
    /// # Errors  as [`OutputFolder::write_all`].
    pub fn write(&self, name: &str, content: &[u8]) -> Result<PathBuf, ReportError> {
        self.write_all([(name, content)], Existing::Own)?;
        Ok(self.file(name))
    }

    /// Checks that files of these names, a result document first, may be written.
    ///
    /// # Errors  a name leads out of the folder, or is taken.
    pub fn check(&self, names: &[&str], existing: Existing) -> Result<(), ReportError> {
        let targets = names.iter().map(|name| self.inside(name)).collect::<Result<Vec<_>, _>>()?;
        check(targets.iter().map(PathBuf::as_path), existing, DOCUMENT_BEGINS)
    }

    /// Returns the path of a file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes files that belong together, all or none: each to a temporary name, and all are renamed at the
    /// end, the first one last. `existing` is what is done with files of these names.
    ///
    /// # Errors  the disk is full; writing is not permitted; a name leads out of the folder, also by a link, or
    ///   is taken.
    pub fn write_all<N: AsRef<str>, C: AsRef<[u8]>>(
        &self,
        files: impl IntoIterator<Item = (N, C)>,
        existing: Existing,
    ) -> Result<(), ReportError> {
        let mut batch = Batch::default();
        let mut begins = Vec::new();
        for (name, content) in files {
            let (target, content) = (self.inside(name.as_ref())?, content.as_ref());
            if batch.files.is_empty() {
                begins = content.iter().take(64).copied().collect();
            }
            batch.add(&target, content).map_err(ReportError::unwritable(&target))?;
        }
        check(batch.files.iter().map(|(_, target)| target.as_path()), existing, &begins)?;
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
        let mut held = held_files();
        let mut former = Former::default();
        // Of several files no mixture of former and new ones may look whole: first the first one leaves.
        if self.files.len() > 1 {
            for (_, target) in &self.files {
                former.set_aside(target).map_err(ReportError::unwritable(target))?;
            }
        }
        while let Some((temporary, target)) = self.files.last() {
            fs::rename(temporary, target).map_err(ReportError::unwritable(target))?;
            held.remove(temporary);
            former.replaced.extend(self.files.pop().map(|(_, target)| target));
        }
        // An end of the process waits until the former files are gone, too.
        former.forget();
        drop(held);
        self.made.clear();
        Ok(())
    }
}

/// Checks that files may be written; see [`check_targets`].
fn check<'p>(
    targets: impl Iterator<Item = &'p Path>,
    existing: Existing,
    begins: &[u8],
) -> Result<(), ReportError> {
    check_targets(targets, existing, begins)
        .map_err(|(path, fault)| ReportError::target(&path, fault.to_string()))
}

/// Files that new ones replace. They return on drop, unless they are forgotten.
#[derive(Default)]
struct Former {
    /// Name aside, and proper name of each.
    aside: Vec<(PathBuf, PathBuf)>,
    /// New files in place.
    replaced: Vec<PathBuf>,
}

impl Former {
    fn set_aside(&mut self, target: &Path) -> std::io::Result<()> {
        if target.symlink_metadata().is_ok() {
            let (_, aside) = create_exclusive(target)?;
            fs::rename(target, &aside).inspect_err(|_| drop(fs::remove_file(&aside)))?;
            self.aside.push((aside, target.into()));
        }
        Ok(())
    }

    fn forget(mut self) {
        self.replaced.clear();
        for (aside, _) in self.aside.drain(..) {
            let _ = fs::remove_file(aside);
        }
    }
}

impl Drop for Former {
    fn drop(&mut self) {
        for file in &self.replaced {
            let _ = fs::remove_file(file);
        }
        for (aside, target) in &self.aside {
            let _ = fs::rename(aside, target);
        }
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
