//! Motion records by the commands.

use assert_cmd::Command;

use crate::support::axis::{Axis, course};

const CONFIG: &str = "configs/emps.toml";

fn near(found: f64, expected: f64, relative: f64) {
    assert!((found / expected - 1.0).abs() < relative, "{found} for {expected}");
}

fn jointid() -> Command {
    let mut command = Command::cargo_bin("jointid").unwrap();
    command.env("NO_COLOR", "1");
    command
}

/// The commands on a set of motions, from identification to the page.
#[test]
fn a_set_of_motions_goes_through_all_commands() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    std::fs::create_dir_all(&set).unwrap();
    std::fs::write(
        set.join("manifest.toml"),
        "title = \"made\"\n[split]\nfit = [\"a\"]\n[[motion]]\nname = \"a\"\nfile = \"a.csv\"\n[[motion]]\nname = \"b\"\nfile = \"b.csv\"\n",
    )
    .unwrap();
    let axis = Axis { viscous_backward: 320.0, ..Axis::usual() };
    for (name, seed) in [("a", 1), ("b", 1001)] {
        let mut text = String::from("time_s,command_m,position_m,force_n\n");
        for (i, (command, position, force)) in axis.run(&course(seed), seed).iter().enumerate() {
            text += &format!("{:.3},{command:.9},{position:.9},{force:.6}\n", 1e-3 * i as f64);
        }
        std::fs::write(set.join(format!("{name}.csv")), text).unwrap();
    }
    let out = folder.path().join("out");
    let on_set = |command: &mut Command| {
        command.args(["--config", CONFIG, "--measurements"]).arg(&set).arg("--out").arg(&out).arg("--json").output().unwrap()
    };
    let read = |stdout: &[u8]| serde_json::from_slice::<serde_json::Value>(stdout).unwrap();
    let ran = on_set(jointid().arg("identify"));
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let identified = read(&ran.stdout);
    assert_eq!(identified["positions"]["b"]["role"], "held_out");
    assert_eq!(identified["positions"]["a"]["gap"], identified["records"]["a"]["force_error"]);
    near(identified["parameters"]["moving_mass"]["value"].as_f64().unwrap(), axis.mass_kg, 0.02);
    let ran = jointid()
        .arg("validate")
        .arg("--result")
        .arg(out.join("identification.json"))
        .args(["--fail-above", "1e-6", "--json"])
        .output()
        .unwrap();
    assert_eq!(ran.status.code(), Some(1), "{}", String::from_utf8_lossy(&ran.stderr));
    assert_eq!(read(&ran.stdout)["positions"]["b"]["gap"], identified["positions"]["b"]["gap"]);
    let ran = on_set(jointid().args(["diagnose", "--nulls", "24"]));
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let found = read(&ran.stdout);
    assert_eq!((found["domain"].as_str(), found["verdict"]["kind"].as_str()), (Some("motion"), Some("effect")), "{:#}", found["effects"]);
    for phase in ["reversal", "acceleration", "constant-speed"] {
        assert!(found["gap"]["by_phase"][phase].is_number(), "{phase}");
    }
    let schema = jointid().args(["schema", "diagnosis"]).output().unwrap();
    let schema = jsonschema::validator_for(&read(&schema.stdout)).unwrap();
    assert!(schema.is_valid(&found));
    jointid().arg("report").arg(&out).assert().success();
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for part in ["id=\"force\"", "id=\"phases\"", "id=\"friction-curve\"", "friction-asymmetry", "Record by record"] {
        assert!(page.contains(part), "{part}");
    }
}

/// Faults of records and machines are one message, exit code 2, nothing written.
#[test]
fn faults_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = "title = \"x\"\n[[motion]]\nname = \"a\"\nfile = \"a.csv\"\n";
    std::fs::write(folder.path().join("manifest.toml"), manifest).unwrap();
    let row = |t: f64| format!("{t},{0},{0},{1}\n", (9.0 * t).sin(), 30.0 * (9.0 * t).cos());
    let text = |head: &str, times: &[f64]| head.to_string() + &times.iter().map(|t| row(*t)).collect::<String>();
    let even: Vec<f64> = (0..300).map(|i| (1e3 * (1e-3 * i as f64)).round() / 1e3).collect();
    let mut repeated = even.clone();
    repeated[100] = repeated[99];
    let head = "time_s,command_m,position_m,force_n\n";
    let cases = [
        (text(head, &even[..200]), "a.csv: has 200 samples, but filtering and thinning need at least 274"),
        (text(head, &repeated), "a.csv, line 102: time_s repeats 0.099"),
        (
            text("time_s,command_m,position_m,torque_nm\n", &even),
            "a.csv: gives torque_nm, but the drive moves «table», which takes force_n",
        ),
    ];
    for (csv, words) in cases {
        std::fs::write(folder.path().join("a.csv"), csv).unwrap();
        let out = folder.path().join("out");
        let ran =
            jointid().args(["diagnose", "--config", CONFIG, "--measurements"]).arg(folder.path()).arg("--out").arg(&out).output().unwrap();
        let told = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert_eq!(ran.status.code(), Some(2), "{told}");
        assert!(told.contains(words) && told.lines().count() == 1, "{told}");
        assert!(!out.exists() && ran.stdout.is_empty());
    }
    std::fs::write(folder.path().join("a.csv"), text(head, &even)).unwrap();
    let ran = jointid().args(["identify", "--measurements"]).arg(folder.path()).output().unwrap();
    assert_eq!(ran.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&ran.stderr).contains("no [drive]"));
}

/// A cable chain that pulls along the travel, which no effect of the library does, could pass for a force along the travel if that were four times as large as
/// it ordinarily is: then it is none.
#[test]
fn recover_what_is_more_than_ordinary() {
    use jointid::truth::motion::{Plan, QUICK, generate_one, write_case};
    let (seed, index) = (97, 78);
    let (case, label) = generate_one(seed, &Plan::from_counts(&QUICK, seed), index).unwrap();
    assert_eq!(label.effects, ["cable-chain"]);
    let folder = tempfile::tempdir().unwrap();
    write_case(folder.path(), &case).unwrap();
    let set = folder.path().to_str().unwrap();
    let machine = format!("{set}/machine.toml");
    let output = jointid().args(["diagnose", "--config", &machine, "--measurements", set, "--json", "--quiet"]).output().unwrap();
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["verdict"]["kind"], "unknown", "{:#}", found["verdict"]);
    assert!(found["verdict"]["reason"].as_str().unwrap().contains("force along 1"), "{:#}", found["verdict"]);
    assert_eq!(found["where"][0]["over"], "position", "{:#}", found["where"][0]);
}
