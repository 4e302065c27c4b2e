//! What is said beside the results: on stderr, wrapped to 80 columns, coloured on a terminal unless NO_COLOR is set.

use std::sync::{LazyLock, OnceLock};
use std::time::Instant;

use anstyle::{AnsiColor, Style};
use serde_json::Value;

use crate::arguments::OutputArguments;
use report::wrapped;

/// When the program began.
pub static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
/// On how many threads it was asked to work.
pub static THREADS: OnceLock<usize> = OnceLock::new();

/// A warning: what is the matter, and what to do about it.
pub fn warning(text: &str) {
    labelled("warning:", AnsiColor::Yellow.on_default().bold(), text);
}

/// A remark.
pub fn note(text: &str) {
    labelled("note:", AnsiColor::Cyan.on_default().bold(), text);
}

/// The one message that says why the command could not run: in one line, that it may be searched for.
pub fn failed(text: &str) {
    let red = AnsiColor::Red.on_default().bold();
    anstream::eprintln!("{red}jointid:{red:#} {text}");
}

fn labelled(label: &str, style: Style, text: &str) {
    let text = wrapped(&format!("{label} {text}"));
    let rest = text.strip_prefix(label).unwrap_or(&text);
    anstream::eprint!("{style}{label}{style:#}{rest}");
}

/// With `--verbose`: what a result rests on, how it was set, how its searches went, how long it took.
pub fn background(output: &OutputArguments, json: &str) {
    if !output.verbose {
        return;
    }
    let document: Value = serde_json::from_str(json).unwrap_or_default();
    let list = |key: &str| document[key].as_array().cloned().unwrap_or_default();
    let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_string);
    for input in list("inputs") {
        let digest = word(&input["sha256"]);
        eprint!("{}", wrapped(&format!("read {} (SHA-256 {}…)", word(&input["path"]), digest.get(..12).unwrap_or(&digest))));
    }
    for (key, what) in [("overrides", "overridden"), ("without", "taken out")] {
        list(key).iter().for_each(|value| eprint!("{}", wrapped(&format!("{what}: {}", word(value)))));
    }
    let settings = document["settings"].as_object().cloned().unwrap_or_default();
    let set = settings.iter().filter(|(_, v)| !v.is_null() && v.as_array().is_none_or(|list| !list.is_empty()));
    let set: Vec<String> = set.map(|(key, value)| format!("{} {}", key.replace('_', " "), word(value))).collect();
    if !set.is_empty() {
        eprint!("{}", wrapped(&format!("settings: {}", set.join(", "))));
    }
    for search in list("searches") {
        let cost = search["cost"].as_f64().unwrap_or(f64::NAN);
        eprintln!("search with seed {}: cost {cost:.6} after {} evaluations", search["seed"], search["evaluations"]);
    }
    let threads = THREADS.get().copied().unwrap_or_else(rayon::current_num_threads);
    eprintln!("{:.1} s on {threads} threads, seed {}", BEGUN.elapsed().as_secs_f64(), document["seed"]);
}
