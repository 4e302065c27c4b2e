//! Folders follow the way from data to report, and imports run one way.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What each folder may import, besides itself, `numeric` and `unit`.
fn allowed() -> BTreeMap<&'static str, Vec<&'static str>> {
    BTreeMap::from([
        ("numeric", vec![]),
        ("unit", vec![]),
        ("measurement", vec![]),
        ("contact", vec![]),
        ("machine", vec!["contact"]),
        ("modal", vec![]),
        ("model", vec!["machine"]),
        ("objective", vec!["measurement", "machine", "model", "optimizer"]),
        ("motion", vec!["measurement", "machine", "model"]),
        ("inverse_dynamics", vec!["measurement", "machine", "model"]),
        ("optimizer", vec![]),
        ("network", vec!["optimizer"]),
        ("identification", vec!["measurement", "machine", "model", "motion", "objective", "inverse_dynamics", "optimizer"]),
        ("validation", vec!["measurement", "machine", "model", "objective", "optimizer", "identification"]),
        ("diagnosis", vec!["measurement", "machine", "model", "objective", "inverse_dynamics", "optimizer", "identification"]),
        ("report", vec![]),
        ("config", vec!["contact", "machine"]),
        // The independent truth of the blind check shares nothing with the models under test, not even constants.
        ("truth", vec![]),
        // Its cases and labels come from the truth, its answers from the command line: it knows no model.
        ("withheld", vec!["truth", "report"]),
        ("guide", vec![]),
        (
            "cli",
            vec![
                "modal",
                "measurement",
                "contact",
                "machine",
                "model",
                "objective",
                "inverse_dynamics",
                "motion",
                "network",
                "optimizer",
                "identification",
                "validation",
                "diagnosis",
                "report",
                "config",
                "truth",
                "withheld",
            ],
        ),
    ])
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

fn all_sources() -> Vec<(String, PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    files
        .into_iter()
        .filter_map(|path| {
            let inner = path.strip_prefix(&root).unwrap();
            let folder = inner.components().next().unwrap().as_os_str().to_string_lossy().trim_end_matches(".rs").to_string();
            let text = fs::read_to_string(&path).unwrap();
            (!["lib", "main"].contains(&folder.as_str())).then_some((folder, path, text))
        })
        .collect()
}

#[test]
fn imports_run_one_way() {
    let allowed = allowed();
    let mut faults = Vec::new();
    for (folder, path, text) in all_sources() {
        let may = allowed.get(folder.as_str()).unwrap_or_else(|| panic!("{folder} is not in the table of this test"));
        for (at, _) in text.match_indices("crate::") {
            let name: String = text[at + 7..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect();
            let leaf = ["numeric", "unit"].contains(&name.as_str()) && folder != "truth";
            let fine = name == folder || leaf || may.contains(&name.as_str());
            if !fine {
                faults.push(format!("{} imports {name}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn the_model_knows_no_machine_by_name() {
    for (folder, path, text) in all_sources() {
        let code: String = text.split("#[cfg(test)]").next().unwrap().lines().filter(|l| !l.trim_start().starts_with("//")).collect();
        if ["model", "objective", "optimizer", "identification"].contains(&folder.as_str()) {
            for name in ["tian", "k_al", "k_m", "\"rotor\"", "\"table\""] {
                assert!(!code.contains(name), "{} knows «{name}»", path.display());
            }
        }
    }
}

#[test]
fn files_are_short_enough_to_read() {
    for (_, path, text) in all_sources() {
        let lines = text.split("#[cfg(test)]").next().unwrap().lines().count();
        assert!(lines <= 500, "{}: {lines} lines before tests", path.display());
    }
}
