//! Faults from outside: full disks, links, interrupts; help, completions and manual pages.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::{lab, refused, root, run};

/// Completions, manual pages and help contain every command, each with an example.
#[test]
fn completions_and_manual_contain_every_command() {
    let (_, help, _) = run(&["--help"]);
    assert!(help.contains("Usage: jointid lab"), "{help}");
    let lists = help.lines().skip_while(|l| *l != "Checks of the method:").take_while(|l| *l != "Options:");
    let names: Vec<&str> =
        lists.filter(|l| l.starts_with("  ")).filter_map(|l| l.split_whitespace().next()).collect();
    assert!(names.len() >= 12, "{help}");
    assert!(help.contains("Structure:") || help.contains("Example:\n  jointid "), "no example: {help}");
    let fits = |name: &str, help: &str| {
        for line in help.lines() {
            assert!(line.chars().count() <= 80 || line.starts_with("  jointid"), "{name}: {line}");
        }
    };
    fits("lab", &help);
    let (_, script, _) = run(&["completions", "bash"]);
    assert!(script.contains("jointid-lab"), "{script}");
    let asked = [("JOINTID_COMPLETE", "bash"), ("_CLAP_COMPLETE_INDEX", "1"), ("_CLAP_IFS", "\n")];
    let offered = lab().envs(asked).args(["--", "jointid-lab", ""]).output().unwrap().stdout;
    let offered = String::from_utf8(offered).unwrap();
    let folder = tempfile::tempdir().unwrap();
    lab().args(["man", "--out"]).arg(folder.path()).assert().success();
    for name in &names {
        assert!(offered.lines().any(|word| word == *name), "{name}");
        assert!(folder.path().join(format!("jointid-lab-{name}.1")).exists(), "{name}");
        let (_, help, _) = run(&[name, "--help"]);
        assert!(help.contains("Example:\n  jointid lab "), "{name} has no example");
        fits(name, &help);
    }
}

#[cfg(unix)]
#[test]
fn refuse_a_full_stdout_and_folders_that_exist() {
    let folder = tempfile::tempdir().unwrap();
    let (out, other) = (folder.path().join("out"), folder.path().join("other"));
    fs::create_dir_all(&out).unwrap();
    fs::create_dir_all(&other).unwrap();
    std::os::unix::fs::symlink(&other, out.join("sines")).unwrap();
    refused(&["machine", "--out", out.to_str().unwrap()], &["sines", "already exists"]);
    assert_eq!(fs::read_dir(&other).unwrap().count(), 0);
    if Path::new("/dev/full").exists() {
        let program = assert_cmd::cargo::cargo_bin!("jointid-lab");
        let output = Command::new("sh")
            .args(["-c", "exec \"$0\" published > /dev/full"])
            .arg(program)
            .current_dir(root())
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.code() == Some(2)
                && message.contains("stdout")
                && message.contains("cannot be written"),
            "{message}"
        );
    }
}

/// Ctrl-C ends a command within a second, with or without a result, and leaves no locks.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_every_command_soon() {
    let folder = tempfile::tempdir().unwrap();
    for (command, after) in [(&["machine"][..], 400), (&["withheld", "--cases", "5"], 1000)] {
        let out = folder.path().join(command[0]);
        let program = assert_cmd::cargo::cargo_bin!("jointid-lab");
        let mut child = Command::new(program);
        child
            .args(command)
            .arg("--out")
            .arg(&out)
            .current_dir(root())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let mut child = child.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(after));
        let begun = Instant::now();
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let code = child.wait().unwrap().code();
        // The deadline of the command is 0.85 s; the rest is for a busy processor.
        assert!(begun.elapsed() < Duration::from_secs(2), "{command:?}: {:?}", begun.elapsed());
        assert!([Some(0), Some(3)].contains(&code), "{command:?}: {code:?}");
        let left = fs::read_dir(&out)
            .into_iter()
            .flatten()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let left: Vec<String> = left.filter(|name| name.starts_with('.')).collect();
        assert!(left.is_empty(), "{command:?}: {left:?}");
    }
}

/// After the word `jointid` the words are those of the product's command line, which the blind check runs.
#[test]
fn the_program_contains_the_product() {
    let (code, out, _) = run(&["jointid", "simulate", "modes", "--position", "l1"]);
    assert!(code == Some(0) && out.contains("frequency Hz"), "{out}");
    let (code, _, err) = run(&["jointid", "identify", "--config", "nowhere.toml"]);
    assert!(code == Some(2) && err.starts_with("jointid: nowhere.toml"), "{err}");
}
