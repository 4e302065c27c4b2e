//! What the manifests cannot say of the folders: that imports run one way between them is a fact of each crate's Cargo.toml.

use std::fs;
use std::path::{Path, PathBuf};

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

/// A check of a model against itself proves nothing: the simulator that makes the cases of the blind check stands on no crate of this project.
#[test]
fn the_reference_simulator_shares_no_code_with_the_models() {
    let manifest: toml::Table = fs::read_to_string("src/reference_simulator/Cargo.toml").unwrap().parse().unwrap();
    let workspace: toml::Table = fs::read_to_string("Cargo.toml").unwrap().parse().unwrap();
    let ours = |name: &str| workspace["workspace"]["dependencies"][name].get("path").is_some();
    let found: Vec<&String> = manifest["dependencies"].as_table().unwrap().keys().filter(|name| ours(name)).collect();
    assert!(found.is_empty(), "{found:?}");
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
