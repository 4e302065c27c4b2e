//! Answers that were wrong or missing without a word: gains, peaks, time records.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use measurement::{read_set, read_set_from};
use num_complex::Complex64;

/// Runs the command in a folder; returns exit code, stdout and stderr with single blanks.
fn run(folder: &Path, line: &str) -> (i32, String, String) {
    let words = line.split_whitespace();
    let output = Command::cargo_bin("jointid").unwrap().args(words).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).split_whitespace().collect::<Vec<_>>().join(" ");
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// Receptance (m/N) of 100 kg with a natural frequency (Hz) and a damping ratio.
fn mode(hz: f64, (natural_hz, damping): (f64, f64)) -> Complex64 {
    let (omega, natural) = (TAU * hz, TAU * natural_hz);
    0.01 / Complex64::new(natural * natural - omega * omega, 2.0 * damping * natural * omega)
}

/// A number from −1 to 1 that looks drawn.
fn scatter(at: u32) -> f64 {
    2.0 * ((f64::from(at) * 12.9898).sin().abs() * 43_758.545_3).fract() - 1.0
}

/// A table of lines from 20 Hz at a step (Hz), with relative noise.
fn table(step_hz: f64, noise: f64, value: impl Fn(f64) -> Complex64) -> String {
    let mut text = "frequency_hz,real,imag\n".to_string();
    for at in 0..400 {
        let hz = 20.0 + step_hz * f64::from(at);
        let h = value(hz) * (1.0 + noise * Complex64::new(scatter(2 * at), scatter(2 * at + 1)));
        writeln!(text, "{hz},{:e},{:e}", h.re, h.im).unwrap();
    }
    text
}

const IMPORT: &str = "--quantity receptance --position l1 --response table --excitation table";

#[test]
fn limit_exported_values_are_those_of_the_structure() {
    let made = tempfile::tempdir().unwrap();
    let folder = made.path();
    fs::write(folder.join("a.csv"), table(0.5, 0.0, |hz| mode(hz, (60.0, 0.02)))).unwrap();
    assert_eq!(run(folder, &format!("import a.csv --out set {IMPORT}")).0, 0);
    let manifest = fs::read_to_string(folder.join("set/manifest.toml")).unwrap();
    let set = |name: &str| read_set(folder.join(name).to_str().unwrap()).unwrap();
    let original = set("set");
    for (gain, name, factor, note) in
        [("4.0", "known", 0.25, "divided by the gain"), ("\"unknown\"", "unknown", 1.0, "not calibrated")]
    {
        let stated = manifest.lines().filter(|line| !line.starts_with("gain")).collect::<Vec<_>>().join("\n");
        fs::write(folder.join("set/manifest.toml"), format!("gain = {gain}\n{stated}")).unwrap();
        let (code, _, message) = run(folder, &format!("export --measurements set --out {name}.uff"));
        assert!(code == 0 && message.contains(note), "{message}");
        assert_eq!(run(folder, &format!("import {name}.uff --out {name} {IMPORT}")).0, 0);
        for (a, b) in original.frfs[0].lines.iter().zip(&set(name).frfs[0].lines) {
            assert!((a.value * factor - b.value).norm() < 1e-9 * b.value.norm());
        }
    }
}

#[test]
fn peaks_says_why_a_record_shows_no_mode() {
    let made = tempfile::tempdir().unwrap();
    let folder = made.path();
    let narrow = |hz: f64| mode(hz, (120.05, 1e-5)) + mode(hz, (500.0, 0.5));
    for (name, text, expected) in [
        (
            "conjugate",
            table(0.5, 0.003, |hz| mode(hz, (120.0, 0.02)).conj()),
            "complex conjugates of its values do, at 120.0 Hz",
        ),
        ("narrow", table(0.5, 0.6, narrow), "at 120.0 Hz, is"),
        ("flat", table(0.5, 0.0, |hz| Complex64::new(1e-8 / hz, 0.0)), "|H| has no peak from 20 to 219.5 Hz"),
    ] {
        fs::write(folder.join("a.csv"), text).unwrap();
        assert_eq!(run(folder, &format!("import a.csv --out {name} {IMPORT}")).0, 0);
        let (code, out, message) = run(folder, &format!("peaks --measurements {name} --out out-{name}"));
        assert!(code == 0 && out.starts_with("no mode found in the FRF"), "{out}");
        assert!(message.contains("shows no mode") && message.contains(expected), "{message}");
        assert!(!folder.join(format!("out-{name}/modes.csv")).exists());
    }
}

#[test]
fn clean_records_at_several_levels_are_modes() {
    let made = tempfile::tempdir().unwrap();
    let folder = made.path();
    let mut manifest =
        "title = \"levels\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n"
            .to_string();
    for level in 1..=8_u32 {
        let damping = 0.0015 * f64::from(level).powf(0.7);
        let frequency_hz = 80.0 - 0.05 * f64::from(level);
        let text = table(0.25, 0.002, |hz| mode(hz, (frequency_hz, damping)) * f64::from(level).powf(-0.2));
        fs::write(folder.join(format!("{level}.csv")), text).unwrap();
        write!(manifest, "[[frf]]\nrecord = \"r{level}\"\nfile = \"{level}.csv\"\nforce_n = {level}.0\n")
            .unwrap();
    }
    fs::write(folder.join("manifest.toml"), manifest).unwrap();
    let (code, out, message) = run(folder, "peaks --measurements .");
    assert!(code == 0 && out.contains("a mode: observed in 8 of 8"), "{out}");
    assert!(message.contains("depends on the level of the force"), "{message}");
    assert!(read_set_from(folder.to_str().unwrap(), false).is_ok());
}

#[test]
fn time_records_are_no_frfs() {
    let made = tempfile::tempdir().unwrap();
    let folder = made.path();
    let numbers: String =
        (0..400).map(|k| format!("{},{},{}\n", 0.0025 * f64::from(k), k % 7, k % 5)).collect();
    let columns = "--columns frequency_hz,real,imag";
    for header in ["time,force,acceleration\n", "Time (s),Ch1,Ch2\n", "t,x,y\n"] {
        fs::write(folder.join("a.csv"), format!("{header}{numbers}")).unwrap();
        for (more, expected) in [
            ("", "is a time, and FRFs stand over frequency"),
            (columns, "of the header is named frequency_hz"),
        ] {
            let (code, _, message) = run(folder, &format!("import a.csv --out set {IMPORT} {more}"));
            assert!(code == 2 && message.contains(expected), "{header}{more}: {message}");
        }
    }
    fs::write(folder.join("a.csv"), numbers).unwrap();
    let (code, _, message) = run(folder, &format!("import a.csv --out set {IMPORT} {columns}"));
    assert!(code == 0 && message.contains("below the modes of any machine"), "{message}");
}

/// What is warned about can be acted on: a combination is named with what distinguishes its parameters.
#[test]
fn a_combination_is_stated_with_its_remedy() {
    let study = jointid::Study::open(&jointid::Sources::default()).unwrap().fit(["l1", "l3", "l5"]).unwrap();
    let settings = jointid::Settings { repeats: 1, ..study.settings().clone() };
    let found = study.with_settings(settings).identify().unwrap();
    assert!(!found.combinations.is_empty());
    for combination in &found.combinations {
        let is_stated = |text: &String| {
            text.starts_with(&combination.description) && text.contains("prior") && text.contains("plan")
        };
        assert!(found.stamp.warnings.iter().any(is_stated), "{:?}", found.stamp.warnings);
    }
}
