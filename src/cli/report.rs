//! `jointid report`: one HTML page of the result documents in a folder.

use std::path::{Path, PathBuf};

use crate::message::{shown, to_message};
use crate::outcome::{CommandResult, Outcome};
use crate::terminal;
use report::OutputFolder;
use report::page;
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
    if target.is_dir() {
        return Err(format!("{}: is a folder; name a file with --out", target.display()));
    }
    let parent = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = target.file_name().ok_or_else(|| format!("{}: name a file with --out", target.display()))?;
    let written = OutputFolder::prepare(parent)
        .map_err(to_message)?
        .write(&file.to_string_lossy(), html.as_bytes())
        .map_err(to_message)?;
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
