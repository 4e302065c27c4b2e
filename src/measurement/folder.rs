//! Files of a measurement set.

use std::io::{self, ErrorKind};
use std::path::Path;

use super::frf::{ReadLines, read_lines};
use super::import::ImportedTable;
use super::{MeasurementError, SourceFile};

/// What a file of a set holds.
pub(super) enum Content {
    /// A file that was read.
    Bytes(Vec<u8>),
    /// The table that an imported FRF would be written to.
    Imported(Box<ImportedTable>),
}

/// Reads files of a set, and keeps them.
pub(super) struct OpenFolder<'f> {
    pub path: &'f str,
    pub read: &'f mut dyn FnMut(&str) -> io::Result<Content>,
    pub files: Vec<SourceFile>,
}

impl OpenFolder<'_> {
    /// Returns the text of a file.
    pub fn text(&mut self, file: &str) -> Result<String, MeasurementError> {
        let bytes = match self.open(file)? {
            Content::Bytes(bytes) => bytes,
            Content::Imported(table) => table.text().into_bytes(),
        };
        let file = SourceFile::new(self.name(file), || bytes);
        let text = file.text()?.to_string();
        self.files.push(file);
        Ok(text)
    }

    /// Returns the lines of an FRF; those of an imported one are neither written as text nor parsed.
    pub fn lines(&mut self, file: &str) -> Result<ReadLines, MeasurementError> {
        let name = self.name(file);
        match self.open(file)? {
            Content::Bytes(bytes) => {
                let file = SourceFile::new(name, || bytes);
                let lines = read_lines(&file.path, file.text()?)?;
                self.files.push(file);
                Ok(lines)
            }
            Content::Imported(table) => {
                let lines = table.lines().map_err(|fault| MeasurementError::file(&name, fault))?;
                self.files.push(SourceFile::new(name, move || table.text().into_bytes()));
                Ok(lines)
            }
        }
    }

    fn open(&mut self, file: &str) -> Result<Content, MeasurementError> {
        let name = self.name(file);
        (self.read)(file).map_err(|error| {
            let here = Path::new(self.path);
            let (path, fault) = match error.kind() {
                ErrorKind::NotFound if !here.exists() => {
                    (self.path, "there is no such folder; name one with a manifest.toml".into())
                }
                ErrorKind::NotADirectory => {
                    (self.path, "is a file; name the folder that holds manifest.toml".into())
                }
                ErrorKind::NotFound => (name.as_str(), "there is no such file".to_string()),
                ErrorKind::PermissionDenied => (name.as_str(), "reading it is not permitted".into()),
                _ if here.join(file).is_dir() => (name.as_str(), "is a folder where a file is needed".into()),
                _ => (name.as_str(), error.to_string()),
            };
            MeasurementError::file(path, fault)
        })
    }

    pub fn name(&self, file: &str) -> String {
        Path::new(self.path).join(file).display().to_string()
    }
}
