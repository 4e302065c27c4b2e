//! A long run that is stopped or killed resumes from its journal and gives the same result as an
//! uninterrupted run.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

/// A run of several steps: three searches, profiles and two bootstraps.
const RUN: [&str; 7] = ["identify", "--positions", "l1,l3,l5", "--seed", "3", "--bootstrap", "100"];

fn command(out: &Path, threads: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_jointid"));
    command
        .args(RUN)
        .args(["--threads", threads, "--out"])
        .arg(out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

fn result(out: &Path) -> Vec<u8> {
    std::fs::read(out.join("identification.json")).expect("a result")
}

/// Starts the run and waits until its journal has `lines` lines; `None` if it ends before.
fn start(out: &Path, threads: &str, lines: usize) -> Option<Child> {
    let mut child = command(out, threads).spawn().expect("a process");
    let journal = out.join("unfinished.jsonl");
    loop {
        if std::fs::read_to_string(&journal).is_ok_and(|text| text.lines().count() >= lines) {
            return Some(child);
        }
        if child.try_wait().expect("a process").is_some() {
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
    let mut names: Vec<String> = entries.map(|e| name(e).to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_run_killed_anywhere_resumes_to_the_same_result() {
    let folder = tempfile::tempdir().expect("a folder");
    let reference = folder.path().join("reference");
    assert!(command(&reference, "2").output().expect("a run").status.success());
    let mut kills = 0;
    // After the first search, in the middle of the bootstrap and near its end; then again in the resumed run.
    for (at, lines) in [2, 60, 150].into_iter().enumerate() {
        let out = folder.path().join(format!("killed {at}"));
        for lines in [lines, lines + 20] {
            if let Some(mut child) = start(&out, "1", lines) {
                child.kill().expect("a kill");
                child.wait().expect("an end");
                kills += 1;
                assert!(!out.join("identification.json").exists(), "a killed run wrote a result");
            }
        }
        let last = command(&out, "2").output().expect("a run");
        assert!(last.status.success());
        let stderr = String::from_utf8_lossy(&last.stderr);
        assert!(stderr.contains("resumes where an earlier run was stopped"), "{stderr}");
        assert!(
            result(&out) == result(&reference),
            "the result differs after a kill at {lines} journal lines"
        );
        assert_eq!(names(&out), ["identification.json"], "files other than the result remain");
    }
    assert!(kills >= 4, "only {kills} kills hit a running process");
}

#[cfg(unix)]
#[test]
fn a_run_stopped_by_a_signal_writes_a_partial_result_and_resumes() {
    let folder = tempfile::tempdir().expect("a folder");
    let reference = folder.path().join("reference");
    assert!(command(&reference, "2").output().expect("a run").status.success());
    for signal in ["-INT", "-TERM"] {
        let out = folder.path().join(format!("stopped{signal}"));
        let child = start(&out, "2", 3).expect("a running process");
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().expect("kill").success());
        let stopped = child.wait_with_output().expect("an end");
        assert_eq!(stopped.status.code(), Some(3));
        assert!(String::from_utf8_lossy(&stopped.stderr).contains("the same command resumes from here"));
        let partial: Value = serde_json::from_slice(&result(&out)).expect("JSON");
        assert_eq!(partial["complete"], false);
        assert_eq!(names(&out), ["identification.json", "unfinished.jsonl"]);
        assert!(command(&out, "2").output().expect("a run").status.success());
        assert!(result(&out) == result(&reference));
        assert_eq!(names(&out), ["identification.json"]);
    }
}

#[test]
fn refuse_the_journal_of_another_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("results");
    let mut child = start(&out, "2", 3).expect("a running process");
    child.kill().expect("a kill");
    child.wait().expect("an end");
    let other = |out: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_jointid"));
        command
            .args(["identify", "--positions", "l1,l3,l5", "--seed", "4", "--repeats", "1", "--out"])
            .arg(out);
        let output = command.output().expect("a run");
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(!other(&out).contains("resumes"), "a journal of another seed was used");
    let fresh = folder.path().join("fresh");
    other(&fresh);
    assert!(result(&out) == result(&fresh));
}
