//! `jointid identify`: joint parameters, and predictions of held-out positions.

use crate::arguments::{OutputArguments, SearchArguments, Sources, SplitArguments};
use crate::long_work::{finish, on_threads, resumable};
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare, warn};
use crate::progress::WorkProgress;
use crate::search::settings;
use report::identification_text;

/// `identify`.
#[derive(Debug, clap::Args)]
pub struct IdentifyArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    #[command(flatten)]
    pub search: SearchArguments,
    /// Evaluate the objective and all errors at the start values, without fitting
    #[arg(long, conflicts_with_all = ["freeze", "bootstrap"])]
    pub evaluate: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &IdentifyArguments) -> CommandResult {
    let study = given.sources.open()?;
    let mut settings = settings(&given.search)?;
    if given.evaluate {
        settings.freeze = study.machine().parameters.iter().map(|p| p.id.clone()).collect();
    }
    let study = study.with_settings(settings);
    let study = given.split.applied(study)?;
    let folder = prepare(&given.output, &["identification.json"])?;
    let progress = WorkProgress::searches(given.output.quiet, "identify", study.settings().repeats);
    let study = resumable(study, &given.output, folder.as_ref(), &progress, "identify")?;
    let ran = on_threads(given.search.threads, || study.identify())?;
    progress.end();
    let document = match ran {
        Err(error) if error.is_stop() => return Ok(finish(&given.output, study.control(), false)),
        made => made.map_err(shown)?,
    };
    warn(&given.output, &document.stamp.warnings);
    let derived: Vec<String> = study.machine().derived.iter().map(|d| d.name.clone()).collect();
    let text = identification_text(&study.machine().title, &document, &derived);
    deliver(&given.output, folder.as_ref(), "identification.json", &document, &text)?;
    Ok(finish(&given.output, study.control(), document.stamp.complete))
}
