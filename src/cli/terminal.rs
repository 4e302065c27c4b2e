//! Messages on stderr: wrapped to the terminal, except errors; coloured on a terminal unless NO_COLOR is set.

use std::sync::{LazyLock, OnceLock};
use std::time::Instant;

use anstyle::{AnsiColor, Style};
use serde_json::Value;

use crate::arguments::OutputArguments;
use report::wrapped;

/// Time at which the program started.
pub static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
/// Number of threads requested with `--threads`; unset without it.
pub static THREADS: OnceLock<usize> = OnceLock::new();

/// Prints a warning: the finding, and the remedy.
pub fn warning(text: &str) {
    labelled("warning:", AnsiColor::Yellow.on_default().bold(), text);
}

/// Prints a remark.
pub fn note(text: &str) {
    labelled("note:", AnsiColor::Cyan.on_default().bold(), text);
}

/// Prints the message why the command could not run, in one line so that it can be searched for.
pub fn failed(text: &str) {
    let red = AnsiColor::Red.on_default().bold();
    anstream::eprintln!("{red}jointid:{red:#} {text}");
}

fn labelled(label: &str, style: Style, text: &str) {
    let text = wrapped(&format!("{label} {text}"));
    let rest = text.strip_prefix(label).unwrap_or(&text);
    anstream::eprint!("{style}{label}{style:#}{rest}");
}

/// Prints the background of a result, with `--verbose`: inputs, overrides, settings, searches, effects not applicable and run time.
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
    for effect in list("effects").iter().filter(|effect| effect["status"] == "not-applicable") {
        eprint!("{}", wrapped(&format!("not applicable: {}: {}", word(&effect["id"]), word(&effect["why"]))));
    }
    let threads = THREADS.get().copied().unwrap_or_else(rayon::current_num_threads);
    eprintln!("{:.1} s on {threads} threads, seed {}", BEGUN.elapsed().as_secs_f64(), document["seed"]);
}
