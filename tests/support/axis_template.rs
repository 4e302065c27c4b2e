//! The template of `jointid init`, filled in with the published bench.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// Replaces the `nan` of each key, one after another.
pub fn fill(text: &str, values: &[(&str, &str)]) -> String {
    let mut text = text.to_string();
    for (key, value) in values {
        let placeholder = format!("{key} = nan");
        assert!(text.contains(&placeholder), "{key}");
        text = text.replacen(&placeholder, &format!("{key} = {value}"), 1);
    }
    text
}

/// Values of the published bench, in the order of the template.
pub const BENCH: [(&str, &str); 6] = [
    ("mass_kg", "272.0"),
    ("inertia_kg_m2", "1e-3"),
    ("inertia_kg_m2", "1e-4"),
    ("length_m", "2.6"),
    ("diameter_m", "0.04"),
    ("lead_m", "0.04"),
];
/// Nut positions of the published bench, in the order of the template.
pub const POSITIONS: [(&str, &str); 3] = [("nut_m", "0.6"), ("nut_m", "1.0"), ("nut_m", "1.6")];

/// Fills the published bench into the template of a machine.
pub fn fill_in_machine(axis: &Path) {
    let machine = axis.join("machine.toml");
    fs::write(&machine, fill(&fs::read_to_string(&machine).unwrap(), &BENCH)).unwrap();
}

/// Fills positions and modes into the template's set, and writes the FRFs of the same positions next to it,
/// one table each.
pub fn fill_in_measurements(axis: &Path, taps: &Path) {
    let manifest = axis.join("measurements/manifest.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    if text.contains("nut_m = nan") {
        fs::write(&manifest, fill(&text, &POSITIONS)).unwrap();
    }
    let measured =
        [["24,", "118,", "523,", "716,"], ["24,", "116,", "565,", "721,"], ["23,", "113,", "561,", "728,"]];
    let mut text = String::from("position,order,frequency_hz,amplitude\n");
    for (position, row) in measured.iter().enumerate() {
        for (order, cell) in row.iter().enumerate() {
            text += &format!("p{},{},{cell}\n", position + 1, order + 1);
        }
    }
    fs::write(axis.join("measurements/modes.csv"), text).unwrap();
    fs::create_dir_all(taps).unwrap();
    for (at, (_, nut_m)) in POSITIONS.iter().enumerate() {
        let frf = [
            "simulate",
            "frf",
            "--nut-m",
            nut_m,
            "--from-hz",
            "5",
            "--to-hz",
            "900",
            "--step-hz",
            "1",
            "--quiet",
        ];
        let text =
            String::from_utf8(Command::cargo_bin("jointid").unwrap().args(frf).output().unwrap().stdout)
                .unwrap();
        let lines: String = text.lines().map(|l| format!("{}\n", l.split_once(',').unwrap().1)).collect();
        fs::write(taps.join(format!("tap-p{}.csv", at + 1)), lines).unwrap();
    }
}
