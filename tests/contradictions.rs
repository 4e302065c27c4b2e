//! Results that were changed after they were written: whatever the change, every command refuses them.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use jointid::{Sources, Study, read_identification};
use rand::prelude::*;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::{Value, json};
use test_data::draws;

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

/// Identifications of modes, of FRFs, and of motion records.
fn identifications(folder: &Path) -> Vec<String> {
    let run = |words: &str| {
        let output =
            Command::cargo_bin("jointid").unwrap().current_dir(folder).args(words.split(' ')).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    for nut_m in ["0.6", "1.6"] {
        let line = format!("simulate frf --nut-m {nut_m} --from-hz 20 --to-hz 200 --step-hz 2 --quiet");
        let table = run(&line).replace("position,", "").replace(&format!("\n{nut_m},"), "\n");
        fs::write(folder.join(format!("p{nut_m}.csv")), table).unwrap();
    }
    run(
        "import p0.6.csv p1.6.csv --pattern p{} --nut-m 0.6=0.6,1.6=1.6 --quantity receptance --response table --excitation table --out frfs --quiet",
    );
    run("init axis --kind motion-linear --quiet");
    run("simulate motion --config axis/machine.toml --reference s-curve --and-back --out motion --quiet");
    for name in ["fast", "slow"] {
        fs::copy(folder.join("motion/motion.csv"), folder.join(format!("axis/measurements/{name}.csv")))
            .unwrap();
    }
    [
        "identify --positions l1,l3,l5 --repeats 1 --json --quiet",
        "identify --measurements frfs --repeats 1 --json --quiet",
        "identify --config axis/machine.toml --measurements axis/measurements --json --quiet",
    ]
    .map(run)
    .to_vec()
}

/// Returns a document in another layout: keys in another order, other blanks, escapes and forms of numbers.
fn relaid(value: &Value, random: &mut Xoshiro256PlusPlus) -> String {
    let blank = ["", " ", "\n", "\r\n\t"][random.random_range(0..4)];
    let join = |parts: Vec<String>| parts.join(&format!("{blank},{blank}"));
    match value {
        Value::Object(map) => {
            let mut keys: Vec<&String> = map.keys().collect();
            keys.shuffle(random);
            let of = |key: &String| {
                format!("{}:{blank}{}", relaid(&json!(key), random), relaid(&map[key], random))
            };
            format!("{{{blank}{}{blank}}}", join(keys.into_iter().map(of).collect()))
        }
        Value::Array(list) => {
            format!("[{blank}{}]", join(list.iter().map(|inner| relaid(inner, random)).collect()))
        }
        Value::String(text) if random.random_bool(0.5) => {
            let escaped: String = text.encode_utf16().map(|unit| format!("\\u{unit:04x}")).collect();
            format!("\"{escaped}\"")
        }
        Value::Number(x) if x.is_f64() && random.random_bool(0.5) => format!("{:e}", x.as_f64().unwrap()),
        other => other.to_string(),
    }
}

/// Returns a document that differs in one value or key, and what was changed.
fn contradicted(sound: &Value, random: &mut Xoshiro256PlusPlus) -> (String, String) {
    let places = places(sound);
    let draw = |random: &mut Xoshiro256PlusPlus| places.choose(random).unwrap().clone();
    loop {
        let place = draw(random);
        let value = sound.pointer(&place).unwrap();
        let mut changed = sound.clone();
        let other = match (random.random_range(0..4), value) {
            // In its last digit.
            (0, Value::Number(x)) if x.is_f64() => json!(x.as_f64().unwrap().next_up()),
            // That of another place.
            (1, _) => sound.pointer(&draw(random)).unwrap().clone(),
            // The key again, before or after it, with the same or another value.
            (2, _) => {
                let (parent, key) = place.rsplit_once('/').unwrap();
                let key = key.replace("~1", "/").replace("~0", "~");
                if !sound.pointer(parent).unwrap().is_object() {
                    continue;
                }
                let again = if random.random_bool(0.5) { value.clone() } else { json!(1.0) };
                let twice = if random.random_bool(0.5) { [&again, value] } else { [value, &again] };
                let marked = format!("{place} marked");
                *changed.pointer_mut(&place).unwrap() = json!(marked);
                let [first, second] = twice.map(Value::to_string);
                let put = format!("{first},{}:{second}", json!(key));
                return (
                    changed.to_string().replace(&json!(marked).to_string(), &put),
                    format!("{place} twice"),
                );
            }
            _ => others(value).choose(random).unwrap().clone(),
        };
        // 0 and 0.0 are one number.
        let is_same = other == *value || value.is_number() && value.as_f64() == other.as_f64();
        *changed.pointer_mut(&place).unwrap() = other;
        if !is_same {
            return (relaid(&changed, random), place);
        }
    }
}

/// Of three kinds of identifications, each drawn contradiction is refused, and each drawn layout is read.
#[test]
fn refuse_drawn_contradictions_and_read_drawn_layouts() {
    let folder = tempfile::tempdir().unwrap();
    let sound: Vec<Value> =
        identifications(folder.path()).iter().map(|text| serde_json::from_str(text).unwrap()).collect();
    let path = folder.path().join("result.json");
    let mut random = Xoshiro256PlusPlus::seed_from_u64(75);
    let read = |text: &str| {
        fs::write(&path, text).unwrap();
        read_identification(&path).map(|_| ()).map_err(|fault| fault.to_string())
    };
    let count = draws(90, 2000) as usize;
    let (mut accepted, mut unread) = (Vec::new(), Vec::new());
    for value in sound.iter().cycle().take(count) {
        let (text, place) = contradicted(value, &mut random);
        accepted.extend(read(&text).is_ok().then_some(place));
        unread.extend(read(&relaid(value, &mut random)).err());
    }
    println!(
        "{} of {count} contradictions accepted, {} of {count} sound results refused",
        accepted.len(),
        unread.len()
    );
    assert!(accepted.is_empty() && unread.is_empty(), "{accepted:?} {unread:?}");
}
