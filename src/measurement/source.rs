//! Source files: the bytes that are both parsed and hashed.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use file_access::{MOST_TABLE_BYTES, read_file};

use super::MeasurementError;

/// A file that was read, or one that a set in memory would be written to, with its bytes for the digest.
#[derive(Debug, Clone)]
pub struct SourceFile {
    /// Path.
    pub path: String,
    content: Arc<LazyLock<Vec<u8>, Write>>,
}

/// Returns the content of a file.
type Write = Box<dyn FnOnce() -> Vec<u8> + Send + Sync>;

impl PartialEq for SourceFile {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path && self.bytes() == other.bytes()
    }
}

impl SourceFile {
    /// Creates a file whose content is written when it is first needed.
    pub fn new(path: String, write: impl FnOnce() -> Vec<u8> + Send + Sync + 'static) -> Self {
        SourceFile { path, content: Arc::new(LazyLock::new(Box::new(write))) }
    }

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
        Ok(Self::new(path.into(), || bytes))
    }

    /// Returns its content.
    pub fn bytes(&self) -> &[u8] {
        &self.content
    }

    /// Returns its content as text.
    ///
    /// # Errors  the content is not UTF-8.
    pub fn text(&self) -> Result<&str, MeasurementError> {
        let fault = |_| MeasurementError::file(&self.path, "is not text in UTF-8; save it as UTF-8");
        std::str::from_utf8(self.bytes()).map_err(fault)
    }
}
