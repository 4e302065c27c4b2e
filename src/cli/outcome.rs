//! How a command ends: its outcome or fault, and its document as JSON, text and files.

use std::io::Write;

use serde::Serialize;

use crate::arguments::OutputArguments;
use crate::terminal;
use report::{OutputFolder, to_json};

/// How a command ended.
pub enum Outcome {
    /// Done.
    Done,
    /// Done, but a limit that was asked for is not met.
    LimitNotMet,
    /// Stopped early; what is known was delivered.
    Stopped,
}

/// What a command gives: an outcome, or the one message that says why it could not run.
pub type CommandResult = Result<Outcome, String>;

/// Any error as its message.
pub fn to_message(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// The folder results go to, made sure of before the work begins, and this run's alone until its end.
pub fn prepare(output: &OutputArguments) -> Result<Option<OutputFolder>, String> {
    output.out.as_deref().map(OutputFolder::claim).transpose()
}

/// Delivers a document: as JSON alone, or as text for a person; and as a file where a folder was named. That done, so is the command, unless it says otherwise.
pub fn deliver<T: Serialize>(
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    file: &str,
    document: &T,
    text: &str,
) -> CommandResult {
    deliver_with(output, folder, (file, &[]), document, text)
}

/// As [`deliver`], with other files `beside` the document: all are written, or none.
pub fn deliver_with<T: Serialize>(
    output: &OutputArguments,
    folder: Option<&OutputFolder>,
    (file, beside): (&str, &[(&str, String)]),
    document: &T,
    text: &str,
) -> CommandResult {
    let json = to_json(document)?;
    if let Some(folder) = folder {
        let beside = beside.iter().map(|(name, text)| (*name, text.as_str()));
        write_announced(output, folder, &std::iter::once((file, json.as_str())).chain(beside).collect::<Vec<_>>())?;
    }
    print_out(if output.json { &json } else { text })?;
    terminal::background(output, &json);
    Ok(Outcome::Done)
}

/// Writes files, all or none, and says where they are.
pub fn write_announced(output: &OutputArguments, folder: &OutputFolder, files: &[(&str, &str)]) -> Result<(), String> {
    folder.write_all(files.iter().copied())?;
    if !output.json && !output.quiet {
        files.iter().for_each(|(name, _)| eprintln!("written: {}", folder.file(name).display()));
    }
    Ok(())
}

/// Prints to stdout; a closed pipe is no error.
pub fn print_out(text: &str) -> Result<(), String> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(format!("stdout: cannot be written: {error}")),
        _ => Ok(()),
    }
}

/// Warnings for a person, on stderr.
pub fn warn(output: &OutputArguments, warnings: &[String]) {
    if !output.quiet {
        warnings.iter().for_each(|w| terminal::warning(w));
    }
}
