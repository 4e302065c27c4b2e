//! Invalid input gives one clear message and exit code 2, and writes no files.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

const MANIFEST: &str = "measurements/tian/manifest.toml";
const MODES: &str = "measurements/tian/modes.csv";
const CONFIG: &str = "configs/tian.toml";

/// Asserts that the command fails with exit code 2, that its one-line message contains all of `expected`, and
/// that it does not create `out`.
fn refused(arguments: &[&str], expected: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output =
        Command::cargo_bin("jointid").unwrap().args(arguments).arg("--out").arg(&out).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty());
    for part in expected {
        assert!(message.contains(part), "{arguments:?}: «{part}» is not in: {message}");
    }
    assert_eq!(message.trim().lines().count(), 1, "{message}");
    assert!(!message.contains("Error {") && !message.contains("RUST_BACKTRACE"), "{message}");
    assert!(!out.exists(), "{arguments:?} created {}", out.display());
}

/// Copies the bench's set, with one replacement in one of its files.
fn set_with(file: &str, find: &str, put: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (path, name) in [
        (MANIFEST, "manifest.toml"),
        (MODES, "modes.csv"),
        ("measurements/tian/published.csv", "published.csv"),
    ] {
        let text = fs::read_to_string(path).unwrap();
        let text = if name == file {
            assert!(text.contains(find), "{find}");
            text.replacen(find, put, 1)
        } else {
            text
        };
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn refuse_set(file: &str, find: &str, put: &str, expected: &[&str]) {
    let folder = set_with(file, find, put);
    refused(&["identify", "--measurements", folder.path().to_str().unwrap()], expected);
}

fn refuse_config(find: &str, put: &str, expected: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(CONFIG).unwrap();
    assert!(text.contains(find), "{find}");
    let path = folder.path().join("machine.toml");
    fs::write(&path, text.replacen(find, put, 1)).unwrap();
    refused(&["identify", "--config", path.to_str().unwrap()], expected);
}

#[test]
fn refuse_keys_that_are_missing_or_unknown() {
    refuse_set(
        "manifest.toml",
        "quantity = \"mobility\"\n",
        "",
        &["manifest.toml", "quantity", "receptance, mobility, accelerance"],
    );
    refuse_set("manifest.toml", "title = ", "titel = ", &["manifest.toml", "line", "titel"]);
    refuse_set("manifest.toml", "response = \"table\"", "response = \"tabel\"", &["tabel", "table"]);
    refuse_set(
        "manifest.toml",
        "\"mobility\"",
        "\"mobilty\"",
        &["manifest.toml, line", "mobilty", "accelerance"],
    );
    refuse_config("title = ", "titel = ", &["machine.toml, line", "titel"]);
    refuse_config("lower = 5e6\n", "", &["machine.toml, line", "lower"]);
    refuse_config(
        "stiffness = \"k_al\"",
        "stiffness = \"k_la\"",
        &["joint.bearing-left.stiffness", "k_la", "k_al"],
    );
    refuse_config(
        "between = [\"left\", \"ground\"]",
        "between = [\"lft\", \"ground\"]",
        &["joint.bearing-left", "lft", "left"],
    );
    refuse_config("effects = [\"rotor-hold\"]", "effects = [\"rotor-hlod\"]", &["rotor-hlod", "rotor-hold"]);
}

#[test]
fn refuse_numbers_that_make_no_sense() {
    refuse_config("length_m = 2.6", "length_m = -2.6", &["shaft.screw.length_m", "-2.6", "above 0"]);
    refuse_config("mass_kg = 272.0", "mass_kg = 0.0", &["point.table.mass_kg", "0"]);
    refuse_config("mass_kg = 272.0", "mass_kg = nan", &["point.table.mass_kg", "NaN"]);
    refuse_config("upper = 5e8", "upper = 5e6", &["parameter.k_al.lower", "lower < upper"]);
    refuse_config("start = 5e7", "start = 5e9", &["parameter.k_al.start", "outside"]);
    refuse_set("manifest.toml", "nut_m = 0.6", "nut_m = 2.6", &["l1", "outside the screw", "2.6"]);
    refuse_set("manifest.toml", "nut_m = 0.6", "nut_m = -0.6", &["l1", "outside the screw"]);
    refuse_set(
        "manifest.toml",
        "frequency_resolution_hz = 1.0",
        "frequency_resolution_hz = -1.0",
        &["frequency_resolution_hz", "-1"],
    );
    refuse_set(
        "manifest.toml",
        "least_prominence = 1.25",
        "least_prominence = 0.8",
        &["least_prominence", "0.8", "above 1"],
    );
    refused(&["identify", "--amplitude-sd", "0"], &["--amplitude-sd", "above 0"]);
}

#[test]
fn refuse_cells_that_are_no_numbers() {
    refuse_set("modes.csv", "l1,1,24,", "l1,1,NaN,", &["modes.csv, line 2", "frequency_hz", "NaN"]);
    refuse_set("modes.csv", "l1,2,118,", "l1,2,about 118,", &["modes.csv, line 3", "about 118"]);
    refuse_set("modes.csv", "l1,2,118,", "l1,2,-118,", &["modes.csv, line 3", "above 0"]);
    refuse_set("modes.csv", "l1,2,118,", "l1,2,118,2,", &["modes.csv, line 3", "cells"]);
    refuse_set("modes.csv", "l1,1,24,", "l9,1,24,", &["modes.csv, line 2", "l9", "l1, l2"]);
    refuse_set("modes.csv", "l1,2,118,", "l1,1,118,", &["modes.csv, line 3", "twice"]);
    for bad in ["0", "-0.1", "NaN", "wide", "30"] {
        let put = format!("amplitude,frequency_sd_hz\nl1,1,24,2.44e-4,{bad}\n");
        let expected = ["modes.csv, line 2", "frequency_sd_hz", bad, "write"];
        refuse_set("modes.csv", "amplitude\nl1,1,24,2.44e-4\n", &put, &expected);
    }
    refuse_set(
        "modes.csv",
        "position,order,frequency_hz",
        "position,order,frequency",
        &["modes.csv, line 1", "frequency"],
    );
}

#[test]
fn refuse_unknown_positions() {
    refused(&["identify", "--positions", "l1,l7"], &["l7", "l1, l2, l3, l4, l5, l6"]);
    refused(&["identify", "--positions", "l1,l1"], &["l1", "twice"]);
    refuse_set("manifest.toml", "name = \"l2\"", "name = \"l1\"", &["manifest.toml", "l1", "twice"]);
    refuse_set(
        "manifest.toml",
        "fit = [\"l1\", \"l3\", \"l5\"]",
        "fit = [\"l1\", \"l8\"]",
        &["split.fit", "l8"],
    );
    refused(&["compare", "--single", "l0"], &["l0", "l1"]);
}

#[test]
fn refuse_sets_without_observations() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("manifest.toml"), "title = \"nothing\"\n").unwrap();
    refused(&["identify", "--measurements", at.to_str().unwrap()], &["manifest.toml", "no observation"]);
    let empty = "position,order,frequency_hz,amplitude\nl1,1,,\n";
    let text = fs::read_to_string(MANIFEST).unwrap();
    fs::write(at.join("manifest.toml"), text).unwrap();
    fs::write(at.join("modes.csv"), empty).unwrap();
    fs::copy("measurements/tian/published.csv", at.join("published.csv")).unwrap();
    refused(&["identify", "--measurements", at.to_str().unwrap()], &["modes.csv", "no observation"]);
}

#[test]
fn refuse_files_that_are_empty_or_folders_or_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("machine.toml");
    fs::write(&path, "").unwrap();
    refused(&["identify", "--config", path.to_str().unwrap()], &["machine.toml", "is empty"]);
    refused(&["identify", "--config", folder.path().to_str().unwrap()], &["is a folder"]);
    refused(&["identify", "--config", "nowhere.toml"], &["nowhere.toml", "no such file"]);
    refused(&["identify", "--measurements", "nowhere"], &["nowhere", "no such folder"]);
    refused(&["identify", "--measurements", path.to_str().unwrap()], &["is a file"]);
    fs::write(folder.path().join("manifest.toml"), "").unwrap();
    refused(&["identify", "--measurements", folder.path().to_str().unwrap()], &["manifest.toml", "is empty"]);
    fs::write(folder.path().join("manifest.toml"), [0xff, 0xfe, 0x00]).unwrap();
    refused(&["identify", "--measurements", folder.path().to_str().unwrap()], &["manifest.toml", "UTF-8"]);
    refused(&["validate", "--result", "nowhere.json"], &["nowhere.json", "identify"]);
}

#[test]
fn refuse_invalid_overrides() {
    refused(&["identify", "--set", "parameter.k_x.start=3"], &["--set parameter.k_x.start=3", "k_x", "k_al"]);
    refused(&["identify", "--set", "point.table.mass_kg"], &["--set", "key.path=value"]);
    refused(&["identify", "--set", "point.table.mass=3"], &["--set", "mass"]);
    refused(
        &["identify", "--set", "parameter.table_mass_change.start=0.1"],
        &["table_mass_change", "table-mass", "effects"],
    );
    let contained = r#"effects=["drive-flexibility"]"#;
    refused(
        &["identify", "--set", contained, "--set", "parameter.k_drive.start=1e4"],
        &["k_drive", "unit", "declare it"],
    );
    refused(
        &["identify", "--without", "backlash"],
        &["--without backlash: ", "configs/tian.toml", "rotor-hold"],
    );
    refused(&["identify", "--freeze", "k_x"], &["--freeze k_x: ", "k_al"]);
}

#[test]
fn refuse_a_folder_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("results");
    fs::write(&file, "mine").unwrap();
    for out in [file.clone(), file.join("below")] {
        let output =
            Command::cargo_bin("jointid").unwrap().args(["identify", "--out"]).arg(&out).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains("is a file") || message.contains("Not a directory"), "{message}");
    }
    assert_eq!(fs::read_to_string(Path::new(&file)).unwrap(), "mine");
}

#[test]
fn refuse_machines_without_an_equation_of_motion() {
    let damper = "[[point]]\nname = \"acc\"\nmotion = \"translation\"\n\n[[joint]]\nname = \"acc\"\nbetween = [\"table\", \"acc\"]\ndamping = 10.0\n\n[[shaft]]";
    refuse_config("[[shaft]]", damper, &["point.acc.mass_kg", "nor a joint with a stiffness"]);
    let station = "    { at_m = 1.8 },\n    { at = \"end\"";
    refuse_config("    { at = \"end\"", station, &["l6", "does not keep the order of the stations"]);
    refused(
        &["identify", "--set", "joint.nut.relaxation_stiffness=0"],
        &["joint.nut.relaxation_stiffness", "above 0"],
    );
    refused(&["identify", "--set", "parameter.k_al.lower=-5e8"], &["joint.bearing-left.stiffness", "k_al"]);
}

#[test]
fn refuse_implausible_frequencies_and_grids() {
    refuse_set("modes.csv", "l1,4,716,", "l1,4,716e6,", &["modes.csv, line 5", "716000000"]);
    refused(&["simulate", "frf", "--step-hz", "1e-300"], &["--step-hz", "more than a million"]);
    refused(&["compare", "--single", "multi"], &["multi"]);
}

/// A user's mistake.
enum Mistake {
    /// In a file of the bench's measurement set: file, text to find, replacement.
    Set(&'static str, &'static str, &'static str),
    /// In the bench's configuration: text to find, replacement.
    Machine(&'static str, &'static str),
    /// In the command. `$` stands for a new folder that holds the given files: name, text.
    Command(&'static [&'static str], &'static [(&'static str, &'static str)]),
}

use Mistake::{Command as Typed, Machine, Set};

const FRF: &str = "title = \"x\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n[[position]]\nname = \"l1\"\nnut_m = 0.6\n[[frf]]\nposition = \"l1\"\nfile = \"l1.csv\"\n";
const BRAKE: &str = "[[effect]]\nid = \"brake\"\ndescription = \"the brake grips\"\n[[effect.joint]]\nname = \"brake\"\nbetween = [\"rotr\", \"ground\"]\nstiffness = 1e4\n\n[[joint]]";
const HEADED: &str = "frequency_hz,real,imag\n";

/// The most likely mistakes in describing, measuring and identifying a machine, in the order of work.
const MISTAKES: [(&str, Mistake); 42] = [
    ("`init` in a folder with a machine", Typed(&["init", "$"], &[("machine.toml", "mine")])),
    ("a `nan` left in the machine", Machine("mass_kg = 272.0", "mass_kg = nan")),
    ("several numbers left `nan`", Machine("mass_kg = 272.0", "mass_kg = nan\ninertia_kg_m2 = nan")),
    ("a modulus in GPa", Machine("youngs_modulus_pa = 2e11", "youngs_modulus_pa = 200.0")),
    ("a length beyond physics", Machine("length_m = 2.6", "length_m = 1e18")),
    ("a decimal comma", Machine("mass_kg = 272.0", "mass_kg = 272,0")),
    ("a key is misspelt", Machine("length_m = 2.6", "lenght_m = 2.6")),
    ("a key is missing", Machine("lower = 5e6\n", "")),
    ("a mass of zero", Machine("mass_kg = 272.0", "mass_kg = 0.0")),
    ("a joint with an unknown parameter", Machine("stiffness = \"k_al\"", "stiffness = \"k_la\"")),
    (
        "a joint at an unknown point",
        Machine("between = [\"left\", \"ground\"]", "between = [\"lft\", \"ground\"]"),
    ),
    ("an effect is misspelt", Machine("effects = [\"rotor-hold\"]", "effects = [\"rotor-hlod\"]")),
    ("an own effect at an unknown point", Machine("[[joint]]", BRAKE)),
    ("an empty range", Machine("upper = 5e8", "upper = 5e6")),
    ("a start value outside the range", Machine("start = 5e7", "start = 5e9")),
    ("the nut's position in mm", Set("manifest.toml", "nut_m = 0.6", "nut_m = 600")),
    ("the nut's position is not filled in", Set("manifest.toml", "nut_m = 0.6", "nut_m = nan")),
    (
        "a file outside the set's folder",
        Set("manifest.toml", "modes = \"modes.csv\"", "modes = \"../modes.csv\""),
    ),
    ("no quantity", Set("manifest.toml", "quantity = \"mobility\"\n", "")),
    ("an unknown quantity", Set("manifest.toml", "\"mobility\"", "\"velocity\"")),
    (
        "an accelerometer at an unknown point",
        Set("manifest.toml", "response = \"table\"", "response = \"spindle\""),
    ),
    ("a position twice", Set("manifest.toml", "name = \"l2\"", "name = \"l1\"")),
    (
        "a split with an unknown position",
        Set("manifest.toml", "fit = [\"l1\", \"l3\", \"l5\"]", "fit = [\"l1\", \"l8\"]"),
    ),
    ("a decimal comma in a table", Set("modes.csv", "l1,2,118,", "l1,2,118,2,")),
    ("a cell without a number", Set("modes.csv", "l1,2,118,", "l1,2,about 118,")),
    ("a mode twice", Set("modes.csv", "l1,2,118,", "l1,1,118,")),
    ("a position missing in the manifest", Set("modes.csv", "l1,1,24,", "p1,1,24,")),
    ("an unknown column", Set("modes.csv", "position,order,frequency_hz", "position,order,frequency")),
    (
        "no mode filled in",
        Typed(&["identify", "--measurements", "$"], &[("manifest.toml", "title = \"x\"\n")]),
    ),
    ("a missing FRF file", Typed(&["identify", "--measurements", "$"], &[("manifest.toml", FRF)])),
    (
        "FRFs without numbers",
        Typed(&["identify", "--measurements", "$"], &[("manifest.toml", FRF), ("l1.csv", HEADED)]),
    ),
    (
        "a table imported without its quantity",
        Typed(
            &["import", "$/tap.csv", "--out", "$/set"],
            &[("tap.csv", "frequency_hz,real,imag\n10,1e-8,0\n11,1e-8,0\n")],
        ),
    ),
    (
        "commas between columns and in numbers",
        Typed(
            &["import", "$/tap.csv", "--quantity", "receptance", "--out", "$/set"],
            &[("tap.csv", "frequency_hz,real,imag\n10,0,1e-8,0\n11,0,1e-8,0\n")],
        ),
    ),
    (
        "the manifest instead of its folder",
        Typed(&["identify", "--measurements", "$/manifest.toml"], &[("manifest.toml", FRF)]),
    ),
    ("a device instead of a file", Typed(&["identify", "--config", "/dev/zero"], &[])),
    ("a missing file", Typed(&["identify", "--config", "nowhere.toml"], &[])),
    ("`--positions` of another set", Typed(&["identify", "--positions", "p1,p2"], &[])),
    ("`--freeze` of an unknown parameter", Typed(&["identify", "--freeze", "k_nut"], &[])),
    ("`--set` of an unknown key", Typed(&["identify", "--set", "point.table.mass=300"], &[])),
    ("`validate` before `identify`", Typed(&["validate", "--result", "$/identification.json"], &[])),
    ("a diagnosis at one position", Typed(&["diagnose", "--positions", "l1"], &[])),
    ("a report of an empty folder", Typed(&["report", "$"], &[])),
];

/// Returns the message that a mistake gives, without the path of the test's folder.
fn message(mistake: &Mistake) -> String {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().to_str().unwrap();
    let arguments: Vec<String> = match mistake {
        Set(file, find, put) => {
            let set = set_with(file, find, put);
            for entry in fs::read_dir(set.path()).unwrap() {
                let path = entry.unwrap().path();
                fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
            }
            ["identify", "--measurements", at].map(String::from).to_vec()
        }
        Machine(find, put) => {
            let text = fs::read_to_string(CONFIG).unwrap();
            assert!(text.contains(find), "{find}");
            fs::write(folder.path().join("machine.toml"), text.replacen(find, put, 1)).unwrap();
            ["identify", "--config", &format!("{at}/machine.toml")].map(String::from).to_vec()
        }
        Typed(words, files) => {
            files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
            words.iter().map(|w| w.replace('$', at)).collect()
        }
    };
    let before = fs::read_dir(folder.path()).unwrap().count();
    let output = Command::cargo_bin("jointid").unwrap().args(&arguments).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(text.trim().lines().count(), 1, "{arguments:?}: {text}");
    for form in ["Error {", "Err(", "Some(", "RUST_BACKTRACE", "panicked", "Os {", "{:?}"] {
        assert!(!text.contains(form), "{arguments:?}: {text}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), before, "{arguments:?} wrote files");
    text.trim().replace(&format!("{at}/"), "").replace(at, "axis")
}

/// The table of mistakes in the guide holds the program's messages.
#[test]
fn the_most_likely_mistakes_and_their_messages() {
    let mut page = String::from(
        "# Mistakes and their messages\n\n\
         The most likely mistakes, in the order of work, each with its message. A message is one line; it names the file, line or key, what was\n\
         found there and what to write instead. The exit code is 2, and no file is written. The tests generate this table.\n\n\
         | mistake | message |\n|---|---|\n",
    );
    for (label, mistake) in &MISTAKES {
        // Long messages are cut, so that the table does not change with each effect of the library.
        let text = message(mistake);
        let cut: String = if text.chars().count() > 220 {
            text.chars().take(200).chain([' ', '…']).collect()
        } else {
            text
        };
        page += &format!("| {label} | `` {} `` |\n", cut.replace('|', "\\|"));
    }
    let path = "src/guide/mistakes.md";
    if fs::read_to_string(path).unwrap_or_default() != page {
        let expected = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mistakes.md");
        fs::write(&expected, page).unwrap();
        panic!("{path} differs from the program's messages; the present table is in {}", expected.display());
    }
}
