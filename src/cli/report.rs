//! `jointid report`: one HTML page of the result documents in a folder.

use std::path::PathBuf;

use crate::message::{shown, to_message};
use crate::outcome::{CommandResult, Outcome, file_target};
use crate::terminal;
use report::{Existing, page};
use study::Sources;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// Folder with result documents, such as identification.json, validation.json, peaks.json or
    /// diagnosis.json
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// File of the page; DIR/report.html by default
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Replace an existing file that is no page of an earlier run
    #[arg(long)]
    pub replace: bool,
    /// Accept files outside the measurement sets' folders in their manifests
    #[arg(long)]
    pub allow_outside: bool,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Runs the command.
pub fn run(given: &ReportArguments) -> CommandResult {
    let sources = Sources { allow_outside: given.allow_outside, ..Sources::default() };
    let page = study::page(&given.folder, &sources).map_err(shown)?;
    let html = page::html(&page);
    let target = given.out.clone().unwrap_or_else(|| given.folder.join("report.html"));
    let existing = if given.replace {
        Existing::Replaced
    } else {
        Existing::Earlier("name another file with --out, or replace it with --replace")
    };
    let (folder, name) = file_target(&target, "--out")?;
    folder.write_all([(&name, html.as_bytes())], existing).map_err(to_message)?;
    let written = folder.file(&name);
    if !given.quiet {
        page.notes.iter().for_each(|n| terminal::note(n));
        if html.len() > page::MOST_BYTES {
            terminal::note(&format!(
                "the page has {:.1} MB, more than many mailboxes accept",
                html.len() as f64 / 1e6
            ));
        }
        terminal::say(&format!("written: {} ({:.1} MB)\n", written.display(), html.len() as f64 / 1e6));
    }
    Ok(Outcome::Done)
}
