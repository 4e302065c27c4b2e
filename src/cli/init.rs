//! `jointid init`: a commented machine configuration and an empty measurement set.

use std::path::PathBuf;

use crate::message::to_message;
use crate::outcome::{CommandResult, Outcome};
use crate::terminal;
use crate::words::{Word, one_of};
use report::{Existing, OutputFolder};
use study::Template;

/// Kinds of the right bearing: whether it floats.
const BEARINGS: [Word<bool>; 2] = [
    ("fixed", false, "The bearing carries axial load"),
    ("floating", true, "The bearing carries no axial load: machine.toml has no joint there"),
];

/// Kinds of axes and their records.
const KINDS: [Word<Template>; 3] = [
    ("screw", Template::FixedScrew, "Ball-screw axis, for FRFs or natural frequencies"),
    ("motion-linear", Template::LinearMotion, "Rigid linear axis, for motion records in m and N"),
    ("motion-rotary", Template::RotaryMotion, "Rigid rotary axis, for motion records in rad and N·m"),
];

/// Arguments of `init`.
#[derive(Debug, clap::Args)]
pub struct InitArguments {
    /// Folder to create machine.toml and measurements/ in
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Kind of the axis and its records
    #[arg(long, value_parser = one_of(&KINDS), default_value = "screw", value_name = "KIND")]
    pub kind: Template,
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
    let template = match (given.kind, given.right_bearing) {
        (Template::FixedScrew, true) => Template::FloatingScrew,
        (kind, false) => kind,
        _ => return Err("--right-bearing: an axis for motion records has no screw; leave it out".into()),
    };
    let files = study::templates(template);
    let kept = Existing::Kept("name another folder");
    claimed.write_all(files.iter().map(|(name, text)| (name, text)), kept).map_err(to_message)?;
    if !given.quiet {
        for (name, _) in &files {
            terminal::say(&format!("written: {}\n", folder.join(name).display()));
        }
        let first = match given.kind {
            Template::FixedScrew | Template::FloatingScrew => "replace every nan, fill in modes.csv",
            _ => "name your records in manifest.toml, check the ranges in machine.toml",
        };
        terminal::say(&format!(
            "{first}, then:\n  \
             jointid identify --config {0}/machine.toml \\\n    --measurements {0}/measurements --out {0}/results\n",
            folder.display()
        ));
    }
    Ok(Outcome::Done)
}
