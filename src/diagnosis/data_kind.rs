//! Kinds of data.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataKind {
    /// FRFs.
    Frf,
    /// Modes.
    Modes,
    /// Motion records.
    Motion,
}

impl DataKind {
    /// Returns the word for what is left out in turn.
    pub(super) fn blocks(self) -> &'static str {
        if self == DataKind::Motion { "parts" } else { "positions" }
    }

    /// Returns what to measure next where something is missing at a known location.
    pub(super) fn next_at_location(self) -> &'static str {
        match self {
            DataKind::Motion => "record the same motion at other speeds and loads",
            _ => "mount an accelerometer at that location and strike there, too",
        }
    }

    /// Returns what to measure next where held-out data do not decide.
    pub(super) fn next_to_confirm(self) -> &'static str {
        match self {
            DataKind::Motion => "record more motions with other speeds and loads",
            _ => "measure at more positions, or with less noise",
        }
    }
}
