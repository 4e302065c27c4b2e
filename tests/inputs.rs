//! Inputs of other programs: each states something that must be used, contradicted aloud or refused.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use measurement::{FrfNoise, MeasurementSet, Quantity, read_set};
use num_complex::Complex64;

/// Result of an import: the set, or none where it was refused, and what was said.
struct Imported {
    set: Option<MeasurementSet>,
    said: String,
}

/// Imports a file into a new folder.
fn import(file: &Path, arguments: &[&str]) -> Imported {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("set");
    let output = Command::cargo_bin("jointid")
        .unwrap()
        .arg("import")
        .arg(file)
        .arg("--out")
        .arg(&out)
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    match output.status.code() {
        Some(0) => Imported { set: Some(read_set(out.to_str().unwrap()).unwrap()), said },
        Some(2) => {
            assert!(!out.exists(), "{said}");
            Imported { set: None, said }
        }
        other => panic!("{other:?}: {said}"),
    }
}

fn case(name: &str) -> Option<PathBuf> {
    test_data::shared(&format!("cases/{name}"))
}

/// Accelerance of 10 kg on 100 Hz with 2 % damping, the truth of all cases.
fn truth(frequency_hz: f64) -> Complex64 {
    let (omega, natural) = (std::f64::consts::TAU * frequency_hz, std::f64::consts::TAU * 100.0);
    -omega * omega / (10.0 * Complex64::new(natural * natural - omega * omega, 0.04 * natural * omega))
}

/// Asserts 400 lines of the truth from 0.5 Hz to 200 Hz in every FRF, times a factor.
fn assert_truth(imported: &Imported, factor: f64) {
    let set = imported.set.as_ref().unwrap_or_else(|| panic!("refused: {}", imported.said));
    for frf in &set.frfs {
        let lines: Vec<_> = frf.lines.iter().chain(&frf.rejected).collect();
        assert_eq!(lines.len(), 400, "{}", imported.said);
        for line in lines {
            // Headers state steps with six digits.
            let frequency_hz = (2.0 * line.frequency_hz).round() / 2.0;
            assert!(
                (line.frequency_hz - frequency_hz).abs() < 2e-6 * frequency_hz,
                "{} Hz, {}",
                line.frequency_hz,
                imported.said
            );
            let omega = std::f64::consts::TAU * frequency_hz;
            let expected = match frf.quantity {
                Quantity::Accelerance => truth(frequency_hz),
                Quantity::Mobility => truth(frequency_hz) / Complex64::new(0.0, omega),
                Quantity::Receptance => truth(frequency_hz) / (-omega * omega),
            } * factor;
            let error = (line.value - expected).norm() / expected.norm();
            assert!(
                error < 2e-5,
                "{} Hz: {} for {expected}, {}",
                line.frequency_hz,
                line.value,
                imported.said
            );
        }
    }
}

fn assert_refused(imported: &Imported, words: &[&str]) {
    assert!(imported.set.is_none(), "not refused: {}", imported.said);
    assert_said(imported, words);
}

fn assert_said(imported: &Imported, words: &[&str]) {
    for word in words {
        assert!(imported.said.contains(word), "«{word}» is not in: {}", imported.said);
    }
}

/// Text of a universal file with one FRF of the truth: records 6 (end), 8, 9 and 10 as given, values times a
/// factor, frequencies to be scaled.
struct Universal<'t> {
    locations: &'t str,
    abscissa: (&'t str, &'t str, f64),
    ordinate: (&'t str, &'t str),
    denominator: (&'t str, &'t str),
    value: fn(Complex64) -> Complex64,
}

impl Default for Universal<'_> {
    fn default() -> Self {
        Universal {
            locations: "    4         0    0         0 NONE               1   3 NONE               1   3",
            abscissa: ("18", "Hz", 1.0),
            ordinate: ("12", "m/s^2"),
            denominator: ("13", "N"),
            value: |h| h,
        }
    }
}

impl Universal<'_> {
    fn text(&self) -> String {
        let axis = |code: &str, unit: &str| format!("{code:>10}    0    0    0 {:<20} {unit:<20}\n", "NONE");
        let mut text = String::from("    -1\n    58\nFRF\nNONE\n01-Jan-20 10:00:00\nNONE\nNONE\n");
        let step = 0.5 * self.abscissa.2;
        text += &format!(
            "{}\n{:>10}{:>10}{:>10}{step:>13.5e}{step:>13.5e}{:>13.5e}\n",
            self.locations, 6, 400, 1, 0.0
        );
        text += &axis(self.abscissa.0, self.abscissa.1);
        text += &(axis(self.ordinate.0, self.ordinate.1)
            + &axis(self.denominator.0, self.denominator.1)
            + &axis("0", "NONE"));
        for line in 1..=400 {
            let value = (self.value)(truth(0.5 * f64::from(line)));
            text += &format!("{:>20.11e}{:>20.11e}\n", value.re, value.im);
        }
        text + "    -1\n"
    }

    fn import(&self, arguments: &[&str]) -> Imported {
        import_text(&self.text(), arguments)
    }
}

fn import_text(text: &str, arguments: &[&str]) -> Imported {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.uff");
    fs::write(&path, text).unwrap();
    import(&path, arguments)
}

#[test]
fn limit_a_blow_along_a_negative_direction_changes_the_sign() {
    let Some(folder) = case("uff-negative-direction-mapped") else { return };
    let named = ["--response", "table", "--excitation", "table"];
    let imported = import(&folder.join("tap.uff"), &named);
    assert_truth(&imported, 1.0);
    assert_said(&imported, &["multiplied by -1", "1:-Z"]);
    // Points that keep the file's names keep its directions, and its values.
    assert_truth(&import(&folder.join("tap.uff"), &[]), -1.0);
}

#[test]
fn signs_follow_the_points_that_are_named() {
    let of = |response: i32, reference: i32| {
        format!(
            "    4         0    0         0 NONE               1{response:>4} NONE               1{reference:>4}"
        )
    };
    let import = |response: i32, reference: i32, arguments: &[&str]| {
        Universal { locations: &of(response, reference), ..Universal::default() }.import(arguments)
    };
    let both = ["--response", "table", "--excitation", "table"];
    assert_truth(&import(-1, 1, &both), -1.0);
    assert_truth(&import(-1, -1, &both), 1.0);
    assert_truth(&import(1, -3, &["--excitation", "table"]), -1.0);
    assert_truth(&import(1, -3, &["--response", "table"]), 1.0);
    let cross = import(1, -3, &both);
    assert_truth(&cross, -1.0);
    assert_said(&cross, &["different axes"]);
}

#[test]
fn limit_the_abscissa_is_converted_to_hz_or_refused() {
    let Some(folder) = case("uff-abscissa-unit") else { return };
    for file in ["rad.uff", "rpm.uff"] {
        assert_truth(&import(&folder.join(file), &[]), 1.0);
    }
    assert_refused(&import(&folder.join("time.uff"), &[]), &["time", "not a frequency"]);
    let of = |abscissa| Universal { abscissa, ..Universal::default() }.import(&[]);
    assert_truth(&of(("18", "kHz", 1e-3)), 1.0);
    assert_truth(&of(("0", "NONE", 1.0)), 1.0);
    assert_refused(&of(("36", "order", 1.0)), &["code 36"]);
    assert_refused(&of(("18", "order", 1.0)), &["«order»", "unknown"]);
    assert_refused(&of(("18", "s", 1.0)), &["a time"]);
}

#[test]
fn limit_units_of_universal_files_are_converted_or_refused() {
    let Some(folder) = case("uff-unit-not-understood") else { return };
    for file in ["gs.uff", "g-per-n.uff", "meganewton.uff"] {
        assert_truth(&import(&folder.join(file), &[]), 1.0);
    }
    let of = |ordinate, denominator| Universal { ordinate, denominator, ..Universal::default() }.import(&[]);
    for (unit, force, factor) in [
        ("g_n", "N", 9.806_65),
        ("in/sec^2", "lbs", 0.0254 / 4.448_221_615_260_5),
        ("mm/s**2", "kN", 1e-6),
        ("mil/s²", "kip", 2.54e-5 / 4_448.221_615_260_5),
        ("m/s2", "mN", 1e3),
    ] {
        assert_truth(&of(("12", unit), ("13", force)), factor);
    }
    assert_refused(&of(("12", "furlong/s^2"), ("13", "N")), &["furlong", "unknown"]);
    assert_refused(&of(("12", "m/s^2"), ("13", "bananas")), &["bananas", "unknown"]);
    assert_refused(&of(("12", "V"), ("13", "N")), &["a voltage", "acceleration"]);
    assert_refused(&of(("12", "m/s^2"), ("13", "V")), &["a voltage", "force"]);
}

#[test]
fn contradictions_are_said_with_both_values() {
    let Some(folder) = case("uff-164-against-label") else { return };
    let imported = import(&folder.join("mm-164-label-m.uff"), &[]);
    assert_truth(&imported, 1e-3);
    assert_said(&imported, &["«m/s^2»", "0.001", "dataset 164", "mm (newton)"]);
    let of = |ordinate, arguments: &[&str]| Universal { ordinate, ..Universal::default() }.import(arguments);
    assert_refused(&of(("12", "mm/s"), &[]), &["accelerance", "mobility", "«mm/s»"]);
    assert_said(
        &of(("12", "m/s^2"), &["--quantity", "receptance"]),
        &["states accelerance", "receptance was requested"],
    );
}

#[test]
fn limit_force_over_motion_is_inverted_and_motion_over_motion_refused() {
    let Some(folder) = case("uff-force-over-response") else { return };
    for arguments in [&[][..], &["--quantity", "accelerance"]] {
        let imported = import(&folder.join("apparent-mass.uff"), arguments);
        assert_truth(&imported, 1.0);
        assert_said(&imported, &["reciprocal"]);
    }
    assert_refused(&import(&folder.join("transmissibility.uff"), &[]), &["transmissibility"]);
    let of = |ordinate, denominator, value| {
        Universal { ordinate, denominator, value, ..Universal::default() }.import(&[])
    };
    assert_truth(&of(("1", "N/(m/s^2)"), ("0", "NONE"), |h| h.inv()), 1.0);
    assert_truth(&of(("1", "(1/N)*(m/s^2)"), ("0", "NONE"), |h| h), 1.0);
    assert_refused(&of(("13", "N"), ("13", "N"), |h| h), &["force over force"]);
    assert_refused(&of(("15", "Pa"), ("13", "N"), |h| h), &["a pressure"]);
}

#[test]
fn limit_coherences_pair_by_all_their_fields() {
    let Some(folder) = case("uff-coherence-of-another-record") else { return };
    let coherence = |set: &MeasurementSet, at: usize| {
        let line = set.frfs[at].lines.first().or(set.frfs[at].rejected.first()).unwrap();
        let Some(FrfNoise::Coherence(c)) = line.noise else { panic!("no coherence") };
        c
    };
    // All lines of the second tap are below 0.8, so that the set is not accepted as a whole.
    let folder_of = tempfile::tempdir().unwrap();
    let out = folder_of.path().join("set");
    Command::cargo_bin("jointid")
        .unwrap()
        .arg("import")
        .arg(folder.join("repeats.uff"))
        .args(["--averages", "5", "--out"])
        .arg(&out)
        .assert()
        .success();
    let first = |name: &str| {
        fs::read_to_string(out.join("frf").join(name)).unwrap().lines().nth(1).unwrap().to_string()
    };
    assert!(first("repeats-1.csv").ends_with(",0.97"), "{}", first("repeats-1.csv"));
    assert!(first("repeats-2.csv").ends_with(",0.485"), "{}", first("repeats-2.csv"));
    let imported = import(&folder.join("node0.uff"), &["--averages", "5"]);
    assert_said(&imported, &["paired in spite of"]);
    assert!(coherence(&imported.set.unwrap(), 0) > 0.8);
}

#[test]
fn a_coherence_without_partner_is_named() {
    let of = |node: i32| {
        let locations =
            format!("    6         0    0         0 NONE       {node:>9}   3 NONE               1   3");
        Universal { locations: &locations, value: |_| Complex64::new(0.97, 0.0), ..Universal::default() }
            .text()
    };
    let other = import_text(&(Universal::default().text() + &of(9)), &["--averages", "5"]);
    assert_truth(&other, 1.0);
    assert_said(&other, &["the coherence 9:+Z / 1:+Z", "left out"]);
    let own = import_text(&(Universal::default().text() + &of(1)), &["--averages", "5"]);
    assert!(own.set.unwrap().frfs[0].lines[0].noise.is_some());
}

#[test]
fn limit_one_bad_part_does_not_cost_the_rest() {
    let Some(folder) = case("uff-broken-neighbour-blocks-import") else { return };
    for file in ["nodes-2411-one-line.uff", "time-record-of-type-0.uff", "units-164-blank.uff"] {
        let imported = import(&folder.join(file), &[]);
        assert_truth(&imported, 1.0);
        assert_said(&imported, &["left out"]);
        assert!(!imported.said.contains("0 lines too early"), "{}", imported.said);
        assert!(import(&folder.join(file), &["--strict"]).set.is_none(), "{file}");
    }
    let stars = "    -1\n    15\n         1         0         0        11*************  0.00000E+00  0.00000E+00\n    -1\n";
    let short_82 = "    -1\n    82\n         1         9        30\nline\n         1         2\n    -1\n";
    for broken in [stars, short_82] {
        let imported = import_text(&(broken.to_string() + &Universal::default().text()), &[]);
        assert_truth(&imported, 1.0);
        assert_said(&imported, &["left out"]);
        assert_truth(&import_text(&(Universal::default().text() + broken), &[]), 1.0);
    }
    // Of two FRFs, one with an unknown unit.
    let unknown = Universal { ordinate: ("12", "bananas"), ..Universal::default() }.text();
    let imported = import_text(&(Universal::default().text() + &unknown), &[]);
    assert_truth(&imported, 1.0);
    assert_said(&imported, &["bananas", "this record is left out"]);
    assert!(import_text(&(Universal::default().text() + &unknown), &["--strict"]).set.is_none());
}

#[test]
fn limit_a_value_that_is_missing_costs_its_line_alone() {
    let Some(folder) = case("nan-at-0-hz") else { return };
    assert_truth(&import(&folder.join("frf.uff"), &[]), 1.0);
    assert_truth(&import(&folder.join("frf.csv"), &["--quantity", "accelerance"]), 1.0);
    let clamped = import(&folder.join("coherence-1.00001.uff"), &["--averages", "5"]);
    assert_truth(&clamped, 1.0);
    assert!(clamped.set.unwrap().frfs[0].lines[0].noise.is_some());
    assert!(import(&folder.join("frf.uff"), &["--strict"]).set.is_none());
}

#[test]
fn limit_tables_use_what_their_columns_state() {
    let Some(folder) = case("csv-unit-in-column-name") else { return };
    assert_truth(&import(&folder.join("rad.csv"), &["--quantity", "accelerance"]), 1.0);
    let Some(folder) = case("csv-units-of-real-and-imag-differ") else { return };
    assert_truth(&import(&folder.join("mixed.csv"), &["--quantity", "receptance"]), 1.0);
    let Some(folder) = case("csv-several-frfs-in-one-table") else { return };
    let imported = import(&folder.join("two.csv"), &["--quantity", "accelerance"]);
    let set = imported.set.unwrap();
    assert_eq!(set.frfs.len(), 2);
    for (a, b) in set.frfs[0].lines.iter().zip(&set.frfs[1].lines) {
        assert!((b.value / a.value - 2.0).norm() < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn tables_are_read_in_any_of_their_forms() {
    let folder = tempfile::tempdir().unwrap();
    let form =
        |file: &str, line: &dyn Fn(f64, Complex64) -> String, head: &str, arguments: &[&str], utf16: bool| {
            let lines: String =
                (1..=400).map(|at| line(0.5 * f64::from(at), truth(0.5 * f64::from(at))) + "\n").collect();
            let text = head.to_string() + &lines;
            let bytes = if utf16 {
                [0xFF, 0xFE].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
            } else {
                text.into_bytes()
            };
            let path = folder.path().join(file);
            fs::write(&path, bytes).unwrap();
            let arguments: Vec<&str> =
                ["--quantity", "accelerance"].into_iter().chain(arguments.iter().copied()).collect();
            let imported = import(&path, &arguments);
            assert_truth(&imported, 1.0);
        };
    let cartesian = |f: f64, h: Complex64| format!("{f},{:e},{:e}", h.re, h.im);
    let comma = |f: f64, h: Complex64| format!("{f};{:e};{:e}", h.re, h.im).replace('.', ",");
    form("a.csv", &comma, "Frequenz (Hz);Realteil;Imaginärteil\n", &[], false);
    form("b.csv", &comma, "Frequency;Real;Imag\nHz;(m/s^2)/N;(m/s^2)/N\n", &[], true);
    form(
        "c.txt",
        &cartesian,
        "Analyser 7, test 3\nDate: 2020-01-01\n\nFrequency (Hz),Real,Imag\n",
        &[],
        false,
    );
    form(
        "d.dat",
        &|f, h| format!("{f} {:e} {:e}", h.re, h.im),
        "",
        &["--columns", "frequency_hz,real,imag"],
        false,
    );
    form(
        "e.asc",
        &|f, h| format!("{f}\t{}\t{}", 20.0 * h.norm().log10(), h.arg().to_degrees()),
        "Hz\tMag (dB re 1 (m/s^2)/N)\tPhase (deg)\n",
        &[],
        false,
    );
    form("f.tsv", &|f, h| format!("{f}\t{:e}\t{}", h.norm(), h.arg()), "freq\tmag\tphase_rad\n", &[], false);
    form(
        "g.csv",
        &|f, h| format!("{},{:e},{:e}", f * 60.0, h.re / 9.806_65, h.im / 9.806_65),
        "f (rpm),real (g/N),imag (g/N)\n",
        &[],
        false,
    );
}

#[test]
fn a_list_shows_what_an_import_will_use() {
    let folder = tempfile::tempdir().unwrap();
    let (file, table) = (folder.path().join("file.uff"), folder.path().join("table.csv"));
    fs::write(&file, Universal::default().text()).unwrap();
    fs::write(&table, "f (Hz),re (mm/N),im (mm/N)\n10,1,1\n20,1,1\n").unwrap();
    let output = Command::cargo_bin("jointid")
        .unwrap()
        .arg("import")
        .args([&file, &table])
        .arg("--list")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    for word in [
        "400 lines",
        "0.5…200 Hz",
        "1:+Z / 1:+Z",
        "accelerance",
        "m/s^2 / N",
        "averages",
        "2 lines",
        "10…20 Hz",
        "receptance",
    ] {
        assert!(text.contains(word), "«{word}» is not in: {text}");
    }
}

#[test]
fn a_set_is_replaced_on_request_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("set");
    let run = |name: &str, extra: &[&str]| {
        let path = folder.path().join(name);
        fs::write(&path, "f,re (m/N),im (m/N)\n10,1,1\n20,1,1\n").unwrap();
        Command::cargo_bin("jointid")
            .unwrap()
            .arg("import")
            .arg(path)
            .arg("--out")
            .arg(&out)
            .args(extra)
            .output()
            .unwrap()
    };
    assert!(run("a.csv", &[]).status.success());
    let again = run("b.csv", &[]);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8(again.stderr).unwrap().contains("--replace"));
    assert!(run("b.csv", &["--replace"]).status.success());
    assert!(out.join("frf/b.csv").exists() && !out.join("frf/a.csv").exists());
    assert_eq!(read_set(out.to_str().unwrap()).unwrap().frfs.len(), 1);
}

/// Replacing removes the tables that the manifest lists in `frf/` of the folder, and nothing else.
#[test]
fn replacing_a_set_removes_its_own_tables_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (out, outside) = (folder.path().join("set"), folder.path().join("outside.csv"));
    let import = |text: &str, extra: &[&str]| {
        let path = folder.path().join("new.csv");
        fs::write(&path, text).unwrap();
        Command::cargo_bin("jointid")
            .unwrap()
            .arg("import")
            .arg(path)
            .arg("--out")
            .arg(&out)
            .args(extra)
            .output()
            .unwrap()
    };
    let table = "f,re (m/N),im (m/N)\n10,1,1\n20,1,1\n";
    let kept = ["frf/own-notes.csv", "frf/deep/x.csv", "modes.csv", "frf/a.txt"];
    let listed = [
        "frf/old.csv",
        "frf/old.csv",
        "frf/../modes.csv",
        "../outside.csv",
        "frf/deep/x.csv",
        "/etc/hostname",
        "frf/a.txt",
        "frf/is-folder.csv",
        "frf/missing.csv",
    ];
    let prepare = || {
        fs::create_dir_all(out.join("frf/deep")).unwrap();
        fs::create_dir_all(out.join("frf/is-folder.csv")).unwrap();
        for name in kept.iter().chain(&["frf/old.csv"]) {
            fs::write(out.join(name), "x").unwrap();
        }
        fs::write(&outside, "x").unwrap();
        let entry = |name: &&str| format!("[[frf]]\nfile = \"{name}\"\n");
        fs::write(out.join("manifest.toml"), listed.iter().map(entry).collect::<String>()).unwrap();
    };
    let all_kept = || {
        kept.iter().all(|name| out.join(name).exists())
            && outside.exists()
            && out.join("frf/is-folder.csv").is_dir()
    };
    prepare();
    // A refused import leaves the old set as it is.
    for (text, extra) in
        [("f,re (bananas),im (bananas)\n10,1,1\n20,1,1\n", ["--replace"]), (table, ["--title=x"])]
    {
        assert_eq!(import(text, &extra).status.code(), Some(2));
        assert!(all_kept() && out.join("frf/old.csv").exists() && !out.join("frf/new.csv").exists());
    }
    let output = import(table, &["--replace"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("is-folder.csv"), "{said}");
    assert!(all_kept() && !out.join("frf/old.csv").exists() && out.join("frf/new.csv").exists());
    assert_eq!(read_set(out.to_str().unwrap()).unwrap().frfs.len(), 1);
    // A manifest that is no TOML lists nothing.
    prepare();
    fs::write(out.join("manifest.toml"), "no [ toml").unwrap();
    assert!(import(table, &["--replace"]).status.success());
    assert!(all_kept() && out.join("frf/old.csv").exists());
    // The name of an old table that the new set also has is its new content.
    assert!(import("f,re (m/N),im (m/N)\n10,7,1\n20,1,1\n", &["--replace"]).status.success());
    assert!(fs::read_to_string(out.join("frf/new.csv")).unwrap().contains('7'));
}

/// A link in place of the folder of tables is not followed when a set is replaced.
#[test]
#[cfg(unix)]
fn replacing_a_set_removes_nothing_behind_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (out, other) = (folder.path().join("set"), folder.path().join("other"));
    fs::create_dir_all(&out).unwrap();
    fs::create_dir_all(&other).unwrap();
    fs::write(other.join("old.csv"), "x").unwrap();
    fs::write(out.join("manifest.toml"), "[[frf]]\nfile = \"frf/old.csv\"\n").unwrap();
    std::os::unix::fs::symlink(&other, out.join("frf")).unwrap();
    let path = folder.path().join("new.csv");
    fs::write(&path, "f,re (m/N),im (m/N)\n10,1,1\n20,1,1\n").unwrap();
    let output = Command::cargo_bin("jointid")
        .unwrap()
        .arg("import")
        .arg(&path)
        .arg("--out")
        .arg(&out)
        .arg("--replace")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(other.join("old.csv").exists() && fs::read_dir(&other).unwrap().count() == 1);
}

/// Fields of asterisks that touch their neighbours cost their lines alone, in a file of real origin's
/// columns.
#[test]
fn limit_overflown_fields_cost_their_lines_alone() {
    let lines = |bad: &[usize]| {
        let text = Universal::default().text();
        let mut data = 0;
        let line = |line: &str| {
            let is_data = line.len() == 40 && line.contains('e');
            data += usize::from(is_data);
            match is_data && bad.contains(&data) {
                true => format!("{}{}\n", &line[..20], "*".repeat(20)),
                false => format!("{line}\n"),
            }
        };
        text.lines().map(line).collect::<String>()
    };
    let imported = import_text(&lines(&[7, 8, 400]), &[]);
    let set = imported.set.as_ref().unwrap_or_else(|| panic!("{}", imported.said));
    let frf = &set.frfs[0];
    assert_eq!(frf.lines.len() + frf.rejected.len(), 397, "{}", imported.said);
    for line in &frf.lines {
        let expected = truth(line.frequency_hz);
        assert!(
            (line.value - expected).norm() < 1e-9 * expected.norm(),
            "{} Hz: {}",
            line.frequency_hz,
            line.value
        );
    }
    assert_said(&imported, &["3 lines without a finite value are left out, at 3.5 Hz, 4 Hz, 200 Hz"]);
    assert!(import_text(&lines(&[7]), &["--strict"]).set.is_none());
}
