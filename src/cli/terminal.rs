//! Messages on stderr: wrapped to the terminal, except errors; coloured on a terminal unless NO_COLOR is set.

use std::io::{IsTerminal, Write};
use std::sync::{LazyLock, Mutex, OnceLock};
use std::time::Instant;

use anstyle::{AnsiColor, Style};
use serde_json::Value;

use report::{brief_numbers, printable, shortened, wrapped};

/// Time at which the program started.
pub static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
/// Number of threads requested with `--threads`; unset without it.
pub static THREADS: OnceLock<usize> = OnceLock::new();

/// Greatest length of a message (characters).
const LONGEST: usize = 2000;
/// Warnings about implausible numbers, the likely reason of a message that there is no result.
static KEPT: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Prints text to stderr. A stderr that cannot be written costs no result.
pub fn say(text: &str) {
    let _ = std::io::stderr().lock().write_all(printable(text).as_bytes());
}

/// Keeps warnings about implausible numbers until the command delivers its result or fails.
pub fn keep_warnings(warnings: Vec<String>) {
    if let Ok(mut kept) = KEPT.lock() {
        *kept = warnings;
    }
}

/// Forgets the kept warnings, which the result contains.
pub fn forget_warnings() {
    keep_warnings(Vec::new());
}

/// Prints a warning: the finding, and the remedy.
pub fn warning(text: &str) {
    labelled("warning:", AnsiColor::Yellow.on_default().bold(), text);
}

/// Prints a remark.
pub fn note(text: &str) {
    labelled("note:", AnsiColor::Cyan.on_default().bold(), text);
}

/// Prints the message why the command could not run, in one line so that it can be searched for, with the
/// implausible numbers of its machine.
pub fn failed(text: &str) {
    let kept = KEPT.lock().map(|kept| kept.join("; ")).unwrap_or_default();
    let text = if kept.is_empty() { text.to_string() } else { format!("{text} (implausible: {kept})") };
    let red = AnsiColor::Red.on_default().bold();
    let _ =
        writeln!(anstream::stderr(), "{red}jointid:{red:#} {}", shortened(&brief_numbers(&text), LONGEST));
}

/// Prints the message about a faulty command line, or the help that was asked for, and ends the process.
pub fn refuse(error: &clap::Error) -> ! {
    let text = error.render().to_string();
    if error.use_stderr() && printable(&text) != text {
        say(&text);
        std::process::exit(error.exit_code());
    }
    error.exit()
}

/// Prints a labelled text, wrapped on a terminal and in one line elsewhere.
fn labelled(label: &str, style: Style, text: &str) {
    let text = format!("{label} {}", shortened(&brief_numbers(text), LONGEST));
    let text = if std::io::stderr().is_terminal() { wrapped(&text) } else { text + "\n" };
    let rest = text.strip_prefix(label).unwrap_or(&text);
    let _ = write!(anstream::stderr(), "{style}{label}{style:#}{rest}");
}

/// Prints the background of a result, with `--verbose`: inputs, overrides, settings, searches, effects not
/// applicable and run time.
pub fn background(verbose: bool, json: &str) {
    if !verbose {
        return;
    }
    let document: Value = serde_json::from_str(json).unwrap_or_default();
    let list = |key: &str| document[key].as_array().cloned().unwrap_or_default();
    let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_string);
    for input in list("inputs") {
        let digest = word(&input["sha256"]);
        say(&wrapped(&format!(
            "read {} (SHA-256 {}…)",
            word(&input["path"]),
            digest.get(..12).unwrap_or(&digest)
        )));
    }
    for (key, what) in [("overrides", "overridden"), ("without", "taken out")] {
        list(key).iter().for_each(|value| say(&wrapped(&format!("{what}: {}", word(value)))));
    }
    let settings = document["settings"].as_object().cloned().unwrap_or_default();
    let set =
        settings.iter().filter(|(_, v)| !v.is_null() && v.as_array().is_none_or(|list| !list.is_empty()));
    let set: Vec<String> =
        set.map(|(key, value)| format!("{} {}", key.replace('_', " "), word(value))).collect();
    if !set.is_empty() {
        say(&wrapped(&format!("settings: {}", set.join(", "))));
    }
    for search in list("searches") {
        let cost = search["cost"].as_f64().unwrap_or(f64::NAN);
        say(&format!(
            "round of searches with seed {}: cost {cost:.6} after {} evaluations\n",
            search["seed"], search["evaluations"]
        ));
    }
    for effect in list("effects").iter().filter(|effect| effect["status"] == "not-applicable") {
        say(&wrapped(&format!("not applicable: {}: {}", word(&effect["id"]), word(&effect["why"]))));
    }
    let threads = THREADS.get().copied().unwrap_or_else(rayon::current_num_threads);
    say(&format!("{:.1} s on {threads} threads, seed {}\n", BEGUN.elapsed().as_secs_f64(), document["seed"]));
}
