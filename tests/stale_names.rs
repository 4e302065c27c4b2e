//! Names in back-ticks: every path of the project and every type that a comment or the guide names exists.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Types of the language, its standard library and of dependencies that comments name.
const FOREIGN: [&str; 11] = [
    "Debug",
    "Display",
    "ErrorKind",
    "InvalidInput",
    "KeyboardInterrupt",
    "None",
    "Result",
    "Some",
    "Solver",
    "ValueError",
    "Vec",
];

/// Folders of the project that a path may begin with.
const FOLDERS: [&str; 8] = ["src", "tests", "configs", "measurements", "benches", ".ci", ".cargo", ".github"];

/// Returns all text files of the project with one of the endings, by their path.
fn texts(folder: &Path, endings: &[&str], found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if !path.ends_with("target") && !path.ends_with("fuzz") {
                texts(&path, endings, found);
            }
        } else if path.extension().is_some_and(|e| endings.iter().any(|ending| e == *ending)) {
            found.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
}

/// Returns the quotations in back-ticks of a line.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// Returns the names that items of the code declare, variants of enums included.
fn declared(code: &[(String, String)]) -> BTreeSet<&str> {
    let word = |text: &str| text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let mut names = BTreeSet::new();
    for line in code
        .iter()
        .flat_map(|(_, text)| text.lines())
        .map(str::trim_start)
        .filter(|line| !line.starts_with("//"))
    {
        for keyword in ["struct ", "enum ", "trait ", "type ", "const ", "union "] {
            for rest in line.split(keyword).skip(1) {
                names.insert(&rest[..word(rest)]);
            }
        }
        if line.starts_with(|c: char| c.is_ascii_uppercase()) {
            names.insert(&line[..word(line)]);
        }
    }
    names
}

/// Returns the names of types in a quotation that is a path of types, modules before it included; none for
/// any other text.
fn types_in(quotation: &str) -> Vec<&str> {
    let parts: Vec<&str> = quotation.trim_end_matches("()").split("::").collect();
    let is_word = |part: &&str| !part.is_empty() && part.chars().all(|c| c.is_alphanumeric() || c == '_');
    let is_type = |part: &&str| {
        part.starts_with(|c: char| c.is_ascii_uppercase()) && part.contains(|c: char| c.is_ascii_lowercase())
    };
    if !parts.iter().all(is_word) { Vec::new() } else { parts.into_iter().filter(is_type).collect() }
}

#[test]
fn paths_and_types_in_back_ticks_exist() {
    let (mut code, mut guide) = (Vec::new(), Vec::new());
    for folder in ["src", "tests", "benches"] {
        texts(Path::new(folder), &["rs"], &mut code);
    }
    texts(Path::new("src/guide"), &["md"], &mut guide);
    guide.push(("README.md".into(), fs::read_to_string("README.md").unwrap()));
    let known = declared(&code);
    let mut stale = Vec::new();
    let mut check = |file: &str, at: usize, line: &str| {
        for quotation in quoted(line) {
            let path = quotation.split([':', ' ', '*', '<']).next().unwrap_or_default();
            let is_ours = path.split_once('/').is_some_and(|(folder, _)| FOLDERS.contains(&folder));
            let is_source = path.ends_with(".rs") && !path.contains('/');
            let exists = match is_source {
                true => code.iter().any(|(known, _)| known.ends_with(&format!("/{path}"))),
                // Inputs that fuzzing finds are not part of the project.
                false => !is_ours || path.starts_with("tests/fuzz/corpus") || Path::new(path).exists(),
            };
            if !exists {
                stale.push(format!("{file}, line {}: no file `{path}`", at + 1));
            }
            // Names of records and columns may be written like types: `NAME_m`.
            let types = types_in(quotation).into_iter().filter(|t| !t.contains('_') && !FOREIGN.contains(t));
            stale.extend(
                types
                    .filter(|t| !known.contains(t))
                    .map(|t| format!("{file}, line {}: no type `{t}`", at + 1)),
            );
        }
    };
    for (file, text) in &code {
        for (at, line) in text.lines().enumerate() {
            if let Some((_, comment)) = line.split_once("//") {
                check(file, at, comment);
            }
        }
    }
    for (file, text) in &guide {
        text.lines().enumerate().for_each(|(at, line)| check(file, at, line));
    }
    assert!(stale.is_empty(), "{stale:#?}");
}
