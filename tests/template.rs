//! A user's own machine, from template to identification; schemas, completions, manual pages.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

use crate::support::axis_template::{BENCH, POSITIONS, fill, fill_in_measurements};

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

/// The published bench, filled into the template, is identified like any other machine.
#[test]
fn a_template_is_refused_until_it_is_filled_in_and_then_identified() {
    let folder = tempfile::tempdir().unwrap();
    jointid().current_dir(folder.path()).args(["init", "axis"]).assert().success();
    let identify = [
        "identify",
        "--config",
        "axis/machine.toml",
        "--measurements",
        "axis/measurements",
        "--repeats",
        "1",
        "--out",
        "axis/results",
    ];
    let machine = folder.path().join("axis/machine.toml");
    let manifest = folder.path().join("axis/measurements/manifest.toml");

    // As long as a value is missing, the message names a missing one.
    let text = fs::read_to_string(&machine).unwrap();
    let values = BENCH;
    for filled in 0..values.len() {
        fs::write(&machine, fill(&text, &values[..filled])).unwrap();
        let fault = stderr(&["simulate", "modes", "--config", "axis/machine.toml"], folder.path());
        assert!(
            fault.contains("NaN") && values[filled..].iter().any(|(key, _)| fault.contains(key)),
            "{filled}: {fault}"
        );
    }
    let text = fill(&text, &values);
    assert!(!text.lines().any(|l| !l.starts_with('#') && l.contains("nan")), "{text}");
    fs::write(&machine, text).unwrap();
    assert!(stderr(&identify, folder.path()).contains("nut_m"));
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, fill(&text, &POSITIONS)).unwrap();
    assert!(stderr(&identify, folder.path()).contains("modes.csv: holds no observation at all"));

    fill_in_measurements(&folder.path().join("axis"), &folder.path().join("taps"));
    jointid().current_dir(folder.path()).args(identify).assert().success();
    jointid().current_dir(folder.path()).args(["report", "axis/results"]).assert().success();
    let document: Value = serde_json::from_str(
        &fs::read_to_string(folder.path().join("axis/results/identification.json")).unwrap(),
    )
    .unwrap();
    assert_eq!(document["held_out_positions"], serde_json::json!(["p2"]));
    assert!(document["derived"]["largest_frequency_error_fit"].as_f64().unwrap() < 0.05);
}

#[test]
fn refuse_to_overwrite_a_template() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("axis/measurements")).unwrap();
    fs::write(folder.path().join("axis/measurements/modes.csv"), "mine").unwrap();
    assert!(stderr(&["init", "axis"], folder.path()).contains("modes.csv: already exists"));
    assert!(!folder.path().join("axis/machine.toml").exists());
    assert_eq!(fs::read_to_string(folder.path().join("axis/measurements/modes.csv")).unwrap(), "mine");
}

fn schema(name: &str) -> Value {
    let output = jointid().args(["schema", name]).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn assert_valid(schema: &jsonschema::Validator, instance: &Value, document: &str) {
    let faults: Vec<String> =
        schema.iter_errors(instance).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(faults.is_empty(), "{document}: {faults:#?}");
}

fn toml_as_json(path: &Path) -> Value {
    let table: toml::Table = toml::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    serde_json::to_value(table).unwrap()
}

#[test]
fn shipped_files_match_their_schemas() {
    let machine = jsonschema::validator_for(&schema("machine")).unwrap();
    let effects = jsonschema::validator_for(&schema("effects")).unwrap();
    let manifest = jsonschema::validator_for(&schema("manifest")).unwrap();
    let mut seen = 0;
    for entry in fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        let validator = if path.ends_with("effects.toml") { &effects } else { &machine };
        assert_valid(validator, &toml_as_json(&path), &path.display().to_string());
        seen += 1;
    }
    for entry in fs::read_dir("measurements").unwrap() {
        let path = entry.unwrap().path().join("manifest.toml");
        if path.exists() {
            assert_valid(&manifest, &toml_as_json(&path), &path.display().to_string());
            seen += 1;
        }
    }
    assert!(seen >= 8, "{seen}");
    // The schemas reject invalid files.
    let mut wrong = toml_as_json(Path::new("configs/tian.toml"));
    wrong["point"][0]["mas_kg"] = 1.0.into();
    assert!(!machine.is_valid(&wrong));
    let mut wrong = toml_as_json(Path::new("measurements/tian/manifest.toml"));
    wrong["gain"] = "unknwon".into();
    assert!(!manifest.is_valid(&wrong));
}

#[test]
fn results_match_their_schemas() {
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
        &[
            "simulate",
            "stiffness",
            "--config",
            "configs/vertical-axis.toml",
            "--along",
            "acceleration",
            "--from",
            "-35",
            "--to",
            "15",
        ],
        &["diagnose", "--positions", "l1,l3,l5", "--effects", "guide-viscous", "--nulls", "20", "--no-cache"],
        &["compare", "--objectives", "--repeats", "1"],
    ] {
        jointid().args(arguments).args(["--quiet", "--out", out]).assert().success();
    }
    let mut seen = 0;
    for entry in fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let document: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        assert_valid(&jsonschema::validator_for(&schema(&name)).unwrap(), &document, &name);
        seen += 1;
    }
    assert_eq!(seen, 9);
}

#[test]
fn every_listed_schema_is_valid() {
    let output = jointid().args(["schema", "--list"]).output().unwrap();
    let names = String::from_utf8(output.stdout).unwrap();
    assert!(names.lines().count() >= 18);
    for name in names.lines() {
        assert!(jsonschema::validator_for(&schema(name)).is_ok(), "{name}");
    }
    assert!(stderr(&["schema", "machines"], Path::new(".")).contains("there are machine, effects"));
}

/// The templates for motion records ask for records; angles are refused where the axis travels.
#[test]
fn templates_of_motion_ask_for_records_in_their_unit() {
    let folder = tempfile::tempdir().unwrap();
    for axis in ["linear", "rotary"] {
        jointid()
            .current_dir(folder.path())
            .args(["init", axis, "--kind", &format!("motion-{axis}")])
            .assert()
            .success();
    }
    let floating = ["init", "other", "--kind", "motion-linear", "--right-bearing", "floating"];
    assert!(stderr(&floating, folder.path()).contains("--right-bearing: an axis for motion records"));
    let identify =
        |axis: &str| format!("identify --config {axis}/machine.toml --measurements {axis}/measurements");
    let fault = |axis: &str| stderr(&identify(axis).split(' ').collect::<Vec<_>>(), folder.path());
    assert!(fault("linear").contains("linear/measurements/fast.csv"));
    let record = jointid()
        .current_dir(folder.path())
        .args("simulate motion --config rotary/machine.toml --reference sine --out sine --quiet".split(' '))
        .output()
        .unwrap();
    assert!(record.status.success());
    for name in ["fast", "slow"] {
        let to = folder.path().join(format!("linear/measurements/{name}.csv"));
        let text = fs::read_to_string(folder.path().join("sine/motion.csv")).unwrap();
        assert!(text.starts_with("time_s,command_rad,position_rad,torque_nm"));
        fs::write(to, text.replace("torque_nm", "force_n").replace(",table_rad", ",other")).unwrap();
    }
    let refused = fault("linear");
    assert!(refused.contains("position_rad") && refused.contains("«table» reads a travel"), "{refused}");
}

/// Returns what the script of a shell is told to offer for the last of these words.
fn completed(words: &[&str]) -> Vec<String> {
    let last = (words.len() - 1).to_string();
    let asked = [("JOINTID_COMPLETE", "bash"), ("_CLAP_COMPLETE_INDEX", &last), ("_CLAP_IFS", "\n")];
    let output = jointid().envs(asked).arg("--").args(words).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{words:?}");
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// Shells offer the positions and records of the set that the command line names, and ids of effects.
#[test]
fn shells_complete_positions_records_and_effects() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = jointid().args(["completions", shell]).output().unwrap().stdout;
        assert!(String::from_utf8(script).unwrap().contains("JOINTID_COMPLETE"), "{shell}");
    }
    let bench: Vec<String> = (1..=6).map(|at| format!("l{at}")).collect();
    assert_eq!(completed(&["jointid", "identify", "--positions", ""]), bench);
    assert_eq!(completed(&["jointid", "simulate", "modes", "--position", "l3"]), ["l3"]);
    assert_eq!(completed(&["jointid", "diagnose", "--without", "rotor-h"]), ["rotor-hold"]);
    assert_eq!(completed(&["jointid", "effects", "guide-v"]), ["guide-viscous"]);

    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let manifest = "title = \"own\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n\
        [[position]]\nname = \"near\"\nnut_m = 0.6\n[[position]]\nname = \"far\"\nnut_m = 1.2\n\
        [[frf]]\nposition = \"near\"\nrecord = \"first\"\nfile = \"a.csv\"\n";
    fs::write(path("manifest.toml"), manifest).unwrap();
    fs::write(path("a.csv"), "frequency_hz,real,imag\n10,1e-8,-1e-9\n20,1e-8,-1e-9\n").unwrap();
    let set = path("");
    let of_set = |option: &str, begun: &str| {
        completed(&["jointid", "identify", "--measurements", &set, option, begun])
    };
    assert_eq!(of_set("--positions", "near,"), ["near,near", "near,far", "near,first"]);
    assert_eq!(of_set("--hold-out", "f"), ["far", "first"]);
    assert_eq!(completed(&["jointid", "identify", "--measurements", "=", &set, "--hold-out", "fa"]), ["far"]);
    // A set that cannot be read offers nothing.
    assert_eq!(
        completed(&["jointid", "identify", "--measurements", &path("none"), "--positions", ""]),
        [""; 0]
    );

    // A result names its set.
    let result = path("identification.json");
    let identified = jointid()
        .args(["identify", "--positions", "l1,l3,l5", "--repeats", "1", "--quiet", "--json"])
        .output()
        .unwrap();
    fs::write(&result, identified.stdout).unwrap();
    assert_eq!(completed(&["jointid", "validate", "--result", &result, "--positions", ""]), bench);
}

#[test]
fn completions_and_manual_contain_every_command() {
    let help = String::from_utf8(jointid().arg("--help").output().unwrap().stdout).unwrap();
    let lists = help.lines().skip_while(|l| *l != "Identify and diagnose:").take_while(|l| *l != "Options:");
    let names: Vec<&str> =
        lists.filter(|l| l.starts_with("  ")).filter_map(|l| l.split_whitespace().next()).collect();
    assert!(names.len() > 12, "{help}");
    let offered = completed(&["jointid", ""]);
    let folder = tempfile::tempdir().unwrap();
    jointid().args(["man", "--out"]).arg(folder.path()).assert().success();
    for name in &names {
        assert!(offered.iter().any(|word| word == name), "{name}");
        assert!(folder.path().join(format!("jointid-{name}.1")).exists(), "{name}");
        // The laboratory's program shows its own, which its own tests read; here it might have to be built.
        if *name == "lab" {
            continue;
        }
        let help = String::from_utf8(jointid().args([name, "--help"]).output().unwrap().stdout).unwrap();
        assert!(
            help.contains("Structure:") || help.contains("Example:\n  jointid "),
            "{name} has no example"
        );
        for line in help.lines() {
            assert!(line.chars().count() <= 80 || line.starts_with("  jointid"), "{name}: {line}");
        }
    }
    for name in ["modes", "frf", "stiffness"] {
        assert!(folder.path().join(format!("jointid-simulate-{name}.1")).exists());
        let help =
            String::from_utf8(jointid().args(["simulate", name, "--help"]).output().unwrap().stdout).unwrap();
        assert!(help.contains("Example:\n  jointid "), "{name} has no example");
    }
}
