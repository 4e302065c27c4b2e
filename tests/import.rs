//! Import and export of FRFs in the formats of other programs.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use measurement::{Quantity, read_set};

fn jointid() -> Command {
    Command::cargo_bin("jointid").unwrap()
}

fn real_files() -> Option<PathBuf> {
    test_data::shared("realdata/uff")
}

/// Writes a set with two FRFs; its manifest begins with `more`.
fn small_set(folder: &Path, more: &str) {
    fs::write(
        folder.join("manifest.toml"),
        more.to_owned()
            + "title = \"small\"\nquantity = \"mobility\"\nresponse = \"table\"\nexcitation = \"table\"\n\
         [[position]]\nname = \"l1\"\nnut_m = 0.6\n[[frf]]\nposition = \"l1\"\nfile = \"a.csv\"\n[[frf]]\nposition = \"l1\"\nfile = \"b.csv\"\n",
    )
    .unwrap();
    fs::write(
        folder.join("a.csv"),
        "frequency_hz,real,imag\n10.0,1e-9,-2.5e-7\n11.0,1.25e-9,-2e-7\n12.5,3e-9,1e-8\n",
    )
    .unwrap();
    fs::write(folder.join("b.csv"), "frequency_hz,real,imag\n10.0,-1e-9,-2.5e-7\n11.0,-1.25e-9,-2e-7\n")
        .unwrap();
}

/// A window that a universal file cannot hold.
const WINDOW: &str = "exponential_window_s = 0.05\n";

#[test]
fn limit_export_and_import_give_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("set")).unwrap();
    small_set(&at("set"), "");
    fs::create_dir(at("windowed")).unwrap();
    small_set(&at("windowed"), WINDOW);
    for (binary, set, more) in [(false, "set", ""), (true, "set", ""), (true, "windowed", WINDOW)] {
        let file = &format!("{set}-{binary}.uff");
        let mut command = jointid();
        command.args(["export", "--measurements"]).arg(at(set)).arg("--out").arg(at(file));
        if binary {
            command.arg("--binary");
        }
        command.assert().success();
        let out = at(&format!("{file}-set"));
        jointid()
            .arg("import")
            .arg(at(file))
            .arg("--out")
            .arg(&out)
            .args([
                "--pattern",
                "position {}",
                "--nut-m",
                "l1=0.6",
                "--response",
                "table",
                "--excitation",
                "table",
            ])
            .assert()
            .success();
        let manifest = fs::read_to_string(out.join("manifest.toml")).unwrap();
        fs::write(out.join("manifest.toml"), more.to_owned() + &manifest).unwrap();
        let (original, imported) =
            (read_set(at(set).to_str().unwrap()).unwrap(), read_set(out.to_str().unwrap()).unwrap());
        assert_eq!(imported.positions, original.positions);
        assert_eq!(imported.frfs.len(), 2);
        for (a, b) in original.frfs.iter().zip(&imported.frfs) {
            assert_eq!((b.quantity, b.lines.len()), (Quantity::Mobility, a.lines.len()));
            for (x, y) in a.lines.iter().zip(&b.lines) {
                assert!((x.frequency_hz - y.frequency_hz).abs() < 1e-6);
                assert!((x.value - y.value).norm() <= 1e-11 * x.value.norm(), "{} {}", x.value, y.value);
            }
        }
    }
}

#[test]
fn published_beam_imports_with_its_quantity_and_a_warning_on_units() {
    let Some(folder) = real_files() else { return };
    let out = tempfile::tempdir().unwrap();
    let set = out.path().join("set");
    let output =
        jointid().arg("import").arg(folder.join("measurement.uff")).arg("--out").arg(&set).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("taken as SI"), "{stderr}");
    let set = read_set(set.to_str().unwrap()).unwrap();
    assert_eq!(set.frfs.len(), 3);
    assert!(
        set.frfs
            .iter()
            .all(|f| f.quantity == Quantity::Accelerance && f.position.is_none() && f.lines.len() == 1000)
    );
}

/// The program reads every real file or refuses it by name; it never crashes.
#[test]
fn every_real_file_is_read_or_refused() {
    let Some(folder) = real_files() else { return };
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let out = tempfile::tempdir().unwrap();
        let output =
            jointid().arg("import").arg(&path).arg("--out").arg(out.path().join("set")).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match output.status.code() {
            Some(0) => {}
            Some(2) => {
                assert!(stderr.contains(&name), "{stderr}");
                assert!(!out.path().join("set").exists(), "{name}: output of a refused import");
            }
            other => panic!("{name}: {other:?} {stderr}"),
        }
    }
}

#[test]
fn refuse_files_that_cannot_be_imported() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |text: &str, file: &str, extra: &[&str], expected: &str| {
        let path = folder.path().join(file);
        fs::write(&path, text).unwrap();
        let out = folder.path().join("set");
        let output = jointid().arg("import").arg(&path).arg("--out").arg(&out).args(extra).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(expected), "«{expected}» is not in: {stderr}");
        assert!(!out.exists());
    };
    let table = "frequency_hz,real,imag\n10,1,1\n";
    refuse(table, "a.csv", &[], "set the quantity");
    refuse(
        "frequency_hz,real,imag\n10,1,1\n9,1,1\n",
        "b.csv",
        &["--quantity", "receptance"],
        "does not follow",
    );
    refuse("frequency_hz,real,imag\n-1,1,1\n", "c.csv", &["--quantity", "receptance"], "0 or above");
    refuse(
        "frequency_hz,real,imag,coherence\n1,1,1,1.5\n",
        "d.csv",
        &["--quantity", "receptance", "--strict"],
        "between 0 and 1",
    );
    refuse("frequency_hz,real,imag\n1,NaN,1\n", "e.csv", &["--quantity", "receptance"], "line 2");
    refuse(table, "f.csv", &["--quantity", "receptance", "--nut-m", "l1"], "NAME=M");
    refuse(table, "g.csv", &["--quantity", "receptance", "--nut-m", "l9=0.5"], "l9");
    let twice = ["--quantity", "receptance", "--position", "l1", "--nut-m", "l1=0.6,l1=0.7"];
    refuse(table, "h.csv", &twice, "l1 is at 0.6 m already");
    let turned = ["--quantity", "receptance", "--columns", "frequency_hz,imag,real"];
    refuse("frequency_hz,real,imag\n1,1,1\n2,1,1\n", "i.csv", &turned, "«real» of the header is named imag");
    refuse("no universal file", "h.uff", &[], "h.uff");
    refuse("", "i.uff", &[], "i.uff");
}

/// A file from `export` is listed with its positions; noise that was only estimated is not missed in it.
#[test]
fn a_listed_file_shows_what_its_pattern_needs() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    small_set(folder.path(), "");
    let line = |n: u32| {
        let (hz, wiggle) = (f64::from(n), f64::from(n * 7919 % 101));
        format!("{hz},{},{}\n", 1e-9 * (1.0 + 1e-3 * wiggle), -1e-7 / hz)
    };
    let lines: String = (10..50).map(line).collect();
    fs::write(at("a.csv"), format!("frequency_hz,real,imag\n{lines}")).unwrap();
    assert!(read_set(&at("")).unwrap().frfs[0].lines[0].noise.is_some());
    let run = |arguments: &[&str]| {
        let output = jointid().args(arguments).output().unwrap();
        String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
    };
    let said = run(&["export", "--measurements", &at(""), "--out", &at("taps.uff")]);
    assert!(!said.contains("coherence"), "{said}");
    let list = run(&["import", &at("taps.uff"), "--list"]);
    assert_eq!(list.matches("«table / table»  «position l1»").count(), 2, "{list}");
    let import = |more: &[&str]| {
        let names = ["--response", "table", "--excitation", "table", "--nut-m", "l2=0.6"];
        run(&[&["import", &at("taps.uff"), "--out", &at("set")], &names[..], more].concat())
    };
    assert!(import(&[]).contains("no record has a position; use position, pattern or map"));
    assert!(
        import(&["--pattern", "position {}"]).contains("no record has a position of that name; there are l1")
    );
}
