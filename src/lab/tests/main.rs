//! The integration tests of the laboratory, in one binary, with the prefixes of `tests/main.rs` at the root.

mod faults;
mod guide;
mod papers;
mod withheld;

#[path = "../../../tests/support/pages.rs"]
mod pages;

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// Folder of the project.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The laboratory's program, in the folder of the project.
fn lab() -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("jointid-lab"));
    command.current_dir(root()).env("NO_COLOR", "1");
    command
}

/// Runs the program; returns exit code, stdout and stderr.
fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = lab().args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Runs the program, and returns its document.
fn json(arguments: &[&str]) -> Value {
    let (code, out, err) = run(&[arguments, &["--json"]].concat());
    assert_eq!(code, Some(0), "{arguments:?}: {err}");
    serde_json::from_str(&out).unwrap()
}

/// Runs the program, which must refuse its input in one line that contains these parts.
fn refused(arguments: &[&str], expected: &[&str]) {
    let (code, out, err) = run(arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {err}");
    assert!(out.is_empty());
    for part in expected {
        assert!(err.contains(part), "{arguments:?}: «{part}» is not in: {err}");
    }
    assert_eq!(err.trim().lines().count(), 1, "{err}");
}
