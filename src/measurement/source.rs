//! Source files: the bytes that are both parsed and hashed.

use std::io::ErrorKind;
use std::path::Path;

use super::MeasurementError;

/// A file that was read, with its bytes for the digest.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceFile {
    /// Path.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl SourceFile {
    /// Reads a whole file; `missing` is the remedy in the message where the file does not exist.
    ///
    /// # Errors  the file cannot be read.
    pub fn read(path: &str, missing: &str) -> Result<Self, MeasurementError> {
        let bytes = std::fs::read(path).map_err(|error| {
            let fault = match error.kind() {
                ErrorKind::NotFound if missing.is_empty() => "there is no such file".to_string(),
                ErrorKind::NotFound => format!("there is no such file; {missing}"),
                ErrorKind::PermissionDenied => "reading it is not permitted".into(),
                _ if Path::new(path).is_dir() => "is a folder; name a file".into(),
                _ => error.to_string(),
            };
            MeasurementError::file(path, fault)
        })?;
        Ok(Self { path: path.into(), bytes })
    }

    /// Returns its content as text.
    ///
    /// # Errors  the content is not UTF-8.
    pub fn text(&self) -> Result<&str, MeasurementError> {
        let fault = |_| MeasurementError::file(&self.path, "is not text in UTF-8; save it as UTF-8");
        std::str::from_utf8(&self.bytes).map_err(fault)
    }
}
