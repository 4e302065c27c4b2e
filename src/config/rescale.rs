//! Configuration sections of the changes that an effect makes to numbers.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::{MachineError, Rescale, Target, TargetKind};

/// A number that an effect changes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RescaleFile {
    part: TargetKind,
    /// Name of the point, joint or shaft.
    #[serde(default)]
    name: String,
    /// Key of the number of friction, lead error or drive.
    #[serde(default)]
    key: String,
    #[serde(alias = "law")]
    modifier: Rescale,
    by: String,
}

impl RescaleFile {
    /// Returns the number, the modifier and the parameter.
    pub fn rescale(self) -> Result<(Target, Rescale, String), MachineError> {
        let has_keys = self.part.has_keys();
        if has_keys == self.key.is_empty() {
            let remedy = if has_keys {
                "name the number with key = \"…\""
            } else {
                "this part is one number; leave key out"
            };
            return Err(fault(format!("rescale by {}", self.by), remedy));
        }
        Ok((Target { kind: self.part, name: self.name, key: self.key }, self.modifier, self.by))
    }
}
