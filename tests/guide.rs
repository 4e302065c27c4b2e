//! README and guide: every command runs as printed, printed results are the program's, and every test that a
//! page names exists.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::diagnosis::ROTOR_HOLD;
use crate::support::axis_template::{fill_in_machine, fill_in_measurements};
use crate::support::pages::{self, PageCommand};

/// Folder of the guide's pages.
const GUIDE: &str = "src/guide";

/// Runs those commands of a page that are asked for in a folder, but not those of the laboratory; its tests
/// run them.
fn run_page_if(
    page: &Path,
    folder: &Path,
    after_init: impl Fn(&Path),
    is_run: impl Fn(&str) -> bool,
) -> Vec<PageCommand> {
    let programs = assert_cmd::cargo::cargo_bin!("jointid").parent().unwrap();
    let is_run = |command: &str| !pages::is_of_laboratory(command) && is_run(command);
    pages::run_page(page, (programs, is_run), folder, after_init)
}

/// Runs the commands of a page in a folder, those of the laboratory left out.
fn run_page(page: &Path, folder: &Path, after_init: impl Fn(&Path)) -> Vec<PageCommand> {
    run_page_if(page, folder, after_init, |_| true)
}

fn page(name: &str) -> PathBuf {
    Path::new(GUIDE).join(name)
}

fn document(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join(file)).unwrap()).unwrap()
}

/// The published bench, typed into the template, stands for the reader's machine.
fn fill_in(folder: &Path) {
    fill_in_machine(&folder.join("axis"));
    fill_in_measurements(&folder.join("axis"), &folder.join("taps"));
}

/// Diagnoses take longest, and other tests run those of the README: that of the bench, and that of the page
/// on FRFs, which writes into another folder.
#[cfg(unix)]
#[test]
fn the_commands_of_the_readme_run() {
    let folder = tempfile::tempdir().unwrap();
    let is_diagnosis = |command: &str| command.starts_with("jointid diagnose");
    let commands =
        run_page_if(Path::new("README.md"), folder.path(), fill_in, |command| !is_diagnosis(command));
    let commands: Vec<&str> = commands.iter().map(|(command, _)| command.as_str()).collect();
    assert_eq!(commands[..2], ["cargo run --release -- identify --positions l1,l3,l5", "cargo test"]);
    assert!(folder.path().join("axis/results/report.html").exists());
    let on_frfs = fs::read_to_string(page("own-frfs.md")).unwrap();
    let diagnoses: Vec<&str> = commands.into_iter().filter(|command| is_diagnosis(command)).collect();
    assert_eq!(diagnoses.len(), 2);
    for command in diagnoses {
        let there = command.replace("--out axis/results", "--out axis/frf-results");
        assert!(command == ROTOR_HOLD || on_frfs.lines().any(|line| line == there), "{command}");
    }
}

#[cfg(unix)]
#[test]
#[ignore = "second tier"]
fn the_pages_on_machine_and_frfs_lead_to_results() {
    let folder = tempfile::tempdir().unwrap();
    run_page(&page("own-machine.md"), folder.path(), fill_in);
    run_page(&page("own-frfs.md"), folder.path(), |_| {});
    assert!(folder.path().join("axis/frf-results/report.html").exists());
}

#[cfg(unix)]
#[test]
fn the_page_on_results_shows_the_program_s_tables() {
    let folder = tempfile::tempdir().unwrap();
    contains_blocks("results.md", &run_page(&page("results.md"), folder.path(), |_| {}));
}

#[cfg(unix)]
#[test]
fn the_commands_of_the_page_on_prediction_run() {
    let folder = tempfile::tempdir().unwrap();
    run_page(&page("prediction.md"), folder.path(), |_| {});
    let drawn = fs::read_to_string(folder.path().join("results/report.html")).unwrap();
    assert!(drawn.contains("id=\"prediction-frequency\""));
}

/// Simulated records, in rad and N·m, lead back to the inertia with which they were made.
#[cfg(unix)]
#[test]
fn the_page_on_rotary_axes_leads_to_an_inertia() {
    let folder = tempfile::tempdir().unwrap();
    let name_records = |folder: &Path| {
        let manifest = folder.join("table/measurements/manifest.toml");
        let text = fs::read_to_string(&manifest).unwrap();
        fs::write(&manifest, text.replace("st.csv", "st/motion.csv").replace("ow.csv", "ow/motion.csv"))
            .unwrap();
    };
    run_page(&page("rotary.md"), folder.path(), name_records);
    let found = &document(folder.path(), "table/results/identification.json")["parameters"];
    let inertia = &found["moving_inertia"];
    assert!(
        (inertia["value"].as_f64().unwrap() - 1.0).abs() < 1e-3 && inertia["unit"] == "kg*m^2",
        "{inertia}"
    );
    assert!((found["coulomb_friction"]["value"].as_f64().unwrap() - 1.0).abs() < 1e-2, "{found}");
    assert_eq!(document(folder.path(), "table/results/diagnosis.json")["verdict"]["kind"], "none");
    // The page of a diagnosis alone has the title of the machine, too.
    fs::create_dir(folder.path().join("alone")).unwrap();
    fs::copy(folder.path().join("table/results/diagnosis.json"), folder.path().join("alone/diagnosis.json"))
        .unwrap();
    let report = ["report", "alone", "--quiet"];
    assert_cmd::Command::cargo_bin("jointid")
        .unwrap()
        .current_dir(folder.path())
        .args(report)
        .assert()
        .success();
    let made = fs::read_to_string(folder.path().join("alone/report.html")).unwrap();
    assert!(made.contains("<h1>my rotary axis</h1>"));
}

/// The diagnosis names the effect that the page adds, and the one that these data do not distinguish from it.
#[cfg(unix)]
#[test]
fn the_effect_of_the_guide_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(page("own-effect.md")).unwrap();
    let effect = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let bench = fs::read_to_string("configs/tian.toml").unwrap();
    fs::write(folder.path().join("axis.toml"), format!("{bench}\n{effect}")).unwrap();
    run_page(&page("own-effect.md"), folder.path(), |_| {});
    let document = document(folder.path(), "brake/diagnosis.json");
    assert_eq!(
        document["verdict"]["effects"],
        serde_json::json!(["holding-brake", "guide-stiffness"]),
        "{}",
        document["verdict"]
    );
    assert!(document["chosen"]["closed"].as_f64().unwrap() > 0.98);
    // The page draws it over the peaks, before and after.
    let drawn = fs::read_to_string(folder.path().join("brake/report.html")).unwrap();
    assert!(drawn.contains("id=\"diagnosis-curves\"") && drawn.contains("with holding-brake"));
}

#[cfg(unix)]
#[test]
fn the_verdict_of_the_guide_is_the_program_s() {
    let folder = tempfile::tempdir().unwrap();
    contains_blocks("verdicts.md", &run_page(&page("verdicts.md"), folder.path(), |_| {}));
    let text = fs::read_to_string(page("verdicts.md")).unwrap();
    for kind in ["none", "effect", "ambiguous", "unknown", "wrong-parameter", "measurement", "insufficient"] {
        assert!(text.contains(&format!("\n| {kind} |")), "{kind}");
    }
}

/// Checks that the text blocks of a page occur in what its commands print.
fn contains_blocks(name: &str, commands: &[PageCommand]) {
    let output: String = commands.iter().filter_map(|(_, output)| output.as_deref()).collect();
    let text = fs::read_to_string(page(name)).unwrap();
    let blocks: Vec<&str> =
        text.split("```text\n").skip(1).map(|block| block.split("```").next().unwrap()).collect();
    assert!(!blocks.is_empty());
    for block in blocks {
        assert!(output.contains(block.trim_end()), "{name} does not print\n{block}\nbut\n{output}");
    }
}

/// Returns all pages: the README and the guide.
fn pages() -> Vec<(String, String)> {
    let guide = fs::read_dir(GUIDE)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"));
    let pages: Vec<PathBuf> = guide.chain([PathBuf::from("README.md")]).collect();
    pages.iter().map(|path| (path.display().to_string(), fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn every_test_that_a_page_names_exists() {
    let mut sources = String::new();
    let mut folders = vec![PathBuf::from("tests"), PathBuf::from("src")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() && path.file_name().is_some_and(|name| name != "fuzz") {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                sources += &format!(
                    "mod {}\n{}",
                    path.file_stem().unwrap().display(),
                    fs::read_to_string(&path).unwrap()
                );
            }
        }
    }
    let mut named = 0;
    for (path, text) in pages() {
        for span in text.split('`').filter(|span| span.contains("cargo test ")) {
            let words = span.split("cargo test ").nth(1).unwrap().split_whitespace();
            for name in words.filter(|word| !word.starts_with('-') && *word != "main") {
                let exists = ["fn ", "mod "]
                    .iter()
                    .any(|kind| sources.lines().any(|l| l.contains(kind) && l.contains(name)));
                assert!(exists, "{path}: no test is called {name}");
                named += 1;
            }
        }
    }
    assert!(named > 5, "{named}");
}

/// Links between pages lead to files that exist.
#[test]
fn links_between_pages_lead_somewhere() {
    for (path, text) in pages() {
        let folder = Path::new(&path).parent().unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            assert!(link.starts_with("http") || folder.join(link).exists(), "{path}: {link}");
        }
    }
}

#[test]
fn the_readme_is_one_page() {
    let text = fs::read_to_string("README.md").unwrap();
    assert!(
        text.lines().count() <= 150 && text.len() <= 10_000,
        "{} lines, {} bytes",
        text.lines().count(),
        text.len()
    );
}
