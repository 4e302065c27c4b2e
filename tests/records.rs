//! Sets of FRFs through the commands: real records, splits, plans, refused input.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

fn output(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("jointid").unwrap().env("NO_COLOR", "1").args(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = output(&[arguments, &["--json", "--quiet"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(arguments: &[&str], expected: &[&str]) {
    let output = output(arguments);
    let message = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    for part in expected {
        assert!(message.contains(part), "{arguments:?}: «{part}» is not in: {message}");
    }
    assert_eq!(message.trim().lines().count(), 1, "{message}");
}

/// Returns the folder of the real bench with two inertias, if present.
fn two_inertia() -> Option<PathBuf> {
    test_data::shared("realdata/two-inertia-bench")
}

/// Frequencies, inertia ratio and delay of the real bench, from either record.
#[test]
fn published_two_inertia_bench() {
    let Some(folder) = two_inertia() else { return };
    let folder = folder.to_str().unwrap();
    let arguments = ["identify", "--config", "configs/two-inertia.toml", "--measurements", folder];
    let first = json(&arguments);
    let of = |document: &Value, name: &str| document["derived"][name].as_f64().unwrap();
    assert!((of(&first, "antiresonance_hz") - 54.0).abs() < 0.3, "{first:#}");
    assert!((of(&first, "resonance_hz") - 76.2).abs() < 0.3);
    assert!((of(&first, "inertia_ratio") - 0.995).abs() < 0.01);
    assert!((of(&first, "delay_s") - 0.12e-3).abs() < 0.02e-3);
    assert_eq!(first["fit_positions"], serde_json::json!(["multisine-a"]));
    assert_eq!(first["held_out_positions"], serde_json::json!(["multisine-b"]));
    assert_eq!(first["positions"]["multisine-b"]["role"], "held_out");
    let second = json(&[&arguments[..], &["--positions", "multisine-b"]].concat());
    for (name, expected) in [("antiresonance_hz", 54.0), ("resonance_hz", 76.2), ("inertia_ratio", 0.995)] {
        assert!((of(&second, name) / expected - 1.0).abs() < 0.01, "{name}: {}", of(&second, name));
        // Each record's interval contains the other record's estimate.
        for (one, other) in [(&first, &second), (&second, &first)] {
            let interval = &one["derived_interval95"][name];
            let (low, high) = (interval[0].as_f64().unwrap(), interval[1].as_f64().unwrap());
            assert!((low..=high).contains(&of(other, name)), "{name}: {low} to {high}");
        }
    }
    // Holding out one record equals naming the other.
    let held = json(&[&arguments[..], &["--hold-out", "multisine-b"]].concat());
    assert_eq!(held["parameters"], first["parameters"]);
    // Without its delay the machine cannot reproduce the phase.
    let without = json(&[&arguments[..], &["--without", "measurement-delay"]].concat());
    assert!(of(&without, "gap_held_out") > 1.5 * of(&first, "gap_held_out"));
}

/// Writes a set of FRFs of the bench, simulated by the command; `lines` are from, to, step (Hz).
fn bench_set(lines: [&str; 3], change: impl Fn(&str, &str) -> String) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let [from, to, step] = lines;
    let out = output(&[
        "simulate",
        "frf",
        "--position",
        "l1,l3,l5",
        "--from-hz",
        from,
        "--to-hz",
        to,
        "--step-hz",
        step,
    ]);
    let text = String::from_utf8(out.stdout).unwrap();
    let mut manifest = String::from(
        "title = \"simulated\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n",
    );
    for (name, nut) in [("l1", 0.6), ("l3", 1.0), ("l5", 1.6)] {
        let _ = write!(
            manifest,
            "[[position]]\nname = \"{name}\"\nnut_m = {nut:?}\n[[frf]]\nposition = \"{name}\"\nfile = \"{name}.csv\"\n"
        );
        let mut rows = String::from("frequency_hz,real,imag\n");
        for row in text.lines().filter_map(|l| l.strip_prefix(&format!("{name},"))) {
            rows += row;
            rows.push('\n');
        }
        fs::write(folder.path().join(format!("{name}.csv")), change(name, &rows)).unwrap();
    }
    fs::write(folder.path().join("manifest.toml"), change("manifest", &manifest)).unwrap();
    folder
}

/// Identification from simulated FRFs recovers their parameters. With all positions fitted, each is left out
/// once.
#[test]
fn limit_simulated_frfs_give_back_their_parameters() {
    let folder = bench_set(["6", "900", "3"], |_, text| text.to_string());
    let document = json(&[
        "identify",
        "--measurements",
        folder.path().to_str().unwrap(),
        "--repeats",
        "1",
        "--tolerances",
        "none",
    ]);
    for (id, value) in [("k_al", 5e7), ("k_ar", 5e7), ("k_n", 7e8), ("k_m", 3e3), ("c_n", 1e5), ("c_m", 0.1)]
    {
        let found = document["parameters"][id]["value"].as_f64().unwrap();
        assert!((found / value - 1.0).abs() < 1e-3, "{id}: {found}");
    }
    assert_eq!(document["leave_one_out"], true);
    assert!(document["positions"]["l3"]["gap"].as_f64().unwrap() < 1e-3);
    let shares = document["frfs"].as_array().unwrap().iter().map(|f| f["accepted_share"].as_f64().unwrap());
    assert!(shares.clone().count() == 3 && shares.fold(1.0, f64::min) == 1.0);
}

/// Twenty choices of three positions include the split of the bench. More data reduce the score, i.e. the
/// uncertainty.
#[test]
fn plan_ranks_the_subsets_of_the_bench() {
    let plan = json(&["plan", "--set", "parameter.k_m.start=400", "--set", "parameter.k_al.start=4e7"]);
    let rankings = plan["rankings"].as_array().unwrap();
    assert_eq!(
        (rankings[0]["choices"].as_array().unwrap().len(), rankings[1]["choices"].as_array().unwrap().len()),
        (15, 20)
    );
    assert!(rankings[1]["split_rank"].as_u64().unwrap() >= 1);
    let best = |at: usize| rankings[at]["choices"][0]["score"].as_f64().unwrap();
    assert!(best(1) < best(0) && best(0) < 1.0);
    let next =
        json(&["plan", "--data", "frf", "--measured", "l1,l3", "--channels", "table/table,rotor/table"]);
    let first = &next["rankings"][0]["choices"][0]["measure"][0];
    assert!(first.as_str().unwrap().contains("rotor/table"), "{first}");
    refused(&["plan", "--measured", "l9"], &["--measured l9", "l1"]);
    refused(&["plan", "--choose", "7"], &["--choose 7", "6 measurements"]);
    refused(&["plan", "--data", "frf", "--channels", "table"], &["--channels table", "RESPONSE/EXCITATION"]);
}

/// The six natural frequencies of a real beam are found in all three of its FRFs, and no other peak is
/// reported as a mode.
#[test]
fn published_frequencies_of_a_beam() {
    let Some(file) = test_data::shared("realdata/uff/measurement.uff") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (set, out) = (folder.path().join("beam"), folder.path().join("peaks"));
    let (set, out) = (set.to_str().unwrap(), out.to_str().unwrap());
    assert!(output(&["import", file.to_str().unwrap(), "--out", set, "--quiet"]).status.success());
    let document = json(&["peaks", "--measurements", set, "--out", out]);
    let regular: Vec<&Value> =
        document["modes"].as_array().unwrap().iter().filter(|m| m["regular"] == true).collect();
    let expected = [51.5, 142.2, 278.7, 460.4, 687.2, 958.5];
    assert_eq!(regular.len(), expected.len(), "{regular:#?}");
    for (at, (mode, hz)) in regular.iter().zip(expected).enumerate() {
        assert_eq!(mode["order"], at + 1);
        let records = mode["records"].as_object().unwrap();
        assert_eq!(records.len(), 3);
        for row in records.values() {
            let found = row["frequency_hz"].as_f64().unwrap();
            assert!((found / hz - 1.0).abs() < 0.004, "{found} against {hz}");
            assert!(
                row["frequency_sd_hz"].as_f64().unwrap() < 0.1
                    && row["damping_ratio"].as_f64().unwrap() > 0.0
            );
        }
    }
    let csv = fs::read_to_string(Path::new(out).join("modes.csv")).unwrap();
    assert!(csv.starts_with("position,order,frequency_hz,amplitude\n"), "{csv}");
}

/// Peaks extracted from simulated FRFs of the bench agree with the model's modes.
#[test]
fn limit_peaks_of_simulated_frfs_are_those_of_the_model() {
    let folder = bench_set(["5", "900", "0.5"], |_, text| text.to_string());
    let path = folder.path().to_str().unwrap();
    let document = json(&["peaks", "--measurements", path]);
    let modes = json(&["simulate", "modes", "--position", "l3"]);
    let first = modes["modes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|m| m["frequency_hz"].as_f64().unwrap())
        .find(|f| *f > 1.0)
        .unwrap();
    let regular: Vec<&Value> =
        document["modes"].as_array().unwrap().iter().filter(|m| m["regular"] == true).collect();
    let found = regular[0]["records"]["l3"]["frequency_hz"].as_f64().unwrap();
    assert!((found / first - 1.0).abs() < 0.01, "{found} against {first}");
    assert!(regular.len() >= 3, "{regular:#?}");
    refused(&["peaks", "--measurements", "measurements/tian"], &["no FRF", "[[frf]]"]);
    refused(&["peaks", "--measurements", path, "--local"], &["--local", "band"]);
    refused(&["peaks", "--measurements", path, "--band", "500,500.5"], &["l1.csv", "usable lines"]);
}

#[test]
fn refuse_sets_that_cannot_be_fitted() {
    let disjoint_bands = |name: &str, text: &str| {
        // Bands without overlap.
        let keep = |row: &&str| {
            let frequency = row.split(',').next().and_then(|f| f.parse::<f64>().ok());
            frequency.is_none_or(|f| if name == "l1" { f < 100.0 } else { f > 200.0 })
        };
        if name == "manifest" {
            text.to_string()
        } else {
            text.lines().filter(keep).map(|l| format!("{l}\n")).collect()
        }
    };
    let folder = bench_set(["6", "300", "6"], disjoint_bands);
    let path = folder.path().to_str().unwrap();
    refused(&["identify", "--measurements", path], &["l1.csv", "l3.csv", "no frequency in common"]);
    let folder = bench_set(["6", "300", "6"], |_, text| text.to_string());
    let path = folder.path().to_str().unwrap();
    refused(&["identify", "--measurements", path, "--band", "400,500"], &["l1.csv", "from 400 to 500 Hz"]);
    refused(&["identify", "--measurements", path, "--band", "500"], &["--band 500"]);
    // Too few lines to estimate the noise.
    let few = bench_set(["6", "300", "60"], |_, text| text.to_string());
    let few = few.path().to_str().unwrap();
    refused(
        &["identify", "--measurements", few, "--frf-model-error", "0"],
        &["l1.csv", "noise", "frf_model_error"],
    );
    refused(&["identify", "--measurements", path, "--positions", "l9"], &["l9", "l1, l3, l5"]);
    refused(&["identify", "--measurements", path, "--hold-out", "l1,l3,l5"], &["nothing is left to fit"]);
    refused(
        &["identify", "--measurements", path, "--config", "configs/two-inertia.toml"],
        &["response", "table", "motor, load"],
    );
    let outside = bench_set(["6", "300", "6"], |name, text| {
        if name == "manifest" { text.replace("1.6", "2.7") } else { text.into() }
    });
    refused(&["identify", "--measurements", outside.path().to_str().unwrap()], &["nut_m = 2.7", "0 and 2.6"]);
    refused(&["identify", "--objective", "frf"], &["no FRF"]);
    let twice = bench_set(["6", "300", "6"], |name, text| {
        if name == "manifest" { text.replace("l3.csv", "l1.csv") } else { text.into() }
    });
    refused(&["identify", "--measurements", twice.path().to_str().unwrap()], &["l1.csv", "listed twice"]);
    // Of several overrides the message names the faulty one.
    let message = output(&[
        "simulate",
        "modes",
        "--set",
        "point.table.mass_kg=300",
        "--set",
        "parameter.k_n.start=.12",
    ]);
    let message = String::from_utf8_lossy(&message.stderr).to_string();
    assert!(message.contains("k_n") && !message.contains("mass_kg"), "{message}");
    refused(&["validate", "--result", "measurements/tian/modes.csv"], &["modes.csv"]);
}

/// Two records of one position: the held-out one is reported by its name, and validation distinguishes it
/// from the other.
#[test]
fn records_of_a_position_are_held_out_by_name() {
    let folder = bench_set(["6", "600", "6"], |name, text| {
        if name != "manifest" {
            return text.to_string();
        }
        let again = text.replace("position = \"l1\"\nfile", "position = \"l1\"\nrecord = \"first\"\nfile");
        again + "[[frf]]\nposition = \"l1\"\nrecord = \"second\"\nfile = \"l1-again.csv\"\n"
    });
    let own = fs::read_to_string(folder.path().join("l1.csv")).unwrap();
    fs::write(folder.path().join("l1-again.csv"), own).unwrap();
    let path = folder.path().to_str().unwrap();
    let out = folder.path().join("out");
    let found = json(&[
        "identify",
        "--measurements",
        path,
        "--hold-out",
        "second",
        "--repeats",
        "1",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(found["held_out_positions"], serde_json::json!(["second"]));
    assert_eq!(found["fit_positions"], serde_json::json!(["first", "l3", "l5"]));
    let result = out.join("identification.json");
    let checked = json(&["validate", "--result", result.to_str().unwrap()]);
    let roles: Vec<&str> =
        checked["positions"].as_object().unwrap().values().map(|p| p["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["held_out"]);
    refused(
        &["validate", "--result", result.to_str().unwrap(), "--measurements", "measurements/tian"],
        &["no FRF to check"],
    );
}
