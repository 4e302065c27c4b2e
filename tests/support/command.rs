//! The command as tests run it.

use assert_cmd::Command;
use serde_json::Value;

/// Runs the command; returns exit code, stdout and stderr.
pub fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::cargo_bin("jointid").unwrap().args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Runs the command, and returns its document.
pub fn json(arguments: &[&str]) -> Value {
    let (code, out, err) = run(&[arguments, &["--json"]].concat());
    assert_eq!(code, Some(0), "{arguments:?}: {err}");
    serde_json::from_str(&out).unwrap()
}

/// Runs the command, which must refuse its input in one line that contains these parts.
pub fn refused(arguments: &[&str], expected: &[&str]) {
    let (code, out, err) = run(arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {err}");
    assert!(out.is_empty());
    for part in expected {
        assert!(err.contains(part), "{arguments:?}: «{part}» is not in: {err}");
    }
    assert_eq!(err.trim().lines().count(), 1, "{err}");
}
