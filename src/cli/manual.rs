//! `jointid completions` and `jointid man`: both of the definitions of the command line.

use clap::CommandFactory;

use super::arguments::{Arguments, CompletionsArguments, ManArguments};
use super::common::{CommandResult, Outcome, print_out};
use crate::report::OutputFolder;

/// Prints completions.
pub fn completions(given: &CompletionsArguments) -> CommandResult {
    let mut text = Vec::new();
    clap_complete::generate(given.shell, &mut Arguments::command(), "jointid", &mut text);
    print_out(&String::from_utf8_lossy(&text))?;
    Ok(Outcome::Done)
}

/// Writes the manual pages of the program and of every command.
pub fn man(given: &ManArguments) -> CommandResult {
    let folder = OutputFolder::prepare(&given.out)?;
    let mut root = Arguments::command();
    root.build();
    let mut count = 0;
    write(&root, &folder, &mut count)?;
    eprintln!("written: {count} pages into {}", given.out.display());
    Ok(Outcome::Done)
}

fn write(command: &clap::Command, folder: &OutputFolder, count: &mut usize) -> Result<(), String> {
    // The name of a page is one word: jointid-simulate-modes.
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    let mut text = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut text).map_err(|e| format!("{name}.1: {e}"))?;
    folder.write(&format!("{name}.1"), &text)?;
    *count += 1;
    command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()).try_for_each(|sub| write(sub, folder, count))
}
