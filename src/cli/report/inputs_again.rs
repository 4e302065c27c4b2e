//! What a document was made on, read again for its page.

use crate::sources::{Loaded, load_again, stamp};
use report::document::{Input, Stamp};

/// Reads machine and measurements of a document again, if all of them are still what they were.
pub(super) fn read_inputs_again(config: &str, measurements: &str, then: &Stamp, (of, again): (&str, &str)) -> Result<Loaded, String> {
    let loaded = load_again(config, measurements, then, (&[], &[]));
    let loaded = loaded.map_err(|e| format!("{e} (paths are those of the {of}; run report where it was run)"))?;
    match changed(&then.inputs, &stamp(of, 0, true, &loaded, Vec::new()).inputs) {
        Some(path) => Err(format!("{path} is no longer what it was at the {of}; {again} again")),
        None => Ok(loaded),
    }
}

/// The first input that is not the same now.
fn changed<'a>(then: &'a [Input], now: &'a [Input]) -> Option<&'a str> {
    let missing = |list: &[Input], i: &Input| !list.iter().any(|other| other.path == i.path && other.sha256 == i.sha256);
    let gone = then.iter().find(|i| missing(now, i));
    gone.or_else(|| now.iter().find(|i| missing(then, i))).map(|i| i.path.as_str())
}
