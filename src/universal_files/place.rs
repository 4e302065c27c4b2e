//! Places in a file.

use std::fmt;

/// A place in a universal file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FilePlace {
    /// Offset (bytes).
    pub byte: u64,
    /// Line, from 1; `None` after a binary payload, where lines cannot be counted.
    pub line: Option<u64>,
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line} (byte {})", self.byte),
            None => write!(f, "byte {}", self.byte),
        }
    }
}
