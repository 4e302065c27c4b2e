//! Bounded reading of regular files.

use std::fmt;
use std::fs::{File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path};

/// Largest size of a text written by hand, such as a machine's description or a manifest (bytes).
pub const MOST_TEXT_BYTES: u64 = 4 << 20;
/// Largest size of a result document, journal or cache (bytes).
pub const MOST_DOCUMENT_BYTES: u64 = 256 << 20;
/// Largest size of a table or of another measurement file (bytes).
pub const MOST_TABLE_BYTES: u64 = 2 << 30;
/// Largest size of a file that is read piece by piece (bytes).
pub const MOST_STREAM_BYTES: u64 = 64 << 30;

/// Why a file cannot be read; the text states the correction and no content of the file.
#[derive(Debug)]
pub enum ReadFault {
    /// The operating system refuses the reading.
    Io(io::Error),
    /// The path is that of a folder.
    Folder,
    /// The path is that of a pipe, device or socket.
    Special(&'static str),
    /// The file is larger than its kind allows.
    TooLarge {
        /// Largest size (bytes).
        most_bytes: u64,
    },
    /// The content is not UTF-8.
    NoText,
    /// The file changed between its first and its last byte.
    Changed,
}

impl ReadFault {
    /// Whether there is no such file.
    pub fn is_missing(&self) -> bool {
        matches!(self, ReadFault::Io(error) if error.kind() == ErrorKind::NotFound)
    }

    /// Whether a part of the path that should be a folder is a file.
    pub fn is_below_file(&self) -> bool {
        matches!(self, ReadFault::Io(error) if error.kind() == ErrorKind::NotADirectory)
    }
}

impl fmt::Display for ReadFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ReadFault::Io(error) => match error.kind() {
                ErrorKind::NotFound => write!(f, "there is no such file"),
                ErrorKind::PermissionDenied => write!(f, "reading it is not permitted"),
                ErrorKind::InvalidInput | ErrorKind::InvalidFilename => {
                    write!(f, "is no valid name of a file")
                }
                _ => write!(f, "cannot be read: {error}"),
            },
            ReadFault::Folder => write!(f, "is a folder; name a file"),
            ReadFault::Special(what) => {
                write!(f, "is a {what}; only regular files are read, write its content to a file")
            }
            ReadFault::TooLarge { most_bytes } => {
                write!(f, "is larger than {} MiB, the limit for files of this kind", most_bytes >> 20)
            }
            ReadFault::Changed => {
                write!(f, "the file changed while it was read; read it again when it is complete")
            }
            ReadFault::NoText => write!(f, "is not text in UTF-8; save it as UTF-8"),
        }
    }
}

impl std::error::Error for ReadFault {}

impl From<ReadFault> for io::Error {
    fn from(fault: ReadFault) -> Self {
        match fault {
            ReadFault::Io(error) => error,
            fault => io::Error::other(fault),
        }
    }
}

impl From<io::Error> for ReadFault {
    fn from(error: io::Error) -> Self {
        ReadFault::Io(error)
    }
}

/// Opens a regular file of at most `most_bytes` for reading.
///
/// Opening a pipe would wait for its writer, so the kind is checked before and after.
///
/// # Errors  there is no such file; it is a folder, pipe, device or socket; it is too large.
pub fn open_file(path: &Path, most_bytes: u64) -> Result<File, ReadFault> {
    let file = open_regular(path, most_bytes)?;
    super::target::remember(path);
    Ok(file)
}

fn open_regular(path: &Path, most_bytes: u64) -> Result<File, ReadFault> {
    check_kind(std::fs::metadata(path)?.file_type())?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    check_kind(metadata.file_type())?;
    if metadata.len() > most_bytes {
        return Err(ReadFault::TooLarge { most_bytes });
    }
    Ok(file)
}

/// Reads a regular file of at most `most_bytes`.
///
/// # Errors  as [`open_file`]; the reading fails.
pub fn read_file(path: &Path, most_bytes: u64) -> Result<Vec<u8>, ReadFault> {
    content(open_file(path, most_bytes)?, most_bytes)
}

/// Reads a text that the run is going to replace: it is no input, as that of [`read_text`] is.
///
/// # Errors  as [`read_text`].
pub fn read_replaced(path: &Path, most_bytes: u64) -> Result<String, ReadFault> {
    text(content(open_regular(path, most_bytes)?, most_bytes)?)
}

fn content(file: File, most_bytes: u64) -> Result<Vec<u8>, ReadFault> {
    let expected = file.metadata()?.len();
    let mut bytes = Vec::with_capacity(usize::try_from(expected).unwrap_or(0));
    // The file may grow meanwhile; files of the kernel state no size.
    file.take(most_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return Err(ReadFault::TooLarge { most_bytes });
    }
    Ok(bytes)
}

/// Opens a regular file of at most `most_bytes` and has it read; one that is still being written would
/// otherwise be read in part without notice.
///
/// # Errors  as [`open_file`]; the file changes meanwhile.
pub fn read_unchanged<T>(path: &Path, most_bytes: u64, read: impl FnOnce(File) -> T) -> Result<T, ReadFault> {
    let file = open_file(path, most_bytes)?;
    let state = || std::fs::metadata(path).and_then(|found| Ok((found.len(), found.modified()?)));
    let before = state()?;
    let found = read(file);
    if state()? == before { Ok(found) } else { Err(ReadFault::Changed) }
}

/// Reads a regular file of at most `most_bytes` as text.
///
/// # Errors  as [`read_file`]; the content is not UTF-8.
pub fn read_text(path: &Path, most_bytes: u64) -> Result<String, ReadFault> {
    text(read_file(path, most_bytes)?)
}

fn text(bytes: Vec<u8>) -> Result<String, ReadFault> {
    String::from_utf8(bytes).map_err(|_| ReadFault::NoText)
}

fn check_kind(kind: FileType) -> Result<(), ReadFault> {
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(ReadFault::Folder);
    }
    Err(ReadFault::Special(super::target::special(kind)))
}

/// Whether a file named in a folder's list stays inside the folder, links resolved. A file that does not
/// exist is judged by its name.
pub fn is_inside(folder: &Path, name: &str) -> bool {
    if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
        return false;
    }
    match (folder.canonicalize(), folder.join(name).canonicalize()) {
        (Ok(folder), Ok(file)) => file.starts_with(folder),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(path: impl AsRef<Path>, most_bytes: u64) -> String {
        read_file(path.as_ref(), most_bytes).unwrap_err().to_string()
    }

    #[test]
    fn only_regular_files_of_bounded_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, [b'x'; 1000]).unwrap();
        assert_eq!(read_file(&file, 1000).unwrap().len(), 1000);
        assert!(refusal(&file, 999).contains("is larger than"));
        assert!(refusal(folder.path(), 1).contains("is a folder"));
        assert!(refusal(folder.path().join("none"), 1).contains("there is no such file"));
        assert!(refusal("a\0b", 1).contains("is no valid name"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_sockets_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert!(refusal("/dev/zero", 1).contains("is a device"));
        assert!(refusal(&socket, 1).contains("is a socket"));
        // A link is judged by its target.
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        assert!(refusal(&link, 1).contains("is a device"));
    }

    #[cfg(unix)]
    #[test]
    fn names_and_links_that_leave_the_folder_are_outside() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("set");
        std::fs::create_dir_all(folder.join("frf")).unwrap();
        std::fs::write(outer.path().join("secret"), "x").unwrap();
        std::fs::write(folder.join("frf/a.csv"), "x").unwrap();
        std::os::unix::fs::symlink("../secret", folder.join("link")).unwrap();
        std::os::unix::fs::symlink("frf/a.csv", folder.join("inner")).unwrap();
        for name in ["frf/a.csv", "./frf/a.csv", "inner", "missing.csv"] {
            assert!(is_inside(&folder, name), "{name}");
        }
        for name in ["../secret", "/etc/passwd", "link", "frf/../../secret"] {
            assert!(!is_inside(&folder, name), "{name}");
        }
    }
}
