//! Files that are written: nothing of the user's is replaced unasked, and nothing is half-written.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// The FRF of a mass on a spring, as a table.
fn table(from_hz: u32) -> String {
    let mut text = "frequency_hz,real,imag\n".to_string();
    for hz in (from_hz..120).step_by(2) {
        let omega = std::f64::consts::TAU * f64::from(hz);
        let (stiffness, damping) = (1e7 - 100.0 * omega * omega, 3e3 * omega);
        let size = stiffness * stiffness + damping * damping;
        text += &format!("{hz},{:e},{:e}\n", stiffness / size, -damping / size);
    }
    text
}

const IMPORT: [&str; 8] =
    ["--quantity", "receptance", "--position", "l1", "--response", "table", "--excitation", "table"];

/// Runs the command in a folder. Returns exit code and stderr.
fn run(folder: &Path, line: &str) -> (i32, String) {
    let words = line.split_whitespace();
    let output = Command::cargo_bin("jointid").unwrap().args(words).current_dir(folder).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn done(folder: &Path, line: &str) {
    let (code, message) = run(folder, line);
    assert_eq!(code, 0, "{line}: {message}");
}

/// Content of all files of a folder that can be read, by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let kind = entry.file_type().unwrap();
        let name = entry.file_name().to_string_lossy().into_owned();
        if kind.is_dir() {
            found.extend(
                files(&entry.path()).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)),
            );
        } else {
            found.push((name, if kind.is_file() { fs::read(entry.path()).unwrap() } else { Vec::new() }));
        }
    }
    found.sort();
    found
}

/// Asserts that a command is refused with one line that contains `expected`, and changes no file.
fn refused(folder: &Path, line: &str, expected: &str) {
    let before = files(folder);
    let (code, message) = run(folder, line);
    assert_eq!(code, 2, "{line}: {message}");
    let last = message.lines().last().unwrap_or_default();
    assert!(last.starts_with("jointid: ") && last.contains(expected), "{line}: {message}");
    assert!(files(folder) == before, "{line} changed {:?}", files(folder));
}

/// A folder with a result `r`, a set `set`, and files of the user.
fn folder() -> tempfile::TempDir {
    let made = tempfile::tempdir().unwrap();
    let folder = made.path();
    fs::write(folder.join("a.csv"), table(5)).unwrap();
    fs::write(folder.join("own"), "the user's").unwrap();
    done(folder, &format!("import a.csv --out set {}", IMPORT.join(" ")));
    done(folder, "identify --repeats 1 --quiet --out r");
    made
}

const PREDICT: &str = "predict --result r/identification.json --nut-m 1 --draws 39 --quiet";

#[test]
fn named_files_are_replaced_on_request_and_inputs_never() {
    let made = folder();
    let folder = made.path();
    let lines = [
        (format!("{PREDICT} --machine-out"), "r/identification.json"),
        ("export --measurements set --out".into(), "set/frf/a.csv"),
        ("report r --out".into(), "r/identification.json"),
        ("diagnose --measurements set --apply".into(), "set/manifest.toml"),
    ];
    for (line, input) in lines {
        refused(folder, &format!("{line} own"), "own: already exists; name another file");
        refused(folder, &format!("{line} {input}"), "");
        refused(folder, &format!("{line} {input} --replace"), "is an input of this run");
        if !line.starts_with("diagnose") {
            fs::write(folder.join("other"), "the user's").unwrap();
            done(folder, &format!("{line} other --replace"));
            assert_ne!(fs::read(folder.join("other")).unwrap(), b"the user's");
        }
    }
    for same in ["p/prediction.json", "./p/prediction.json", "p/../p/prediction.json"] {
        let line = format!("{PREDICT} --out p --machine-out {same}");
        refused(folder, &line, "is a document of this run");
    }
    // A page is replaced by the next one.
    done(folder, "report r");
    done(folder, "report r");
}

#[test]
fn result_folders_replace_results_of_an_earlier_run_alone() {
    let made = folder();
    let folder = made.path();
    for _ in 0..2 {
        done(folder, &format!("{PREDICT} --out r"));
        done(folder, "man --out man");
    }
    for (name, line) in [
        ("prediction.csv", format!("{PREDICT} --out new")),
        ("modes.csv", "peaks --measurements set --out new".into()),
        (
            "motion.csv",
            format!(
                "simulate motion --config {}/configs/servo-axis.toml --reference s-curve --travel-m 0.1 --out new",
                env!("CARGO_MANIFEST_DIR")
            ),
        ),
        ("identification.json", "identify --repeats 1 --out new".into()),
        ("jointid.1", "man --out new".into()),
        ("machine.toml", "init new".into()),
    ] {
        let new = folder.join("new");
        fs::create_dir(&new).unwrap();
        fs::write(new.join(name), "the user's").unwrap();
        refused(folder, &line, &format!("{name}: already exists"));
        fs::remove_dir_all(&new).unwrap();
    }
}

#[test]
fn a_set_is_imported_as_a_whole() {
    let made = folder();
    let folder = made.path();
    let import = |out: &str| format!("import a.csv --out {out} {}", IMPORT.join(" "));
    fs::create_dir_all(folder.join("tables/frf")).unwrap();
    fs::write(folder.join("tables/frf/a.csv"), "the user's").unwrap();
    refused(folder, &import("tables"), "a.csv: already exists");
    refused(folder, &import("set"), "manifest.toml: already exists");
    done(folder, &(import("set") + " --replace"));
    let own = import("set").replace("a.csv", "set/frf/a.csv");
    refused(folder, &(own + " --replace"), "is an input of this run");
    // A table that cannot be replaced keeps the former set.
    fs::write(folder.join("a.csv"), table(7)).unwrap();
    fs::remove_file(folder.join("set/frf/a.csv")).unwrap();
    fs::create_dir(folder.join("set/frf/a.csv")).unwrap();
    refused(folder, &(import("set") + " --replace"), "is a folder");
}

#[cfg(unix)]
#[test]
fn links_pipes_and_devices_are_never_replaced() {
    let made = folder();
    let folder = made.path();
    let pipe = folder.join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::os::unix::fs::symlink("nowhere", folder.join("link")).unwrap();
    std::os::unix::fs::symlink("/dev/null", folder.join("null")).unwrap();
    for (name, kind) in [("pipe", "is a pipe"), ("link", "is a link"), ("null", "is a link")] {
        for line in [
            format!("{PREDICT} --machine-out"),
            "export --measurements set --out".into(),
            "report r --out".into(),
            "diagnose --apply".into(),
        ] {
            refused(folder, &format!("{line} {name}"), kind);
            refused(folder, &format!("{line} {name} --replace"), kind);
        }
    }
    fs::create_dir(folder.join("out")).unwrap();
    fs::rename(&pipe, folder.join("out/modes.json")).unwrap();
    refused(folder, "simulate modes --out out", "is a pipe");
    refused(folder, "simulate modes --out link", "is a link to nothing");
    refused(folder, "simulate modes --out /dev/null", "/dev/null: is a file; name a folder");
    fs::rename(folder.join("link"), folder.join("out/machine.toml")).unwrap();
    refused(folder, "init out", "is a link");
}
