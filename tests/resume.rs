//! Long work that is stopped or killed goes on where it was, and ends as if there had been no stop.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

/// Work of several pieces: three searches, profiles and two bootstraps.
const WORK: [&str; 7] = ["identify", "--positions", "l1,l3,l5", "--seed", "3", "--bootstrap", "100"];

fn command(out: &Path, threads: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_jointid"));
    command.args(WORK).args(["--threads", threads, "--out"]).arg(out).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn result(out: &Path) -> Vec<u8> {
    std::fs::read(out.join("identification.json")).expect("a result")
}

/// Begins the work and waits until its journal has so many lines; `None` where it ended before.
fn begun(out: &Path, threads: &str, lines: usize) -> Option<Child> {
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
    std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn killed_anywhere_it_ends_as_the_very_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let reference = folder.path().join("reference");
    assert!(command(&reference, "2").output().expect("a run").status.success());
    let mut kills = 0;
    // After the first search, in the middle of the bootstrap, and near its end; then once more in what is left.
    for (at, lines) in [2, 60, 150].into_iter().enumerate() {
        let out = folder.path().join(format!("killed {at}"));
        for lines in [lines, lines + 20] {
            if let Some(mut child) = begun(&out, "1", lines) {
                child.kill().expect("a kill");
                child.wait().expect("an end");
                kills += 1;
                assert!(!out.join("identification.json").exists(), "killed, it has no result");
            }
        }
        let last = command(&out, "2").output().expect("a run");
        assert!(last.status.success());
        let told = String::from_utf8_lossy(&last.stderr);
        assert!(told.contains("goes on where an earlier run was stopped"), "{told}");
        assert!(result(&out) == result(&reference), "killed after {lines} pieces it ends otherwise");
        assert_eq!(names(&out), ["identification.json"], "nothing else is left");
    }
    assert!(kills >= 4, "{kills} kills met the work");
}

#[cfg(unix)]
#[test]
fn stopped_by_ctrl_c_it_tells_what_is_known_and_goes_on_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let (reference, out) = (folder.path().join("reference"), folder.path().join("stopped"));
    assert!(command(&reference, "2").output().expect("a run").status.success());
    let child = begun(&out, "2", 3).expect("still at work");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill").success());
    let stopped = child.wait_with_output().expect("an end");
    assert_eq!(stopped.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&stopped.stderr).contains("the same command goes on from here"));
    let known: Value = serde_json::from_slice(&result(&out)).expect("JSON");
    assert_eq!(known["complete"], false);
    assert!(out.join("unfinished.jsonl").exists());
    assert!(command(&out, "2").output().expect("a run").status.success());
    assert!(result(&out) == result(&reference));
    assert_eq!(names(&out), ["identification.json"]);
}

#[test]
fn refuse_pieces_of_other_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("results");
    let mut child = begun(&out, "2", 3).expect("still at work");
    child.kill().expect("a kill");
    child.wait().expect("an end");
    let other = |out: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_jointid"));
        command.args(["identify", "--positions", "l1,l3,l5", "--seed", "4", "--repeats", "1", "--out"]).arg(out);
        let ran = command.output().expect("a run");
        assert!(ran.status.success());
        String::from_utf8_lossy(&ran.stderr).into_owned()
    };
    assert!(!other(&out).contains("goes on"), "another seed is other work");
    let fresh = folder.path().join("fresh");
    other(&fresh);
    assert!(result(&out) == result(&fresh));
}
