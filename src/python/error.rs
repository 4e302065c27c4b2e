//! Errors of the library as exceptions of the package.

use std::path::Path;

use pyo3::exceptions::PyRuntimeError;
use pyo3::{PyErr, PyResult, import_exception};
use report::ReportError;
use serde::de::DeserializeOwned;
use study::StudyError;

import_exception!(jointid._errors, InputError);
import_exception!(jointid._errors, StoppedError);

/// Converts an error; file, line and key become attributes of the exception.
pub fn to_exception(error: &StudyError) -> PyErr {
    if error.is_stop() {
        return StoppedError::new_err(error.to_string());
    }
    let at = error.location();
    // The setting of the command's overrides.
    let key = at.key.map(|key| if key == "set" { "overrides" } else { key }.to_string());
    InputError::new_err((error.to_string(), at.file.map(String::from), at.line, key))
}

/// Makes the exception of an argument.
pub fn argument(key: &str, fault: &str) -> PyErr {
    InputError::new_err((format!("{key}: {fault}"), None::<String>, None::<u64>, Some(key.to_string())))
}

/// Makes the exception of a file that an argument names and that cannot be written.
pub fn unwritten(path: &Path, key: &str, error: &ReportError) -> PyErr {
    InputError::new_err((
        error.to_string(),
        Some(path.display().to_string()),
        None::<u64>,
        Some(key.to_string()),
    ))
}

/// Reads a word of a closed vocabulary; `None` where none is given.
///
/// # Errors  the word is unknown; the message lists those that there are.
pub fn word<T: DeserializeOwned>(key: &str, given: Option<&str>) -> PyResult<Option<T>> {
    given.map(report::vocabulary::word).transpose().map_err(|error| argument(key, &error.to_string()))
}

/// Makes the exception of work in a process that was forked from one that has computed.
pub fn forked(owner: u32) -> PyErr {
    PyRuntimeError::new_err(format!(
        "this process was forked from process {owner} after jointid had computed there, and lacks its threads: start processes with multiprocessing.get_context('spawn'), or give threads=1"
    ))
}

/// Makes the exception of a fault inside the extension.
pub fn internal(fault: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(fault.to_string())
}
