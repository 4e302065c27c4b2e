//! The end of a command: its outcome or error, and its document as JSON, text and files.

use std::io::Write;
use std::path::{Component, Path, PathBuf};

use serde::Serialize;

use crate::arguments::OutputArguments;
use crate::message::to_message;
use crate::terminal;
use report::{EARLIER, Existing, OutputFolder, printable, to_json, wrapped};
use study::Study;

/// How a command ended.
pub enum Outcome {
    /// The command completed.
    Done,
    /// The command completed, but a limit requested by the user is exceeded, such as `--fail-above`.
    LimitNotMet,
    /// Ended early, by Ctrl-C or because a simulated motion diverged; the results so far, if any, are
    /// delivered.
    Stopped,
}

/// Result of a command: its outcome, or the message why it could not run.
pub type CommandResult = Result<Outcome, String>;

/// Returns the line that names the machine and measurements of a result.
pub fn used(study: &Study, result: &Path) -> String {
    let (title, config) = study.machine_source();
    wrapped(&format!(
        "result {}: machine «{title}» ({config}), measurements {}",
        result.display(),
        study.measurements().path
    ))
}

/// Claims the result folder, so that no other run writes into it, for files of these names; `None` without
/// `--out`. Called before the computations start.
pub fn prepare(output: &OutputArguments, names: &[&str]) -> Result<Option<OutputFolder>, String> {
    let folder = output.out.as_deref().map(OutputFolder::claim).transpose().map_err(to_message)?;
    folder.iter().try_for_each(|folder| folder.check(names, EARLIER)).map_err(to_message)?;
    Ok(folder)
}

/// Delivers a document: prints it as JSON or as text, and writes it into the result folder if there is one.
pub fn deliver<T: Serialize>(
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    file: &str,
    document: &T,
    text: &str,
) -> CommandResult {
    deliver_with(output, folder, (file, &[]), document, text)
}

/// As [`deliver`], with other files in addition to the document: all are written, or none.
pub fn deliver_with<T: Serialize>(
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    (file, others): (&str, &[(&str, String)]),
    document: &T,
    text: &str,
) -> CommandResult {
    let json = to_json(document).map_err(to_message)?;
    if let Some(folder) = folder {
        let others = others.iter().map(|(name, text)| (*name, text.as_str()));
        write_announced(
            output,
            folder,
            &std::iter::once((file, json.as_str())).chain(others).collect::<Vec<_>>(),
            EARLIER,
        )?;
    }
    print_out(if output.json { &json } else { text })?;
    terminal::forget_warnings();
    terminal::background(output.verbose, &json);
    Ok(Outcome::Done)
}

/// Writes files, all or none, and prints their paths to stderr, unless `--json` or `--quiet` is given.
pub fn write_announced(
    output: &OutputArguments,
    folder: &OutputFolder,
    files: &[(&str, &str)],
    existing: Existing,
) -> Result<(), String> {
    folder.write_all(files.iter().copied(), existing).map_err(to_message)?;
    if !output.json && !output.quiet {
        files
            .iter()
            .for_each(|(name, _)| terminal::say(&format!("written: {}\n", folder.file(name).display())));
    }
    Ok(())
}

/// Returns what is done with an existing file that an argument names, as `--replace` states.
pub fn named_file(replace: bool) -> Existing {
    if replace {
        Existing::Replaced
    } else {
        Existing::Kept("name another file, or replace it with --replace")
    }
}

/// Checks that a file can be written which is none of the documents of these names in the result folder.
/// Returns its folder and its name.
pub fn prepare_file(
    (path, argument): (&Path, &str),
    existing: Existing,
    (out, documents): (Option<&Path>, &[&str]),
) -> Result<(OutputFolder, String), String> {
    let (folder, name) = file_target(path, argument)?;
    if out.is_some_and(|out| resolved(out) == resolved(folder.path())) && documents.contains(&name.as_str()) {
        return Err(format!("{argument} {}: is a document of this run; name another file", path.display()));
    }
    folder.check(&[&name], existing).map_err(to_message)?;
    Ok((folder, name))
}

/// Returns a path without links and detours, also where its end does not exist yet.
fn resolved(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for part in std::path::absolute(path).unwrap_or_else(|_| path.into()).components() {
        match part {
            Component::ParentDir => drop(clean.pop()),
            part => clean.push(part),
        }
    }
    let known = clean.ancestors().find_map(|known| Some((known, known.canonicalize().ok()?)));
    let rest = known.and_then(|(known, real)| Some(real.join(clean.strip_prefix(known).ok()?)));
    rest.unwrap_or(clean)
}

/// Returns folder and name of a file to write.
pub fn file_target(path: &Path, argument: &str) -> Result<(OutputFolder, String), String> {
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .ok_or_else(|| format!("{argument} {}: name a file", path.display()))?;
    Ok((OutputFolder::prepare(folder).map_err(to_message)?, name.into()))
}

/// Prints to stdout, hidden characters escaped; a closed pipe is no error.
pub fn print_out(text: &str) -> Result<(), String> {
    let text = printable(text);
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(format!("stdout: cannot be written: {error}"))
        }
        _ => Ok(()),
    }
}

/// Prints warnings to stderr.
pub fn warn(output: &OutputArguments, warnings: &[String]) {
    if !output.quiet {
        warnings.iter().for_each(|w| terminal::warning(w));
    }
}

/// Returns the exit code of a command, and prints the message why it could not run.
pub fn exit_code(outcome: CommandResult) -> u8 {
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::LimitNotMet) => 1,
        Ok(Outcome::Stopped) => 3,
        Err(message) => {
            terminal::failed(&message);
            2
        }
    }
}
