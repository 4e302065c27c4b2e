//! Rules of architecture that the manifests cannot express. Cargo enforces acyclic imports between crates;
//! these tests check the imports within each crate.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A source file of a crate, with its module path in the crate and its text without comments and tests.
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
            let mut module: Vec<String> = file
                .trim_start_matches("src/")
                .trim_end_matches(".rs")
                .split('/')
                .map(String::from)
                .collect();
            let crate_name = module.remove(0);
            if module.last().is_some_and(|last| last == "mod" || last == "lib") {
                module.pop();
            }
            let text = fs::read_to_string(&path).unwrap();
            let lines = text.split("#[cfg(test)]").next().unwrap().lines();
            let code = lines
                .map(|l| if l.trim_start().starts_with("//") { "" } else { l })
                .collect::<Vec<_>>()
                .join("\n");
            found.push(Source { crate_name, module, file, code });
        }
    }
}

/// Returns all source files of the crates. The guide and the root module of the library belong to no crate.
fn all_sources() -> Vec<Source> {
    let mut found = Vec::new();
    sources(Path::new("src"), &mut found);
    found.retain(|source| Path::new("src").join(&source.crate_name).join("Cargo.toml").exists());
    found
}

/// Returns the crates of this project that a crate names as dependencies.
fn dependencies(crate_name: &str) -> BTreeSet<String> {
    let workspace: toml::Table = fs::read_to_string("Cargo.toml").unwrap().parse().unwrap();
    let manifest: toml::Table =
        fs::read_to_string(format!("src/{crate_name}/Cargo.toml")).unwrap().parse().unwrap();
    let ours = |name: &&String| workspace["workspace"]["dependencies"][name.as_str()].get("path").is_some();
    manifest["dependencies"].as_table().unwrap().keys().filter(ours).cloned().collect()
}

/// A check of a model against itself proves nothing. The simulator of the blind check's cases therefore
/// depends on no crate of this project.
#[test]
fn the_reference_simulator_shares_no_code_with_the_models() {
    assert_eq!(dependencies("reference_simulator"), BTreeSet::new());
}

/// What is examined does not know what examines it: all but the laboratory itself stands without it.
#[test]
fn the_product_stands_without_the_laboratory() {
    for entry in fs::read_dir("src").unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if Path::new("src").join(&name).join("Cargo.toml").exists() && name != "lab" {
            let found = dependencies(&name);
            assert!(!found.contains("lab") && !found.contains("reference_simulator"), "{name}: {found:?}");
        }
    }
    let manifest: toml::Table = fs::read_to_string("Cargo.toml").unwrap().parse().unwrap();
    let own: Vec<&String> = manifest["dependencies"].as_table().unwrap().keys().collect();
    assert_eq!(own, ["cli", "report", "study"]);
}

/// `cargo test` tests every crate: the Python package alone, whose tests are in Python, is no default member.
#[test]
fn every_crate_but_the_python_package_is_a_default_member() {
    let manifest: toml::Table = fs::read_to_string("Cargo.toml").unwrap().parse().unwrap();
    let members = manifest["workspace"]["default-members"].as_array().unwrap();
    assert!(members.iter().any(|member| member.as_str() == Some("src/[!p]*")), "{members:?}");
    let left_out =
        all_sources().into_iter().map(|source| source.crate_name).filter(|name| name.starts_with('p'));
    assert_eq!(left_out.collect::<BTreeSet<_>>(), BTreeSet::from(["python".to_string()]));
}

/// Answers are judged from result documents only, like an outsider: the judges use neither models nor the
/// simulator's truth beyond its labels.
#[test]
fn the_blind_check_is_judged_from_documents() {
    for source in all_sources().iter().filter(|s| s.file.starts_with("src/lab/withheld/")) {
        for name in [
            "machine",
            "config",
            "dynamics",
            "identification",
            "diagnosis",
            "measurement",
            "optimizer",
            "cli",
        ] {
            assert!(!source.code.contains(&format!("use {name}::")), "{} uses {name}", source.file);
        }
    }
}

/// The source distribution of the Python package builds without the rest of the repository.
#[test]
fn the_source_distribution_has_every_file_that_is_compiled_in() {
    let manifest: toml::Table = fs::read_to_string("pyproject.toml").unwrap().parse().unwrap();
    let included: Vec<&str> = manifest["tool"]["maturin"]["include"]
        .as_array()
        .unwrap()
        .iter()
        .map(|i| i["path"].as_str().unwrap())
        .collect();
    let mut folders = BTreeSet::new();
    for source in all_sources() {
        let outside =
            source.code.split("include_str!(\"../../").skip(1).filter_map(|rest| rest.split('/').next());
        folders.extend(outside.map(|folder| format!("{folder}/**/*")));
    }
    assert!(folders.len() >= 2, "{folders:?}");
    assert!(folders.iter().all(|folder| included.contains(&folder.as_str())), "{folders:?} {included:?}");
}

/// A dependency that no code names costs build time and misleads. Those that only enable features of others
/// are listed for the tool `cargo machete`, too.
#[test]
fn every_dependency_is_named_in_the_code_of_its_crate() {
    let mut unnamed = Vec::new();
    let folders = fs::read_dir("src").unwrap().map(|entry| entry.unwrap().path().display().to_string());
    let crates = folders
        .filter(|folder| Path::new(folder).join("Cargo.toml").exists())
        .map(|folder| (folder.clone(), vec![folder]));
    let root =
        (".".to_string(), ["src/lib.rs", "src/main.rs", "tests", "benches"].map(String::from).to_vec());
    for (folder, places) in crates.chain([root]) {
        let manifest: toml::Table =
            fs::read_to_string(format!("{folder}/Cargo.toml")).unwrap().parse().unwrap();
        let ignored = manifest["package"]
            .get("metadata")
            .map_or(Vec::new(), |m| m["cargo-machete"]["ignored"].as_array().unwrap().clone());
        let code: String = places.iter().map(|place| code_in(Path::new(place))).collect();
        for name in ["dependencies", "dev-dependencies"]
            .into_iter()
            .filter_map(|kind| manifest.get(kind)?.as_table())
            .flat_map(|t| t.keys())
        {
            let name_in_code = name.replace('-', "_");
            let is_named = code.match_indices(&name_in_code).any(|(at, _)| {
                let is_word = |c: char| c.is_alphanumeric() || c == '_';
                let (before, after) = (&code[..at], &code[at + name_in_code.len()..]);
                !before.ends_with(is_word)
                    && !before.ends_with("mod ")
                    && (after.starts_with("::") || after.starts_with([';', ',']))
            });
            if !is_named && !ignored.iter().any(|i| i.as_str() == Some(name)) {
                unnamed.push(format!("{folder}: {name}"));
            }
        }
    }
    assert!(unnamed.is_empty(), "{unnamed:#?}");
}

/// Returns the code of a Rust file, or of all in a folder, with tests and without comments.
fn code_in(place: &Path) -> String {
    if place.is_dir() {
        return fs::read_dir(place).unwrap().map(|entry| code_in(&entry.unwrap().path())).collect();
    }
    if place.extension().is_none_or(|e| e != "rs") {
        return String::new();
    }
    let text = fs::read_to_string(place).unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).flat_map(|line| [line, "\n"]).collect()
}

/// Looking for examples in the documentation of a crate without any takes `cargo test` seconds: such crates
/// say `doctest = false`, and no other, so that every example is tested.
#[test]
fn crates_with_examples_in_their_documentation_test_them() {
    let mut files: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for source in all_sources().into_iter().filter(|s| s.crate_name != "python") {
        files.entry(source.crate_name).or_default().push(source.file);
    }
    for (name, files) in files {
        let has_examples = files.iter().any(|file| {
            let text = fs::read_to_string(file).unwrap();
            let lines = text.lines().map(str::trim_start);
            let documentation = lines.filter(|line| line.starts_with("///") || line.starts_with("//!"));
            let fences = documentation.filter_map(|line| line[3..].trim_start().strip_prefix("```"));
            fences.step_by(2).any(|language| language != "text")
        });
        let manifest: toml::Table =
            fs::read_to_string(format!("src/{name}/Cargo.toml")).unwrap().parse().unwrap();
        let tests_them = manifest["lib"].get("doctest").is_none();
        assert_eq!(has_examples, tests_them, "{name}: examples in its documentation, and tested");
    }
}

/// The command parses arguments, shows progress and prints. Everything else is the library's.
#[test]
fn the_command_uses_the_library_and_the_documents_alone() {
    assert_eq!(dependencies("cli"), ["report", "study"].map(String::from).into());
}

/// A message of the library serves every caller: options of the command line are the command's own.
#[test]
fn no_library_names_an_option_of_the_command_line() {
    let is_option = |text: &str| {
        text.strip_prefix("--").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
    };
    let mut found = Vec::new();
    // The blind check runs the command itself.
    let of_command = |file: &str| file.contains("/blind_check/") || file.contains("src/lab/command/");
    let libraries = all_sources().into_iter().filter(|s| s.crate_name != "cli" && !of_command(&s.file));
    for source in libraries {
        for (at, line) in source.code.lines().enumerate() {
            let words = line.split(|c: char| c.is_whitespace() || "\"«(".contains(c));
            // A whole command may be quoted.
            if words.into_iter().any(is_option) && !line.contains("`jointid ") {
                found.push(format!("{}, line {}: {}", source.file, at + 1, line.trim()));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// Errors of the library are enums, so that a caller can tell what is wrong with which file, line or key.
#[test]
fn no_function_of_the_library_returns_a_text_as_its_error() {
    let with_text =
        |line: &str| line.contains("Result<") && line.contains(", String>") && !line.contains("Ok(");
    let is_library = |s: &Source| {
        !["cli", "reference_simulator"].contains(&s.crate_name.as_str())
            && !s.file.starts_with("src/lab/command/")
    };
    let libraries = all_sources().into_iter().filter(is_library);
    let found: Vec<String> = libraries
        .filter(|s| !s.file.ends_with("/tests.rs") && s.code.lines().any(with_text))
        .map(|s| s.file)
        .collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn the_model_contains_no_machine_specific_name() {
    for source in all_sources()
        .iter()
        .filter(|s| ["dynamics", "optimizer", "identification"].contains(&s.crate_name.as_str()))
    {
        for name in ["tian", "k_al", "k_m\"", "\"rotor\"", "\"table\""] {
            assert!(!source.code.contains(name), "{} contains «{name}»", source.file);
        }
    }
}

#[test]
fn files_are_short_enough_to_read() {
    for source in all_sources() {
        let lines = source.code.lines().count();
        assert!(lines <= 500, "{}: {lines} lines, not counting tests", source.file);
    }
}

/// The crate `diagnosis` is exempt.
#[test]
fn functions_are_short_enough_to_read() {
    let mut long = Vec::new();
    for source in all_sources().iter().filter(|s| s.crate_name != "diagnosis") {
        let lines: Vec<&str> = source.code.lines().collect();
        for (at, line) in lines
            .iter()
            .enumerate()
            .filter(|(_, line)| line.contains("fn ") && !line.trim_end().ends_with(';'))
        {
            let indent = &line[..line.len() - line.trim_start().len()];
            // rustfmt puts the end of a body on its own line, at the indentation of the line that begins it.
            let end = lines[at..].iter().position(|l| {
                *l == format!("{indent}}}") || (l.starts_with(indent) && l[indent.len()..].starts_with("} "))
            });
            let count = end.map_or(0, |end| end + 1);
            if count > 100 {
                long.push(format!("{}, line {}: {count} lines", source.file, at + 1));
            }
        }
    }
    assert!(long.is_empty(), "{long:#?}");
}

/// A cycle of any length between the modules of a crate makes each of them part of one unit in several files.
#[test]
fn modules_of_a_crate_import_without_cycles() {
    let all = all_sources();
    let mut found = Vec::new();
    for name in all.iter().map(|s| s.crate_name.as_str()).collect::<BTreeSet<_>>() {
        let files: Vec<&Source> = all.iter().filter(|s| s.crate_name == name).collect();
        let cycles = import_cycles(&imports(&files)).into_iter();
        found.extend(cycles.map(|cycle| {
            cycle.into_iter().map(|module| format!("{name}::{}", module.join("::"))).collect::<Vec<String>>()
        }));
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// Imports within functions count, those for type checkers alone do not: they are never executed.
#[test]
fn modules_of_the_python_package_import_without_cycles() {
    let folder = Path::new("src/python/jointid");
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "py"));
    let modules: BTreeMap<String, String> = files
        .map(|path| {
            (path.file_stem().unwrap().to_str().unwrap().to_string(), fs::read_to_string(&path).unwrap())
        })
        .collect();
    let known = |name: &str| modules.contains_key(name).then(|| vec![name.to_string()]);
    let all: BTreeMap<Module, BTreeSet<Module>> = modules
        .iter()
        .map(|(name, text)| {
            (vec![name.clone()], python_imports(text).iter().filter_map(|name| known(name)).collect())
        })
        .collect();
    assert!(all[&known("study").unwrap()].len() > 3, "{all:?}");
    assert_eq!(import_cycles(&all), Vec::<Vec<Module>>::new());
}

/// Returns the modules of its own package that a Python module imports when it is executed.
fn python_imports(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_for_types = false;
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        is_for_types = line.starts_with("if TYPE_CHECKING:") || (is_for_types && line.starts_with(' '));
        let Some(rest) = line.trim_start().strip_prefix("from .").filter(|_| !is_for_types) else { continue };
        let Some((module, names)) = rest.split_once(" import ") else { continue };
        match module {
            "" => found
                .extend(names.split(',').map(|name| name.split(" as ").next().unwrap().trim().to_string())),
            module => found.push(module.to_string()),
        }
    }
    found
}

type Module = Vec<String>;

/// Returns the modules of its own crate that each module imports. A re-exported name counts as an import of
/// its defining module.
fn imports(files: &[&Source]) -> BTreeMap<Module, BTreeSet<Module>> {
    let reexports: BTreeMap<&Module, Vec<Vec<String>>> =
        files.iter().map(|s| (&s.module, uses(&s.code, true))).collect();
    let mut all = BTreeMap::new();
    for source in files {
        let mut into = BTreeSet::new();
        let children =
            files.iter().filter(|s| s.module.split_last().is_some_and(|(_, parent)| parent == source.module));
        let children: Vec<String> = children.filter_map(|s| s.module.last().cloned()).collect();
        for path in uses(&source.code, false).into_iter().chain(inline_paths(&source.code, &children)) {
            into.extend(resolve(&source.module, &path, &reexports).filter(|module| *module != source.module));
        }
        all.insert(source.module.clone(), into);
    }
    all
}

/// Resolves a path used in the module `from` to the module that defines its item; `None` for paths outside
/// the crate.
fn resolve(
    from: &Module,
    path: &[String],
    reexports: &BTreeMap<&Module, Vec<Vec<String>>>,
) -> Option<Module> {
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
    if rest.len() == path.len()
        && !reexports.contains_key(&[module.clone(), vec![rest.first()?.clone()]].concat())
    {
        return None;
    }
    while let [first, more @ ..] = rest {
        let inner = [module.clone(), vec![first.clone()]].concat();
        if reexports.contains_key(&inner) {
            (module, rest) = (inner, more);
            continue;
        }
        let on = reexports[&module].iter().find(|on| on.last() == Some(first) && on.len() > 1);
        return on.map_or(Some(module.clone()), |on| resolve(&module, on, reexports));
    }
    Some(module)
}

/// Returns the paths of `use` items, one per name: of re-exports (`pub use`) if `public`, otherwise of
/// private imports.
fn uses(code: &str, public: bool) -> Vec<Vec<String>> {
    let mut all = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let before = code[..at].rsplit('\n').next().unwrap().trim();
        if !(before.is_empty() || before.starts_with("pub")) || before.starts_with("pub") != public {
            continue;
        }
        let tree = code[at + 4..].split(';').next().unwrap();
        expand_use_tree(&tree.split_whitespace().collect::<Vec<_>>().join(" "), &[], &mut all);
    }
    all
}

/// Appends the paths of one use tree, each with the prefix `before`.
fn expand_use_tree(tree: &str, before: &[String], all: &mut Vec<Vec<String>>) {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap().split("::").map(|name| name.trim().to_string());
        all.push(before.iter().cloned().chain(path).collect());
        return;
    };
    let stem: Vec<String> = tree[..open]
        .trim_end_matches("::")
        .split("::")
        .filter(|n| !n.is_empty())
        .map(|n| n.trim().to_string())
        .collect();
    let stem = [before, &stem].concat();
    let (mut depth, mut from) = (0, open + 1);
    for (at, letter) in tree.char_indices().skip_while(|(at, _)| *at <= open) {
        match letter {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                if !tree[from..at].trim().is_empty() {
                    expand_use_tree(&tree[from..at], &stem, all);
                }
                from = at + 1;
            }
            _ => {}
        }
    }
}

/// Returns the paths written inline in the code, starting at the crate, at a parent or at a child. `use`
/// items are skipped.
fn inline_paths(code: &str, children: &[String]) -> Vec<Vec<String>> {
    let starts = ["crate", "super"]
        .into_iter()
        .chain(children.iter().map(String::as_str))
        .map(|name| format!("{name}::"));
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

/// Returns the import cycles, sorted: sets of more than one module in which each reaches every other.
fn import_cycles(imports: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<Vec<Module>> {
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
    let reached: BTreeMap<&Module, BTreeSet<Module>> =
        imports.keys().map(|module| (module, reach(module))).collect();
    let cycle = |of: &Module| -> Vec<Module> {
        imports
            .keys()
            .filter(|other| reached[of].contains(*other) && reached[*other].contains(of))
            .cloned()
            .collect()
    };
    let all: BTreeSet<Vec<Module>> = imports.keys().map(cycle).filter(|cycle| cycle.len() > 1).collect();
    all.into_iter().collect()
}
