//! Locks a result folder for one run, so that two runs at a time do not mix their results.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::ReportError;

/// Name of the file that is locked while a run writes.
const NAME: &str = ".jointid-lock";
/// Number of attempts to lock a file that other runs remove at the same time.
const ATTEMPTS: usize = 100;

/// Lock of a folder while a run writes into it. On drop the lock is removed, and so is a folder that was made and is still empty.
#[derive(Debug)]
pub(super) struct Claim {
    /// Locked as long as it is open; `None` where the file system has no locks.
    file: Option<File>,
    path: PathBuf,
    made: Vec<PathBuf>,
}

impl Claim {
    /// Makes the folder if it does not exist, and locks it.
    ///
    /// # Errors  another run has locked it (named by its process id); the disk is full; writing is not permitted.
    pub fn new(folder: &Path) -> Result<Self, ReportError> {
        let cannot_write = ReportError::unwritable(folder);
        let mut claim = Self { file: None, path: folder.join(NAME), made: Vec::new() };
        for _ in 0..ATTEMPTS {
            claim.made.extend(make_folder(folder).map_err(&cannot_write)?);
            let mut file = match OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&claim.path) {
                Ok(file) => file,
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => return Err(cannot_write(error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    claim.made.clear();
                    let who =
                        fs::read_to_string(&claim.path).ok().filter(|id| !id.is_empty()).map_or(String::new(), |id| format!(" ({id})"));
                    let remedy = "wait for its end, or name another folder";
                    return Err(ReportError::target(folder, format!("another run{who} is writing there; {remedy}")));
                }
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                    drop(file);
                    let _ = fs::remove_file(&claim.path);
                    return Ok(claim);
                }
                Err(TryLockError::Error(error)) => return Err(cannot_write(error)),
            }
            let own_id = format!("process {}", std::process::id());
            let written = file.set_len(0).and_then(|()| file.write_all(own_id.as_bytes()));
            claim.file = Some(file);
            written.map_err(&cannot_write)?;
            // A run that has just ended may have removed the file. A lock on a removed file would exclude nobody.
            match fs::read_to_string(&claim.path) {
                Ok(id) if id != own_id => {}
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                _ => return Ok(claim),
            }
            claim.file = None;
        }
        Err(ReportError::target(folder, "other runs write there continually; name another folder"))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if self.file.is_some() {
            let _ = fs::remove_file(&self.path);
        }
        remove_folders(&self.made);
    }
}

/// Makes a folder and its parents. Returns the folders made, the outermost first.
pub(super) fn make_folder(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists());
    let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
    missing.reverse();
    fs::create_dir_all(path).inspect_err(|_| remove_folders(&missing))?;
    Ok(missing)
}

/// Removes folders that were made, as far as they are empty.
pub(super) fn remove_folders(made: &[PathBuf]) {
    for folder in made.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
}
