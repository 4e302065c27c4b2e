//! Creation of files that follows no link.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Number of names tried for a new file before the creation fails.
const ATTEMPTS: u32 = 1000;

/// Creates a new file next to `path`, named after it: `.NAME.PROCESS` or, where that exists, with a further
/// number. Returns it with its path.
///
/// An existing file, or a link of that name, is never opened.
///
/// # Errors  the disk is full; writing is not permitted.
pub fn create_exclusive(path: &Path) -> io::Result<(File, PathBuf)> {
    let name = path.file_name().map_or_else(|| "file".into(), |name| name.to_string_lossy().into_owned());
    let mut found = None;
    for attempt in 0..ATTEMPTS {
        let further = if attempt == 0 { String::new() } else { format!(".{attempt}") };
        let temporary = path.with_file_name(format!(".{name}.{}{further}", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((file, temporary)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => found = Some(error),
            Err(error) => return Err(error),
        }
    }
    Err(found.unwrap_or_else(|| ErrorKind::AlreadyExists.into()))
}

/// Opens the file of a lock for reading and writing, and creates it where it does not exist.
///
/// # Errors  as [`create_exclusive`]; the name is that of a link, of a file with a second name, or of no
///   regular file ([`ErrorKind::InvalidInput`]).
pub fn open_lock(path: &Path) -> io::Result<File> {
    match OpenOptions::new().read(true).write(true).create_new(true).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        opened => return opened,
    }
    let here = fs::symlink_metadata(path)?;
    if !here.file_type().is_file() {
        return Err(refused("is a link or no regular file"));
    }
    let file = OpenOptions::new().read(true).write(true).open(path)?;
    if !is_same(&here, &file.metadata()?) {
        return Err(refused("is a link, or has a second name"));
    }
    Ok(file)
}

fn refused(what: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, format!("{what}; remove it"))
}

/// Whether a file found by its name is the opened one and has no further name: a link may have taken the name
/// meanwhile.
#[cfg(unix)]
fn is_same(named: &fs::Metadata, opened: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    named.dev() == opened.dev() && named.ino() == opened.ino() && opened.nlink() <= 1
}

#[cfg(not(unix))]
fn is_same(_: &fs::Metadata, opened: &fs::Metadata) -> bool {
    opened.is_file()
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_are_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (victim, target) = (folder.path().join("victim"), folder.path().join("result.json"));
        fs::write(&victim, "kept").unwrap();
        symlink(&victim, folder.path().join(format!(".result.json.{}", std::process::id()))).unwrap();
        let (mut file, temporary) = create_exclusive(&target).unwrap();
        file.write_all(b"new").unwrap();
        assert!(temporary.display().to_string().ends_with(".1"));
        let lock = folder.path().join("lock");
        symlink(&victim, &lock).unwrap();
        assert_eq!(open_lock(&lock).unwrap_err().kind(), ErrorKind::InvalidInput);
        fs::remove_file(&lock).unwrap();
        fs::hard_link(&victim, &lock).unwrap();
        assert_eq!(open_lock(&lock).unwrap_err().kind(), ErrorKind::InvalidInput);
        fs::remove_file(&lock).unwrap();
        open_lock(&lock).unwrap();
        open_lock(&lock).unwrap();
        assert_eq!(fs::read_to_string(&victim).unwrap(), "kept");
    }
}
