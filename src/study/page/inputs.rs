//! Inputs of a document, reopened for its page.

use crate::stamp::changed_input;
use crate::{Sources, Study, StudyError, StudyResult};
use report::document::Stamp;

/// Checks that the inputs of a reopened study are those of a document, unless the sources name another set.
///
/// # Errors  an input cannot be read, or has changed since the document was written.
pub(super) fn unchanged(
    study: StudyResult<Study>,
    then: &Stamp,
    (of, again): (&str, &str),
    sources: &Sources,
) -> StudyResult<Study> {
    let study = study.map_err(|e| {
        StudyError::impossible(format!("{e} (paths are those of the {of}; make the page in the same folder)"))
    })?;
    if sources.measurements.is_some() {
        return Ok(study);
    }
    match changed_input(&then.inputs, &study.inputs()) {
        Some(path) => {
            Err(StudyError::impossible(format!("{path} has changed since the {of}; {again} again")))
        }
        None => Ok(study),
    }
}
