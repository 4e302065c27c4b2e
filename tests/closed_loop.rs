//! Closed-loop FRFs, position over command: against the sampled loops, identified, diagnosed, and refused.
//! The data come from the linear loops, a map between samples whose plant is integrated by matrix
//! exponentials; the model under test is a receptance with the loops' impedance.

use std::path::Path;
use std::sync::Arc;

use config::read_machine_text;
use dynamics::model::{RodModel, Structure};
use dynamics::motion::{LinearLoops, ServoImpedance, SimulationSettings};
use machine::{Machine, Operating};
use num_complex::Complex64;
use numeric::unit::omega_rad_s;
use serde_json::{Value, json};

use crate::support::Draws;
use crate::support::command::{json as run_json, refused, run};

const SERVO: &str = "configs/servo-axis.toml";

fn machine(text: &str, set: &[&str]) -> Machine {
    let set: Vec<String> = set.iter().map(|s| (*s).to_string()).collect();
    read_machine_text("axis.toml", text, &set, &[]).unwrap_or_else(|e| panic!("{e}")).machine
}

fn servo_text() -> String {
    std::fs::read_to_string(SERVO).unwrap()
}

fn at(nut_m: Option<f64>) -> SimulationSettings {
    SimulationSettings {
        operating: Operating { nut_m, ..Operating::default() },
        ..SimulationSettings::default()
    }
}

/// Returns position over command of a point by the sampled loops; a rotation as travel.
fn sampled(machine: &Machine, nut_m: Option<f64>, point: &str, frequency_hz: f64) -> Complex64 {
    let loops = LinearLoops::new(machine, &machine.start(), &at(nut_m)).unwrap();
    let coordinate = loops.names.iter().position(|name| name == point).unwrap();
    let travel = if ["motor", "screw-end", "screw-angle"].contains(&point) {
        0.020 / std::f64::consts::TAU
    } else {
        1.0
    };
    loops.response(frequency_hz, Some(coordinate)) * travel
}

/// Writes a set of Bode diagrams of a machine: (name, nut position, response).
fn write_bodes(
    folder: &Path,
    truth: &Machine,
    records: &[(&str, Option<f64>, &str)],
    fit: &[&str],
    noise: f64,
) {
    let mut manifest = format!(
        "title = \"axis, Bode diagrams\"\nquantity = \"receptance\"\nexcitation = \"command\"\nexcitation_unit = \"m\"\n[split]\nfit = {}\n",
        json!(fit)
    );
    let mut draws = Draws(7);
    for (name, nut_m, response) in records {
        let mut text = "frequency_hz,real,imag,relative_sd\n".to_string();
        for line in 0..120 {
            let hz = 10.0 * 35.0_f64.powf(f64::from(line) / 119.0);
            let h = sampled(truth, *nut_m, response, hz)
                * (Complex64::ONE + noise * Complex64::new(draws.normal(), draws.normal()));
            text += &format!("{hz},{:e},{:e},{}\n", h.re, h.im, noise * std::f64::consts::SQRT_2);
        }
        std::fs::write(folder.join(format!("{name}.csv")), text).unwrap();
        if let Some(nut_m) = nut_m {
            manifest += &format!("[[position]]\nname = \"{name}\"\nnut_m = {nut_m}\n");
        }
        let place = if nut_m.is_some() { "position" } else { "record" };
        manifest +=
            &format!("[[frf]]\n{place} = \"{name}\"\nresponse = \"{response}\"\nfile = \"{name}.csv\"\n");
    }
    std::fs::write(folder.join("manifest.toml"), manifest).unwrap();
}

/// The receptance with the impedance of the loops follows the sampled loops below half the sampling rate of
/// the position loop. The rest is aliasing: a component at f returns at the sampling rate minus f, and grows
/// towards half that rate.
#[test]
fn limit_closed_loop_frf_is_that_of_the_sampled_loops() {
    let feed_forward = ["drive.delay_s=3.1e-4", "drive.velocity.acceleration_feed_forward=0.5"];
    for (config, set, point, travel) in [
        (SERVO, &[][..], "slide", 1.0),
        (SERVO, &feed_forward[..], "motor", 0.020 / std::f64::consts::TAU),
        ("configs/hybrid-axis.toml", &[][..], "table", 1.0),
    ] {
        let axis = machine(&std::fs::read_to_string(config).unwrap(), set);
        let (values, here) = (axis.start(), Operating::default());
        let loops = LinearLoops::new(&axis, &values, &at(None)).unwrap();
        let coordinate = loops.names.iter().position(|name| name == point);
        let servo = ServoImpedance::new(&axis, &values, &here).unwrap();
        let open = |response: usize, omega: f64| {
            let structure = Arc::new(Structure::new(&axis, response, servo.on, RodModel::Exact).unwrap());
            let mut model = structure.empty_model();
            model.update(&axis, &values, &here);
            model.receptance(omega, &mut structure.workspace())
        };
        for (hz, within) in [(2.0, 1e-4), (20.0, 1e-3), (60.0, 5e-3), (150.0, 0.03)] {
            let omega = omega_rad_s(hz);
            let ours =
                servo.follow(omega, open(axis.point(point).unwrap(), omega) * travel, |at| open(at, omega));
            let exact = loops.response(hz, coordinate) * travel;
            assert!((ours / exact - 1.0).norm() < within, "{config} {set:?} {hz} Hz: {ours} for {exact}");
        }
    }
}

/// Stiffnesses and a gain of the loops follow from Bode diagrams at two nut positions, and predict a third.
#[test]
fn recover_stiffness_and_gain_from_bode_diagrams() {
    let text = servo_text().replace("gain_per_s = 45.4 ", "gain_per_s = \"k_v\" ")
        + "\n[parameter.k_v]\nunit = \"1/s\"\nstart = 45.4\nlower = 5.0\nupper = 200.0\nsource = \"setting of the controller\"\n";
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    std::fs::write(path("axis.toml"), &text).unwrap();
    let truth = machine(
        &text,
        &["parameter.k_v.start=52.0", "parameter.k_support.start=1.5e8", "parameter.k_12t.start=2.2e4"],
    );
    write_bodes(
        folder.path(),
        &truth,
        &[("a", Some(0.2), "slide"), ("b", Some(0.8), "slide"), ("c", Some(0.5), "slide")],
        &["a", "b"],
        0.005,
    );
    let set = folder.path().to_str().unwrap();
    let found = run_json(&[
        "identify",
        "--config",
        &path("axis.toml"),
        "--measurements",
        set,
        "--freeze",
        "k_12a,k_23a,k_23t",
        "--tolerances",
        "none",
    ]);
    for (id, value) in [("k_v", 52.0), ("k_support", 1.5e8), ("k_12t", 2.2e4)] {
        let had = found["parameters"][id]["value"].as_f64().unwrap();
        assert!((had / value - 1.0).abs() < 0.03, "{id}: {had} for {value}");
    }
    assert!(found["derived"].get("gain").is_none() && found["parameters"].get("gain").is_none(), "{found:#}");
    let warnings = found["warnings"].to_string();
    assert!(
        warnings.contains("screw-friction") && warnings.contains("closed-loop FRFs are linear"),
        "{warnings}"
    );
    let held_out = found["frfs"].as_array().unwrap().iter().find(|f| f["role"] == "held_out").unwrap();
    assert!(held_out["gap"].as_f64().unwrap() < 0.02, "{held_out:#}");
}

/// Bode diagrams as controllers export them, decibels and degrees, go through `import`; the stiffness that
/// differs from the description follows.
#[test]
fn recover_stiffness_from_imported_bode_diagrams() {
    let truth = machine(&servo_text(), &["parameter.k_support.start=1.5e8"]);
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    for (name, nut_m) in [("a", 0.2), ("b", 0.8)] {
        let mut text = "frequency_hz,magnitude_db,phase_deg\n".to_string();
        for line in 0..150 {
            let hz = 10.0 * 35.0_f64.powf(f64::from(line) / 149.0);
            let h = sampled(&truth, Some(nut_m), "slide", hz);
            text += &format!("{hz},{:.4},{:.3}\n", 20.0 * h.norm().log10(), h.arg().to_degrees());
        }
        std::fs::write(path(&format!("{name}.csv")), text).unwrap();
    }
    let set = path("set");
    let (a, b) = (path("a.csv"), path("b.csv"));
    let whole = [
        "--quantity",
        "receptance",
        "--excitation",
        "command",
        "--response",
        "slide",
        "--pattern",
        "{}",
        "--nut-m",
        "a=0.2,b=0.8",
    ];
    let (code, _, err) =
        run(&[&["import", a.as_str(), b.as_str(), "--out", set.as_str()], &whole[..]].concat());
    assert_eq!(code, Some(0), "{err}");
    assert!(std::fs::read_to_string(path("set/manifest.toml")).unwrap().contains("excitation_unit = \"m\""));
    let options = ["--freeze", "k_12a,k_12t,k_23a,k_23t", "--tolerances", "none"];
    let found =
        run_json(&[&["identify", "--config", SERVO, "--measurements", set.as_str()], &options[..]].concat());
    let stiffness = found["parameters"]["k_support"]["value"].as_f64().unwrap();
    assert!((stiffness / 1.5e8 - 1.0).abs() < 0.01, "{stiffness}");
}

/// The real axis of Fig. 7 showed two peaks where the model has one. Here the metal support is a mass on a
/// spring, which the description lacks: the Bode diagram has two peaks near 152 Hz, and the diagnosis names
/// the compliant bed.
#[test]
fn recover_two_peaks_of_a_bode_diagram() {
    let resonant = servo_text()
        .replace("between = [\"screw\", \"ground\"]", "between = [\"screw\", \"bed\"]")
        + "\n[[point]]\nname = \"bed\"\nmotion = \"translation\"\nmass_kg = 400.0\n\n[[joint]]\nname = \"bed-foundation\"\nbetween = [\"bed\", \"ground\"]\nstiffness = 1.91e8\ndamping = 5.5e3\n";
    let truth = machine(&resonant, &[]);
    let peaks = |of: &Machine| {
        let magnitudes: Vec<f64> =
            (100..240).map(|hz| sampled(of, Some(0.5), "slide", f64::from(hz)).norm()).collect();
        magnitudes.windows(3).filter(|w| w[1] > w[0] && w[1] > w[2]).count()
    };
    assert_eq!((peaks(&machine(&servo_text(), &[])), peaks(&truth)), (1, 2));
    let folder = tempfile::tempdir().unwrap();
    let records = [("a", Some(0.2), "slide"), ("b", Some(0.8), "slide"), ("c", Some(0.5), "slide")];
    write_bodes(folder.path(), &truth, &records, &["a", "b"], 0.005);
    let set = folder.path().to_str().unwrap();
    let found: Value =
        run_json(&["diagnose", "--config", SERVO, "--measurements", set, "--no-cache", "--nulls", "20"]);
    assert_eq!(found["verdict"]["effects"], json!(["bed-compliance"]), "{:#}", found["verdict"]);
    assert!(found["effects"][0]["closed"].as_f64().unwrap() > 0.9, "{:#}", found["effects"][0]);
}

#[test]
fn refuse_closed_loop_frfs_without_loops() {
    let folder = tempfile::tempdir().unwrap();
    let axis = machine(&servo_text(), &[]);
    write_bodes(
        folder.path(),
        &axis,
        &[("a", Some(0.3), "slide"), ("b", Some(0.7), "slide")],
        &["a", "b"],
        0.01,
    );
    let set = folder.path().to_str().unwrap();
    let text = servo_text();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let parameters = &text[text.find("[parameter.k_12t]").unwrap()..];
    let open = text[..text.find("# The loops of Fig. 3").unwrap()].to_string() + parameters;
    std::fs::write(path("open.toml"), open).unwrap();
    for command in ["identify", "diagnose"] {
        refused(
            &[command, "--config", &path("open.toml"), "--measurements", set],
            &["a.csv", "excitation = \"command\"", "no loops", "[drive]"],
        );
        let unstable = ["--config", SERVO, "--measurements", set, "--set", "drive.velocity.gain=5000.0"];
        refused(&[&[command], &unstable[..]].concat(), &["[drive]", "unstable at the start values", "Hz"]);
    }
    refused(
        &[
            "simulate",
            "frf",
            "--config",
            "configs/two-inertia.toml",
            "--response",
            "load",
            "--excitation",
            "command",
        ],
        &["command", "no loops", "[drive]"],
    );
    refused(
        &[
            "simulate",
            "frf",
            "--config",
            SERVO,
            "--response",
            "slide",
            "--excitation",
            "command",
            "--to-hz",
            "600",
        ],
        &["500 Hz", "half the slowest sampling rate"],
    );
    let modes = format!(
        "{}modes = \"modes.csv\"\nresponse = \"slide\"\n",
        "title = \"peaks\"\nexcitation = \"command\"\nquantity = \"receptance\"\n"
    );
    std::fs::create_dir(path("peaks")).unwrap();
    std::fs::write(path("peaks/manifest.toml"), format!("{modes}[[position]]\nname = \"a\"\nnut_m = 0.3\n"))
        .unwrap();
    std::fs::write(path("peaks/modes.csv"), "position,order,frequency_hz,amplitude\na,1,150,\n").unwrap();
    refused(
        &["identify", "--config", SERVO, "--measurements", &path("peaks")],
        &["command", "no natural frequencies", "[[frf]]"],
    );
}
