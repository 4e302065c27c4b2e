//! Inputs of a document, reopened for its page.

use crate::{Study, StudyError, StudyResult};
use report::document::{Input, Stamp};

/// Checks that the inputs of a reopened study are those of a document.
///
/// # Errors  an input cannot be read, or has changed since the document was written.
pub(super) fn unchanged(study: StudyResult<Study>, then: &Stamp, (of, again): (&str, &str)) -> StudyResult<Study> {
    let study =
        study.map_err(|e| StudyError::impossible(format!("{e} (paths are those of the {of}; make the page in the same folder)")))?;
    match changed(&then.inputs, &study.inputs()) {
        Some(path) => Err(StudyError::impossible(format!("{path} has changed since the {of}; {again} again"))),
        None => Ok(study),
    }
}

/// Returns the path of the first input that differs.
fn changed<'a>(then: &'a [Input], now: &'a [Input]) -> Option<&'a str> {
    let missing = |list: &[Input], i: &Input| !list.iter().any(|other| other.path == i.path && other.sha256 == i.sha256);
    let absent = then.iter().find(|i| missing(now, i));
    absent.or_else(|| now.iter().find(|i| missing(then, i))).map(|i| i.path.as_str())
}
