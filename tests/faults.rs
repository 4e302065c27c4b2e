//! Faults of the program's environment: full disks, read-only folders, changing files, concurrent runs, other
//! systems' text files, large data. No file is lost or written in part, one message states the cause, and the
//! exit code is 2.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use file_access::{MOST_STREAM_BYTES, ReadFault, read_unchanged};
use measurement::{Quantity, read_set};
use universal_files::read_where;

fn jointid() -> Command {
    Command::new(env!("CARGO_BIN_EXE_jointid"))
}

/// Returns a shell command in which `$0` is the program.
fn shell(script: &str) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_jointid")]);
    command
}

/// Asserts one line on stderr that contains `parts`, and exit code 2.
fn assert_refused(output: &Output, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.trim().lines().count(), 1, "{message}");
    assert!(message.starts_with("jointid: ") && !message.contains("panicked"), "{message}");
    parts.iter().for_each(|part| assert!(message.contains(part), "«{part}» is not in: {message}"));
}

/// Asserts success and returns stdout.
fn successful(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Returns the names of all files and folders below a folder, including hidden ones.
fn names(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        found.push(path.file_name().unwrap().to_string_lossy().into_owned());
        if path.is_dir() {
            found.extend(names(&path));
        }
    }
    found.sort();
    found
}

/// Runs a script in its own mount namespace. Where that is not possible, reports the test as skipped and
/// returns `None`.
fn in_mount_namespace(script: &str, folder: &Path) -> Option<Output> {
    let mut command = Command::new("unshare");
    let script = format!("{script} || exit 99");
    let output =
        command.args(["--mount", "sh", "-c", &script, env!("CARGO_BIN_EXE_jointid")]).arg(folder).output();
    match output {
        Ok(output) if output.status.code() != Some(99) && output.status.code() != Some(1) => Some(output),
        _ => {
            test_data::skipped("no mount namespace available");
            None
        }
    }
}

/// Writes a universal file of `count` FRFs of `lines` lines each, with `position NAME` in their headers.
fn universal_file(path: &Path, count: usize, lines: usize) {
    let mut text = String::new();
    for at in 0..count {
        text += &format!("    -1\n    58\ntap\nNONE\nNONE\nposition p{at}\nNONE\n");
        text += "    4         0    0         0 table              1   1 table              1   1\n";
        text +=
            &format!("         6{lines:>10}         1{:>13}{:>13}{:>13}\n", "1.0E+00", "1.0E+00", "0.0E+00");
        for (kind, label, unit) in
            [(18, "Frequency", "Hz"), (8, "Displacement", "m"), (13, "Force", "N"), (0, "NONE", "NONE")]
        {
            text += &format!("{kind:>10}    0    0    0 {label:<20} {unit:<20}\n");
        }
        for line in 0..lines {
            text += &format!("  {:.12E} -{:.12E}\n", 1.0 / (1.0 + line as f64), 0.5 / (1.0 + at as f64));
        }
        text += "    -1\n";
    }
    fs::write(path, text).unwrap();
}

/// Writes a set of one position with one FRF.
fn small_set(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let manifest = "title = \"x\"\nquantity = \"mobility\"\nresponse = \"table\"\nexcitation = \"table\"\n[[position]]\nname = \"l1\"\nnut_m = 0.6\n\
                    [[frf]]\nposition = \"l1\"\nfile = \"a.csv\"\n";
    fs::write(folder.join("manifest.toml"), manifest).unwrap();
    fs::write(
        folder.join("a.csv"),
        "frequency_hz,real,imag\n10.0,1e-9,-2.5e-7\n11.0,1.25e-9,-2e-7\n12.5,3e-9,1e-8\n",
    )
    .unwrap();
}

#[test]
fn refuse_a_full_stdout() {
    if !Path::new("/dev/full").exists() {
        test_data::skipped("no /dev/full");
        return;
    }
    for words in ["simulate modes --json", "schema machine", "completions bash"] {
        assert_refused(
            &shell(&format!("exec \"$0\" {words} > /dev/full")).output().unwrap(),
            &["stdout", "cannot be written"],
        );
    }
}

/// A file size limit of 4 kB simulates a full disk: earlier results stay, new ones are complete or absent.
#[test]
fn refuse_a_full_disk_and_keep_earlier_results() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("out")).unwrap();
    let earlier = "{\n  \"schema\": \"jointid/frf/1\", …";
    fs::write(at("out").join("frf.json"), earlier).unwrap();
    universal_file(&at("taps.uff"), 3, 2000);
    for words in [
        "simulate frf --position l1 --quiet --out out",
        "import taps.uff --out set",
        "man --out pages",
        "simulate motion --config servo-axis.toml --reference s-curve --travel-m 0.1 --quiet --out moved",
    ] {
        fs::copy("configs/servo-axis.toml", at("servo-axis.toml")).unwrap();
        let output =
            shell(&format!("ulimit -f 8; exec \"$0\" {words}")).current_dir(folder.path()).output().unwrap();
        assert_refused(&output, &["cannot be written"]);
        assert_eq!(names(folder.path()), ["frf.json", "out", "servo-axis.toml", "taps.uff"], "{words}");
        assert_eq!(fs::read_to_string(at("out").join("frf.json")).unwrap(), earlier);
    }
}

#[test]
fn refuse_a_full_file_system() {
    let folder = tempfile::tempdir().unwrap();
    universal_file(&folder.path().join("taps.uff"), 3, 2000);
    let full = "cd \"$1\" && mkdir full && mount -t tmpfs -o size=64k none full";
    let Some(output) = in_mount_namespace(
        &format!("{full} && {{ \"$0\" import taps.uff --out full/set; code=$?; ls -A full; exit $code; }}"),
        folder.path(),
    ) else {
        return;
    };
    assert_refused(&output, &["full/set", "cannot be written", "No space left"]);
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "the folder is not empty");
}

#[test]
fn refuse_a_file_system_that_is_read_only() {
    let folder = tempfile::tempdir().unwrap();
    let locked = "cd \"$1\" && mkdir out && mount --bind out out && mount -o remount,ro,bind out";
    let Some(output) = in_mount_namespace(
        &format!("{locked} && {{ \"$0\" simulate modes --out out; exit $?; }}"),
        folder.path(),
    ) else {
        return;
    };
    assert_refused(&output, &["out", "ead-only"]);
    assert!(output.stdout.is_empty(), "results precede the check of the folder");
    // Folders that nobody can write to, whatever their permissions.
    if Path::new("/proc/self").exists() {
        assert_refused(
            &jointid().args(["simulate", "modes", "--out", "/proc/jointid"]).output().unwrap(),
            &["/proc"],
        );
    }
}

/// A folder exists under the name of an output file: no file is written.
#[test]
fn refuse_a_folder_in_the_place_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir_all(out.join("modes.json")).unwrap();
    let output = jointid().args(["simulate", "modes", "--quiet", "--out"]).arg(&out).output().unwrap();
    assert_refused(&output, &["modes.json", "is a folder"]);
    assert_eq!(names(folder.path()), ["modes.json", "out"]);
}

/// The second of two runs into one folder is refused with the process id of the first. The lock of a killed
/// run does not block others.
#[test]
fn refuse_a_second_run_into_the_same_folder() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/out");
    let mut first = jointid();
    first
        .args(["identify", "--repeats", "50", "--quiet", "--out"])
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut first = first.spawn().unwrap();
    let begun = Instant::now();
    let held = || fs::read_to_string(out.join(".jointid-lock")).is_ok_and(|text| text.starts_with("process"));
    while !held() {
        assert!(
            begun.elapsed() < Duration::from_secs(60) && first.try_wait().unwrap().is_none(),
            "the first run takes no lock"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    let second = || jointid().args(["simulate", "modes", "--quiet", "--out"]).arg(&out).output().unwrap();
    assert_refused(&second(), &["another run", &format!("process {}", first.id()), "name another folder"]);
    assert!(
        names(&out).iter().all(|name| [".jointid-lock", "unfinished.jsonl"].contains(&name.as_str())),
        "{:?}",
        names(&out)
    );
    first.kill().unwrap();
    first.wait().unwrap();
    successful(&second());
    let left: Vec<String> = names(&out).into_iter().filter(|name| name != "unfinished.jsonl").collect();
    assert_eq!(left, ["modes.json"], "the lock outlives its run");
}

/// Twenty concurrent runs: some succeed, the others are refused, every document is complete.
#[test]
fn limit_concurrent_runs_into_one_folder_leave_it_consistent() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let runs: Vec<_> = (0..20)
        .map(|_| {
            let mut run = jointid();
            run.args(["simulate", "modes", "--quiet", "--out"])
                .arg(&out)
                .stdout(Stdio::null())
                .stderr(Stdio::piped());
            run.spawn().unwrap()
        })
        .collect();
    let outputs: Vec<Output> = runs.into_iter().map(|r| r.wait_with_output().unwrap()).collect();
    let (good, bad): (Vec<&Output>, Vec<&Output>) = outputs.iter().partition(|o| o.status.success());
    assert!(!good.is_empty());
    bad.iter().for_each(|output| assert_refused(output, &["another run"]));
    assert_eq!(names(&out), ["modes.json"]);
    let document: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("modes.json")).unwrap()).unwrap();
    assert_eq!(document["complete"], true);
}

/// A universal file that another program is still writing is refused. A measured file that changed after the
/// identification gives a warning, a missing one an error.
#[test]
fn refuse_files_that_change_while_read_and_warn_of_later_changes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    universal_file(&at("taps.uff"), 2, 5);
    assert_eq!(read_where(fs::File::open(at("taps.uff")).unwrap(), |_| true).unwrap().functions.len(), 2);
    let growing = read_unchanged(&at("taps.uff"), MOST_STREAM_BYTES, |input| {
        read_where(input, |_| {
            fs::OpenOptions::new().append(true).open(at("taps.uff")).unwrap().write_all(b"    -1\n").unwrap();
            true
        })
    });
    assert!(matches!(growing, Err(ReadFault::Changed)), "{growing:?}");

    fs::create_dir(at("set")).unwrap();
    for file in ["manifest.toml", "modes.csv", "published.csv"] {
        fs::copy(Path::new("measurements/tian").join(file), at("set").join(file)).unwrap();
    }
    let run = |words: &[&str]| jointid().current_dir(folder.path()).args(words).output().unwrap();
    successful(&run(&[
        "identify",
        "--measurements",
        "set",
        "--positions",
        "l1,l3,l5",
        "--repeats",
        "1",
        "--quiet",
        "--out",
        "out",
    ]));
    let validate = ["validate", "--result", "out/identification.json", "--positions", "l2"];
    assert!(!String::from_utf8_lossy(&run(&validate).stderr).contains("has changed"));
    let modes = fs::read_to_string(at("set/modes.csv")).unwrap();
    fs::write(at("set/modes.csv"), modes.replace("l2,1,24,", "l2,1,25,")).unwrap();
    let changed = run(&validate);
    successful(&changed);
    let warning = String::from_utf8_lossy(&changed.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(warning.contains("modes.csv has changed since the identification"), "{warning}");
    fs::remove_file(at("set/modes.csv")).unwrap();
    assert_refused(&run(&validate), &["modes.csv", "no such file"]);
    // A result whose settings ask for more memory than available.
    let result = fs::read_to_string(at("out/identification.json")).unwrap();
    assert!(result.contains("\"lumps\": null"));
    fs::write(at("out/identification.json"), result.replace("\"lumps\": null", "\"lumps\": 1000000000000"))
        .unwrap();
    assert_refused(&run(&validate), &["identification.json", "was changed after it was written"]);
}

/// A locale with decimal commas changes nothing.
#[test]
fn limit_the_locale_changes_nothing() {
    let run = |words: &[&str], locale: &str| {
        let mut command = jointid();
        command.args(words).env("LC_ALL", locale).env("LANG", locale).env("LC_NUMERIC", locale);
        successful(&command.output().unwrap())
    };
    for words in
        [&["simulate", "modes", "--position", "l1"][..], &["simulate", "frf", "--position", "l1", "--json"]]
    {
        assert_eq!(run(words, "de_DE.UTF-8"), run(words, "C"), "{words:?}");
    }
}

#[test]
fn refuse_decimal_commas_in_every_table() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    small_set(&at("set"));
    let peaks = |text: &str, parts: &[&str]| {
        fs::write(at("set/a.csv"), text).unwrap();
        assert_refused(&jointid().args(["peaks", "--measurements"]).arg(at("set")).output().unwrap(), parts);
    };
    peaks("frequency_hz;real;imag\n10,5;1e-9;-2e-7\n", &["a.csv, line 1", "semicolons", "commas"]);
    peaks("frequency_hz\treal\timag\n10,5\t1e-9\t-2e-7\n", &["a.csv, line 1", "tabs"]);
    peaks("frequency_hz,real,imag\n10,5,1e-9,-2e-7\n", &["a.csv, line 2", "decimal commas"]);
    peaks("frequency_hz,real,imag\n\"10,5\",1e-9,-2e-7\n", &["a.csv, line 2", "10,5", "point"]);
    fs::write(at("runs.csv"), "velocity_m_s;force_n\n0,1;12,5\n").unwrap();
    assert_refused(
        &jointid().args(["friction", "--data"]).arg(at("runs.csv")).output().unwrap(),
        &["runs.csv, line 1", "semicolons"],
    );
}

#[test]
fn import_reads_decimal_commas_that_are_no_separators() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let import = |text: &str, out: &str| {
        fs::write(at("tap.csv"), text).unwrap();
        jointid()
            .args(["import", "--quantity", "receptance"])
            .arg(at("tap.csv"))
            .arg("--out")
            .arg(at(out))
            .output()
            .unwrap()
    };
    assert!(import("f;re;im\n1,5;1;1\n", "new").status.success());
    assert!(fs::read_to_string(at("new/frf/tap.csv")).unwrap().contains("\n1.5,1e0,1e0"));
    // Commas between cells and in numbers cannot be told apart.
    assert_refused(&import("f,re,im\n1,5,1,1\n2,5,1,1\n", "other"), &["tap.csv", "names"]);
}

/// Paths with blanks and letters of other scripts give the same numbers.
#[test]
fn limit_paths_may_hold_blanks_and_any_letter() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("Prüfstand 2 – Achse «X»/測定 #1");
    fs::create_dir_all(&place).unwrap();
    let (machine, set, out) =
        (place.join("Maschine ä.toml"), place.join("Messung é"), place.join("Ergebnis 'a b'"));
    fs::copy("configs/tian.toml", &machine).unwrap();
    small_set(&set);
    let expected = successful(&jointid().args(["simulate", "modes", "--position", "l1"]).output().unwrap());
    let odd = jointid()
        .args(["simulate", "modes", "--position", "l1", "--config"])
        .arg(&machine)
        .arg("--measurements")
        .arg(&set)
        .output()
        .unwrap();
    assert_eq!(successful(&odd), expected);
    let file = place.join("Übertragung 1.uff");
    successful(
        &jointid().args(["export", "--measurements"]).arg(&set).arg("--out").arg(&file).output().unwrap(),
    );
    successful(
        &jointid()
            .arg("import")
            .arg(&file)
            .args(["--position", "Lage ü 1", "--nut-m", "Lage ü 1=0.6", "--out"])
            .arg(&out)
            .output()
            .unwrap(),
    );
    let read = read_set(out.to_str().unwrap()).unwrap();
    assert_eq!((read.positions[0].name.as_str(), read.frfs[0].lines.len()), ("Lage ü 1", 3));
}

/// Line ends of other systems and byte order marks do not change what is read.
#[test]
fn limit_line_ends_and_byte_order_marks_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let foreign = |from: &Path, to: &Path| {
        let text = fs::read_to_string(from).unwrap().replace('\n', "\r\n");
        fs::write(to, format!("\u{feff}{text}")).unwrap();
    };
    foreign(Path::new("configs/tian.toml"), &at("machine.toml"));
    fs::create_dir(at("set")).unwrap();
    for file in ["manifest.toml", "modes.csv", "published.csv"] {
        foreign(&Path::new("measurements/tian").join(file), &at("set").join(file));
    }
    let expected = successful(&jointid().args(["simulate", "modes", "--position", "l1"]).output().unwrap());
    let mut run = jointid();
    run.args(["simulate", "modes", "--position", "l1", "--config"])
        .arg(at("machine.toml"))
        .arg("--measurements")
        .arg(at("set"));
    assert_eq!(successful(&run.output().unwrap()), expected);
    let (ours, theirs) =
        (read_set("measurements/tian").unwrap(), read_set(at("set").to_str().unwrap()).unwrap());
    assert_eq!(
        (&ours.modes, &ours.positions, &ours.published),
        (&theirs.modes, &theirs.positions, &theirs.published)
    );

    universal_file(&at("plain.uff"), 2, 5);
    foreign(&at("plain.uff"), &at("foreign.uff"));
    fs::write(at("plain.csv"), "freq [Hz];real (mm/N);imag (mm/N)\n10;1;2\n11;1;3\n").unwrap();
    foreign(&at("plain.csv"), &at("foreign.csv"));
    for kind in ["uff", "csv"] {
        let lines = |name: &str| {
            let out = at(&format!("{name}-{kind}"));
            let file = at(&format!("{name}.{kind}"));
            successful(
                &jointid()
                    .arg("import")
                    .arg(file)
                    .args(["--quantity", "receptance", "--out"])
                    .arg(&out)
                    .output()
                    .unwrap(),
            );
            read_set(out.to_str().unwrap()).unwrap().frfs.into_iter().map(|f| f.lines).collect::<Vec<_>>()
        };
        assert_eq!(lines("plain"), lines("foreign"), "{kind}");
    }
}

#[test]
fn limit_a_thousand_positions() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    universal_file(&at("taps.uff"), 1000, 20);
    let import = jointid()
        .arg("import")
        .arg(at("taps.uff"))
        .args(["--pattern", "position {}", "--quiet", "--out"])
        .arg(at("set"))
        .output()
        .unwrap();
    assert!(successful(&import).contains("1000 FRFs imported"));
    let set = read_set(at("set").to_str().unwrap()).unwrap();
    assert_eq!((set.positions.len(), set.frfs.len()), (1000, 1000));
    assert_eq!((set.frfs[999].position, set.frfs[999].quantity), (Some(999), Quantity::Receptance));
    successful(
        &jointid()
            .args(["export", "--measurements"])
            .arg(at("set"))
            .arg("--out")
            .arg(at("again.uff"))
            .output()
            .unwrap(),
    );
    // Modes at a thousand positions, all validated against one result.
    let mut manifest = String::from(
        "title = \"x\"\nquantity = \"mobility\"\nresponse = \"table\"\nexcitation = \"table\"\nmodes = \"m.csv\"\n",
    );
    let mut modes = String::from("position,order,frequency_hz,amplitude\n");
    for p in 0..1000 {
        manifest += &format!("[[position]]\nname = \"p{p}\"\nnut_m = {}\n", 0.6 + 1.3e-3 * f64::from(p));
        modes += &format!("p{p},1,24,\np{p},2,116,\n");
    }
    fs::write(at("manifest.toml"), manifest).unwrap();
    fs::write(at("m.csv"), modes).unwrap();
    successful(
        &jointid().args(["identify", "--repeats", "1", "--quiet", "--out"]).arg(at("out")).output().unwrap(),
    );
    let result = at("out/identification.json");
    let validate = jointid()
        .args(["validate", "--json", "--result"])
        .arg(result)
        .arg("--measurements")
        .arg(folder.path())
        .output()
        .unwrap();
    let document: serde_json::Value = serde_json::from_str(&successful(&validate)).unwrap();
    assert_eq!(document["positions"].as_object().unwrap().len(), 1000);
}

/// A universal file of 2 GB, with two time records followed by an FRF, is listed and imported within 200 MB
/// of address space.
#[test]
fn limit_a_file_of_two_gigabytes_in_two_hundred_megabytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.uff");
    universal_file(&path, 1, 50);
    let frf = fs::read(&path).unwrap();
    let mut file = fs::File::create(&path).unwrap();
    let values = 250_000_000_u64;
    for _ in 0..2 {
        let mut header = format!(
            "    -1\n    58b     1     2          11{:>12}{:>12}{:>12}           0           0\n",
            4 * values,
            0,
            0
        );
        header += "record\nNONE\nNONE\nNONE\nNONE\n    1         0    0         0 table              1   1 table              1   1\n";
        header += &format!("         2{values:>10}         1  0.00000E+00  1.00000E-03  0.00000E+00\n");
        for (kind, label, unit) in
            [(17, "Time", "s"), (12, "Acceleration", "m/s^2"), (0, "NONE", "NONE"), (0, "NONE", "NONE")]
        {
            header += &format!("{kind:>10}    0    0    0 {label:<20} {unit:<20}\n");
        }
        file.write_all(header.as_bytes()).unwrap();
        // A hole in the file: zeros that occupy no disk space.
        file.seek(SeekFrom::Current(4 * values as i64)).unwrap();
        file.write_all(b"    -1\n").unwrap();
    }
    file.write_all(&frf).unwrap();
    drop(file);
    assert!(fs::metadata(&path).unwrap().len() > 2_000_000_000);
    let run = |words: &str| {
        shell(&format!("ulimit -v 204800; exec \"$0\" {words}")).current_dir(folder.path()).output().unwrap()
    };
    let listed = successful(&run("import large.uff --list"));
    assert!(listed.contains("3 functions") && listed.contains("250000000 values"), "{listed}");
    let imported = run("import large.uff --out set");
    assert!(successful(&imported).contains("1 FRF imported"));
    assert!(String::from_utf8_lossy(&imported.stderr).contains("2 records of dataset 58 are not FRFs"));
    assert_eq!(read_set(folder.path().join("set").to_str().unwrap()).unwrap().frfs[0].lines.len(), 50);
}
