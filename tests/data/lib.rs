//! Access of the tests to real measurements in `../shared`, next to the project and not part of it. Number of
//! draws of a study.

use std::io::Write;
use std::path::{Path, PathBuf};

/// Returns the path `../shared/{inner}`. Where it is missing, reports the calling test as skipped and returns
/// `None`.
///
/// # Panics
/// Panics where the environment has `JOINTID_DATA=required` and the folder or file is missing.
pub fn shared(inner: &str) -> Option<PathBuf> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let path = project.parent()?.join("shared").join(inner);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var("JOINTID_DATA").is_ok_and(|value| value == "required");
    assert!(!required, "JOINTID_DATA=required, but {} does not exist", path.display());
    skipped(&format!("no data ({})", path.display()));
    None
}

/// Reports on stderr that the calling test is skipped, and why. It writes to stderr directly, because the
/// test harness hides the output of passing tests.
pub fn skipped(why: &str) {
    let test = std::thread::current().name().unwrap_or("a test").to_string();
    let _ = writeln!(std::io::stderr(), "skipped: {why}, {test}");
}

/// Returns the number of draws of a test: `all` in a study, otherwise `few`.
pub fn draws(few: u64, all: u64) -> u64 {
    if is_study() { all } else { few }
}

/// Whether this is a study (`JOINTID_STUDY=full`, as set by `.ci/study`): with all draws, and with what is
/// computed for comparison only.
pub fn is_study() -> bool {
    std::env::var("JOINTID_STUDY").is_ok_and(|value| value == "full")
}
