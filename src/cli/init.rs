//! `jointid init`.

use std::io::Write;

use super::arguments::InitArguments;
use super::common::{CommandResult, Outcome};
use crate::config::MACHINE_BEGINNING;
use crate::measurement::SET_BEGINNING;

/// Runs the command: writes all files, or none where one of them is there already.
pub fn run(given: &InitArguments) -> CommandResult {
    let folder = &given.folder;
    let machine = (folder.join("machine.toml"), MACHINE_BEGINNING);
    let set = SET_BEGINNING.map(|(name, text)| (folder.join("measurements").join(name), text));
    let files: Vec<_> = std::iter::once(machine).chain(set).collect();
    if let Some((path, _)) = files.iter().find(|(path, _)| path.exists()) {
        return Err(format!("{}: is there already; name another folder", path.display()));
    }
    for (path, text) in &files {
        let told = |e: std::io::Error| format!("{}: cannot be written: {e}", path.display());
        std::fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(told)?;
        // `create_new`: what appears in between is not overwritten either.
        let mut file = std::fs::OpenOptions::new().write(true).create_new(true).open(path).map_err(told)?;
        file.write_all(text.as_bytes()).map_err(told)?;
    }
    if !given.quiet {
        for (path, _) in &files {
            eprintln!("written: {}", path.display());
        }
        eprintln!(
            "replace every nan, fill in modes.csv, then:\n  \
             jointid identify --config {0}/machine.toml \\\n    --measurements {0}/measurements --out {0}/results",
            folder.display()
        );
    }
    Ok(Outcome::Done)
}
