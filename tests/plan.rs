//! Plans by what measurements decide: predictions, operating states, and the verdict of a diagnosis.

use std::fs;

use assert_cmd::Command;
use serde_json::{Value, json};

use crate::diagnosis::rotor_hold_document;

fn command(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("jointid").unwrap().args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn plan(arguments: &[&str]) -> Value {
    let (code, text, fault) = command(&[&["plan", "--json", "--quiet"], arguments].concat());
    assert_eq!(code, 0, "{arguments:?}: {fault}");
    serde_json::from_str(&text).unwrap()
}

fn choices(plan: &Value, ranking: usize) -> &Vec<Value> {
    plan["rankings"][ranking]["choices"].as_array().unwrap()
}

/// Choices rank by the interval of what is predicted; more measurements leave narrower intervals.
#[test]
fn predictions_decide_a_plan_where_they_are_named() {
    let found = plan(&["--data", "frf", "--choose", "1,2", "--predict-at", "0.3,2.2", "--lines", "60"]);
    let width = |choice: &Value| choice["prediction95"].as_f64().unwrap();
    for ranking in [0, 1] {
        let widths: Vec<f64> = choices(&found, ranking).iter().map(width).collect();
        assert!(
            widths.len() >= 6 && widths.iter().all(|w| *w > 0.0 && w.is_finite()) && widths.is_sorted(),
            "{widths:?}"
        );
    }
    assert!(width(&choices(&found, 1)[0]) < width(&choices(&found, 0)[0]));
    // The order is not that of the parameters.
    let of_parameters = plan(&["--data", "frf", "--choose", "2", "--lines", "60"]);
    let order = |of: &Value, ranking: usize| {
        choices(of, ranking).iter().map(|c| c["measure"].clone()).collect::<Vec<_>>()
    };
    assert_ne!(order(&found, 1), order(&of_parameters, 0));
    assert!(choices(&of_parameters, 0)[0].get("prediction95").is_none());
    // A line of the table, within 80 columns.
    let (code, text, fault) =
        command(&["plan", "--data", "frf", "--choose", "2", "--predict-at", "0.3,2.2", "--lines", "60"]);
    assert!(
        code == 0 && text.contains("Predicted ±") && text.lines().all(|l| l.chars().count() <= 80),
        "{text}{fault}"
    );
}

/// With the drive off nothing is learnt about it: its stiffness stays open, and the state is refused where
/// nothing holds the rotor.
#[test]
fn operating_states_are_candidates() {
    let base = ["--data", "frf", "--choose", "1", "--lines", "60"];
    let found = plan(&[&base[..], &["--states", "as-is,servo-off,mass=40"]].concat());
    let all = choices(&found, 0);
    let named = |end: &str| all.iter().find(|c| c["measure"][0] == format!("l3{end}")).unwrap();
    assert_eq!(all.len(), 18);
    let half = |choice: &Value, id: &str| choice["half_width95"][id].as_f64().unwrap();
    let (held, off, heavy) = (named(""), named("@servo-off"), named("@mass=40"));
    assert!(half(held, "k_s") < half(off, "k_s"), "{held} {off}");
    assert_ne!(half(held, "k_n"), half(heavy, "k_n"));
    // One that is measured already, in its state.
    let further =
        plan(&[&base[..], &["--states", "as-is,servo-off", "--measured", "l3@servo-off,l1"]].concat());
    assert_eq!(further["measured"], json!(["l1", "l3@servo-off"]));
    for (arguments, words) in [
        (&["--states", "off"][..], "--states off: write as-is, servo-off"),
        (&["--states", "mass=-3"], "--states mass=-3"),
        (&["--states", "as-is,as-is"], "named twice"),
        (&["--states", "servo-off", "--without", "rotor-hold"], "has no servo"),
        (&["--states", "level=200"], "depends on the force level"),
        (&["--predict-at", "2.9"], "--predict-at"),
        (&["--predict-at", "nan"], "--predict-at"),
    ] {
        let (code, text, fault) = command(&[&["plan"], &base[..], arguments].concat());
        assert!(code == 2 && text.is_empty() && fault.contains(words), "{arguments:?}: {code} {fault}");
    }
    let (code, _, fault) = command(&["plan", "--data", "modes", "--states", "servo-off"]);
    assert!(code == 2 && fault.contains("--states") && fault.contains("planned for FRFs"), "{fault}");
}

/// The probability that a verdict is settled lies between 0 and 1, falls with noise, and grows with
/// measurements; results that cannot be used are refused.
#[test]
fn an_ambiguous_verdict_decides_a_plan() {
    let folder = tempfile::tempdir().unwrap();
    let changed = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut document = rotor_hold_document().clone();
        document["verdict"]["kind"] = json!("ambiguous");
        document["verdict"]["effects"] = json!(["rotor-hold", "table-mass"]);
        change(&mut document);
        let path = folder.path().join(name);
        fs::write(&path, document.to_string()).unwrap();
        path.display().to_string()
    };
    let ambiguous = changed("ambiguous.json", &|_| ());
    let settled = changed("settled.json", &|d| {
        d["verdict"] =
            json!({"kind": "effect", "effects": ["rotor-hold"], "reason": "", "next_measurement": null})
    });
    let base = ["--without", "rotor-hold", "--data", "frf", "--lines", "60"];
    let of = |more: &[&str]| plan(&[&base[..], &["--diagnosis", &ambiguous], more].concat());
    let found = of(&["--choose", "1,2", "--states", "as-is,mass=40", "--noise", "0.3"]);
    assert_eq!(found["rivals"], json!(["rotor-hold", "table-mass"]));
    let probability = |choice: &Value| choice["settled"].as_f64().unwrap();
    for ranking in [0, 1] {
        let all: Vec<f64> = choices(&found, ranking).iter().map(probability).collect();
        assert!(all.iter().all(|p| (0.0..=1.0).contains(p)) && all.is_sorted_by(|a, b| a >= b), "{all:?}");
    }
    let best = |of: &Value, ranking: usize| probability(&choices(of, ranking)[0]);
    assert!(best(&found, 1) >= best(&found, 0) && best(&found, 0) > 0.0);
    let noisy = of(&["--choose", "1", "--states", "as-is,mass=40", "--noise", "0.99"]);
    assert!(best(&noisy, 0) < best(&found, 0), "{} {}", best(&noisy, 0), best(&found, 0));
    let version = changed("version.json", &|d| d["tool_version"] = json!("0.0.1"));
    let stopped = changed("stopped.json", &|d| d["complete"] = json!(false));
    let other = changed("machine.json", &|d| {
        let text = d["machine"]["text"].as_str().unwrap().replace("272", "273");
        d["machine"]["text"] = json!(text);
    });
    let set = changed("set.json", &|d| d["inputs"][1]["sha256"] = json!("0".repeat(64)));
    let unknown = changed("unknown.json", &|d| d["verdict"]["effects"] = json!(["rotor-hold", "gremlin"]));
    for (file, words) in [
        (&settled, "leaves no effects to tell apart"),
        (&version, "version 0.0.1"),
        (&stopped, "is not complete"),
        (&other, "another machine"),
        (&set, "has changed since"),
        (&unknown, "gremlin"),
    ] {
        let (code, text, fault) = command(&[&["plan"], &base[..], &["--diagnosis", file]].concat());
        assert!(code == 2 && text.is_empty() && fault.contains(words), "{file}: {code} {fault}");
    }
}
