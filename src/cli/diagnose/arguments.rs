//! Arguments of `diagnose`.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, SearchArguments, Sources, SplitArguments};
use diagnosis::Ablation;

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
    pub fn ablation(self) -> Ablation {
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
