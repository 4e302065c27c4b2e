//! Files of a measurement set.

use std::io::{self, ErrorKind};
use std::path::Path;

use super::{MeasurementError, SourceFile};

/// Reads files of a set, and keeps them.
pub(super) struct OpenFolder<'f> {
    pub path: &'f str,
    pub read: &'f dyn Fn(&str) -> io::Result<Vec<u8>>,
    pub files: Vec<SourceFile>,
}

impl OpenFolder<'_> {
    pub fn text(&mut self, file: &str) -> Result<String, MeasurementError> {
        let name = self.name(file);
        let bytes = (self.read)(file).map_err(|error| {
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
        })?;
        let file = SourceFile { path: name, bytes };
        let text = file.text()?.to_string();
        self.files.push(file);
        Ok(text)
    }

    pub fn name(&self, file: &str) -> String {
        Path::new(self.path).join(file).display().to_string()
    }
}
