//! A journal of finished work in a file, so that a stopped or killed run continues from there.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use file_access::{MOST_DOCUMENT_BYTES, create_exclusive, read_file};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use numeric::digest::digest;

const SCHEMA: &str = "jointid/unfinished/3";

/// The first line, which identifies the work.
#[derive(PartialEq, Serialize, Deserialize)]
struct Head {
    schema: String,
    /// Digest of all inputs on which the results depend.
    work: String,
}

/// A finished piece, or the last state of an unfinished one.
#[derive(Serialize, Deserialize)]
struct JournalLine {
    /// Digest of the piece's name.
    piece: String,
    found: Value,
    /// Digest of both.
    whole: String,
}

impl JournalLine {
    fn new(piece: String, found: Value) -> Self {
        JournalLine { whole: digest(format!("{piece} {found}").as_bytes()), piece, found }
    }

    /// Reads a line as it was written; `None` for a torn or corrupted line.
    fn read(line: &str) -> Option<Self> {
        let JournalLine { piece, found, whole } = serde_json::from_str(line).ok()?;
        Some(JournalLine::new(piece, found)).filter(|line| line.whole == whole)
    }
}

/// Serialises a named result as one line of JSON, which [`found_in`] accepts only unchanged.
///
/// # Errors  the result cannot be serialised as JSON.
pub fn kept_as<T: Serialize>(name: &str, found: &T) -> io::Result<String> {
    to_line(&JournalLine::new(digest(name.as_bytes()), serde_json::to_value(found)?))
}

/// Reads a result that [`kept_as`] has written under a name.
pub fn found_in<T: DeserializeOwned>(line: &str, name: &str) -> Option<T> {
    let line = JournalLine::read(line).filter(|line| line.piece == digest(name.as_bytes()))?;
    serde_json::from_value(line.found).ok()
}

/// A journal: pieces of work by name, one JSON object per line.
///
/// Each line carries its digest, so that lines changed by a killed process or a faulty disk are ignored.
/// Numbers are written such that they are read back exactly. Pieces depend only on their name and the work,
/// so a resumed run ends with the same results as an uninterrupted one.
pub struct Journal {
    path: PathBuf,
    known: HashMap<String, JournalLine>,
    sink: Mutex<Sink>,
}

/// State of the journal's file.
enum Sink {
    /// Not created before the first write; holds the initial lines.
    Nowhere(String),
    Open(File),
    Failed(String),
}

impl Journal {
    /// Opens the journal at a path and takes over the pieces that an earlier run of the same work has
    /// finished. `work` is a text of all inputs on which the results depend. A journal of other work is
    /// replaced.
    ///
    /// # Errors  the file exists and cannot be read.
    pub fn open(path: &Path, work: &str) -> io::Result<Journal> {
        let head = Head { schema: SCHEMA.into(), work: digest(work.as_bytes()) };
        if path.is_symlink() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "is a link"));
        }
        let text = match read_file(path, MOST_DOCUMENT_BYTES) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(fault) if fault.is_missing() => String::new(),
            Err(fault) => return Err(io::Error::other(fault.to_string())),
        };
        let mut lines = text.lines();
        let same = lines
            .next()
            .and_then(|line| serde_json::from_str::<Head>(line).ok())
            .is_some_and(|found| found == head);
        let kept = lines.filter(|_| same).filter_map(JournalLine::read);
        let known: HashMap<String, JournalLine> = kept.map(|line| (line.piece.clone(), line)).collect();
        // The file is rewritten without torn lines, each piece once.
        let mut first = to_line(&head)?;
        for line in known.values() {
            first += &to_line(line)?;
        }
        Ok(Journal { path: path.into(), known, sink: Mutex::new(Sink::Nowhere(first)) })
    }

    /// Returns the number of pieces taken over from an earlier run.
    pub fn taken_over(&self) -> usize {
        self.known.len()
    }

    /// Returns a piece that an earlier run has written.
    pub fn read<T: DeserializeOwned>(&self, piece: &str) -> Option<T> {
        serde_json::from_value(self.known.get(&digest(piece.as_bytes()))?.found.clone()).ok()
    }

    /// Writes a piece; the last one of a name counts. After a failed write nothing more is written, which
    /// costs a later run time but does not change the result.
    pub fn write<T: Serialize>(&self, piece: &str, found: &T) {
        let line = kept_as(piece, found);
        let Ok(mut sink) = self.sink.lock() else { return };
        let written = line.and_then(|line| {
            if let Sink::Nowhere(first) = &*sink {
                *sink = Sink::Open(self.begin(first)?);
            }
            match &mut *sink {
                Sink::Open(file) => file.write_all(line.as_bytes()),
                _ => Ok(()),
            }
        });
        if let Err(error) = written {
            *sink = Sink::Failed(format!("{}: {error}", self.path.display()));
        }
    }

    /// Creates the file with its first lines atomically.
    fn begin(&self, first: &str) -> io::Result<File> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let (mut file, temporary) = create_exclusive(&self.path)?;
        let begun = file.write_all(first.as_bytes()).and_then(|()| std::fs::rename(&temporary, &self.path));
        begun.inspect_err(|_| drop(std::fs::remove_file(&temporary)))?;
        Ok(file)
    }

    /// Returns why pieces could not be written.
    pub fn fault(&self) -> Option<String> {
        match &*self.sink.lock().ok()? {
            Sink::Failed(reason) => Some(reason.clone()),
            _ => None,
        }
    }

    /// Removes the journal of finished work.
    pub fn remove(&self) {
        // A remaining journal is replaced by the next run, or read by the same one.
        let _ = std::fs::remove_file(&self.path);
    }
}

fn to_line<T: Serialize>(value: &T) -> io::Result<String> {
    Ok(serde_json::to_string(value)? + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write_two(path: &Path) {
        let journal = Journal::open(path, "work").unwrap();
        journal.write("a", &vec![0.1 + 0.2, f64::MAX, 5e-324]);
        journal.write("b", &1_u64);
        journal.write("b", &2_u64);
    }

    #[test]
    fn pieces_are_read_back_exactly_and_the_last_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("unfinished.jsonl");
        write_two(&path);
        for _ in 0..2 {
            let journal = Journal::open(&path, "work").unwrap();
            assert_eq!(journal.taken_over(), 2);
            assert_eq!(journal.read::<Vec<f64>>("a").unwrap(), [0.1 + 0.2, f64::MAX, 5e-324]);
            assert_eq!(journal.read::<u64>("b"), Some(2));
            assert_eq!(journal.read::<u64>("a"), None, "a piece of another type is not returned");
            assert_eq!(journal.read::<u64>("c"), None);
        }
        let other = Journal::open(&path, "other work").unwrap();
        assert_eq!(other.taken_over(), 0);
        other.write("a", &3_u64);
        assert_eq!(Journal::open(&path, "work").unwrap().taken_over(), 0, "the other work has replaced it");
    }

    #[test]
    fn limit_a_truncated_journal_yields_only_complete_pieces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("unfinished.jsonl");
        write_two(&path);
        let whole = std::fs::read(&path).unwrap();
        let mut most = 0;
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let journal = Journal::open(&path, "work").unwrap();
            assert!(journal.taken_over() >= most && journal.taken_over() <= 2, "{length}");
            most = most.max(journal.taken_over());
            assert!(journal.read::<u64>("b").is_none_or(|b| b == 1 || b == 2));
        }
        assert_eq!(most, 2);
    }

    /// A flipped bit anywhere leaves each piece as it was written, or removes it.
    #[test]
    fn limit_a_corrupted_journal_yields_no_altered_pieces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("unfinished.jsonl");
        write_two(&path);
        let whole = std::fs::read(&path).unwrap();
        let mut left_out = 0;
        for at in 0..whole.len() {
            for bit in [0, 3, 6] {
                let mut corrupted = whole.clone();
                corrupted[at] ^= 1 << bit;
                std::fs::write(&path, &corrupted).unwrap();
                let journal = Journal::open(&path, "work").unwrap();
                let a = journal.read::<Vec<f64>>("a");
                assert!(
                    a.as_ref().is_none_or(|a| *a == [0.1 + 0.2, f64::MAX, 5e-324]),
                    "byte {at}, bit {bit}: {a:?}"
                );
                assert!(journal.read::<u64>("b").is_none_or(|b| b == 1 || b == 2), "byte {at}, bit {bit}");
                left_out += usize::from(a.is_none());
            }
        }
        // Flips in the piece's own line and in the first line, which identifies the work.
        assert!(left_out > whole.len());
    }

    #[test]
    fn no_file_is_created_before_the_first_write() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results").join("unfinished.jsonl");
        let journal = Journal::open(&path, "work").unwrap();
        assert!(!path.parent().unwrap().exists());
        journal.write("a", &1_u64);
        assert!(path.exists() && journal.fault().is_none());
    }
}
