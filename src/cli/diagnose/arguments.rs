//! What can be said to `diagnose`.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, SearchArguments, Sources, SplitArguments};
use diagnosis::Ablation;

/// A part of the method that can be left out.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum MethodPart {
    /// Thresholds from χ² tables instead of simulated nulls
    ChiSquare,
    /// Candidates fitted with the nominal parameters kept where the nominal fit left them
    FrozenNominal,
    /// Nothing that is ordinarily a little wrong is fitted along
    NoNuisances,
    /// Candidates ranked by the positions they were fitted to alone
    InSample,
}

impl MethodPart {
    /// The same in the words of the method.
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
    /// Candidates; all that apply by default
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    pub effects: Vec<String>,
    /// No candidates
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    pub exclude: Vec<String>,
    /// Simulated nulls that thresholds rest on; ten times as many for motion records
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(20..=2000))]
    pub nulls: u16,
    /// Folder where nulls are kept; the platform's cache by default
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Keep no nulls, and use none
    #[arg(long)]
    pub no_cache: bool,
    /// Leave parts of the method out, to see what they are worth
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    pub ablate: Vec<MethodPart>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}
