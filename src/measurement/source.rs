//! Source files: the bytes that are both parsed and hashed.

use std::path::Path;

use file_access::{MOST_TABLE_BYTES, read_file};

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
    /// # Errors  the file cannot be read, or is no regular file of a bounded size.
    pub fn read(path: &str, missing: &str) -> Result<Self, MeasurementError> {
        let bytes = read_file(Path::new(path), MOST_TABLE_BYTES).map_err(|fault| {
            match fault.is_missing() && !missing.is_empty() {
                true => MeasurementError::file(path, format!("{fault}; {missing}")),
                false => MeasurementError::file(path, fault.to_string()),
            }
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
