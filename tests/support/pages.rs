//! The commands of README and guide.

use std::fs;
use std::path::Path;

/// Returns the commands of a page: lines of its shell blocks, and code spans that start with `jointid` and
/// have arguments. Spans with a placeholder in capitals are no commands.
fn commands(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, part) in page.split("```").enumerate() {
        if at % 2 == 1 {
            let lines = part.strip_prefix("sh\n").into_iter().flat_map(str::lines);
            let lines = lines
                .map(|line| line.split(" #").next().unwrap_or_default().trim())
                .filter(|line| !line.is_empty() && !line.starts_with('#'));
            found.extend(lines.map(String::from));
        } else {
            let spans = part.split('`').skip(1).step_by(2).map(|span| span.replace('\n', " "));
            let is_placeholder = |word: &str| word.len() > 1 && word.chars().all(|c| c.is_ascii_uppercase());
            found.extend(spans.filter(|span| {
                span.starts_with("jointid ")
                    && span.split(' ').count() > 2
                    && !span.split(' ').any(is_placeholder)
            }));
        }
    }
    found
}

/// Shortens a long command: a comparison with fewer searches, no cache, one blind case.
fn shortened(command: &str) -> String {
    match command.trim_start_matches("jointid lab ").trim_start_matches("jointid ").split_whitespace().next()
    {
        Some("compare") => format!("{command} --repeats 1"),
        Some("diagnose") => format!("{command} --no-cache"),
        Some("withheld") => {
            let mut words: Vec<&str> = command.split(' ').collect();
            let count = words
                .iter()
                .position(|word| *word == "--cases")
                .expect("the command states its number of cases");
            words[count + 1] = "1";
            words.join(" ")
        }
        _ => command.to_string(),
    }
}

/// Whether a command is one of the laboratory.
pub fn is_of_laboratory(command: &str) -> bool {
    command.starts_with("jointid lab ") || command.starts_with("jointid withheld ")
}

/// A command of a page as printed, and what it prints on stdout; `None` where it was not run.
pub type PageCommand = (String, Option<String>);

/// Runs those commands of a page that are asked for, in a folder; `programs` is the folder of the program
/// `jointid`, and `after_init` fills in the files that `jointid init` writes. Returns all commands of the
/// page.
pub fn run_page(
    page: &Path,
    (programs, is_run): (&Path, impl Fn(&str) -> bool),
    folder: &Path,
    after_init: impl Fn(&Path),
) -> Vec<PageCommand> {
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let run = |text: String| {
        if !text.starts_with("jointid ") || !is_run(&text) {
            return (text, None);
        }
        let line = shortened(&text);
        let output = std::process::Command::new("sh")
            .args(["-c", &line])
            .env("PATH", &path)
            .current_dir(folder)
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{}: {line}: {}",
            page.display(),
            String::from_utf8_lossy(&output.stderr)
        );
        if text.contains(" init ") {
            after_init(folder);
        }
        (text, Some(String::from_utf8(output.stdout).unwrap()))
    };
    commands(&fs::read_to_string(page).unwrap()).into_iter().map(run).collect()
}
