//! Reads the inputs of a document again for its page.

use crate::sources::{Loaded, load_again, stamp};
use report::document::{Input, Stamp};

/// Reads machine and measurements of a document again.
///
/// # Errors  an input cannot be read, or has changed since the document was written.
pub(super) fn read_inputs_again(config: &str, measurements: &str, then: &Stamp, (of, again): (&str, &str)) -> Result<Loaded, String> {
    let loaded = load_again(config, measurements, then, (&[], &[]));
    let loaded = loaded.map_err(|e| format!("{e} (paths are those of the {of}; run report in the same folder)"))?;
    match changed(&then.inputs, &stamp(of, 0, true, &loaded, Vec::new()).inputs) {
        Some(path) => Err(format!("{path} has changed since the {of}; {again} again")),
        None => Ok(loaded),
    }
}

/// Returns the path of the first input that differs.
fn changed<'a>(then: &'a [Input], now: &'a [Input]) -> Option<&'a str> {
    let missing = |list: &[Input], i: &Input| !list.iter().any(|other| other.path == i.path && other.sha256 == i.sha256);
    let absent = then.iter().find(|i| missing(now, i));
    absent.or_else(|| now.iter().find(|i| missing(then, i))).map(|i| i.path.as_str())
}
