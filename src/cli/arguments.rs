//! Arguments shared by several commands.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::completion;
use crate::message::shown;
use crate::terminal;
use crate::words::{Word, one_of};
use report::document::{IdentificationDocument, Input};
use report::vocabulary::ToleranceUse;
use study::{ObjectiveKind, Quantity, RodModel, Study, StudyResult};

/// Fitted and held-out positions.
#[derive(Debug, Args)]
pub struct SplitArguments {
    /// Positions or records to fit, comma-separated; all others are held out
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::records())]
    pub positions: Option<Vec<String>>,
    /// Records or positions to hold out, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::records())]
    pub hold_out: Vec<String>,
}

/// Machine and measurements.
#[derive(Debug, Clone, Args)]
pub struct Sources {
    /// Machine configuration (.toml); by default the published bench, configs/tian.toml
    #[arg(long, value_name = "FILE")]
    pub config: Option<String>,
    /// Folder of the measurement set (with manifest.toml); by default the set that the configuration names
    #[arg(long, value_name = "DIR")]
    pub measurements: Option<String>,
    /// Override one key of the configuration, such as parameter.k_s.start=1e5; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Effects to take out of the machine's description, comma-separated
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',', add = completion::effects())]
    pub without: Vec<String>,
    /// Accept files outside the measurement set's folder in its manifest
    #[arg(long)]
    pub allow_outside: bool,
}

/// Output of results.
#[derive(Debug, Args)]
pub struct OutputArguments {
    /// Print only the result document, as JSON
    #[arg(long)]
    pub json: bool,
    /// Folder for the result document; without it nothing is written
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print only results and errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Also print inputs, settings, searches and run time
    #[arg(short, long)]
    pub verbose: bool,
}

/// Objectives by name.
const OBJECTIVES: [Word<ObjectiveKind>; 6] = [
    ("least-squares", ObjectiveKind::LeastSquares, "Weighted least squares of frequencies and ln(amplitude)"),
    ("eq26", ObjectiveKind::Eq26, "Eq. 26 of Tian et al. as printed"),
    ("frequencies", ObjectiveKind::Frequencies, "Weighted least squares of frequencies only"),
    ("frf", ObjectiveKind::Frf, "Whole FRFs: complex logarithm of measured over predicted"),
    (
        "inverse-dynamics",
        ObjectiveKind::InverseDynamics,
        "Motion records: force that the rigid machine needs for the measured motion",
    ),
    (
        "output-error",
        ObjectiveKind::OutputError,
        "Motion records: force of the closed loop, simulated from the command",
    ),
];

/// Models by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelName {
    /// Exact wave solution
    Receptance,
    /// Chains of springs and masses
    Lumped,
}

/// Representation of rods.
#[derive(Debug, Args)]
pub struct RodArguments {
    /// Model of the rods
    #[arg(long, value_enum, default_value = "receptance")]
    pub model: ModelName,
    /// Masses per rod of the lumped model
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=500))]
    pub lumps: u16,
}

impl SplitArguments {
    /// Chooses what a study fits and holds out.
    pub fn applied(&self, study: Study) -> Result<Study, String> {
        let study = match &self.positions {
            Some(names) => study.fit(names).map_err(shown)?,
            None => study,
        };
        if self.hold_out.is_empty() { Ok(study) } else { study.hold_out(&self.hold_out).map_err(shown) }
    }
}

/// Returns the ends of a band (Hz); `None` where it is not given.
pub fn band(given: &[f64], example: &str) -> Result<Option<(f64, f64)>, String> {
    match given {
        [] => Ok(None),
        [from, to] => Ok(Some((*from, *to))),
        _ => {
            let given = given.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
            Err(format!(
                "--band {given}: write the lowest and the highest frequency in Hz, such as --band {example}"
            ))
        }
    }
}

impl Sources {
    fn sources(&self) -> study::Sources {
        study::Sources {
            config: self.config.clone(),
            measurements: self.measurements.clone(),
            overrides: self.set.clone(),
            without: self.without.clone(),
            allow_outside: self.allow_outside,
        }
    }

    /// Reads machine and measurements.
    pub fn open(&self) -> Result<Study, String> {
        opened(Study::open(&self.sources()))
    }

    /// Reopens machine and measurements of a result; those that are named replace its own.
    pub fn open_result(&self, path: &Path) -> Result<(Study, IdentificationDocument, Input), String> {
        let (study, document, input) = Study::open_with_result(&self.sources(), path).map_err(shown)?;
        Ok((opened(Ok(study))?, document, input))
    }

    /// Reads a machine; its measurement set where there is one.
    pub fn open_machine(&self) -> Result<Study, String> {
        opened(Study::open_machine(&self.sources()))
    }
}

/// Keeps the warnings about implausible numbers of a study, for the case that it has no result.
pub fn opened(study: StudyResult<Study>) -> Result<Study, String> {
    let study = study.map_err(shown)?;
    terminal::keep_warnings(study.implausible_numbers().to_vec());
    Ok(study)
}

impl RodArguments {
    /// Returns the requested representation.
    pub fn represent(&self) -> RodModel {
        match self.model {
            ModelName::Receptance => RodModel::Exact,
            ModelName::Lumped => RodModel::Lumped(usize::from(self.lumps)),
        }
    }
}

/// Treatment of tolerances.
const TOLERANCES: [Word<ToleranceUse>; 2] = [
    ("fit", ToleranceUse::Fit, "Fit them as nuisance parameters, each with its prior"),
    ("none", ToleranceUse::None, "Hold them at their stated values"),
];

/// Settings of the search.
#[derive(Debug, Args)]
pub struct SearchArguments {
    /// Model of the rods.
    #[command(flatten)]
    pub rods: RodArguments,
    /// Objective to minimise; by default frf for FRFs, inverse-dynamics for motion records, else
    /// least-squares
    #[arg(long, value_parser = one_of(&OBJECTIVES))]
    pub objective: Option<ObjectiveKind>,
    /// Model error of frequencies, relative standard deviation
    #[arg(long, value_name = "SHARE", default_value_t = 0.01)]
    pub frequency_model_error: f64,
    /// Error of ln(amplitude), standard deviation
    #[arg(long, value_name = "SD", default_value_t = 0.13)]
    pub amplitude_sd: f64,
    /// Model error of ln H in addition to the noise, standard deviation
    #[arg(long, value_name = "SD", default_value_t = 0.01)]
    pub frf_model_error: f64,
    /// Treatment of the tolerances that machine and measurement state
    #[arg(long, value_parser = one_of(&TOLERANCES), default_value = "fit")]
    pub tolerances: ToleranceUse,
    /// Lowest and highest frequency of FRFs (Hz), comma-separated
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Bootstrap samples over lines, and as many over positions; 0: none
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub bootstrap: u16,
    /// Parameters to hold at their start values, comma-separated
    #[arg(long, value_name = "PARAMETERS", value_delimiter = ',')]
    pub freeze: Vec<String>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of times that the best minimum has to be found from new starts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub repeats: u16,
    /// Number of threads, which does not change the result; all cores by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// Quantities by name.
pub const QUANTITIES: [Word<Quantity>; 3] = [
    ("receptance", Quantity::Receptance, "Displacement over force"),
    ("mobility", Quantity::Mobility, "Velocity over force"),
    ("accelerance", Quantity::Accelerance, "Acceleration over force"),
];
