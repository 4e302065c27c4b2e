//! A machine of one's own: begun, filled in, identified; schemas, completions, manual pages.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

fn jointid() -> Command {
    let mut command = Command::cargo_bin("jointid").unwrap();
    command.env("NO_COLOR", "1");
    command
}

fn stderr(arguments: &[&str], folder: &Path) -> String {
    let output = jointid().current_dir(folder).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stderr).unwrap()
}

/// Replaces the `nan` of each key in turn.
fn fill(text: &str, values: &[(&str, &str)]) -> String {
    let mut text = text.to_string();
    for (key, value) in values {
        let gap = format!("{key} = nan");
        assert!(text.contains(&gap), "{key}");
        text = text.replacen(&gap, &format!("{key} = {value}"), 1);
    }
    text
}

/// The numbers of the published bench, in the order of the empty file.
const BENCH: [(&str, &str); 6] = [
    ("mass_kg", "272.0"),
    ("inertia_kg_m2", "1e-3"),
    ("inertia_kg_m2", "1e-4"),
    ("length_m", "2.6"),
    ("diameter_m", "0.04"),
    ("lead_m", "0.04"),
];
const PLACES: [(&str, &str); 3] = [("nut_m", "0.6"), ("nut_m", "1.0"), ("nut_m", "1.6")];

/// Types positions and modes into the empty set, and lays the FRFs of the same places beside it, one table for each.
fn fill_in_measurements(folder: &Path) {
    let manifest = folder.join("axis/measurements/manifest.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    if text.contains("nut_m = nan") {
        fs::write(&manifest, fill(&text, &PLACES)).unwrap();
    }
    let measured = [["24,", "118,", "523,", "716,"], ["24,", "116,", "565,", "721,"], ["23,", "113,", "561,", "728,"]];
    let mut text = String::from("position,order,frequency_hz,amplitude\n");
    for (position, row) in measured.iter().enumerate() {
        for (order, cell) in row.iter().enumerate() {
            text += &format!("p{},{},{cell}\n", position + 1, order + 1);
        }
    }
    fs::write(folder.join("axis/measurements/modes.csv"), text).unwrap();
    fs::create_dir_all(folder.join("taps")).unwrap();
    for (at, (_, nut_m)) in PLACES.iter().enumerate() {
        let frf = ["simulate", "frf", "--nut-m", nut_m, "--from-hz", "5", "--to-hz", "900", "--step-hz", "1", "--quiet"];
        let text = String::from_utf8(jointid().args(frf).output().unwrap().stdout).unwrap();
        let lines: String = text.lines().map(|l| format!("{}\n", l.split_once(',').unwrap().1)).collect();
        fs::write(folder.join(format!("taps/tap-p{}.csv", at + 1)), lines).unwrap();
    }
}

/// The published bench typed into the empty files: identified like any other.
#[test]
fn a_template_is_refused_by_name_until_it_is_filled_in_and_then_identified() {
    let folder = tempfile::tempdir().unwrap();
    jointid().current_dir(folder.path()).args(["init", "axis"]).assert().success();
    let identify =
        ["identify", "--config", "axis/machine.toml", "--measurements", "axis/measurements", "--repeats", "1", "--out", "axis/results"];
    let machine = folder.path().join("axis/machine.toml");
    let manifest = folder.path().join("axis/measurements/manifest.toml");

    // As long as there is a gap, one is named.
    let text = fs::read_to_string(&machine).unwrap();
    let values = BENCH;
    for filled in 0..values.len() {
        fs::write(&machine, fill(&text, &values[..filled])).unwrap();
        let fault = stderr(&["simulate", "modes", "--config", "axis/machine.toml"], folder.path());
        assert!(fault.contains("NaN") && values[filled..].iter().any(|(key, _)| fault.contains(key)), "{filled}: {fault}");
    }
    let text = fill(&text, &values);
    assert!(!text.lines().any(|l| !l.starts_with('#') && l.contains("nan")), "{text}");
    fs::write(&machine, text).unwrap();
    assert!(stderr(&identify, folder.path()).contains("nut_m"));
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, fill(&text, &PLACES)).unwrap();
    assert!(stderr(&identify, folder.path()).contains("modes.csv: holds no observation at all"));

    fill_in_measurements(folder.path());
    jointid().current_dir(folder.path()).args(identify).assert().success();
    jointid().current_dir(folder.path()).args(["report", "axis/results"]).assert().success();
    let document: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("axis/results/identification.json")).unwrap()).unwrap();
    assert_eq!(document["held_out_positions"], serde_json::json!(["p2"]));
    assert!(document["derived"]["largest_frequency_error_fit"].as_f64().unwrap() < 0.05);
}

#[test]
fn refuse_to_overwrite_a_template() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("axis/measurements")).unwrap();
    fs::write(folder.path().join("axis/measurements/modes.csv"), "mine").unwrap();
    assert!(stderr(&["init", "axis"], folder.path()).contains("modes.csv: is there already"));
    assert!(!folder.path().join("axis/machine.toml").exists());
    assert_eq!(fs::read_to_string(folder.path().join("axis/measurements/modes.csv")).unwrap(), "mine");
}

fn schema(name: &str) -> Value {
    let output = jointid().args(["schema", name]).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn hold(schema: &jsonschema::Validator, instance: &Value, what: &str) {
    let faults: Vec<String> = schema.iter_errors(instance).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(faults.is_empty(), "{what}: {faults:#?}");
}

fn toml_as_json(path: &Path) -> Value {
    let table: toml::Table = toml::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    serde_json::to_value(table).unwrap()
}

#[test]
fn shipped_files_fulfil_their_schemas() {
    let machine = jsonschema::validator_for(&schema("machine")).unwrap();
    let effects = jsonschema::validator_for(&schema("effects")).unwrap();
    let manifest = jsonschema::validator_for(&schema("manifest")).unwrap();
    let mut seen = 0;
    for entry in fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        let which = if path.ends_with("effects.toml") { &effects } else { &machine };
        hold(which, &toml_as_json(&path), &path.display().to_string());
        seen += 1;
    }
    for entry in fs::read_dir("measurements").unwrap() {
        let path = entry.unwrap().path().join("manifest.toml");
        if path.exists() {
            hold(&manifest, &toml_as_json(&path), &path.display().to_string());
            seen += 1;
        }
    }
    assert!(seen >= 8, "{seen}");
    // A schema that takes everything would say nothing.
    let mut wrong = toml_as_json(Path::new("configs/tian.toml"));
    wrong["point"][0]["mas_kg"] = 1.0.into();
    assert!(!machine.is_valid(&wrong));
    let mut wrong = toml_as_json(Path::new("measurements/tian/manifest.toml"));
    wrong["gain"] = "unknwon".into();
    assert!(!manifest.is_valid(&wrong));
}

#[test]
fn results_fulfil_their_schemas() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let result = folder.path().join("identification.json");
    let result = result.to_str().unwrap();
    for arguments in [
        &["identify", "--positions", "l1,l3,l5", "--repeats", "1"][..],
        &["validate", "--result", result],
        &["compare", "--positions", "l1,l3,l5", "--single", "l3", "--repeats", "1"],
        &["plan", "--result", result],
        &["simulate", "modes"],
        &["simulate", "frf", "--position", "l1", "--to-hz", "30"],
        &["simulate", "matrices", "--config", "configs/twin-ball-screw.toml"],
        &["simulate", "sensitivity", "--config", "configs/servo-axis.toml"],
        &["simulate", "stiffness", "--config", "configs/vertical-axis.toml", "--along", "acceleration", "--from", "-35", "--to", "15"],
        &["simulate", "published"],
        &["diagnose", "--positions", "l1,l3,l5", "--effects", "guide-viscous", "--nulls", "20", "--no-cache"],
        &["compare", "--objectives", "--repeats", "1"],
        &["convergence", "--repeats", "1", "--counts", "3"],
    ] {
        jointid().args(arguments).args(["--quiet", "--out", out]).assert().success();
    }
    let mut seen = 0;
    for entry in fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let document: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        hold(&jsonschema::validator_for(&schema(&name)).unwrap(), &document, &name);
        seen += 1;
    }
    assert_eq!(seen, 13);
}

#[test]
fn every_schema_that_is_listed_is_one() {
    let output = jointid().args(["schema", "--list"]).output().unwrap();
    let names = String::from_utf8(output.stdout).unwrap();
    assert!(names.lines().count() >= 18);
    for name in names.lines() {
        assert!(jsonschema::validator_for(&schema(name)).is_ok(), "{name}");
    }
    assert!(stderr(&["schema", "machines"], Path::new(".")).contains("there are machine, effects"));
}

#[test]
fn completions_and_manual_know_every_command() {
    let help = String::from_utf8(jointid().arg("--help").output().unwrap().stdout).unwrap();
    let commands: Vec<&str> = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty()).collect();
    let names: Vec<&str> =
        commands.iter().filter(|l| l.starts_with("  ") && !l.starts_with("   ")).filter_map(|l| l.split_whitespace().next()).collect();
    assert!(names.len() > 12, "{help}");
    let bash = String::from_utf8(jointid().args(["completions", "bash"]).output().unwrap().stdout).unwrap();
    let folder = tempfile::tempdir().unwrap();
    jointid().args(["man", "--out"]).arg(folder.path()).assert().success();
    for name in names.iter().filter(|n| **n != "help") {
        assert!(bash.contains(name), "{name}");
        assert!(folder.path().join(format!("jointid-{name}.1")).exists(), "{name}");
        let help = String::from_utf8(jointid().args([name, "--help"]).output().unwrap().stdout).unwrap();
        assert!(help.contains("Commands:") || help.contains("Example:\n  jointid "), "{name} has no example");
        for line in help.lines() {
            assert!(line.chars().count() <= 80 || line.starts_with("  jointid"), "{name}: {line}");
        }
    }
    for name in ["modes", "frf", "matrices", "stiffness", "sensitivity", "published"] {
        assert!(folder.path().join(format!("jointid-simulate-{name}.1")).exists());
        let help = String::from_utf8(jointid().args(["simulate", name, "--help"]).output().unwrap().stdout).unwrap();
        assert!(help.contains("Example:\n  jointid "), "{name} has no example");
    }
}

/// Steps of the guide up to whole FRFs: each is one command or one edit, but for the last, which is two.
fn guide_steps(guide: &str) -> usize {
    let numbered = |line: &&str| line.strip_prefix("**").and_then(|l| l.split_once(".**")).is_some_and(|(n, _)| n.parse::<u8>().is_ok());
    guide.lines().filter(numbered).count() + 1
}

/// Runs the commands of a page in a shell, as they stand there, with what else a test adds to each.
fn run_page(page: &str, folder: &Path, more: impl Fn(&str) -> &'static str) {
    let program = assert_cmd::cargo::cargo_bin!("jointid");
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let text = fs::read_to_string(page).unwrap();
    let blocks = text.split("```sh\n").skip(1).map(|b| b.split("```").next().unwrap());
    let commands: Vec<&str> = blocks.flat_map(str::lines).collect();
    assert!(commands.len() > 1, "{page}");
    for command in commands {
        let line = format!("{command} {}", more(command));
        let output = std::process::Command::new("sh").args(["-c", &line]).env("PATH", &path).current_dir(folder).output().unwrap();
        assert!(output.status.success(), "{page}: {line}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

fn quickly(command: &str) -> &'static str {
    match command.split_whitespace().nth(1) {
        Some("identify") => "--repeats 1",
        Some("diagnose") => "--no-cache",
        _ => "",
    }
}

/// The page on an effect of one's own, with its effect appended to the bench: the diagnosis names it.
#[cfg(unix)]
#[test]
fn the_effect_of_the_guide_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let page = "src/guide/own-effect.md";
    let text = fs::read_to_string(page).unwrap();
    let effect = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let bench = fs::read_to_string("configs/tian.toml").unwrap();
    fs::write(folder.path().join("axis.toml"), format!("{bench}\n{effect}")).unwrap();
    run_page(page, folder.path(), quickly);
    let document: Value = serde_json::from_str(&fs::read_to_string(folder.path().join("brake/diagnosis.json")).unwrap()).unwrap();
    assert_eq!(document["verdict"]["effects"], serde_json::json!(["holding-brake"]), "{}", document["verdict"]);
    assert!(document["chosen"]["closed"].as_f64().unwrap() > 0.98);
    // The page draws it over the peaks, before and after.
    let page = fs::read_to_string(folder.path().join("brake/report.html")).unwrap();
    assert!(page.contains("id=\"diagnosis-curves\"") && page.contains("with holding-brake"));
    assert!(!page.contains("is not drawn"));
}

/// The page on verdicts: its commands, and the verdict it prints.
#[cfg(unix)]
#[test]
fn the_verdict_of_the_guide_is_the_program_s() {
    let folder = tempfile::tempdir().unwrap();
    let page = "src/guide/verdicts.md";
    run_page(page, folder.path(), quickly);
    let document: Value = serde_json::from_str(&fs::read_to_string(folder.path().join("rotor/diagnosis.json")).unwrap()).unwrap();
    let text = fs::read_to_string(page).unwrap();
    assert_eq!(document["verdict"]["kind"], "effect");
    assert!(text.contains("verdict — effect: rotor-hold") && document["verdict"]["effects"] == serde_json::json!(["rotor-hold"]));
    let percent = |x: &Value| format!("{:.1} %", 100.0 * x.as_f64().unwrap());
    assert!(text.contains(&format!("{} before", percent(&document["gap"]["held_out"]))));
    assert!(text.contains(&format!("{} after", percent(&document["chosen"]["gap_held_out"]))));
    // Every kind of verdict has its row.
    for kind in ["none", "effect", "ambiguous", "unknown", "wrong-parameter", "measurement", "insufficient"] {
        assert!(text.contains(&format!("\n| {kind} |")), "{kind}");
    }
}

/// The commands of the guide, in its order, on the published bench typed into the empty files.
#[test]
fn the_commands_of_the_guide_run() {
    let folder = tempfile::tempdir().unwrap();
    let guide = fs::read_to_string("src/guide/own-machine.md").unwrap();
    let blocks = guide.split("```sh\n").skip(1).map(|b| b.split("```").next().unwrap());
    let commands: Vec<&str> = blocks.flat_map(str::lines).collect();
    assert_eq!(commands.len(), 11);
    assert!(guide_steps(&guide) <= 12, "commands and edits to an identified machine");
    let machine = folder.path().join("axis/machine.toml");
    for command in commands {
        let mut words: Vec<&str> = command.split_whitespace().collect();
        assert_eq!(words.remove(0), "jointid");
        match words[0] {
            "identify" => words.extend(["--repeats", "1"]),
            "diagnose" => words.extend(["--nulls", "20", "--no-cache", "--effects", "guide-stiffness,table-mass"]),
            _ => {}
        }
        jointid().current_dir(folder.path()).args(&words).assert().success();
        if words[0] == "init" {
            fs::write(&machine, fill(&fs::read_to_string(&machine).unwrap(), &BENCH)).unwrap();
            fill_in_measurements(folder.path());
        }
    }
    assert!(folder.path().join("axis/frf-results/report.html").exists());
}
