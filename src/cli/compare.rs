//! `jointid compare`: multi-position against single-position identification, or objectives against each
//! other.

use std::path::{Path, PathBuf};

use crate::arguments::{OutputArguments, SearchArguments, Sources};
use crate::completion;
use crate::long_work::{finish, on_threads, resumable};
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare, warn};
use crate::progress::WorkProgress;
use crate::search::settings;
use report::{change_text, comparison_text, objectives_table};
use study::{compare_results, read_identification};

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions of the multi-position identification, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::records())]
    pub positions: Option<Vec<String>>,
    /// Positions to identify one by one, comma-separated; by default the fit positions except the first, as
    /// in the paper
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::records())]
    pub single: Option<Vec<String>>,
    /// Compare objectives instead, by leave-one-out cross-validation over the fit positions
    #[arg(long, conflicts_with = "single")]
    pub objectives: bool,
    /// Set two identification.json of one machine side by side instead: which parameters changed?
    #[arg(long, value_name = "FILE", num_args = 2, conflicts_with_all = ["single", "objectives", "positions", "config", "measurements", "set", "without"])]
    pub results: Vec<PathBuf>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &CompareArguments) -> CommandResult {
    if let [first, second] = &given.results[..] {
        return results(given, first, second);
    }
    let mut study = given.sources.open()?.with_settings(settings(&given.search)?);
    if let Some(names) = &given.positions {
        study = study.fit(names).map_err(shown)?;
    }
    let name = if given.objectives { "objectives.json" } else { "comparison.json" };
    let folder = prepare(&given.output, &[name])?;
    let runs =
        study.runs_of_comparison(given.single.as_ref().map(Vec::len), given.objectives).map_err(shown)?;
    let progress = WorkProgress::searches(given.output.quiet, "compare", runs * study.settings().repeats);
    let work = format!("compare {:?} {}", given.single, given.objectives);
    let study = resumable(study, &given.output, folder.as_ref(), &progress, &work)?;
    if given.objectives {
        let ran = on_threads(given.search.threads, || study.compare_objectives())?;
        progress.end();
        let document = ran.map_err(shown)?;
        deliver(&given.output, folder.as_ref(), "objectives.json", &document, &objectives_table(&document))?;
        return Ok(finish(&given.output, study.control(), document.stamp.complete));
    }
    let ran = on_threads(given.search.threads, || study.compare_with(given.single.as_deref()))?;
    progress.end();
    let document = ran.map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "comparison.json", &document, &comparison_text(&document))?;
    Ok(finish(&given.output, study.control(), document.stamp.complete))
}

/// Sets two results side by side.
fn results(given: &CompareArguments, first: &Path, second: &Path) -> CommandResult {
    let (a, a_file) = read_identification(first).map_err(shown)?;
    let (b, b_file) = read_identification(second).map_err(shown)?;
    let (machine, document) = compare_results((&a, &a_file), (&b, &b_file)).map_err(shown)?;
    let folder = prepare(&given.output, &["change.json"])?;
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "change.json", &document, &change_text(&machine.title, &document))
}
