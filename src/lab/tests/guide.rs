//! README and guide: the commands of the laboratory, and the pages on models, motion and papers, run as
//! printed.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::pages::{self, PageCommand};
use crate::{lab, root};

/// Runs the commands of a page in a folder. A script stands for the program `jointid`, all of which the
/// laboratory's program contains.
fn run_page_if(page: &Path, folder: &Path, is_run: impl Fn(&str) -> bool) -> Vec<PageCommand> {
    let programs = tempfile::tempdir().unwrap();
    let program = assert_cmd::cargo::cargo_bin!("jointid-lab").display().to_string();
    let script = format!(
        "#!/bin/sh\ncase $1 in lab) shift; exec '{program}' \"$@\";; withheld) exec '{program}' \"$@\";; esac\nexec '{program}' jointid \"$@\"\n"
    );
    let file = programs.path().join("jointid");
    fs::write(&file, script).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    pages::run_page(page, (programs.path(), is_run), folder, |_| {})
}

fn run_page(page: &Path, folder: &Path) -> Vec<PageCommand> {
    run_page_if(page, folder, |_| true)
}

fn page(name: &str) -> PathBuf {
    root().join("src/guide").join(name)
}

fn document(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join(file)).unwrap()).unwrap()
}

#[test]
#[ignore = "second tier"]
fn the_commands_of_the_readme_run() {
    let folder = tempfile::tempdir().unwrap();
    let commands = run_page_if(&root().join("README.md"), folder.path(), pages::is_of_laboratory);
    assert!(commands.iter().any(|(command, _)| pages::is_of_laboratory(command)));
}

#[test]
fn the_commands_on_models_run() {
    let folder = tempfile::tempdir().unwrap();
    let commands = run_page(&page("models.md"), folder.path());
    assert!(commands.len() > 8);
}

#[test]
#[ignore = "second tier"]
fn the_commands_on_motion_run() {
    let folder = tempfile::tempdir().unwrap();
    let commands = run_page(&page("motion.md"), folder.path());
    assert!(commands.len() > 10);
    let verdict = &document(folder.path(), "hybrid-diagnosis/diagnosis.json")["verdict"];
    assert_eq!(verdict["effects"], serde_json::json!(["lead-growth+lead-error"]), "{verdict}");
    let mass = document(folder.path(), "workpiece/diagnosis/diagnosis.json");
    assert_eq!(mass["verdict"]["kind"], "wrong-parameter", "{}", mass["verdict"]);
    assert!(mass["verdict"]["reason"].as_str().unwrap().contains("moving_mass"), "{}", mass["verdict"]);
}

/// The page on the papers: its commands run, and its table of rival models prints what they find.
#[test]
#[ignore = "second tier"]
fn the_page_on_the_papers_states_what_its_commands_find() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root().join("measurements"), folder.path().join("measurements")).unwrap();
    let text = fs::read_to_string(page("papers.md")).unwrap();
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.contains("| `jointid identify"))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 3);
    // The commands of the rows print documents below.
    let is_in_row = |command: &str| rows.iter().any(|row| row[5].trim_matches('`') == command);
    let commands = run_page_if(&page("papers.md"), folder.path(), |command| !is_in_row(command));
    assert_eq!(commands.iter().filter(|(command, _)| is_in_row(command)).count(), 3);
    for row in rows {
        let arguments: Vec<&str> =
            row[5].trim_matches('`').split_whitespace().skip(1).map(|a| a.trim_matches('\'')).collect();
        let output = lab().arg("jointid").args(&arguments).args(["--json", "--quiet"]).output().unwrap();
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(row[2], format!("{:.1}", found["cost"].as_f64().unwrap()), "{row:?}");
        let largest = 100.0 * found["derived"]["largest_frequency_error_fit"].as_f64().unwrap();
        assert_eq!(row[3], format!("{largest:.1} %"), "{row:?}");
        let positions = found["positions"].as_object().unwrap().values();
        let unexpected = positions
            .flat_map(|p| p["lone_peaks"].as_array().unwrap())
            .filter(|p| p["unexpected"] == true)
            .count();
        assert_eq!(row[4].split(' ').next().unwrap(), unexpected.to_string(), "{row:?}");
    }
}
