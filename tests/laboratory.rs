//! `jointid lab` and former names of its commands start the laboratory's program, for which a script stands
//! here.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Copies the command into a folder, and a script as the laboratory's program beside it.
///
/// Another process writes both: a file that this one holds open for writing could not be started while
/// another test starts a program.
fn with_script(folder: &Path, script: &str) {
    let write =
        "cp \"$1\" jointid && printf '#!/bin/sh\\n%s\\n' \"$2\" > jointid-lab && chmod 755 jointid-lab";
    let words = ["-c", write, "sh", env!("CARGO_BIN_EXE_jointid"), script];
    assert!(Command::new("sh").args(words).current_dir(folder).status().unwrap().success());
}

/// The command of a folder, started outside Cargo.
fn jointid(folder: &Path) -> Command {
    let mut command = Command::new(folder.join("jointid"));
    command.env_remove("CARGO").env_remove("CARGO_MANIFEST_DIR").env("NO_COLOR", "1");
    command
}

fn text(output: &Output) -> (String, String) {
    (String::from_utf8(output.stdout.clone()).unwrap(), String::from_utf8(output.stderr.clone()).unwrap())
}

#[test]
fn arguments_input_and_exit_code_pass_through() {
    let folder = tempfile::tempdir().unwrap();
    with_script(folder.path(), "echo \"$#: $*\"; cat; echo aside >&2; exit 7");
    let mut child = jointid(folder.path());
    let mut child = child
        .args(["lab", "withheld", "--help", "a b"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), b"from stdin\n").unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(7));
    assert_eq!(text(&output), ("3: withheld --help a b\nfrom stdin\n".into(), "aside\n".into()));
}

#[test]
fn former_names_are_forwarded_with_the_new_one() {
    let folder = tempfile::tempdir().unwrap();
    with_script(folder.path(), "echo \"$*\"");
    let of = |words: &str| text(&jointid(folder.path()).args(words.split(' ')).output().unwrap());
    for (words, forwarded) in [
        ("hybrid --seed 2", "hybrid --seed 2"),
        ("convergence", "convergence"),
        ("simulate machine --out m", "machine --out m"),
        ("simulate published", "published"),
        ("simulate circle --help", "circle --help"),
        ("schema gain", "schema gain"),
    ] {
        let (out, err) = of(words);
        assert_eq!(out, format!("{forwarded}\n"));
        assert!(
            err.contains(&format!("«jointid lab {forwarded}»")) && err.lines().count() == 1,
            "{words}: {err}"
        );
        assert_eq!(of(&format!("{words} --quiet")), (format!("{forwarded} --quiet\n"), String::new()));
        assert_eq!(of(&format!("{words} --json")).1, "");
    }
    // The blind check keeps its old name.
    assert_eq!(of("withheld --cases 3"), ("withheld --cases 3\n".into(), String::new()));
    assert!(of("simulate modes").0.contains("frequency Hz"));
}

/// Ctrl-C reaches the laboratory's program, and its end is that of the command. A script that was started
/// with Ctrl-C ignored cannot trap it, hence `env`.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_passes_through() {
    let folder = tempfile::tempdir().unwrap();
    with_script(
        folder.path(),
        "exec env --default-signal=INT sh -c \"trap 'exit 3' INT; echo ready; while :; do sleep 0.05; done\"",
    );
    let mut child = jointid(folder.path()).args(["lab", "machine"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(child.stdout.take().unwrap()), &mut line)
        .unwrap();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(3));
}

#[test]
fn refuse_a_missing_laboratory() {
    let folder = tempfile::tempdir().unwrap();
    with_script(folder.path(), "");
    fs::remove_file(folder.path().join("jointid-lab")).unwrap();
    for words in [&["lab", "withheld"][..], &["withheld"], &["hybrid", "-q"]] {
        let output = jointid(folder.path()).args(words).env("PATH", "").output().unwrap();
        let (out, err) = text(&output);
        assert_eq!(output.status.code(), Some(2), "{err}");
        assert!(out.is_empty() && err.lines().count() == 1, "{err}");
        assert!(err.contains("jointid-lab") && err.contains("`cargo install --path src/lab`"), "{err}");
    }
}
