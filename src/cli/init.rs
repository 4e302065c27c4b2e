//! `jointid init`: a commented machine configuration and an empty measurement set.

use std::path::PathBuf;

use crate::message::to_message;
use crate::outcome::{CommandResult, Outcome};
use crate::terminal;
use crate::words::{Word, one_of};
use report::{Existing, OutputFolder};

/// Kinds of the right bearing: whether it floats.
const BEARINGS: [Word<bool>; 2] = [
    ("fixed", false, "The bearing carries axial load"),
    ("floating", true, "The bearing carries no axial load: machine.toml has no joint there"),
];

/// Arguments of `init`.
#[derive(Debug, clap::Args)]
pub struct InitArguments {
    /// Folder to create machine.toml and measurements/ in
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Right bearing of the screw: fixed, or floating, which carries no axial load
    #[arg(long, action = clap::ArgAction::Set, value_parser = one_of(&BEARINGS), default_value = "fixed", value_name = "KIND")]
    pub right_bearing: bool,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Runs the command. Writes all files, or none if one of them already exists.
pub fn run(given: &InitArguments) -> CommandResult {
    let folder = &given.folder;
    let claimed = OutputFolder::claim(folder).map_err(to_message)?;
    let files = study::templates(given.right_bearing);
    let kept = Existing::Kept("name another folder");
    claimed.write_all(files.iter().map(|(name, text)| (name, text)), kept).map_err(to_message)?;
    if !given.quiet {
        for (name, _) in &files {
            terminal::say(&format!("written: {}\n", folder.join(name).display()));
        }
        terminal::say(&format!(
            "replace every nan, fill in modes.csv, then:\n  \
             jointid identify --config {0}/machine.toml \\\n    --measurements {0}/measurements --out {0}/results\n",
            folder.display()
        ));
    }
    Ok(Outcome::Done)
}
