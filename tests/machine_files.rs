//! Machine files of results: the identified machine, and the machine with the effect that a diagnosis names.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use reference_simulator::{ordinary, write_case};
use serde_json::Value;

/// Runs the command in the project. Returns exit code, stdout and stderr.
fn command(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("jointid").unwrap().args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn document(arguments: &[&str]) -> Value {
    let (code, text, fault) = command(&[arguments, &["--json", "--quiet"]].concat());
    assert_eq!(code, 0, "{arguments:?}: {fault}");
    serde_json::from_str(&text).unwrap()
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Returns the undamped natural frequencies of the modes of a document.
fn frequencies(modes: &Value, key: &str) -> Vec<f64> {
    modes.as_array().unwrap().iter().map(|m| m[key].as_f64().unwrap()).collect()
}

/// Whole FRFs with tolerances: the file has the same FRFs and frequencies as the identified machine, and a
/// second identification returns to them.
#[test]
#[ignore = "second tier"]
fn an_identified_machine_is_a_machine_of_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    write_case(folder.path(), &ordinary(4_311, 0).unwrap().case).unwrap();
    let (machine, found, out) = (path("machine.toml"), path("found.toml"), path("out"));
    let set = folder.path().display().to_string();
    let fit = ["--measurements", &set, "--positions", "l1,l3,l5", "--repeats", "1", "--quiet"];
    let (code, text, fault) =
        command(&[&["identify", "--config", &machine, "--out", &out], &fit[..]].concat());
    assert_eq!(code, 0, "{fault}");
    // FRF fits, too, print natural frequencies.
    assert!(text.contains("natural frequencies"), "{text}");
    let result = path("out/identification.json");
    let identified = read(Path::new(&result));
    let (code, _, fault) = command(&[
        "predict",
        "--result",
        &result,
        "--nut-m",
        "0.5",
        "--draws",
        "39",
        "--machine-out",
        &found,
    ]);
    assert_eq!(code, 0, "{fault}");
    let text = fs::read_to_string(&found).unwrap();
    assert!(text.contains("[fitted.tolerances.\"mass of table\"]"), "{text}");

    // The same FRFs as those that the result predicts, and the frequencies that the identification lists.
    let line = ["--from-hz", "20", "--to-hz", "700", "--step-hz", "3.7", "--json", "--position", "l2,l5"];
    let (_, from_result, fault) = command(&[&["simulate", "frf", "--result", &result], &line[..]].concat());
    assert!(!from_result.is_empty(), "{fault}");
    let (_, from_file, fault) =
        command(&[&["simulate", "frf", "--config", &found, "--measurements", &set], &line[..]].concat());
    assert!(!from_file.is_empty(), "{fault}");
    let (from_result, from_file): (Value, Value) =
        (serde_json::from_str(&from_result).unwrap(), serde_json::from_str(&from_file).unwrap());
    for name in ["l2", "l5"] {
        let values =
            |of: &Value| -> Vec<[f64; 2]> { serde_json::from_value(of["positions"][name].clone()).unwrap() };
        let (a, b) = (values(&from_result), values(&from_file));
        assert!(a.len() > 100 && a.len() == b.len());
        for (a, b) in a.iter().zip(&b) {
            let (distance, size) = ((a[0] - b[0]).hypot(a[1] - b[1]), a[0].hypot(a[1]));
            assert!(distance < 1e-9 * size, "{name}: {a:?} {b:?}");
        }
    }
    let modes = document(&[
        "simulate",
        "modes",
        "--config",
        &found,
        "--measurements",
        &set,
        "--position",
        "l3",
        "--max-hz",
        "600",
    ]);
    let (listed, simulated) =
        (frequencies(&identified["modes"]["l3"], "natural_hz"), frequencies(&modes["modes"], "frequency_hz"));
    let elastic: Vec<f64> = simulated.into_iter().filter(|hz| *hz > 1.0).collect();
    assert!(!elastic.is_empty());
    for hz in elastic {
        assert!(
            listed.iter().any(|other| (other / hz - 1.0).abs() < 1e-6),
            "{hz} Hz is not among {listed:?}"
        );
    }

    // Identified again: the tolerances start with what is known of them, and the frequencies stay.
    let again = document(&[&["identify", "--config", &found], &fit[..6]].concat());
    let counts_twice = |of: &Value| of["warnings"].to_string().contains("they count twice");
    assert!(counts_twice(&again) && !counts_twice(&identified), "{}", again["warnings"]);
    let (first, second) = (&identified["tolerances"], &again["tolerances"]);
    assert_eq!(first.as_object().unwrap().len(), second.as_object().unwrap().len());
    for name in ["mass of table", "nut length on screw"] {
        let (estimate, prior) = (&first[name], &second[name]["prior"]);
        assert_eq!((&estimate["value"], &estimate["sd"]), (&prior["mean"], &prior["sd"]), "{name}");
        assert!(second[name]["sd"].as_f64() <= prior["sd"].as_f64(), "{name}");
    }
    for name in ["l1", "l2", "l6"] {
        let (first, second) = (
            frequencies(&identified["modes"][name], "natural_hz"),
            frequencies(&again["modes"][name], "natural_hz"),
        );
        for (a, b) in first.iter().zip(&second).take(4) {
            assert!((a / b - 1.0).abs() < 2e-3, "{name}: {first:?} {second:?}");
        }
    }

    // Files that describe no such machine.
    for (change, words) in [
        (
            ("\"mass of table\"", "\"mass of tabel\""),
            "fitted.tolerances.mass of tabel: the machine has no such tolerance",
        ),
        (("nuts_m = [", "nuts_m = [-1.0, "), "outside the screw"),
    ] {
        let wrong = path("wrong.toml");
        fs::write(&wrong, text.replace(change.0, change.1)).unwrap();
        let (code, _, fault) = command(&["simulate", "modes", "--config", &wrong]);
        assert!(code == 2 && fault.contains(words), "{code} {fault}");
    }
}

/// The named effect is in the written machine, which is identified with it. Where the verdict names none,
/// nothing is written.
#[test]
fn a_named_effect_is_applied() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (applied, out) = (path("applied.toml"), path("out"));
    let common =
        ["diagnose", "--positions", "l1,l3,l5", "--no-cache", "--nulls", "20", "--repeats", "1", "--quiet"];
    let (code, text, fault) = command(
        &[
            &common[..],
            &[
                "--without",
                "rotor-hold",
                "--effects",
                "rotor-hold,table-mass",
                "--apply",
                &applied,
                "--out",
                &out,
            ],
        ]
        .concat(),
    );
    assert_eq!(code, 0, "{fault}");
    assert!(text.contains("rotor-hold") && text.contains("largest frequency error, held out"), "{text}");
    let written = fs::read_to_string(&applied).unwrap();
    assert!(written.contains("effects = [\"rotor-hold\"]"), "{written}");
    // Far better than the machine without the effect, in the fit and at the held-out positions.
    let identified = read(&folder.path().join("out/identification-applied.json"));
    assert_eq!(identified["settings"]["config"], applied);
    let without =
        document(&["identify", "--without", "rotor-hold", "--positions", "l1,l3,l5", "--repeats", "1"]);
    let of = |document: &Value| {
        [&document["cost"], &document["derived"]["largest_frequency_error_held_out"]]
            .map(|x| x.as_f64().unwrap())
    };
    let ([cost, largest], [cost_before, largest_before]) = (of(&identified), of(&without));
    assert!(
        cost < 0.05 * cost_before && largest < 0.2 * largest_before,
        "{cost} {cost_before} {largest} {largest_before}"
    );
    let modes = document(&["simulate", "modes", "--config", &applied, "--position", "l3"]);
    assert!(modes["modes"].as_array().unwrap().len() > 3);

    let nothing = path("nothing.toml");
    let (code, _, fault) =
        command(&[&common[..], &["--apply", &nothing, "--effects", "table-mass"]].concat());
    assert!(
        code == 1 && fault.contains("names no single effect to apply: no machine is written"),
        "{code} {fault}"
    );
    assert!(!Path::new(&nothing).exists());
    let (code, _, fault) = command(&[&common[..], &["--apply", &out]].concat());
    assert!(code == 2 && fault.contains("is a folder"), "{code} {fault}");
}
