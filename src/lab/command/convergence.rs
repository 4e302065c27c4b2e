//! `jointid lab convergence`: the lumped model against the number of lumps.

use crate::convergence::convergence;
use crate::document::convergence::convergence_text;
use cli::arguments::{OutputArguments, SearchArguments, Sources};
use cli::long_work::{finish, on_threads, resumable};
use cli::message::shown;
use cli::outcome::{CommandResult, deliver, prepare, warn};
use cli::progress::WorkProgress;
use cli::search::settings;

/// Arguments of `convergence`.
#[derive(Debug, clap::Args)]
pub struct ConvergenceArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions to fit, comma-separated; all others are held out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Numbers of lumps per rod, comma-separated
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "5,10,20,40", value_parser = clap::value_parser!(u16).range(1..=500))]
    pub counts: Vec<u16>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &ConvergenceArguments) -> CommandResult {
    let counts: Vec<usize> = given.counts.iter().map(|n| usize::from(*n)).collect();
    let mut study = given.sources.open()?.with_settings(settings(&given.search)?);
    if let Some(names) = &given.positions {
        study = study.fit(names).map_err(shown)?;
    }
    let folder = prepare(&given.output, &["convergence.json"])?;
    let progress = WorkProgress::searches(
        given.output.quiet,
        "convergence",
        usize::from(given.search.repeats) * (counts.len() + 1),
    );
    let study =
        resumable(study, &given.output, folder.as_ref(), &progress, &format!("convergence {counts:?}"))?;
    let document = on_threads(given.search.threads, || convergence(&study, &counts));
    progress.end();
    let document = document?.map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    let text = convergence_text(&study.machine().title, &document);
    deliver(&given.output, folder.as_ref(), "convergence.json", &document, &text)?;
    Ok(finish(&given.output, study.control(), document.stamp.complete))
}
