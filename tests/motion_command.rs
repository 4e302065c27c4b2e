//! `simulate motion`: table, document, exit codes, refused input.

use std::fs;

use assert_cmd::Command;
use serde_json::Value;

fn output(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("jointid").unwrap().args(["simulate", "motion"]).args(arguments).output().unwrap()
}

fn refused(arguments: &[&str], expected: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = output(&[arguments, &["--out", out.to_str().unwrap()]].concat());
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty() && !out.exists());
    for part in expected {
        assert!(message.contains(part), "{arguments:?}: «{part}» is not in: {message}");
    }
    assert_eq!(message.trim().lines().count(), 1, "{message}");
}

const EMPS: [&str; 2] = ["--config", "configs/emps.toml"];

#[test]
fn a_flexible_axis_follows_its_command_and_its_document_matches_its_schema() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = [
        "--config",
        "configs/servo-axis.toml",
        "--reference",
        "s-curve",
        "--travel-m",
        "0.2",
        "--json",
        "--out",
        out,
    ];
    let output = output(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["schema"], "jointid/motion/1");
    assert_eq!(document["complete"], true);
    let column = |name: &str| document["columns"][name].as_array().unwrap_or_else(|| panic!("{name}"));
    // Friction at the screw leaves a position error of some micrometres.
    let error = (column("slide_m").last().unwrap().as_f64().unwrap() - 0.2).abs();
    assert!(error > 1e-7 && error < 3e-5, "{error:e}");
    assert_eq!(column("time_s").len(), column("torque_nm").len());
    assert!(document["energy"]["imbalance"].as_f64().unwrap() < 1e-6);
    let schema = Command::cargo_bin("jointid").unwrap().args(["schema", "motion"]).output().unwrap().stdout;
    let schema: Value = serde_json::from_slice(&schema).unwrap();
    assert!(jsonschema::is_valid(&schema, &document));
    assert_eq!(fs::read(folder.path().join("motion.json")).unwrap(), output.stdout);
    let table = fs::read_to_string(folder.path().join("motion.csv")).unwrap();
    assert!(
        table.starts_with("time_s,command_m,position_m,torque_nm,velocity_m_s,motor_rad,nut_m,"),
        "{}",
        &table[..90]
    );
    assert_eq!(table.lines().count(), 1 + column("time_s").len());
}

#[test]
fn a_written_table_is_accepted_as_reference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reference.csv");
    let first = output(&[&EMPS[..], &["--reference", "sine", "--amplitude-m", "0.02", "--quiet"]].concat());
    assert!(first.stderr.is_empty());
    fs::write(&path, &first.stdout).unwrap();
    let again = output(&[&EMPS[..], &["--reference", path.to_str().unwrap(), "--quiet"]].concat());
    let numbers = |text: &[u8]| -> Vec<f64> {
        String::from_utf8_lossy(text)
            .lines()
            .skip(1)
            .map(|l| l.split(',').nth(2).unwrap().parse().unwrap())
            .collect()
    };
    let (first, again) = (numbers(&first.stdout), numbers(&again.stdout));
    assert_eq!(first.len(), again.len());
    assert!(first.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn an_unstable_loop_ends_with_exit_code_3_and_a_partial_document() {
    let gains = ["--reference", "s-curve", "--set", "drive.velocity.gain=6e3", "--json"];
    let output = output(&[&EMPS[..], &gains].concat());
    assert_eq!(output.status.code(), Some(3));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["complete"], false);
    let when = document["unstable"]["time_s"].as_f64().unwrap();
    assert_eq!(document["columns"]["time_s"].as_array().unwrap().last().unwrap().as_f64().unwrap(), when);
}

#[test]
fn refuse_impossible_motions() {
    let emps = |more: &[&str], expected: &[&str]| refused(&[&EMPS[..], more].concat(), expected);
    emps(&["--reference", "square"], &["square", "there is no such file", "s-curve, sine"]);
    emps(&["--record", "sweep"], &["--record sweep", "(measurements)"]);
    emps(&["--reference", "s-curve", "--travel-m", "0"], &["s-curve", "no travel"]);
    emps(&["--reference", "s-curve", "--jerk-m-s3=-1"], &["jerk is -1"]);
    emps(&["--reference", "sine", "--frequency-hz", "400"], &["fewer than ten samples"]);
    emps(
        &["--reference", "s-curve", "--step-s", "2e-3"],
        &["too long for the period of 0.001 s of the innermost loop"],
    );
    emps(&["--reference", "s-curve", "--step-s", "3e-4"], &["not an integer fraction", "such as 0.00025"]);
    emps(
        &["--reference", "s-curve", "--set", "drive.velocity.period_s=3e-4"],
        &["drive.position.period_s", "no multiple"],
    );
    emps(&["--reference", "s-curve", "--set", "drive.on=\"slide\""], &["drive.on", "«slide»", "table"]);
    refused(&["--reference", "s-curve"], &["configs/tian.toml", "no drive"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("uneven.csv");
    fs::write(&path, "time_s,command_m\n0,0\n0.001,0\n0.002,0\n0.0035,0\n0.0045,0\n").unwrap();
    emps(&["--reference", path.to_str().unwrap()], &["uneven.csv, line 5", "uneven"]);
    let axis = folder.path().join("axis.toml");
    let drive = "\n[drive]\non = \"rotor\"\nconstant = 1.0\nposition = { lead_m = 0.04, gain_per_s = 9.0, period_s = 1e-3 }\nvelocity = { gain = 2.0, period_s = 1e-3 }\n";
    fs::write(&axis, fs::read_to_string("configs/tian-as-published.toml").unwrap() + drive).unwrap();
    refused(
        &["--config", axis.to_str().unwrap(), "--reference", "s-curve", "--travel-m", "1.4"],
        &["beyond the screw of 2.6 m"],
    );
}

/// Fitting the simulated loop to the EMPS records gives intervals that contain the least-squares values of
/// the data set's authors.
#[test]
fn published_parameters_of_emps_by_output_error() {
    let Some(folder) = test_data::shared("realdata/emps") else { return };
    let arguments = [
        "identify",
        "--config",
        "configs/emps.toml",
        "--objective",
        "output-error",
        "--json",
        "--quiet",
        "--measurements",
    ];
    let output = Command::cargo_bin("jointid").unwrap().args(arguments).arg(folder).output().unwrap();
    let document: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    for (id, published) in [
        ("moving_mass", 95.1089),
        ("viscous_friction", 203.5034),
        ("coulomb_friction", 20.3935),
        ("friction_offset", -3.1648),
    ] {
        let interval = &document["parameters"][id]["interval95"];
        let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
        assert!(
            low < published && published < high && high - low < 0.5 * published.abs(),
            "{id}: {low} to {high}"
        );
    }
    assert!(document["records"]["sweep"]["simulated_force_error"].as_f64().unwrap() < 0.046);
}

/// The published parameters, simulated on a record by the command.
#[test]
fn published_record_of_emps_by_the_command() {
    let Some(folder) = test_data::shared("realdata/emps") else { return };
    let set: Vec<String> = [
        ("moving_mass", 95.1089),
        ("viscous_friction", 203.5034),
        ("coulomb_friction", 20.3935),
        ("friction_offset", -3.1648),
    ]
    .iter()
    .map(|(id, x)| format!("parameter.{id}.start={x}"))
    .collect();
    let mut arguments = vec![
        "--config",
        "configs/emps.toml",
        "--measurements",
        folder.to_str().unwrap(),
        "--record",
        "sweep",
        "--json",
    ];
    set.iter().for_each(|s| arguments.extend(["--set", s]));
    let output = output(&arguments);
    let document: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    assert!(document["record"]["force_gap"].as_f64().unwrap() < 0.046);
}
