//! `jointid diagnose`: the effect that the model lacks, where, and what it closes.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, SearchArguments, Sources, SplitArguments};
use crate::long_work::{finish, on_threads, resumable};
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare, warn};
use crate::progress::WorkProgress;
use crate::search::settings;
use report::diagnosis::diagnosis_text;
use report::record::motion_diagnosis_text;
use study::{Ablation, DiagnosisRequest, NullCache};

/// A part of the method that can be disabled.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum MethodPart {
    /// Thresholds from χ² tables instead of null simulations
    ChiSquare,
    /// Candidates fitted with all other parameters held at the nominal fit
    FrozenNominal,
    /// No tolerances fitted as nuisance parameters
    NoNuisances,
    /// Candidates ranked by the fitted positions, without cross-validation
    InSample,
}

impl MethodPart {
    /// Returns the ablation of the method.
    fn ablation(self) -> Ablation {
        match self {
            MethodPart::ChiSquare => Ablation::ChiSquare,
            MethodPart::FrozenNominal => Ablation::FrozenNominal,
            MethodPart::NoNuisances => Ablation::NoNuisances,
            MethodPart::InSample => Ablation::InSample,
        }
    }
}

/// `diagnose`.
#[derive(Debug, clap::Args)]
pub struct DiagnoseArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    /// Candidate effects, comma-separated; by default all that apply
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    pub effects: Vec<String>,
    /// Effects to leave out of the candidates, comma-separated
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    pub exclude: Vec<String>,
    /// Null simulations for the thresholds; ten times as many for motion records
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(20..=2000))]
    pub nulls: u16,
    /// Folder for cached null simulations; the platform's cache by default
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Neither read nor write cached null simulations
    #[arg(long)]
    pub no_cache: bool,
    /// Parts of the method to disable, comma-separated
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    pub ablate: Vec<MethodPart>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &DiagnoseArguments) -> CommandResult {
    let study = given.sources.open()?.with_settings(settings(&given.search)?);
    let study = given.split.applied(study)?;
    let request = DiagnosisRequest {
        effects: given.effects.clone(),
        exclude: given.exclude.clone(),
        nulls: usize::from(given.nulls),
        cache: match (given.no_cache, &given.cache) {
            (true, _) => NullCache::None,
            (false, Some(folder)) => NullCache::Folder(folder.clone()),
            (false, None) => NullCache::Platform,
        },
        ablated: given.ablate.iter().map(|part| part.ablation()).collect(),
    };
    let folder = prepare(&given.output)?;
    let progress = WorkProgress::begin(given.output.quiet, "diagnose");
    let study = resumable(study, &given.output, folder.as_ref(), &progress, &format!("diagnose {request:?}"))?;
    let ran = on_threads(given.search.threads, || study.diagnose_with(&request))?;
    progress.end();
    let document = ran.map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    let text = format!(
        "{}\n{}",
        study.machine().title,
        if document.motion.is_some() { motion_diagnosis_text(&document) } else { diagnosis_text(&document) }
    );
    deliver(&given.output, folder.as_ref(), "diagnosis.json", &document, &text)?;
    Ok(finish(&given.output, study.control(), document.stamp.complete))
}
