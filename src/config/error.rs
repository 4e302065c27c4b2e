//! Errors of configurations.

use thiserror::Error;

use machine::MachineError;

/// An error in a configuration; the message names file, line or key, and the correction.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{path}: {fault}")]
    Unreadable {
        /// File.
        path: String,
        /// Reason.
        fault: String,
    },
    /// The file has a syntax error or a key or value of the wrong type.
    #[error("{path}, line {line}: {fault}")]
    Syntax {
        /// File.
        path: String,
        /// Line, from 1.
        line: usize,
        /// What was found and what to write.
        fault: String,
    },
    /// The file as a whole does not describe a machine.
    #[error("{path}: {fault}")]
    Content {
        /// File.
        path: String,
        /// What was found and what to write.
        fault: String,
    },
    /// A key has a value that does not describe a valid machine.
    #[error("{path}: {key}: {fault}")]
    Key {
        /// File.
        path: String,
        /// Key or part, for example `joint.nut.stiffness`.
        key: String,
        /// What was found and what to write.
        fault: String,
    },
    /// A setting of the caller cannot be applied.
    #[error("{key} {given}: {fault}")]
    Setting {
        /// Name of the setting: `set` for overrides, `without` for removed effects.
        key: &'static str,
        /// The setting as given.
        given: String,
        /// What to write instead.
        fault: String,
    },
}

impl ConfigError {
    /// Returns the name of the faulty setting, where the caller's settings are at fault and not the file.
    pub fn setting(&self) -> Option<&'static str> {
        match self {
            ConfigError::Setting { key, .. } => Some(key),
            _ => None,
        }
    }

    /// Adds the file to an error in its description.
    pub(super) fn in_file(path: &str, error: MachineError) -> Self {
        ConfigError::Key { path: path.into(), key: error.part, fault: error.fault }
    }
}

/// Creates an error in a part of a description, which does not know its file yet.
pub(super) fn fault(part: impl Into<String>, fault: impl Into<String>) -> MachineError {
    MachineError { part: part.into(), fault: fault.into() }
}

#[cfg(test)]
mod tests {
    use super::ConfigError;
    use crate::{BENCH, read_machine};

    #[test]
    fn faulty_settings_are_distinguished_from_faulty_files() {
        let refused =
            |set: &str, without: &[String]| read_machine(BENCH, &[set.to_string()], without).unwrap_err();
        assert_eq!(refused("point.table.mass=1", &[]).setting(), Some("set"));
        assert_eq!(refused("point.table.mass_kg=1", &["backlash".into()]).setting(), Some("without"));
        let error = refused("tolerance.mass=-1", &[]);
        assert!(
            error.setting().is_none()
                && matches!(&error, ConfigError::Key { key, .. } if key == "tolerance.mass"),
            "{error}"
        );
    }
}
