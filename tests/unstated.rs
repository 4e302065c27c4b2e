//! What a set does not state: the noise of its FRFs.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use num_complex::Complex64;
use numeric::random::normal;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;

fn json(arguments: &[&str], folder: &Path) -> Value {
    let output = Command::cargo_bin("jointid").unwrap().current_dir(folder).args(arguments).args(["--json", "--quiet"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn warnings(document: &Value) -> Vec<&str> {
    document["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect()
}

/// Writes FRFs of the bench at l1, l3 and l5 with noise of 0.5 % of |H| and of the response (m/N), with an appendix to each line.
fn write_frfs(folder: &Path, step_hz: &str, (response_m_per_n, columns, cells): (f64, &str, &str)) {
    let frf = ["simulate", "frf", "--from-hz", "5", "--to-hz", "800", "--step-hz", step_hz, "--response", "table", "--excitation", "table"];
    let exact = json(&[&frf[..], &["--position", "l1,l3,l5"]].concat(), folder);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(17);
    let mut manifest = String::from("title = \"taps\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n");
    for (name, nut_m) in [("l1", 0.6), ("l3", 1.0), ("l5", 1.6)] {
        writeln!(manifest, "[[position]]\nname = \"{name}\"\nnut_m = {nut_m}\n[[frf]]\nposition = \"{name}\"\nfile = \"{name}.csv\"")
            .unwrap();
        let mut table = format!("frequency_hz,real,imag{columns}\n");
        for (f, h) in exact["frequency_hz"].as_array().unwrap().iter().zip(exact["positions"][name].as_array().unwrap()) {
            let h = Complex64::new(h[0].as_f64().unwrap(), h[1].as_f64().unwrap());
            let sd = 0.005_f64.hypot(response_m_per_n / h.norm());
            let h = h * (1.0 + sd * Complex64::new(normal(&mut random), normal(&mut random)));
            writeln!(table, "{f},{:e},{:e}{cells}", h.re, h.im).unwrap();
        }
        fs::write(folder.join(format!("{name}.csv")), table).unwrap();
    }
    fs::write(folder.join("manifest.toml"), manifest).unwrap();
}

/// FRFs that state no noise are fitted with the noise of their lines: χ² is as large as its degrees of freedom, and the result says so.
#[test]
fn unstated_noise_is_estimated_and_reported() {
    for (columns, cells) in [("", ""), (",coherence", ",1")] {
        let folder = tempfile::tempdir().unwrap();
        write_frfs(folder.path(), "1", (2e-11, columns, cells));
        let document = json(&["identify", "--measurements", ".", "--tolerances", "none", "--repeats", "1"], folder.path());
        let of = |key: &str| document["derived"][key].as_f64().unwrap();
        // The model error of 1 % is added to the noise, so that noise alone leaves a χ² below its degrees of freedom.
        let ratio = of("chi_square") / of("degrees_of_freedom");
        assert!((0.3..1.1).contains(&ratio), "{ratio}");
        assert!(document["frfs"].as_array().unwrap().iter().all(|row| row["noise_source"] == "neighbouring lines"), "{document}");
        let gap = document["frfs"][0]["gap"].as_f64().unwrap() / document["frfs"][0]["noise_floor"].as_f64().unwrap();
        assert!((0.8..1.25).contains(&gap), "{gap}");
        let warned = warnings(&document);
        assert!(
            warned.iter().any(|w| w.contains("the noise of 3 FRFs is not stated") && w.contains("coherence and averages")),
            "{warned:?}"
        );
        assert_eq!(warned.iter().any(|w| w.contains("the coherence is 1 at every line")), !columns.is_empty(), "{warned:?}");
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
