//! Errors of a study.

use config::ConfigError;
use dynamics::inverse_dynamics::InverseError;
use dynamics::model::ModelError;
use dynamics::motion::MotionError;
use identification::objective::ObjectiveError;
use machine::MachineError;
use measurement::MeasurementError;
use report::ReportError;

/// Why a study cannot be made or run; the text names file, line or key, what was found, and what to write
/// instead.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The machine's file.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The measurement set.
    #[error(transparent)]
    Measurement(#[from] MeasurementError),
    /// Machine and data do not fit together, or the data do not suffice.
    #[error(transparent)]
    Objective(#[from] ObjectiveError),
    /// The force of a motion cannot be computed.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// A frequency response cannot be computed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A motion cannot be simulated.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The machine does not allow an operating condition or an effect.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// A document cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A setting or argument.
    #[error("{key}{}: {fault}", preceded(given))]
    Setting {
        /// Its name, such as `band_hz`.
        key: String,
        /// What was given; empty where the whole setting is meant.
        given: String,
        /// What is wrong with it, and what to write.
        fault: String,
    },
    /// A file, folder or result document.
    #[error("{path}: {fault}")]
    Input {
        /// Its path.
        path: String,
        /// What is wrong with it, and what to do.
        fault: String,
    },
    /// The work was stopped before there was a result; the same work resumes from its journal.
    #[error("stopped before there was a result")]
    Stopped,
    /// Anything else that machine, data and settings together do not allow.
    #[error("{0}")]
    Impossible(String),
}

/// Where a fault lies; each part is absent where it is unknown or does not apply.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FaultLocation<'e> {
    /// File, folder or measurement set.
    pub file: Option<&'e str>,
    /// Line of the file, from 1.
    pub line: Option<u64>,
    /// Key of the file, part of the machine, record, or setting.
    pub key: Option<&'e str>,
}

fn preceded(given: &str) -> String {
    if given.is_empty() { String::new() } else { format!(" {given}") }
}

impl StudyError {
    /// Whether the work was stopped before there was a result.
    pub fn is_stop(&self) -> bool {
        matches!(self, StudyError::Stopped | StudyError::Inverse(InverseError::Stopped))
    }

    /// Returns the name of the setting that is wrong, with which the text begins.
    pub fn setting_key(&self) -> Option<&str> {
        match self {
            StudyError::Setting { key, .. } => Some(key),
            StudyError::Config(error) => error.setting(),
            StudyError::Objective(error) => error.setting(),
            StudyError::Inverse(error) => error.setting(),
            _ => None,
        }
    }

    /// Returns where the fault lies.
    pub fn location(&self) -> FaultLocation<'_> {
        let file = |path| FaultLocation { file: Some(path), ..FaultLocation::default() };
        let key = |key| FaultLocation { key: Some(key), ..FaultLocation::default() };
        match self {
            StudyError::Config(ConfigError::Unreadable { path, .. } | ConfigError::Content { path, .. }) => {
                file(path)
            }
            StudyError::Config(ConfigError::Syntax { path, line, .. }) => {
                FaultLocation { line: Some(*line as u64), ..file(path) }
            }
            StudyError::Config(ConfigError::Key { path, key, .. }) => {
                FaultLocation { key: Some(key), ..file(path) }
            }
            StudyError::Measurement(MeasurementError::Line { path, line, .. }) => {
                FaultLocation { line: Some(*line), ..file(path) }
            }
            StudyError::Measurement(MeasurementError::File { path, .. }) => file(path),
            StudyError::Measurement(MeasurementError::Key { path, key, .. }) => {
                FaultLocation { key: Some(key), ..file(path) }
            }
            StudyError::Measurement(MeasurementError::Record { path, record, .. }) => {
                FaultLocation { key: Some(record), ..file(path) }
            }
            StudyError::Machine(error) | StudyError::Objective(ObjectiveError::Machine(error)) => {
                key(&error.part)
            }
            StudyError::Input { path, .. } => file(path),
            other => FaultLocation { key: other.setting_key(), ..FaultLocation::default() },
        }
    }

    /// Makes the error of a setting, with what was given.
    pub fn setting(key: &str, given: impl std::fmt::Display, fault: impl Into<String>) -> Self {
        StudyError::Setting { key: key.into(), given: given.to_string(), fault: fault.into() }
    }

    /// Makes the error of a file, folder or result document.
    pub fn input(path: impl std::fmt::Display, fault: impl Into<String>) -> Self {
        StudyError::Input { path: path.to_string(), fault: fault.into() }
    }

    /// Makes an error of machine, data and settings together.
    pub fn impossible(error: impl std::fmt::Display) -> Self {
        StudyError::Impossible(error.to_string())
    }
}

/// Result of a part of a study.
pub type StudyResult<T> = Result<T, StudyError>;
