//! The command-line program, as used by a person and by a script.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

fn jointid() -> Command {
    let mut command = Command::cargo_bin("jointid").unwrap();
    command.env("NO_COLOR", "1");
    command
}

fn json(arguments: &[&str]) -> Value {
    let output = jointid().args(arguments).arg("--json").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn identify_runs_from_any_folder_and_writes_the_documented_result() {
    let elsewhere = tempfile::tempdir().unwrap();
    let out = elsewhere.path().join("results");
    jointid()
        .current_dir(elsewhere.path())
        .args(["identify", "--positions", "l1,l3,l5", "--out"])
        .arg(&out)
        .assert()
        .success();
    let document: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("identification.json")).unwrap()).unwrap();
    assert_eq!(document["schema"], "jointid/identification/1");
    assert_eq!(document["complete"], true);
    assert_eq!(document["tool_version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(document["inputs"][0]["sha256"].as_str().unwrap().len(), 64);
    for id in ["k_al", "k_ar", "k_n", "k_m", "c_al", "c_ar", "c_n", "c_m", "k_s", "c_s", "gain"] {
        let row = &document["parameters"][id];
        assert!(row["value"].as_f64().unwrap() > 0.0, "{id}");
        assert!(row["lower"].as_f64().unwrap() < row["upper"].as_f64().unwrap(), "{id}");
    }
    assert_eq!(document["parameters"]["c_al"]["identifiable"], false);
    assert_eq!(document["held_out_positions"], serde_json::json!(["l2", "l4", "l6"]));
    assert_eq!(document["positions"]["l2"]["role"], "held_out");
    let third = &document["positions"]["l4"]["orders"][2];
    assert_eq!((third["order"].as_u64(), third["measured_hz"].is_null()), (Some(3), true));
    let left: Vec<_> = std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 1, "{left:?}");

    let result = out.join("identification.json");
    let result = result.to_str().unwrap();
    let validation = json(&["validate", "--result", result]);
    assert_eq!(validation["schema"], "jointid/validation/1");
    let largest = validation["largest_error"].as_f64().unwrap();
    assert!(
        (largest - document["derived"]["largest_frequency_error_held_out"].as_f64().unwrap()).abs() < 2e-7
    ); // the precision of a peak
    assert!(validation["positions"].get("l1").is_none());
    jointid().args(["validate", "--result", result, "--fail-above", "0.0295"]).assert().code(0);
    jointid().args(["validate", "--result", result, "--fail-above", "0.001"]).assert().code(1);
}

#[test]
fn modes_of_the_published_bench() {
    let document =
        json(&["simulate", "modes", "--config", "configs/tian-as-published.toml", "--position", "l1"]);
    assert_eq!(document["schema"], "jointid/modes/1");
    let modes = document["modes"].as_array().unwrap();
    let hz: Vec<f64> = modes.iter().map(|m| m["frequency_hz"].as_f64().unwrap()).collect();
    assert_eq!(hz[0], 0.0);
    assert!((hz[1] - 109.222_323_5).abs() < 1e-4, "{hz:?}");
    assert!(modes[1]["shape"]["table"].is_number());
    assert_eq!(modes[1]["order"], 2);
}

#[test]
fn compare_reports_single_and_multi_position_fits() {
    let document = json(&["compare", "--positions", "l1,l3,l5", "--single", "l3,l5", "--repeats", "1"]);
    assert_eq!(document["schema"], "jointid/comparison/1");
    let error = |run: &str| document["runs"][run]["common_error"].as_f64().unwrap();
    assert!(error("multi") < error("l3") && error("multi") < error("l5"));
    assert_eq!(document["runs"]["l3"]["positions"]["l1"]["role"], "held_out");
}

#[test]
fn frf_is_written_as_a_readable_table() {
    let output = jointid()
        .args(["simulate", "frf", "--position", "l1", "--from-hz", "20", "--to-hz", "30", "--step-hz", "1"])
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("position,frequency_hz,real,imag\nl1,20,"), "{text}");
    assert_eq!(text.lines().count(), 12);
}

#[test]
fn an_override_changes_the_machine() {
    let heavier = json(&["simulate", "modes", "--position", "l1", "--set", "point.table.mass_kg=544"]);
    let normal = json(&["simulate", "modes", "--position", "l1"]);
    let first = |d: &Value| d["modes"][0]["frequency_hz"].as_f64().unwrap();
    assert!(first(&heavier) < 0.8 * first(&normal));
    // An override of one key of a parameter from the library of effects; its other keys keep the library's
    // values.
    let with = |more: &[&str]| {
        json(
            &[
                &["simulate", "modes", "--position", "l1", "--set", r#"effects=["rotor-hold","table-mass"]"#],
                more,
            ]
            .concat(),
        )
    };
    let (none, half) = (with(&[]), with(&["--set", "parameter.table_mass_change.start=0.5"]));
    assert_eq!(none["modes"], normal["modes"]);
    assert!(first(&half) < 0.9 * first(&normal) && first(&half) > first(&heavier));
}

#[test]
fn tables_fit_eighty_columns() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let result = folder.path().join("identification.json");
    let result = result.to_str().unwrap();
    for arguments in [
        &["identify", "--repeats", "1", "--verbose", "--bootstrap", "50", "--out", out][..],
        &["validate", "--result", result],
        &["compare", "--repeats", "1"],
        &["compare", "--objectives", "--repeats", "1"],
        &["diagnose", "--effects", "guide-viscous", "--nulls", "20", "--no-cache", "--repeats", "1"],
        &["plan", "--result", result, "--choose", "3"],
        &[
            "plan",
            "--result",
            result,
            "--data",
            "frf",
            "--measured",
            "l1,l3",
            "--channels",
            "table/table,rotor/table",
        ],
        &["simulate", "modes"],
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
        &["--help"],
        &["identify", "--help"],
    ] {
        let output = jointid().args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}");
        let messages = String::from_utf8(output.stderr).unwrap().replace(out, "results");
        for line in String::from_utf8(output.stdout).unwrap().lines().chain(messages.lines()) {
            // Without a terminal a message is one line, so that it can be searched for.
            let is_message = ["warning: ", "note: "].iter().any(|label| line.starts_with(label));
            assert!(is_message || line.chars().count() <= 80, "{arguments:?}: {line}");
            assert!(!line.contains('\u{1b}'), "colour codes without a terminal: {line}");
        }
    }
}

#[test]
fn quiet_omits_and_verbose_adds_messages() {
    let run = |more: &[&str]| {
        let output = jointid()
            .args(["identify", "--repeats", "1", "--positions", "l1,l3,l5"])
            .args(more)
            .output()
            .unwrap();
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (normal, quiet, verbose) = (run(&[]), run(&["-q"]), run(&["-v"]));
    assert!(normal.0 == quiet.0 && normal.0 == verbose.0, "the results differ");
    assert!(quiet.1.is_empty(), "{}", quiet.1);
    assert!(normal.1.contains("warning: ") && !normal.1.contains("SHA-256"), "{}", normal.1);
    for part in [
        "read configs/tian.toml (SHA-256 ",
        "settings: ",
        "round of searches with seed 1: cost ",
        " threads, seed 1",
    ] {
        assert!(verbose.1.contains(part), "{part}: {}", verbose.1);
    }
    jointid().args(["identify", "-q", "-v"]).assert().code(2);
}

#[test]
fn embedded_files_equal_those_of_the_project() {
    assert!(Path::new("configs/tian.toml").exists());
    let from_file = json(&["simulate", "modes"]);
    let elsewhere = tempfile::tempdir().unwrap();
    let output =
        jointid().current_dir(elsewhere.path()).args(["simulate", "modes", "--json"]).output().unwrap();
    let embedded: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(from_file, embedded);
}

/// Ctrl-C ends a long run with exit code 3 and writes the result so far, marked as incomplete.
#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_its_partial_result() {
    use std::process::{Command as Process, Stdio};
    use std::time::Duration;
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut child = Process::new(assert_cmd::cargo::cargo_bin!("jointid"))
        .args(["identify", "--repeats", "100", "--out"])
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    assert!(Process::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(3));
    let document: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("identification.json")).unwrap()).unwrap();
    assert_eq!(document["complete"], false);
    assert_eq!(document["searches_agree"], Value::Null);
}
