//! Locks a result folder for one run, so that two runs at a time do not mix their results.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use file_access::open_lock;

use super::error::ReportError;

/// Name of the file that is locked while a run writes.
const NAME: &str = ".jointid-lock";
/// Text before the process id in the file.
const HOLDER: &str = "process ";
/// Files of this process that its end removes: of its locks, and under temporary names. For
/// [`release_claims`].
static HELD: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// Number of attempts to lock a file that other runs remove at the same time.
const ATTEMPTS: usize = 100;

/// Lock of a folder while a run writes into it. On drop the lock is removed, and so is a folder that was made
/// and is still empty.
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
    /// # Errors  another run has locked it (named by its process id); the disk is full; writing is not
    ///   permitted.
    pub fn new(folder: &Path) -> Result<Self, ReportError> {
        let cannot_write = ReportError::unwritable(folder);
        let mut claim = Self { file: None, path: folder.join(NAME), made: Vec::new() };
        for _ in 0..ATTEMPTS {
            claim.made.extend(make_folder(folder).map_err(&cannot_write)?);
            let mut file = match open_lock(&claim.path) {
                Ok(file) => file,
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) if error.kind() == ErrorKind::InvalidInput => {
                    return Err(ReportError::target(&claim.path, error.to_string()));
                }
                Err(error) => return Err(cannot_write(error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    claim.made.clear();
                    let who = holder(&mut file)
                        .filter(|id| !id.is_empty())
                        .map_or(String::new(), |id| format!(" ({id})"));
                    let remedy = "wait for its end, or name another folder";
                    return Err(ReportError::target(
                        folder,
                        format!("another run{who} is writing there; {remedy}"),
                    ));
                }
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                    drop(file);
                    let _ = fs::remove_file(&claim.path);
                    return Ok(claim);
                }
                Err(TryLockError::Error(error)) => return Err(cannot_write(error)),
            }
            if holder(&mut file).is_none() {
                let fault = "is not the lock of a run; remove it, or name another folder";
                return Err(ReportError::target(&claim.path, fault));
            }
            let own_id = format!("{HOLDER}{}", std::process::id());
            let written =
                file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(own_id.as_bytes()));
            claim.file = Some(file);
            held_files().insert(claim.path.clone());
            written.map_err(&cannot_write)?;
            // A run that has just ended may have removed the file. A lock on a removed file would exclude
            // nobody.
            match open_lock(&claim.path).map(|mut file| holder(&mut file)) {
                Ok(id) if id.as_deref() != Some(own_id.as_str()) => {}
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                _ => return Ok(claim),
            }
            claim.release();
        }
        Err(ReportError::target(folder, "other runs write there continually; name another folder"))
    }
}

/// Reads who holds a lock: empty where nobody has yet; `None` where the file is not that of a lock.
fn holder(file: &mut File) -> Option<String> {
    let mut text = String::new();
    file.rewind().and_then(|()| Read::by_ref(file).take(64).read_to_string(&mut text)).ok()?;
    let is_id = text
        .strip_prefix(HOLDER)
        .is_some_and(|id| !id.is_empty() && id.len() < 20 && id.chars().all(|c| c.is_ascii_digit()));
    (text.is_empty() || is_id).then_some(text)
}

/// Returns the files that an end of this process removes. As long as they are kept locked, this end waits.
pub(super) fn held_files() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the locks of this process and its unfinished files, for an end of the process that drops nothing.
/// Afterwards no file gets its final name any more, so that files that belong together are all written or
/// none.
pub fn release_claims() {
    let mut held = held_files();
    for path in std::mem::take(&mut *held) {
        let _ = fs::remove_file(path);
    }
    std::mem::forget(held);
}

impl Claim {
    /// Forgets the lock, whose file another run has removed.
    fn release(&mut self) {
        self.file = None;
        held_files().remove(&self.path);
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if self.file.is_some() {
            let _ = fs::remove_file(&self.path);
            self.release();
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
