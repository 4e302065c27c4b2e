//! What a set does not state: the noise of its FRFs, the orders of its modes. Wrong orders are named.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use measurement::misplaced_modes;
use num_complex::Complex64;
use numeric::random::normal;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use reference_simulator::ordinary;
use serde_json::Value;
use test_data::draws;

use crate::support::axis_template::fill;

fn json(arguments: &[&str], folder: &Path) -> Value {
    let output = Command::cargo_bin("jointid")
        .unwrap()
        .current_dir(folder)
        .args(arguments)
        .args(["--json", "--quiet"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn warnings(document: &Value) -> Vec<&str> {
    document["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect()
}

/// Writes FRFs of the bench at l1, l3 and l5 with noise of 0.5 % of |H| and of the response (m/N), with an
/// appendix to each line.
fn write_frfs(folder: &Path, step_hz: &str, (response_m_per_n, columns, cells): (f64, &str, &str)) {
    let frf = [
        "simulate",
        "frf",
        "--from-hz",
        "5",
        "--to-hz",
        "800",
        "--step-hz",
        step_hz,
        "--response",
        "table",
        "--excitation",
        "table",
    ];
    let exact = json(&[&frf[..], &["--position", "l1,l3,l5"]].concat(), folder);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(17);
    let mut manifest = String::from(
        "title = \"taps\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n",
    );
    for (name, nut_m) in [("l1", 0.6), ("l3", 1.0), ("l5", 1.6)] {
        writeln!(manifest, "[[position]]\nname = \"{name}\"\nnut_m = {nut_m}\n[[frf]]\nposition = \"{name}\"\nfile = \"{name}.csv\"")
            .unwrap();
        let mut table = format!("frequency_hz,real,imag{columns}\n");
        for (f, h) in
            exact["frequency_hz"].as_array().unwrap().iter().zip(exact["positions"][name].as_array().unwrap())
        {
            let h = Complex64::new(h[0].as_f64().unwrap(), h[1].as_f64().unwrap());
            let sd = 0.005_f64.hypot(response_m_per_n / h.norm());
            let h = h * (1.0 + sd * Complex64::new(normal(&mut random), normal(&mut random)));
            writeln!(table, "{f},{:e},{:e}{cells}", h.re, h.im).unwrap();
        }
        fs::write(folder.join(format!("{name}.csv")), table).unwrap();
    }
    fs::write(folder.join("manifest.toml"), manifest).unwrap();
}

/// FRFs that state no noise are fitted with the noise of their lines: χ² is as large as its degrees of
/// freedom, and the result says so.
#[test]
fn unstated_noise_is_estimated_and_reported() {
    for (columns, cells) in [("", ""), (",coherence", ",1")] {
        let folder = tempfile::tempdir().unwrap();
        write_frfs(folder.path(), "1", (2e-11, columns, cells));
        let document = json(
            &["identify", "--measurements", ".", "--tolerances", "none", "--repeats", "1"],
            folder.path(),
        );
        let of = |key: &str| document["derived"][key].as_f64().unwrap();
        // The model error of 1 % is added to the noise, so that noise alone leaves a χ² below its degrees of
        // freedom.
        let ratio = of("chi_square") / of("degrees_of_freedom");
        assert!((0.3..1.1).contains(&ratio), "{ratio}");
        assert!(
            document["frfs"]
                .as_array()
                .unwrap()
                .iter()
                .all(|row| row["noise_source"] == "neighbouring lines"),
            "{document}"
        );
        let gap = document["frfs"][0]["gap"].as_f64().unwrap()
            / document["frfs"][0]["noise_floor"].as_f64().unwrap();
        assert!((0.8..1.25).contains(&gap), "{gap}");
        let warned = warnings(&document);
        assert!(
            warned
                .iter()
                .any(|w| w.contains("the noise of 3 FRFs is not stated")
                    && w.contains("coherence and averages")),
            "{warned:?}"
        );
        assert_eq!(
            warned.iter().any(|w| w.contains("the coherence is 1 at every line")),
            !columns.is_empty(),
            "{warned:?}"
        );
    }
}

/// FRFs with too few lines have an unknown noise, which is said; a fit is made all the same.
#[test]
fn few_lines_leave_the_noise_unknown() {
    let folder = tempfile::tempdir().unwrap();
    write_frfs(folder.path(), "100", (0.0, "", ""));
    let document = json(&["identify", "--measurements", ".", "--repeats", "1"], folder.path());
    assert_eq!(document["frfs"][0]["noise_source"], "unknown");
    assert!(warnings(&document).iter().any(|w| w.contains("too few lines to estimate it")), "{document}");
}

/// An axis with a screw of 28.5 mm, in the template's order.
const AXIS: [(&str, &str); 6] = [
    ("mass_kg", "415.0"),
    ("inertia_kg_m2", "4.2e-3"),
    ("inertia_kg_m2", "3.1e-4"),
    ("length_m", "1.12"),
    ("diameter_m", "0.0285"),
    ("lead_m", "0.010"),
];
/// Its modes; the second of p3 is entered as its first. The stiffness of screw and nut is 4.6e8 N/m.
const MODES: &str = "position,order,frequency_hz,amplitude\np1,1,99,2.081e-06\np1,2,400,4.780e-10\np1,3,1472,2.968e-11\np2,1,93,1.839e-06
p2,2,401,5.256e-10\np3,1,402,4.7e-10\np4,1,88,2.641e-06\np4,2,403,5.028e-10\np5,1,87,2.740e-06\np5,2,404,4.912e-10\n";

/// A mode under a wrong order is named, with the result that the right order gives.
#[test]
fn a_mode_under_a_wrong_order_is_named_with_the_result_of_the_right_one() {
    let folder = tempfile::tempdir().unwrap();
    Command::cargo_bin("jointid")
        .unwrap()
        .current_dir(folder.path())
        .args(["init", "axis"])
        .assert()
        .success();
    let machine = folder.path().join("axis/machine.toml");
    fs::write(&machine, fill(&fs::read_to_string(&machine).unwrap(), &AXIS)).unwrap();
    let mut manifest = String::from(
        "title = \"taps\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\nmodes = \"modes.csv\"\n",
    );
    manifest += "frequency_resolution_hz = 1.0\n[split]\nfit = [\"p1\", \"p3\", \"p5\"]\n";
    for (at, nut_m) in [0.18, 0.37, 0.56, 0.75, 0.96].iter().enumerate() {
        writeln!(manifest, "[[position]]\nname = \"p{}\"\nnut_m = {nut_m}", at + 1).unwrap();
    }
    fs::write(folder.path().join("axis/measurements/manifest.toml"), manifest).unwrap();
    fs::write(folder.path().join("axis/measurements/modes.csv"), MODES).unwrap();
    let identify = ["identify", "--config", "axis/machine.toml", "--measurements", "axis/measurements"];
    let document = json(&identify, folder.path());
    let renumbered = &document["renumbered"];
    let expected =
        serde_json::json!([{"position": "p3", "order": 1, "frequency_hz": 402.0, "fits_order": 2}]);
    let modes: Value = renumbered["modes"].clone();
    assert_eq!(modes.as_array().unwrap().len(), 1, "{modes}");
    assert_eq!(modes[0]["position"], expected[0]["position"]);
    assert_eq!(modes[0]["fits_order"], expected[0]["fits_order"]);
    assert!((modes[0]["frequency_hz"].as_f64().unwrap() - 402.0).abs() < 1e-9);
    let (entered, there) = (document["cost"].as_f64().unwrap(), renumbered["cost"].as_f64().unwrap());
    assert!(there < 10.0 && entered > 5.0 * there, "{entered} {there}");
    let interval = &renumbered["parameters"]["k_n"]["interval95"];
    assert!(interval[0].as_f64().unwrap() <= 4.6e8 && interval[1].as_f64().unwrap() >= 4.6e8, "{renumbered}");
    assert!(
        warnings(&document)[0].contains("402.0 Hz at p3 fits order 2, but is entered as order 1"),
        "{document}"
    );
    // With the right order, nothing is named.
    fs::write(folder.path().join("axis/measurements/modes.csv"), MODES.replace("p3,1,402", "p3,2,402"))
        .unwrap();
    let right = json(&identify, folder.path());
    assert!(right["renumbered"].is_null(), "{right}");
    assert!((right["cost"].as_f64().unwrap() - there).abs() < 1e-6 * there.max(1.0), "{right}");
}

/// Sound tables are rarely accused, and wrong orders are mostly named. The tables are those of drawn machines
/// that show equally many peaks at each position: other tables cannot be numbered without knowing the
/// machine.
#[test]
fn sound_tables_of_drawn_machines_are_rarely_accused() {
    let (mut tables, mut accused, mut shifted, mut named) = (0, 0, 0, 0);
    for number in 0..draws(40, 400) as usize {
        let simulated = ordinary(6_211, number).unwrap();
        let most = simulated.peaks.iter().map(Vec::len).max().unwrap();
        if simulated.peaks.iter().any(|peaks| peaks.len() < most) {
            continue;
        }
        let position = |at: usize| measurement::Position {
            name: format!("l{}", at + 1),
            nut_m: Some(simulated.case.positions[at].nut_m),
        };
        let modes = |skipped: usize, from: usize| {
            let table = |(at, peaks): (usize, &Vec<(f64, f64)>)| {
                let seen = peaks.iter().skip(if at == skipped { from } else { 0 }).enumerate();
                let mode = |(order, (hz, _)): (usize, &(f64, f64))| measurement::ModeObservation {
                    order: order as u32 + 1,
                    frequency_hz: Some((hz / simulated.step_hz).round() * simulated.step_hz),
                    frequency_sd_hz: None,
                    amplitude: None,
                };
                seen.map(mode).collect()
            };
            let positions = simulated.peaks.iter().enumerate().map(table).collect();
            measurement::ModeTable {
                positions,
                resolution_hz: Some(simulated.step_hz),
                least_prominence: None,
            }
        };
        let set = |modes| measurement::MeasurementSet {
            positions: (0..simulated.peaks.len()).map(position).collect(),
            modes: Some(modes),
            ..measurement::MeasurementSet::none()
        };
        tables += 1;
        let sound = misplaced_modes(&set(modes(0, 0)));
        if !sound.is_empty() {
            accused += 1;
            println!("{number}: {sound:?} {:?}", simulated.peaks);
        }
        // The first mode of one position missed, so that all above are shifted.
        shifted += 1;
        named += usize::from(
            misplaced_modes(&set(modes(2, 1)))
                .iter()
                .any(|m| m.position == 2 && m.order == 1 && m.fits == Some(2)),
        );
    }
    println!("{accused} of {tables} sound tables accused; {named} of {shifted} shifted positions named");
    // A sound table is accused at odds of 1000 to 1 and a wrong order in a hundred positions: one of ten that
    // are named may be sound.
    assert!(tables > 0 && accused as f64 <= 0.05 * f64::from(tables) && 2 * named > shifted);
}
