//! The report page: made from result documents, self-contained in one file, interactive in a browser.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

use assert_cmd::Command;
use serde_json::{Value, json};

fn jointid() -> Command {
    let mut command = Command::cargo_bin("jointid").unwrap();
    command.env("NO_COLOR", "1");
    command
}

/// Returns the document of a command on a file.
fn json_of(arguments: &[&str], file: &Path) -> Value {
    let output = jointid().args(arguments).arg(file).arg("--json").output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Writes results of the published bench together with an invented diagnosis.
fn results(folder: &Path) -> PathBuf {
    let out = folder.join("results");
    let document = out.join("identification.json");
    jointid()
        .args(["identify", "--positions", "l1,l3,l5", "--repeats", "1", "--quiet", "--out"])
        .arg(&out)
        .assert()
        .success();
    jointid()
        .args(["validate", "--quiet", "--result"])
        .arg(&document)
        .arg("--out")
        .arg(&out)
        .assert()
        .success();
    fs::write(out.join("diagnosis.json"), diagnosis("ambiguous").to_string()).unwrap();
    out
}

fn diagnosis(kind: &str) -> Value {
    let effect = |id: &str, closed: f64| {
        json!({"id": id, "status": "tried", "gap_held_out_before": 0.21, "gap_held_out_after": 0.21 * (1.0 - closed), "closed": closed,
               "closed95": [closed - 0.06, closed + 0.04], "p_value": 0.001, "parameters": {"k_s": 900.0}, "selected": closed > 0.9})
    };
    let cell = |p: usize, from: f64, to: f64| json!({"position": format!("l{p}"), "channel": "table/table", "from_hz": from, "to_hz": to, "gap": 0.1});
    json!({
        "schema": "jointid/diagnosis/1", "tool_version": "0.1.0", "seed": 1, "complete": true, "inputs": [], "warnings": [],
        "domain": "frf", "noise_floor": 0.012,
        "gap": {"fit": 0.18, "held_out": 0.21, "by_position": {"l1": 0.2}, "by_band": [{"from_hz": 5.0, "to_hz": 50.0, "gap": 0.2}],
                "by_mode": [], "by_phase": {}},
        "where": [{"interface": "rotor", "gap_held_out": 0.02, "shape": "stiffness"}, {"interface": "<b>nut", "gap_held_out": 0.1, "shape": "other"}],
        "effects": [effect("rotor-hold", 0.97), effect("drive-flexibility", 0.95), effect("table-mass", 0.1)],
        "verdict": {"kind": kind, "effects": ["rotor-hold", "drive-flexibility"], "reason": "both close it", "next_measurement": "rotor/table at l1",
                    "where": "rotor", "band_hz": [5.0, 50.0]},
        "residual_map": [cell(1, 5.0, 50.0), cell(1, 50.0, 500.0), cell(2, 5.0, 50.0)],
        "delta_z": [{"interface": "rotor", "frequency_hz": [5.0, 50.0], "real": [900.0, 890.0], "imag": [1.0, 10.0]}],
    })
}

#[test]
fn a_report_is_one_self_contained_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = results(folder.path());
    jointid().arg("report").arg(&out).assert().success();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.len() < 8 << 20, "{} bytes", page.len());
    for part in [
        "these data do not distinguish them",
        "rotor-hold or drive-flexibility",
        "The first of them acts at «rotor»; it changes the FRFs most from 5.000 to 50.00 Hz.",
        "Measure next:",
        "id=\"curves\"",
        "id=\"frequency-position\"",
        "id=\"correlations\"",
        "id=\"intervals\"",
        "id=\"shapes-chart\"",
        "id=\"convergence\"",
        "id=\"residual-map\"",
        "id=\"delta-z\"",
        "id=\"effects\"",
        "relative error",
        "id=\"provenance\"",
        "configs/tian.toml",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("<b>nut") && page.contains("&lt;b&gt;nut"));
    let own = page.split("<script type=\"text/javascript\">").next().unwrap();
    assert!(!own.contains("src=\"http") && !own.contains("href=\"http"));
    // The page can be written to another folder.
    let other = folder.path().join("a/b.html");
    jointid().arg("report").arg(&out).arg("--out").arg(&other).assert().success();
    assert_eq!(fs::read_to_string(other).unwrap(), page);
}

/// A position whose name is HTML markup appears as text.
#[test]
fn a_name_from_a_file_is_text_in_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    fs::create_dir_all(&set).unwrap();
    let markup = "<script>document.title='x'</script>";
    let manifest = fs::read_to_string("measurements/tian/manifest.toml")
        .unwrap()
        .replace("published = \"published.csv\"", "");
    fs::write(set.join("manifest.toml"), manifest.replace("\"l1\"", &format!("\"{markup}\""))).unwrap();
    let modes = fs::read_to_string("measurements/tian/modes.csv").unwrap();
    fs::write(set.join("modes.csv"), modes.replace("l1,", &format!("{markup},"))).unwrap();
    let out = folder.path().join("out");
    jointid()
        .args(["identify", "--repeats", "1", "--quiet", "--measurements"])
        .arg(&set)
        .arg("--out")
        .arg(&out)
        .assert()
        .success();
    jointid().arg("report").arg(&out).assert().success();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains(markup));
    assert!(page.contains("&lt;script&gt;document.title=&#39;x&#39;&lt;/script&gt;"));
}

#[test]
fn changed_inputs_are_reported_and_not_plotted() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (config, set) = (folder.path().join("machine.toml"), folder.path().join("set"));
    fs::copy("configs/tian.toml", &config).unwrap();
    fs::create_dir(&set).unwrap();
    for file in fs::read_dir("measurements/tian").unwrap().map(|file| file.unwrap().path()) {
        fs::copy(&file, set.join(file.file_name().unwrap())).unwrap();
    }
    let identify = ["identify", "--repeats", "1", "--quiet", "--config"];
    jointid()
        .args(identify)
        .arg(&config)
        .arg("--measurements")
        .arg(&set)
        .arg("--out")
        .arg(&out)
        .assert()
        .success();
    // A result embeds its machine: it is drawn even if the machine's file has changed since, or is gone.
    fs::write(&config, fs::read_to_string(&config).unwrap().replace("272.0", "300.0")).unwrap();
    jointid().arg("report").arg(&out).assert().success();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("the machine is that of the result") && page.contains("id=\"curves\""));
    let checked = json_of(&["validate", "--result"], &out.join("identification.json"));
    assert!(checked["warnings"].to_string().contains("the machine is that of the result"), "{checked:#}");
    fs::remove_file(&config).unwrap();
    let alone = json_of(&["validate", "--result"], &out.join("identification.json"));
    assert_eq!(alone["positions"], checked["positions"]);
    let modes = set.join("modes.csv");
    fs::write(&modes, fs::read_to_string(&modes).unwrap() + "\n").unwrap();
    jointid().arg("report").arg(&out).assert().success();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("has changed since the identification")
            && !page.contains("id=\"curves\"")
            && page.contains("id=\"correlations\"")
    );
}

#[test]
fn refuse_a_folder_without_results() {
    let folder = tempfile::tempdir().unwrap();
    let fault = |arguments: &[&str]| {
        let output = jointid().current_dir(folder.path()).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(fault(&["report", "."]).contains("holds no result document"));
    assert!(fault(&["report", "nowhere"]).contains("there is no such folder"));
    fs::write(folder.path().join("peaks.json"), "{").unwrap();
    assert!(fault(&["report", "."]).contains("peaks.json, line 1: is not a result document"));
    fs::write(folder.path().join("peaks.json"), "{\"schema\":\"other/1\"}").unwrap();
    assert!(fault(&["report", "."]).contains("`schema` is not jointid/peaks/1"));
    assert!(!folder.path().join("report.html").exists());
}

#[test]
fn every_kind_of_verdict_is_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, words) in [
        ("none", "explains the measurements"),
        ("effect", "The model lacks rotor-hold and"),
        ("ambiguous", "do not distinguish"),
        ("unknown", "lacks an effect at «rotor»"),
        ("wrong-parameter", "held fixed"),
        ("measurement", "measurements are faulty"),
        ("insufficient", "do not suffice"),
    ] {
        // Optional keys may be absent.
        let mut document = diagnosis(kind);
        for key in ["residual_map", "delta_z", "noise_floor"] {
            document.as_object_mut().unwrap().remove(key);
        }
        fs::write(folder.path().join("diagnosis.json"), document.to_string()).unwrap();
        jointid().arg("report").arg(folder.path()).assert().success();
        let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
        assert!(page.contains(words), "{kind}");
        assert!(!page.contains("id=\"residual-map\"") && !page.contains("id=\"delta-z\""));
    }
}

fn chromium() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    names.iter().flat_map(|name| folders.iter().map(move |f| f.join(name))).find(|path| path.is_file())
}

/// A browser with its own profile.
struct Browser {
    program: PathBuf,
    folder: tempfile::TempDir,
}

impl Browser {
    /// Finds the browser of this machine; without one, reports the test as skipped.
    fn find() -> Option<Browser> {
        let program = chromium();
        if program.is_none() {
            test_data::skipped("no Chromium");
        }
        Some(Browser { program: program?, folder: tempfile::tempdir().unwrap() })
    }

    /// Runs the browser and returns its stdout and stderr.
    fn open(&self, more: &[&str]) -> (String, String) {
        let profile = format!("--user-data-dir={}", self.folder.path().join("profile").display());
        let fixed = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--enable-logging=stderr",
            &profile,
        ];
        let output = Process::new(&self.program)
            .args(fixed)
            .arg("--virtual-time-budget=20000")
            .args(more)
            .output()
            .unwrap();
        (
            String::from_utf8_lossy(&output.stdout).into_owned(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    }

    /// Returns the result of the page's self-test, and asserts that it has no errors, network requests or
    /// console messages.
    fn self_test(&self, page: &Path) -> Value {
        let (dom, log) = self.open(&[
            "--window-size=1366,768",
            "--dump-dom",
            &format!("file://{}#selftest", page.display()),
        ]);
        let result = dom
            .split("id=\"selftest-result\"")
            .nth(1)
            .and_then(|t| t.split('>').nth(1))
            .and_then(|t| t.split('<').next());
        let result = result
            .unwrap_or_else(|| panic!("no self-test: {log}"))
            .replace("&quot;", "\"")
            .replace("&lt;", "<")
            .replace("&gt;", ">");
        let result: Value = serde_json::from_str(&result).unwrap_or_else(|e| panic!("{e}: {result}"));
        assert_eq!(result["errors"], json!([]), "{result}");
        assert_eq!(result["requests"], json!([]), "{result}");
        assert!(!log.contains("CONSOLE"), "{log}");
        assert_eq!(result["drawn"], result["charts"], "{result}");
        assert_eq!(result["wide"], 0, "the page is wider than its window: {result}");
        // A click on a position hides it, a second click shows it again.
        let count = |key: &str| result["toggled"][key].as_u64().unwrap();
        assert!(count("less") < count("before") && count("after") == count("before"), "{result}");
        result
    }
}

/// In a browser the page draws its charts, requests no other file, and a switch hides and shows a position.
#[test]
fn a_report_works_in_chromium() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = results(folder.path());
    jointid().arg("report").arg(&out).assert().success();
    let page = out.join("report.html");
    let result = browser.self_test(&page);
    assert!(result["charts"].as_u64().unwrap() >= 12, "{result}");
    assert!(result["traces"].as_u64().unwrap() > 60 && result["lines"].as_u64().unwrap() > 60, "{result}");
    let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page.png");
    let _ = fs::remove_file(&picture);
    browser.open(&[
        "--window-size=1280,2400",
        &format!("--screenshot={}", picture.display()),
        &format!("file://{}", page.display()),
    ]);
    assert!(fs::metadata(&picture).unwrap().len() > 50_000);
    println!("screenshot: {}", picture.display());
}

/// Six positions, six responses, ten thousand lines each, with noise: the page omits invisible detail, stays
/// below its size limit and works.
#[test]
fn a_report_of_many_lines_works_in_chromium() {
    use num_complex::Complex64;
    use report::page::{MOST_BYTES, Page, PageCurve, html};
    let curve = |position: usize, response: usize| {
        let modes = [
            24.0,
            116.0 + position as f64,
            540.0 + 9.0 * position as f64,
            720.0 + 5.0 * response as f64,
            1400.0,
        ];
        let at = |f: f64| {
            modes.iter().map(|m| 1e-2 / Complex64::new(m * m - f * f, 0.04 * m * f)).sum::<Complex64>()
        };
        let noise =
            |i: usize| 1.0 + 0.02 * (((i * 7919 + position * 31 + response * 17) % 101) as f64 / 50.0 - 1.0);
        let predicted: Vec<(f64, Complex64)> =
            (1..=10_000).map(|i| (0.2 * i as f64, at(0.2 * i as f64))).collect();
        let measured = predicted.iter().enumerate().map(|(i, (f, h))| (*f, h * noise(i))).collect();
        let channel = format!("p{response}/table");
        let (position, held_out, unit) =
            (format!("l{position}"), position % 2 == 1, "receptance (µm/N)".to_string());
        PageCurve { position, channel, held_out, unit, measured, predicted, ..PageCurve::default() }
    };
    let curves = (0..36).map(|n| curve(n / 6, n % 6)).collect();
    let page = html(&Page { title: "many lines".into(), curves, ..Page::default() });
    assert!(page.len() < MOST_BYTES, "{} bytes", page.len());
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("many-lines.html");
    fs::write(&path, page).unwrap();
    let Some(browser) = Browser::find() else { return };
    let result = browser.self_test(&path);
    assert_eq!(result["traces"], 36 * 4, "{result}");
}
