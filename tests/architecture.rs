//! What the manifests cannot say of the folders: that imports run one way between crates is a fact of each crate's Cargo.toml, within one it is counted here.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A file of a crate: its module path in the crate, and its text without comments and tests.
struct Source {
    crate_name: String,
    module: Vec<String>,
    file: String,
    code: String,
}

fn sources(folder: &Path, found: &mut Vec<Source>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "tests") {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let file = path.display().to_string();
            let mut module: Vec<String> = file.trim_start_matches("src/").trim_end_matches(".rs").split('/').map(String::from).collect();
            let crate_name = module.remove(0);
            if module.last().is_some_and(|last| last == "mod" || last == "lib") {
                module.pop();
            }
            let text = fs::read_to_string(&path).unwrap();
            let lines = text.split("#[cfg(test)]").next().unwrap().lines();
            let code = lines.map(|l| if l.trim_start().starts_with("//") { "" } else { l }).collect::<Vec<_>>().join("\n");
            found.push(Source { crate_name, module, file, code });
        }
    }
}

/// All files of the crates; the guide and the front page of the library are no crate.
fn all_sources() -> Vec<Source> {
    let mut found = Vec::new();
    sources(Path::new("src"), &mut found);
    found.retain(|source| Path::new("src").join(&source.crate_name).join("Cargo.toml").exists());
    found
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
    for source in all_sources().iter().filter(|s| ["dynamics", "optimizer", "identification"].contains(&s.crate_name.as_str())) {
        for name in ["tian", "k_al", "k_m\"", "\"rotor\"", "\"table\""] {
            assert!(!source.code.contains(name), "{} knows «{name}»", source.file);
        }
    }
}

#[test]
fn files_are_short_enough_to_read() {
    for source in all_sources() {
        let lines = source.code.lines().count();
        assert!(lines <= 500, "{}: {lines} lines before tests", source.file);
    }
}

/// Outside `diagnosis`, which is rebuilt.
#[test]
fn functions_are_short_enough_to_read() {
    let mut long = Vec::new();
    for source in all_sources().iter().filter(|s| s.crate_name != "diagnosis") {
        let lines: Vec<&str> = source.code.lines().collect();
        for (at, line) in lines.iter().enumerate().filter(|(_, line)| line.contains("fn ") && !line.trim_end().ends_with(';')) {
            let indent = &line[..line.len() - line.trim_start().len()];
            // By rustfmt a body ends in a line of its own, as far in as the line that begins it.
            let end = lines[at..]
                .iter()
                .position(|l| *l == format!("{indent}}}") || (l.starts_with(indent) && l[indent.len()..].starts_with("} ")));
            let count = end.map_or(0, |end| end + 1);
            if count > 100 {
                long.push(format!("{}, line {}: {count} lines", source.file, at + 1));
            }
        }
    }
    assert!(long.is_empty(), "{long:#?}");
}

/// Circles of files that import one another, by the files in them, each argued. Those of the diagnosis are left until it is rebuilt: what a hypothesis adds
/// to a machine and what its nulls draw beside it, the stages of a verdict on motions and what they share, a gap and its floor, a survey and its null are
/// each one thought in two files.
const CIRCLES: [&[&str]; 3] = [
    &["diagnosis::motion::conclude", "diagnosis::motion::stage", "diagnosis::motion::verdict", "diagnosis::motion::work"],
    &["diagnosis::motion::floor", "diagnosis::motion::gap"],
    &["diagnosis::motion::null", "diagnosis::motion::survey"],
];

#[test]
fn files_of_a_folder_do_not_import_in_circles() {
    let all = all_sources();
    let mut found = Vec::new();
    for name in all.iter().map(|s| s.crate_name.as_str()).collect::<BTreeSet<_>>() {
        let files: Vec<&Source> = all.iter().filter(|s| s.crate_name == name).collect();
        found.extend(
            circles(&imports(&files))
                .into_iter()
                .map(|circle| circle.into_iter().map(|module| format!("{name}::{}", module.join("::"))).collect::<Vec<String>>()),
        );
    }
    let known: Vec<Vec<String>> = CIRCLES.iter().map(|circle| circle.iter().map(|m| m.to_string()).collect()).collect();
    assert_eq!(found, known);
}

type Module = Vec<String>;

/// What each module imports of its own crate. A name that a module passes on counts for where it stands.
fn imports(files: &[&Source]) -> BTreeMap<Module, BTreeSet<Module>> {
    let passed_on: BTreeMap<&Module, Vec<Vec<String>>> = files.iter().map(|s| (&s.module, uses(&s.code, true))).collect();
    let mut all = BTreeMap::new();
    for source in files {
        let mut into = BTreeSet::new();
        let children = files.iter().filter(|s| s.module.split_last().is_some_and(|(_, parent)| parent == source.module));
        let children: Vec<String> = children.filter_map(|s| s.module.last().cloned()).collect();
        for path in uses(&source.code, false).into_iter().chain(paths(&source.code, &children)) {
            into.extend(home(&source.module, &path, &passed_on).filter(|module| *module != source.module));
        }
        all.insert(source.module.clone(), into);
    }
    all
}

/// The module in which a path of another module leads to something.
fn home(from: &Module, path: &[String], passed_on: &BTreeMap<&Module, Vec<Vec<String>>>) -> Option<Module> {
    let mut module = from.clone();
    let mut rest = path;
    while let [first, more @ ..] = rest {
        match first.as_str() {
            "crate" => module.clear(),
            "super" => {
                module.pop()?;
            }
            "self" => {}
            _ => break,
        }
        rest = more;
    }
    if rest.len() == path.len() && !passed_on.contains_key(&[module.clone(), vec![rest.first()?.clone()]].concat()) {
        return None;
    }
    while let [first, more @ ..] = rest {
        let inner = [module.clone(), vec![first.clone()]].concat();
        if passed_on.contains_key(&inner) {
            (module, rest) = (inner, more);
            continue;
        }
        let on = passed_on[&module].iter().find(|on| on.last() == Some(first) && on.len() > 1);
        return on.map_or(Some(module.clone()), |on| home(&module, on, passed_on));
    }
    Some(module)
}

/// Paths of `use` items, one for each name: those passed on (`pub use`), or the others.
fn uses(code: &str, public: bool) -> Vec<Vec<String>> {
    let mut all = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let before = code[..at].rsplit('\n').next().unwrap().trim();
        if !(before.is_empty() || before.starts_with("pub")) || before.starts_with("pub") != public {
            continue;
        }
        let tree = code[at + 4..].split(';').next().unwrap();
        branches(&tree.split_whitespace().collect::<Vec<_>>().join(" "), &[], &mut all);
    }
    all
}

fn branches(tree: &str, before: &[String], all: &mut Vec<Vec<String>>) {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap().split("::").map(|name| name.trim().to_string());
        all.push(before.iter().cloned().chain(path).collect());
        return;
    };
    let stem: Vec<String> =
        tree[..open].trim_end_matches("::").split("::").filter(|n| !n.is_empty()).map(|n| n.trim().to_string()).collect();
    let stem = [before, &stem].concat();
    let (mut depth, mut from) = (0, open + 1);
    for (at, letter) in tree.char_indices().skip_while(|(at, _)| *at <= open) {
        match letter {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                if !tree[from..at].trim().is_empty() {
                    branches(&tree[from..at], &stem, all);
                }
                from = at + 1;
            }
            _ => {}
        }
    }
}

/// Paths that stand in the code itself, from the crate, from a parent or from a child; of `pub use` items only what they pass on stands there.
fn paths(code: &str, children: &[String]) -> Vec<Vec<String>> {
    let starts = ["crate", "super"].into_iter().chain(children.iter().map(String::as_str)).map(|name| format!("{name}::"));
    let within = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let mut all = Vec::new();
    for start in starts {
        for (at, _) in code.match_indices(&start).filter(|(at, _)| !code[..*at].ends_with(within)) {
            let item = code[..at].rsplit([';', '}']).next().unwrap().trim_start();
            if !item.starts_with("pub use ") && !item.starts_with("use ") {
                let path = code[at..].split(|c| !within(c)).next().unwrap();
                all.push(path.split("::").filter(|name| !name.is_empty()).map(String::from).collect());
            }
        }
    }
    all
}

/// Sets of more than one module each of which leads to every other, in order.
fn circles(imports: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<Vec<Module>> {
    let reach = |from: &Module| {
        let mut seen = BTreeSet::new();
        let mut next: Vec<&Module> = imports[from].iter().collect();
        while let Some(module) = next.pop() {
            if seen.insert(module.clone()) {
                next.extend(imports.get(module).into_iter().flatten());
            }
        }
        seen
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> = imports.keys().map(|module| (module, reach(module))).collect();
    let circle = |of: &Module| -> Vec<Module> {
        imports.keys().filter(|other| reached[of].contains(*other) && reached[*other].contains(of)).cloned().collect()
    };
    let all: BTreeSet<Vec<Module>> = imports.keys().map(circle).filter(|circle| circle.len() > 1).collect();
    all.into_iter().collect()
}
