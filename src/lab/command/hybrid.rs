//! `jointid lab hybrid`: a model, a neural network trained on its residual, and two axes on a circle.

use std::path::PathBuf;

use crate::document::hybrid::hybrid_text;
use crate::hybrid::{HybridRequest, hybrid};
use cli::arguments::{OutputArguments, Sources, SplitArguments};
use cli::long_work::{finish, resumable};
use cli::message::shown;
use cli::outcome::{CommandResult, deliver, prepare, warn};
use cli::progress::WorkProgress;

/// Arguments of `hybrid`.
#[derive(Debug, clap::Args)]
pub struct HybridArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    /// identification.json of the machine with the diagnosed effects, to compare with the network
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Folder of a second axis's measurement set; records with the same name in both sets form circles
    #[arg(long, alias = "beside", value_name = "DIR")]
    pub second_axis: Option<String>,
    /// Override one key of the second axis's configuration, e.g. parameter.k_s.start=1e5
    #[arg(long, alias = "beside-set", value_name = "KEY=VALUE", requires = "second_axis")]
    pub second_axis_set: Vec<String>,
    /// identification.json of the second axis with the diagnosed effects
    #[arg(long, alias = "beside-result", value_name = "FILE", requires = "second_axis", requires = "result")]
    pub second_axis_result: Option<PathBuf>,
    /// Seed of the network's initial weights
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &HybridArguments) -> CommandResult {
    let study = given.sources.open()?;
    let second_axis = given.second_axis_sources().map(|sources| sources.open()).transpose()?;
    let folder = prepare(&given.output, &["hybrid.json"])?;
    let request = given.request();
    let progress = WorkProgress::begin(given.output.quiet, "hybrid");
    let work = request.work(second_axis.as_ref()).map_err(shown)?;
    let study = resumable(study, &given.output, folder.as_ref(), &progress, &work)?;
    let document = hybrid(&study, second_axis.as_ref(), &request);
    progress.end();
    let document = match document {
        Err(error) if error.is_stop() => return Ok(finish(&given.output, study.control(), false)),
        made => made.map_err(shown)?,
    };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "hybrid.json", &document, &hybrid_text(&document))?;
    Ok(finish(&given.output, study.control(), document.stamp.complete))
}

impl HybridArguments {
    /// Returns the sources of the second axis: the machine of the first with further overrides, and its own
    /// measurement set.
    fn second_axis_sources(&self) -> Option<Sources> {
        let measurements = self.second_axis.clone()?;
        let set = self.sources.set.iter().chain(&self.second_axis_set).cloned().collect();
        Some(Sources { measurements: Some(measurements), set, ..self.sources.clone() })
    }

    fn request(&self) -> HybridRequest {
        HybridRequest {
            fit: self.split.positions.clone(),
            hold_out: self.split.hold_out.clone(),
            result: self.result.clone(),
            second_axis_result: self.second_axis_result.clone(),
            seed: self.seed,
        }
    }
}
