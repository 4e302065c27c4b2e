//! The rule for files to be written: nothing of the user's is replaced unasked.

use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, File, FileType};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Number of first bytes by which a file is recognised as one that this program wrote.
const MARK_BYTES: usize = 31;
/// Name of the program, which these bytes contain.
const MARK: &[u8] = b"jointid";

/// Files that the runs of commands in this process have read, and the number of these runs. They are inputs,
/// which no output replaces.
static READ: Mutex<(BTreeSet<PathBuf>, usize)> = Mutex::new((BTreeSet::new(), 0));

/// A run of a command: what is read meanwhile is its input. Other work of a process that lives long, such as a
/// Python session, remembers nothing.
#[derive(Debug)]
pub struct Run(());

impl Run {
    /// Begins a run, which ends when the value is dropped.
    #[must_use]
    pub fn begin() -> Run {
        READ.lock().unwrap_or_else(PoisonError::into_inner).1 += 1;
        Run(())
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let (read, runs) = &mut *READ.lock().unwrap_or_else(PoisonError::into_inner);
        *runs -= 1;
        if *runs == 0 {
            read.clear();
        }
    }
}

/// What is done with existing files of the names to be written. The text tells the user what to do instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// None is replaced.
    Kept(&'static str),
    /// Those of an earlier run are replaced: files that begin as the first new one, and the others where an
    /// earlier run wrote the first one.
    Earlier(&'static str),
    /// All are replaced, except inputs: the user asked for it.
    Replaced,
    /// All are replaced: the program alone keeps files here, such as a cache.
    Own,
}

/// Why a file is not written; the text states what to do instead.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TargetFault {
    /// It is no regular file, but this.
    Kind(&'static str),
    /// It exists.
    Exists(&'static str),
    /// This run has read it.
    Input,
}

impl fmt::Display for TargetFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TargetFault::Kind(what) => write!(f, "is a {what}; name a regular file, or remove it"),
            TargetFault::Exists(remedy) => write!(f, "already exists; {remedy}"),
            TargetFault::Input => write!(f, "is an input of this run; name another file"),
        }
    }
}

/// Returns what a file is that is neither regular nor a folder.
#[cfg(unix)]
pub(super) fn special(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if kind.is_fifo() {
        "pipe"
    } else if kind.is_socket() {
        "socket"
    } else {
        "device"
    }
}

#[cfg(not(unix))]
pub(super) fn special(_: FileType) -> &'static str {
    "device"
}

/// Remembers that a file is read.
pub(super) fn remember(path: &Path) {
    let (read, runs) = &mut *READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let (1.., Ok(path)) = (*runs, path.canonicalize()) {
        read.insert(path);
    }
}

/// Checks that files may be written under these names. `begins` holds the first bytes of the first one.
///
/// # Errors  the first name that is taken, and by what.
pub fn check_targets<'p>(
    paths: impl Iterator<Item = &'p Path>,
    existing: Existing,
    begins: &[u8],
) -> Result<(), (PathBuf, TargetFault)> {
    let mut is_earlier = None;
    for path in paths {
        // What else prevents the writing is reported there.
        let Ok(found) = fs::symlink_metadata(path) else { continue };
        let kind = found.file_type();
        let fault = if kind.is_symlink() {
            Some(TargetFault::Kind("link"))
        } else if kind.is_dir() {
            Some(TargetFault::Kind("folder"))
        } else if !kind.is_file() {
            Some(TargetFault::Kind(special(kind)))
        } else {
            match existing {
                Existing::Own => None,
                Existing::Kept(remedy) => Some(TargetFault::Exists(remedy)),
                Existing::Earlier(_) if begins_as(path, begins) => None,
                _ if is_input(path) => Some(TargetFault::Input),
                Existing::Earlier(remedy) if is_earlier != Some(true) => Some(TargetFault::Exists(remedy)),
                Existing::Earlier(_) | Existing::Replaced => None,
            }
        };
        if let Some(fault) = fault {
            return Err((path.into(), fault));
        }
        is_earlier.get_or_insert_with(|| begins_as(path, begins));
    }
    Ok(())
}

fn is_input(path: &Path) -> bool {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    path.canonicalize().is_ok_and(|path| read.0.contains(&path))
}

/// Whether a regular file begins as a new one that names this program there: other beginnings, such as those of
/// universal files, are those of everybody's files. An empty one is nobody's loss.
fn begins_as(path: &Path, begins: &[u8]) -> bool {
    let most = begins.len().min(MARK_BYTES);
    let is_marked = begins[..most].windows(MARK.len()).any(|bytes| bytes == MARK);
    let mut found = Vec::new();
    let read = File::open(path).and_then(|file| file.take(most as u64).read_to_end(&mut found));
    read.is_ok() && (found.is_empty() || (is_marked && found == begins[..most]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_text;

    #[test]
    fn files_of_the_user_are_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let check = |names: &[&str], existing| {
            let paths: Vec<PathBuf> = names.iter().map(|name| path(name)).collect();
            check_targets(paths.iter().map(PathBuf::as_path), existing, b"{\n  \"schema\": \"jointid/")
                .map_err(|(path, fault)| (path.file_name().unwrap().display().to_string(), fault))
        };
        let (kept, earlier) = (Existing::Kept("a"), Existing::Earlier("b"));
        let exists = |name: &str, remedy| Err((name.to_string(), TargetFault::Exists(remedy)));
        fs::write(path("own.csv"), "x,y\n").unwrap();
        assert_eq!(check(&["new", "own.csv"], kept), exists("own.csv", "a"));
        assert_eq!(check(&["new.json", "own.csv"], earlier), exists("own.csv", "b"));
        fs::write(path("old.json"), "{\n  \"schema\": \"jointid/modes/1\"}").unwrap();
        assert_eq!(check(&["old.json", "own.csv"], earlier), Ok(()));
        assert_eq!(check(&["new.json", "old.json"], earlier), Ok(()));
        fs::write(path("own.uff"), "    -1\n   151\n").unwrap();
        let universal = check_targets([&*path("own.uff")].into_iter(), earlier, b"    -1\n   151\n");
        assert_eq!(universal.unwrap_err().1, TargetFault::Exists("b"));
        assert_eq!(check(&["own.csv", "old.json"], Existing::Replaced), Ok(()));
        read_text(&path("own.csv"), 100).unwrap();
        assert_eq!(check(&["old.json", "own.csv"], earlier), Ok(()));
        let run = Run::begin();
        read_text(&path("own.csv"), 100).unwrap();
        for existing in [earlier, Existing::Replaced] {
            let found = check(&["old.json", "own.csv"], existing);
            assert_eq!(found, Err(("own.csv".into(), TargetFault::Input)));
        }
        drop(run);
        assert_eq!(check(&["old.json", "own.csv"], earlier), Ok(()));
        assert_eq!(check(&["old.json", "own.csv"], Existing::Own), Ok(()));
    }

    #[cfg(unix)]
    #[test]
    fn links_folders_and_sockets_are_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink("nowhere", path("link")).unwrap();
        let _listener = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        fs::create_dir(path("folder")).unwrap();
        for kind in ["link", "socket", "folder"] {
            for existing in [Existing::Kept(""), Existing::Earlier(""), Existing::Replaced, Existing::Own] {
                let found = check_targets([&*path(kind)].into_iter(), existing, b"");
                assert_eq!(found, Err((path(kind), TargetFault::Kind(kind))));
            }
        }
        let device = check_targets([Path::new("/dev/null")].into_iter(), Existing::Own, b"");
        assert_eq!(device.unwrap_err().1, TargetFault::Kind("device"));
    }
}
