//! What tests run on: real measurements, which lie beside the project in `../shared` and are not part of it, and how many draws a study makes.

use std::io::Write;
use std::path::{Path, PathBuf};

/// `../shared/{inner}` beside the project, or `None` once it is said that the test that asks is skipped.
///
/// # Panics
/// Where the environment has `JOINTID_DATA=required` and the folder or file is missing.
pub fn shared(inner: &str) -> Option<PathBuf> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let path = project.parent()?.join("shared").join(inner);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var("JOINTID_DATA").is_ok_and(|value| value == "required");
    assert!(!required, "JOINTID_DATA=required, and there is no {}", path.display());
    skipped(&format!("no data ({})", path.display()));
    None
}

/// Says on stderr that the test which calls is skipped, and why, past the harness, which keeps what a passing test prints to itself.
pub fn skipped(why: &str) {
    let test = std::thread::current().name().unwrap_or("a test").to_string();
    let _ = writeln!(std::io::stderr(), "skipped: {why}, {test}");
}

/// How many draws a test makes: all of them in a study (`JOINTID_STUDY=full`, as `.ci/study` says it), few in every check.
pub fn draws(few: u64, all: u64) -> u64 {
    if std::env::var("JOINTID_STUDY").is_ok_and(|value| value == "full") { all } else { few }
}
