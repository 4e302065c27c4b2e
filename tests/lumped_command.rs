//! Commands of the lumped models: sweeps, friction, refused input.

use std::fs;

use machine::contact::{ScrewDrive, published};

use crate::support::Draws;
use crate::support::command::{json, refused, run};

const TWIN: &str = "configs/twin-ball-screw.toml";
const SERVO: &str = "configs/servo-axis.toml";
const VERTICAL: &str = "configs/vertical-axis.toml";

#[test]
fn published_table_5_held_out_positions() {
    let document = json(&["identify", "--config", TWIN, "--measurements", "measurements/twin-ball-screw"]);
    assert_eq!(document["held_out_positions"], serde_json::json!(["x25", "x75"]));
    for (position, published) in [("x25", 0.054), ("x75", 0.102)] {
        let row = &document["positions"][position];
        let error = row["overall_error"].as_f64().unwrap();
        assert!(error < 0.015 && error < 0.3 * published, "{position}: {error}");
        assert!(
            (row["orders"][0]["published_hz"].as_f64().unwrap()
                / row["orders"][0]["measured_hz"].as_f64().unwrap()
                - 1.0
                - published)
                .abs()
                < 0.001
        );
    }
    // The printed mass does not explain the frequency level.
    assert!(document["parameters"]["moving_mass"]["value"].as_f64().unwrap() > 10.0 * 24.43);
}

#[test]
fn modes_carry_strain_energy_and_the_operating_condition() {
    let document = json(&[
        "simulate",
        "modes",
        "--config",
        TWIN,
        "--velocity-m-s",
        "0.5",
        "--acceleration-m-s2",
        "-2",
        "--nut-m",
        "0.1",
    ]);
    assert_eq!(document["velocity_m_s"], 0.5);
    assert_eq!(document["acceleration_m_s2"], -2.0);
    let mode = &document["modes"][0];
    let share = |name: &str| mode["strain_energy_share"][name].as_f64().unwrap();
    let parts = share("drive-1/bearing-1") + share("drive-1/screw") + share("drive-1/screw-nut-1");
    assert!((parts - share("drive-1")).abs() < 1e-9 && parts > 0.0);
    let standstill = json(&["simulate", "modes", "--config", TWIN, "--nut-m", "0.1"]);
    assert!(
        standstill["modes"][0]["frequency_hz"].as_f64().unwrap() > mode["frequency_hz"].as_f64().unwrap()
    );
    // Proportional damping: ζ = b·ω/2 and the damped frequency.
    let (f, zeta) = (mode["frequency_hz"].as_f64().unwrap(), mode["damping_ratio"].as_f64().unwrap());
    assert!((zeta / (0.5 * 1.9e-4 * std::f64::consts::TAU * f) - 1.0).abs() < 1e-6);
    assert!((mode["damped_hz"].as_f64().unwrap() / (f * (1.0 - zeta * zeta).sqrt()) - 1.0).abs() < 1e-12);
    // A warning reports an operating condition without influence.
    let (_, _, err) = run(&["simulate", "modes", "--velocity-m-s", "0.5"]);
    assert!(err.contains("change nothing"), "{err}");
}

#[test]
fn stiffness_along_position_velocity_and_acceleration() {
    let position = json(&[
        "simulate",
        "stiffness",
        "--config",
        TWIN,
        "--along",
        "position",
        "--at",
        "table",
        "--in-series-with-nut-m",
        "0.2",
    ]);
    assert_eq!(position["schema"], "jointid/stiffness/1");
    let rows = position["rows"].as_array().unwrap();
    let k: Vec<f64> = rows.iter().map(|r| r["static_stiffness"].as_f64().unwrap()).collect();
    assert!(
        k.len() == 21 && k.windows(2).all(|w| w[1] < w[0]),
        "Fig. 9: stiffness falls with the position: {k:?}"
    );
    let f: Vec<f64> = rows.iter().map(|r| r["frequencies_hz"][0].as_f64().unwrap()).collect();
    assert!(f.windows(2).all(|w| w[1] < w[0]), "Tab. 5: frequency falls with the position");

    let velocity = json(&[
        "simulate",
        "stiffness",
        "--config",
        TWIN,
        "--along",
        "velocity",
        "--from",
        "0",
        "--to",
        "1",
        "--orders",
        "0",
    ]);
    let separations = velocity["separations"].as_array().unwrap();
    let at = |name: &str| {
        separations.iter().find(|s| s["contact"] == name && s["side"] == "B").unwrap()["at"].as_f64().unwrap()
    };
    assert!(
        (60.0 * at("screw-nut-1") - 49.39).abs() < 0.01 && (60.0 * at("screw-nut-2") - 32.03).abs() < 0.01
    );

    let acceleration = json(&[
        "simulate",
        "stiffness",
        "--config",
        VERTICAL,
        "--along",
        "acceleration",
        "--from",
        "-35",
        "--to",
        "15",
        "--steps",
        "101",
    ]);
    let f = |a: f64| {
        let row = acceleration["rows"]
            .as_array()
            .unwrap()
            .iter()
            .find(|r| (r["at"].as_f64().unwrap() - a).abs() < 1e-9)
            .unwrap();
        row["frequencies_hz"][0].as_f64().unwrap()
    };
    let kinks: Vec<f64> =
        acceleration["separations"].as_array().unwrap().iter().map(|s| s["at"].as_f64().unwrap()).collect();
    assert_eq!(kinks.len(), 2, "one kink for each direction of load: {kinks:?}");
    assert!((kinks[1] - (8.0_f64.sqrt() * 1000.0 / 150.0 - 9.80665)).abs() < 1e-9);
    assert!(
        f(0.0) > f(9.0)
            && f(12.0) > f(9.5)
            && f(-10.0) > f(0.0)
            && f(-28.5) < f(-20.0)
            && f(-32.0) > f(-29.0)
    );
}

#[test]
fn bode_from_torque_to_position() {
    let document = json(&[
        "simulate",
        "frf",
        "--config",
        SERVO,
        "--excitation",
        "motor",
        "--response",
        "slide",
        "--from-hz",
        "1",
        "--to-hz",
        "300",
    ]);
    let lines = document["positions"]["mid-stroke"].as_array().unwrap();
    let size = |i: usize| lines[i][0].as_f64().unwrap().hypot(lines[i][1].as_f64().unwrap());
    // The rigid axis at 1 Hz: (lead/2π)/(J + m·(lead/2π)²)/ω².
    let i = 0.020 / std::f64::consts::TAU;
    let rigid = i / ((3e-3 + 153.0 * i * i) * std::f64::consts::TAU.powi(2));
    assert!((size(0) / rigid - 1.0).abs() < 1e-3, "{} {rigid}", size(0));
    let peak = (200..500).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap();
    let hz = document["frequency_hz"][peak].as_f64().unwrap();
    assert!((hz - 152.0).abs() < 1.0, "{hz}");
}

/// Tab. 2 from simulated torques with 2 % noise, both axes.
#[test]
fn recover_table_2_by_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let drive = ScrewDrive::new(published::LEAD_M, published::MOTOR_EFFICIENCY).unwrap();
    for (seed, curve) in [(11, published::friction_axis_1()), (12, published::friction_axis_2())] {
        let mut draws = Draws(seed);
        let mut text = String::from("velocity_m_s,torque_nm\n");
        for i in 0..40 {
            let v = 0.05e-3 * 1000.0_f64.powf(f64::from(i) / 39.0);
            for v in [v, -v] {
                text += &format!(
                    "{v:e},{:e}\n",
                    drive.torque_nm(curve.force_n(v)) * (1.0 + 0.02 * draws.normal())
                );
            }
        }
        let path = folder.path().join("axis.csv");
        fs::write(&path, text).unwrap();
        let arguments = [
            "friction",
            "--data",
            path.to_str().unwrap(),
            "--lead-m",
            "0.005",
            "--efficiency",
            "0.9",
            "--noise",
            "proportional",
        ];
        let document = json(&arguments);
        assert_eq!(document["schema"], "jointid/friction/1");
        let row = |name: &str| &document["parameters"][name];
        for (name, truth, tolerance) in [
            ("coulomb_n", curve.coulomb_n, 0.03),
            ("static_n", curve.static_n, 0.05),
            ("viscous_n_s_per_m", curve.viscous_n_s_per_m, 0.1),
            ("stribeck_velocity_m_s", curve.stribeck_velocity_m_per_s, 0.1),
        ] {
            let value = row(name)["value"].as_f64().unwrap();
            assert!((value / truth - 1.0).abs() < tolerance, "{name}: {value} against {truth}");
            let width =
                row(name)["interval95"][1].as_f64().unwrap() - row(name)["interval95"][0].as_f64().unwrap();
            assert!(width > 0.0 && width < 0.5 * truth, "{name}: interval of {width}");
        }
        assert!((document["residual_scatter"].as_f64().unwrap() / 0.02 - 1.0).abs() < 0.35);
    }
}

#[test]
fn refuse_bad_friction_tables() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.csv");
    let path = path.to_str().unwrap();
    let good: String =
        (1..8).map(|i| format!("{},{}\n", 0.001 * f64::from(i), 100.0 + f64::from(i))).collect();
    let with = |text: String, extra: &[&str], expected: &[&str]| {
        fs::write(path, text).unwrap();
        refused(&[&["friction", "--data", path], extra].concat(), expected);
    };
    with(format!("velocity_m_s,force_n\n{good}0,3\n"), &[], &["f.csv, line 9", "velocity is 0"]);
    with(format!("velocity_m_s,force_n\n{good}0.1,x\n"), &[], &["f.csv, line 9", "force_n"]);
    with(format!("velocity_m_s\n{}", "0.1\n"), &[], &["f.csv", "force_n", "torque_nm"]);
    with(format!("velocity_m_s,torque_nm\n{good}"), &[], &["--lead-m", "torque"]);
    with(format!("velocity_m_s,torque_nm\n{good}"), &["--lead-m", "-1"], &["lead", "-1"]);
    with(format!("velocity_m_s,force_n\n{good}"), &["--lead-m", "0.01"], &["--lead-m", "leave it out"]);
    with(format!("velocity_m_s,force_n\n{good}"), &["--noise", "known"], &["line 2", "standard deviation"]);
    with("velocity_m_s,force_n\n0.1,3\n0.2,4\n".into(), &[], &["f.csv", "too few"]);
    refused(&["friction", "--data", "nowhere.csv"], &["nowhere.csv", "no such file"]);
}

#[test]
fn refuse_bad_contacts_and_machines() {
    let modes = |overrides: &[&str], expected: &[&str]| {
        let sets: Vec<&str> = overrides.iter().flat_map(|o| ["--set", *o]).collect();
        refused(&[&["simulate", "modes", "--config", TWIN], sets.as_slice()].concat(), expected);
    };
    for angle in ["0", "90", "-10"] {
        let set = format!("contact.bearing-1.contact_angle_deg={angle}");
        modes(&[&set], &["twin-ball-screw.toml", "contact.bearing-1", "between 0° and 90°"]);
    }
    modes(&["contact.screw-nut-1.conformity=0.5"], &["contact.screw-nut-1", "conformity", "0.5"]);
    modes(&["contact.screw-nut-1.conformity=[0.52, 0.49]"], &["contact.screw-nut-1", "nut", "0.49"]);
    modes(&["contact.screw-nut-1.preload_n=1e6"], &["contact.screw-nut-1", "beyond the validity", "GPa"]);
    modes(&["contact.screw-nut-1.preload_n=-5"], &["contact.screw-nut-1", "preload", "-5"]);
    modes(
        &["contact.screw-nut-1.friction=axis-3"],
        &["contact.screw-nut-1.friction", "axis-3", "axis-1, axis-2"],
    );
    modes(&["contact.screw-nut-1.share=1.5"], &["contact.screw-nut-1.share", "1.5"]);
    modes(&["contact.bearing-1.lead_m=0.01"], &["contact.bearing-1.lead_m", "does not use"]);
    modes(&["contact.bearing-1.ball_count=2.5"], &["contact.bearing-1.ball_count", "whole number"]);
    modes(
        &["contact.screw-nut-1.loaded_turns=3"],
        &["contact.screw-nut-1", "either ball_count or loaded_turns"],
    );
    modes(&["segment.screw.diameter_m=0"], &["segment.screw.diameter_m", "above 0"]);
    modes(
        &["joint.drive-1.stiffness={ contact = \"nut-9\" }"],
        &["joint.drive-1.stiffness", "nut-9", "bearing-1"],
    );
    modes(&["joint.drive-1.stiffness={ segment = \"rod\" }"], &["joint.drive-1.stiffness", "rod", "screw"]);
    modes(&["joint.drive-1.stiffness={ series = [1e6] }"], &["joint.drive-1.stiffness", "two"]);
    modes(
        &["point.table.mass_kg={ contact = \"bearing-1\" }"],
        &["point.table.mass_kg", "write a number or a parameter"],
    );
    modes(&["joint.drive-1.between=[\"nut-3\", \"ground\"]"], &["joint.drive-1", "nut-3", "nut-1"]);
    modes(&["joint.drive-2.name=drive-1"], &["joint.drive-1", "declared twice"]);
    // An operating condition that loads a contact beyond its validity is refused with the contact and its
    // load.
    refused(
        &["simulate", "modes", "--config", VERTICAL, "--acceleration-m-s2", "1e6"],
        &["contact «", "beyond the validity", "lower the load"],
    );
    refused(&["simulate", "modes", "--config", TWIN, "--velocity-m-s", "inf"], &["velocity", "inf"]);
    // A part that moves freely is named if a command cannot use it.
    refused(
        &[
            "simulate",
            "stiffness",
            "--config",
            SERVO,
            "--along",
            "force",
            "--from",
            "0",
            "--to",
            "1",
            "--at",
            "slide",
            "-q",
        ],
        &["moves freely", "motor", "slide", "ground"],
    );
    refused(
        &["simulate", "stiffness", "--config", TWIN, "--along", "position", "--at", "tabel"],
        &["--at tabel", "table"],
    );
    refused(
        &["simulate", "stiffness", "--config", "configs/hybrid-axis.toml", "--along", "position"],
        &["--along position", "no nut"],
    );
    refused(&["simulate", "stiffness", "--config", TWIN, "--along", "velocity"], &["--from", "velocity_m_s"]);
}

/// A contact of which a side lets go, and an amplitude at which the axis sticks, are named.
#[test]
fn figures_without_sense_are_named() {
    let (_, _, err) = run(&["simulate", "modes", "--config", TWIN, "--velocity-m-s", "0.9"]);
    assert!(
        err.contains("contact.screw-nut-1") && err.contains("has let go") && err.contains("preload is lost"),
        "{err}"
    );
    let (_, _, err) = run(&["simulate", "modes", "--config", TWIN, "--velocity-m-s", "0.1"]);
    assert!(!err.contains("has let go"), "{err}");
    let bode = [
        "simulate",
        "bode",
        "--config",
        SERVO,
        "--response",
        "slide",
        "--from-hz",
        "2",
        "--to-hz",
        "20",
        "--points",
        "3",
    ];
    let (_, out, err) = run(&bode);
    assert!(
        err.contains("the axis sticks at an amplitude of 1e-5") && err.contains("«screw-friction»"),
        "{err}"
    );
    assert!(out.contains("stuck_share") && out.contains("amplitude 1e-5"), "{out}");
    let (_, _, err) = run(&[&bode[..], &["--amplitude-m", "5e-3"]].concat());
    assert!(!err.contains("sticks"), "{err}");
}

#[test]
fn refuse_screw_ends_that_do_not_belong_together() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(VERTICAL).unwrap();
    let path = folder.path().join("bad.toml");
    let refuse = |find: &str, put: &str, expected: &[&str]| {
        assert!(text.contains(find), "{find}");
        fs::write(&path, text.replacen(find, put, 1)).unwrap();
        refused(&["simulate", "modes", "--config", path.to_str().unwrap()], expected);
    };
    refuse("share = 0.5\nsegment = \"upper\"", "share = 0.5", &["contact.bearing-lower.segment", "two ends"]);
    refuse(
        "segment = \"upper\"\n",
        "segment = \"left\"\n",
        &["contact.bearing-upper.segment", "«left»", "upper"],
    );
    refuse("segment = \"upper\"\n", "segment = \"lower\"\n", &["contact.bearing-upper.segment", "same end"]);
}

/// Printed parameters and frequencies stand beside ours in the text of a comparison and an identification.
#[test]
fn published_parameters_stand_beside_ours() {
    let (_, out, _) =
        run(&["compare", "--positions", "l1,l3,l5", "--single", "l3,l5", "--repeats", "1", "-q"]);
    for part in ["Published", "4.280e7", "3.120e7", "6.050e7", "fitted on l5", "published", "not fitted"] {
        assert!(out.contains(part), "«{part}» is not in {out}");
    }
    let (_, out, _) = run(&["identify", "--positions", "l3", "--repeats", "1", "-q"]);
    assert!(out.contains("Published") && out.contains("4.170e7"), "{out}");
}

/// Two screws carry the table: each takes half of an external force, so a contact separates at twice
/// 2^(3/2)·P.
#[test]
fn limit_an_external_force_divides_between_two_screws() {
    let document =
        json(&["simulate", "stiffness", "--config", TWIN, "--along", "force", "--from", "0", "--to", "7000"]);
    let separations = document["separations"].as_array().unwrap();
    let preload_n = 1000.0;
    let expected = 2.0 * 2.0_f64.powf(1.5) * preload_n;
    let bearing = separations.iter().find(|s| s["contact"] == "bearing-1").unwrap();
    let at = bearing["at"].as_f64().unwrap();
    assert!((at / expected - 1.0).abs() < 1e-6, "{at} against {expected}");
}

#[test]
fn refuse_joints_between_a_translation_and_a_rotation() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(SERVO).unwrap();
    let path = folder.path().join("bad.toml");
    let refuse = |find: &str, put: &str, expected: &[&str]| {
        assert!(text.contains(find), "{find}");
        fs::write(&path, text.replacen(find, put, 1)).unwrap();
        refused(&["simulate", "modes", "--config", path.to_str().unwrap()], expected);
    };
    refuse(
        "\"motor\", \"screw-end\"]",
        "\"motor\", \"slide\"]",
        &["coupling", "«motor» is a rotation", "«slide» a translation"],
    );
    refuse(
        "angle = \"screw-angle\"",
        "angle = \"slide\"",
        &["joint.nut", "screw.angle", "«slide» is a translation"],
    );
}

/// The measurements of the published bench are the default for this bench only.
#[test]
fn another_machine_does_not_use_the_measurements_of_the_bench() {
    let document = json(&["simulate", "modes", "--config", SERVO]);
    let inputs: Vec<&str> =
        document["inputs"].as_array().unwrap().iter().map(|i| i["path"].as_str().unwrap()).collect();
    assert_eq!(inputs, [SERVO]);
    refused(&["simulate", "modes", "--config", SERVO, "--position", "l1"], &["l1", "none"]);
    let (code, out, _) =
        run(&["simulate", "frf", "--config", TWIN, "--excitation", "table", "--response", "table"]);
    assert!(code == Some(0) && out.contains("mid-stroke,"), "{out}");
}
