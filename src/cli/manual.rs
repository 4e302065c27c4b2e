//! `jointid completions` and `jointid man`, both generated from the definition of the command line.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use crate::completion;
use crate::message::to_message;
use crate::outcome::{CommandResult, Outcome, print_out};
use crate::terminal;
use report::{EARLIER, OutputFolder};

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// Shell to generate completions for
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for the manual pages jointid.1, jointid-identify.1, …
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Prints the completions of a shell.
pub fn completions(given: &CompletionsArguments, program: &str) -> CommandResult {
    let text = completion::script(given.shell, program).map_err(|fault| fault.to_string())?;
    print_out(&String::from_utf8_lossy(&text))?;
    Ok(Outcome::Done)
}

/// Writes the manual pages of the program and of every command.
pub fn man(given: &ManArguments, mut root: Command) -> CommandResult {
    let folder = OutputFolder::claim(&given.out).map_err(to_message)?;
    root.build();
    let mut pages = Vec::new();
    render_pages(&root, &mut pages)?;
    folder.write_all(pages.iter().map(|(name, text)| (name, text)), EARLIER).map_err(to_message)?;
    terminal::say(&format!("written: {} pages into {}\n", pages.len(), given.out.display()));
    Ok(Outcome::Done)
}

/// Appends name and text of the pages of a command and all its subcommands.
fn render_pages(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<(), String> {
    // The name of a page is one word: jointid-simulate-modes.
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    // By this comment a later run recognises its pages.
    let mut text = b".\\\" Page of jointid.\n".to_vec();
    clap_mangen::Man::new(command.clone()).render(&mut text).map_err(|e| format!("{name}.1: {e}"))?;
    pages.push((format!("{name}.1"), text));
    command
        .get_subcommands()
        .filter(|c| c.get_name() != "help" && !c.is_hide_set())
        .try_for_each(|sub| render_pages(sub, pages))
}
