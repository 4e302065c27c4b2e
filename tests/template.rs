//! A user's own machine, from template to identification; schemas, completions, manual pages.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use num_complex::Complex64;
use numeric::distribution::clopper_pearson;
use numeric::random::normal;
use numeric::statistics::median;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;
use test_data::draws;

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
    let identify =
        ["identify", "--config", "axis/machine.toml", "--measurements", "axis/measurements", "--repeats", "1", "--out", "axis/results"];
    let machine = folder.path().join("axis/machine.toml");
    let manifest = folder.path().join("axis/measurements/manifest.toml");

    // As long as a value is missing, the message names a missing one.
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
    fs::write(&manifest, fill(&text, &POSITIONS)).unwrap();
    assert!(stderr(&identify, folder.path()).contains("modes.csv: holds no observation at all"));

    fill_in_measurements(&folder.path().join("axis"), &folder.path().join("taps"));
    jointid().current_dir(folder.path()).args(identify).assert().success();
    jointid().current_dir(folder.path()).args(["report", "axis/results"]).assert().success();
    let document: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("axis/results/identification.json")).unwrap()).unwrap();
    assert_eq!(document["held_out_positions"], serde_json::json!(["p2"]));
    assert!(document["derived"]["largest_frequency_error_fit"].as_f64().unwrap() < 0.05);
}

/// Coverage of the dampings of the right bearing and of screw and nut, with and without the guide's damping in the model and in the truth.
///
/// The truth is the template's machine with drawn joints. With the guide in the model the intervals hold with either truth. A model without it
/// puts the damping of the guide into other joints.
#[test]
#[ignore = "long"]
fn recover_dampings_with_the_guide_of_the_template() {
    let folder = tempfile::tempdir().unwrap();
    jointid().current_dir(folder.path()).args(["init", "axis"]).assert().success();
    let machine = folder.path().join("axis/machine.toml");
    let text = fill(&fs::read_to_string(&machine).unwrap(), &BENCH);
    fs::write(&machine, &text).unwrap();
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(8_123);
    let mut held = [[(0, 0); 2]; 2];
    let mut widths = [[Vec::new(), Vec::new()], [Vec::new(), Vec::new()]];
    for _ in 0..draws(4, 40) {
        let mut between = |low: f64, high: f64| low * f64::powf(high / low, generator.random::<f64>());
        let drawn = [
            ("k_al", between(3e7, 3e8)),
            ("k_ar", between(3e7, 3e8)),
            ("k_n", between(2e8, 1e9)),
            ("k_m", between(1e3, 1e4)),
            ("c_al", between(500.0, 5e3)),
            ("c_ar", between(500.0, 5e3)),
            ("c_n", between(3e3, 3e4)),
            ("c_m", between(0.05, 0.5)),
        ];
        for (in_truth, guide) in [(0, 1.0), (1, between(1e3, 1e4))] {
            let set = |(id, value): (&str, f64)| ["--set".to_string(), format!("parameter.{id}.start={value}")];
            let values: Vec<String> = drawn.iter().copied().chain([("c_g", guide)]).flat_map(set).collect();
            write_frfs(folder.path(), &values, &mut generator);
            for (in_model, frozen) in [(1, ""), (0, "c_g")] {
                let mut command = jointid();
                command.current_dir(folder.path()).args(["identify", "--config", "axis/machine.toml", "--measurements", "taps", "--json"]);
                if !frozen.is_empty() {
                    command.args(["--freeze", frozen, "--set", "parameter.c_g.start=1"]);
                }
                let document: Value = serde_json::from_slice(&command.arg("--quiet").output().unwrap().stdout).unwrap();
                for (at, id, truth) in [(0, "c_ar", drawn[5].1), (1, "c_n", drawn[6].1)] {
                    let end = |end: usize| document["parameters"][id]["interval95"][end].as_f64().unwrap();
                    let (holds, all) = &mut held[in_truth][in_model];
                    (*holds, *all) = (*holds + usize::from((end(0)..=end(1)).contains(&truth)), *all + 1);
                    widths[in_model][at].push((end(1) / end(0)).ln());
                }
            }
        }
    }
    let middle = |of: &Vec<f64>| median(of.iter().copied()).unwrap();
    println!(
        "c_ar and c_n held: without guide in the truth {:?} without, {:?} with guide in the model; with it {:?} and {:?}; median ln width of \
         c_ar {:.3} without, {:.3} with; of c_n {:.3} and {:.3}",
        held[0][0],
        held[0][1],
        held[1][0],
        held[1][1],
        middle(&widths[0][0]),
        middle(&widths[1][0]),
        middle(&widths[0][1]),
        middle(&widths[1][1])
    );
    for truth in held {
        let (holds, all) = truth[1];
        assert!(clopper_pearson(holds, all, 0.95).unwrap()[1] >= 0.95, "{truth:?}");
    }
}

/// Writes FRFs of the template's machine at three positions with 1 % of stated noise.
fn write_frfs(folder: &Path, values: &[String], generator: &mut Xoshiro256PlusPlus) {
    fs::create_dir_all(folder.join("taps")).unwrap();
    let mut manifest = String::from("quantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n");
    for (at, nut_m) in ["0.6", "1.0", "1.6"].iter().enumerate() {
        manifest += &format!("[[position]]\nname = \"p{at}\"\nnut_m = {nut_m}\n[[frf]]\nposition = \"p{at}\"\nfile = \"p{at}.csv\"\n");
        let frf = ["simulate", "frf", "--config", "axis/machine.toml", "--from-hz", "4", "--to-hz", "900", "--step-hz", "2", "--quiet"];
        let mut command = jointid();
        let output = command.current_dir(folder).args(frf).args(["--nut-m", nut_m]).args(values).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let mut table = String::from("frequency_hz,real,imag,relative_sd\n");
        for line in String::from_utf8(output.stdout).unwrap().lines().skip(1) {
            let cells: Vec<f64> = line.split(',').skip(1).take(3).map(|cell| cell.parse().unwrap()).collect();
            let noise = Complex64::new(normal(generator), normal(generator)) * 0.01;
            let h = Complex64::new(cells[1], cells[2]) * (1.0 + noise);
            table += &format!("{},{:e},{:e},{}\n", cells[0], h.re, h.im, 0.01 * std::f64::consts::SQRT_2);
        }
        fs::write(folder.join(format!("taps/p{at}.csv")), table).unwrap();
    }
    fs::write(folder.join("taps/manifest.toml"), manifest).unwrap();
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
    let faults: Vec<String> = schema.iter_errors(instance).map(|e| format!("{}: {e}", e.instance_path())).collect();
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
        assert_valid(&jsonschema::validator_for(&schema(&name)).unwrap(), &document, &name);
        seen += 1;
    }
    assert_eq!(seen, 13);
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

#[test]
fn completions_and_manual_contain_every_command() {
    let help = String::from_utf8(jointid().arg("--help").output().unwrap().stdout).unwrap();
    let lists = help.lines().skip_while(|l| *l != "Identify and diagnose:").take_while(|l| *l != "Options:");
    let names: Vec<&str> = lists.filter(|l| l.starts_with("  ")).filter_map(|l| l.split_whitespace().next()).collect();
    assert!(names.len() > 12, "{help}");
    let bash = String::from_utf8(jointid().args(["completions", "bash"]).output().unwrap().stdout).unwrap();
    let folder = tempfile::tempdir().unwrap();
    jointid().args(["man", "--out"]).arg(folder.path()).assert().success();
    for name in &names {
        assert!(bash.contains(name), "{name}");
        assert!(folder.path().join(format!("jointid-{name}.1")).exists(), "{name}");
        let help = String::from_utf8(jointid().args([name, "--help"]).output().unwrap().stdout).unwrap();
        assert!(help.contains("Structure:") || help.contains("Example:\n  jointid "), "{name} has no example");
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
