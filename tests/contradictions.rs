//! Results that were changed after they were written: whatever the change, every command refuses them.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use jointid::{Sources, Study, read_identification};
use serde_json::{Value, json};

/// An identification of the bench, in a folder.
fn identified(folder: &Path) -> String {
    let sources = Sources::default();
    let study = Study::open(&sources).unwrap().fit(["l1", "l3", "l5"]).unwrap();
    let settings = jointid::Settings { repeats: 1, ..study.settings().clone() };
    let document = study.with_settings(settings).identify().unwrap();
    let text = report::to_json(&document).unwrap();
    fs::write(folder.join("identification.json"), &text).unwrap();
    text
}

/// Returns the paths of all values of a document; of a list the first and the last.
fn places(value: &Value) -> Vec<String> {
    let below = |key: String, value: &Value| -> Vec<String> {
        let key = key.replace('~', "~0").replace('/', "~1");
        std::iter::once(format!("/{key}"))
            .chain(places(value).into_iter().map(|inner| format!("/{key}{inner}")))
            .collect()
    };
    match value {
        Value::Object(map) => map.iter().flat_map(|(key, value)| below(key.clone(), value)).collect(),
        Value::Array(list) => {
            let ends = [0, list.len().saturating_sub(1)];
            let ends = &ends[..list.len().min(2)];
            ends.iter().flat_map(|at| below(at.to_string(), &list[*at])).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns other values for a value: of the same kind, and of another.
fn others(value: &Value) -> Vec<Value> {
    match value {
        Value::Null => vec![json!(1.0)],
        Value::Bool(is) => vec![json!(!is)],
        Value::Number(x) => {
            let x = x.as_f64().unwrap();
            vec![json!(1.5 * x + 1.0), json!(-1.0 - x), json!(1e300), Value::Null]
        }
        Value::String(text) => vec![json!(format!("{text} "))],
        Value::Array(list) => {
            let mut shorter = list.clone();
            shorter.pop();
            let mut longer = list.clone();
            longer.push(list.last().cloned().unwrap_or(json!("a")));
            let mut turned = list.clone();
            turned.reverse();
            let all = [shorter, longer, turned].into_iter().filter(|other| other != list);
            all.map(Value::Array).collect()
        }
        Value::Object(map) => {
            let mut more = map.clone();
            more.insert("added".into(), json!(1.0));
            let mut renamed = map.clone();
            if let Some(key) = map.keys().next() {
                let first = renamed.remove(key).unwrap();
                renamed.insert(format!("{key}_"), first);
            }
            let mut less = map.clone();
            map.keys().next_back().map(|key| less.remove(key));
            [more, renamed, less].into_iter().filter(|other| other != map).map(Value::Object).collect()
        }
    }
}

#[test]
fn refuse_every_change_of_a_result() {
    let folder = tempfile::tempdir().unwrap();
    let text = identified(folder.path());
    let sound: Value = serde_json::from_str(&text).unwrap();
    let path = folder.path().join("changed.json");
    let refused = |text: &str, what: &str| {
        fs::write(&path, text).unwrap();
        let fault = read_identification(&path).map(|_| ()).expect_err(what).to_string();
        assert!(fault.contains("changed.json") && !fault.contains('\n'), "{what}: {fault}");
    };
    let mut count = 0;
    for place in places(&sound) {
        for other in others(sound.pointer(&place).unwrap()) {
            let mut changed = sound.clone();
            *changed.pointer_mut(&place).unwrap() = other;
            refused(&changed.to_string(), &place);
            count += 1;
        }
    }
    assert!(count > 500, "{count}");
    for (at, line) in text.lines().enumerate() {
        // Each key again, with its value and with another one.
        let Some((key, value)) = line.trim().split_once("\": ").filter(|(_, value)| value.ends_with(','))
        else {
            continue;
        };
        for value in [value, "1,", "{},"] {
            let mut twice: Vec<&str> = text.lines().collect();
            let again = format!("{key}\": {value}");
            twice.insert(at, &again);
            refused(&twice.join("\n"), &again);
        }
    }
    // The same content in another layout is sound.
    let mut spaced = String::new();
    for c in text.chars() {
        if c.is_ascii() { spaced.push(c) } else { spaced += &format!("\\u{:04x}", c as u32) }
    }
    for sound in [text.clone(), sound.to_string(), spaced.replace('\n', "\r\n  ")] {
        fs::write(&path, sound).unwrap();
        read_identification(&path).unwrap();
    }
}

#[test]
fn refuse_a_changed_result_in_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let text = identified(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    fs::copy(at("identification.json"), at("sound.json")).unwrap();
    let file = at("identification.json");
    for (find, put) in [
        ("\"variance\": ", "\"variance\": -"),
        ("mass_kg = 272.0", "mass_kg = 300.0"),
        ("receptance", "magic"),
    ] {
        assert!(text.contains(find), "{find}");
        fs::write(&file, text.replacen(find, put, 1)).unwrap();
        for words in [
            vec!["predict", "--nut-m", "1", "--result", &file],
            vec!["validate", "--result", &file],
            vec!["plan", "--result", &file],
            vec!["simulate", "frf", "--from-hz", "20", "--to-hz", "30", "--step-hz", "5", "--result", &file],
            vec!["simulate", "hold", "--constant", "1", "--lead-m", "0.04", "--result", &file],
            vec!["compare", "--results", &file, &at("sound.json")],
            vec!["report", folder.path().to_str().unwrap()],
        ] {
            let output = Command::cargo_bin("jointid").unwrap().args(&words).output().unwrap();
            let message = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
            assert!(
                output.stdout.is_empty() && message.contains("was changed after it was written"),
                "{message}"
            );
        }
    }
}
