//! Arguments that several commands have.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use dynamics::model::Rods;
use measurement::Quantity;

/// What is fitted, and what is held out.
#[derive(Debug, Args)]
pub struct SplitArguments {
    /// Positions (or records) to fit; all others are held out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Records (or positions) to hold out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub hold_out: Vec<String>,
}

/// The machine and its measurements.
#[derive(Debug, Clone, Args)]
pub struct Sources {
    /// Machine configuration (.toml); the published bench by default
    #[arg(long, value_name = "FILE", default_value = config::BENCH)]
    pub config: String,
    /// Folder of the measurement set; the published bench by default
    #[arg(long, value_name = "DIR", default_value = measurement::BENCH)]
    pub measurements: String,
    /// Override one key of the configuration, e.g. parameter.k_s.start=1e5
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Take effects out of the machine's description
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    pub without: Vec<String>,
}

/// How results leave.
#[derive(Debug, Args)]
pub struct OutputArguments {
    /// Print the result document alone, as JSON
    #[arg(long)]
    pub json: bool,
    /// Write the result document into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Say nothing but results and errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say also what was read, how it was set and how long it took
    #[arg(short, long)]
    pub verbose: bool,
}

/// Objectives by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveName {
    /// Weighted, on frequencies and ln(amplitude)
    LeastSquares,
    /// Tian et al., Eq. 26, as printed
    Eq26,
    /// Weighted, on the frequencies alone
    Frequencies,
    /// On whole FRFs: complex logarithm of measured over predicted
    Frf,
    /// On motion records: the force that a rigid machine needs for the measured motion
    InverseDynamics,
    /// On motion records: the force of the closed loop, simulated with the command
    OutputError,
}

/// Models by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelName {
    /// Rods by their exact wave solution
    Receptance,
    /// Rods as chains of springs and masses
    Lumped,
}

/// How rods are represented.
#[derive(Debug, Args)]
pub struct RodArguments {
    /// How rods are represented
    #[arg(long, value_enum, default_value = "receptance")]
    pub model: ModelName,
    /// Lumps per rod of the lumped model
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=500))]
    pub lumps: u16,
}

impl RodArguments {
    /// Rods as asked for.
    pub fn represent(&self) -> Rods {
        match self.model {
            ModelName::Receptance => Rods::Exact,
            ModelName::Lumped => Rods::Lumped(usize::from(self.lumps)),
        }
    }
}

/// What becomes of tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ToleranceName {
    /// Fitted along with whole FRFs, each with its prior
    Fit,
    /// Held at what is stated
    None,
}

/// How the search is run.
#[derive(Debug, Args)]
pub struct SearchArguments {
    #[command(flatten)]
    pub rods: RodArguments,
    /// What is made least; frf where the set has FRFs, inverse-dynamics for motion records, else least-squares
    #[arg(long, value_enum)]
    pub objective: Option<ObjectiveName>,
    /// Relative standard deviation of frequencies that the model causes
    #[arg(long, value_name = "SHARE", default_value_t = 0.01)]
    pub frequency_model_error: f64,
    /// Standard deviation of ln(amplitude)
    #[arg(long, value_name = "SD", default_value_t = 0.13)]
    pub amplitude_sd: f64,
    /// Standard deviation of ln H that the model causes, beside the noise
    #[arg(long, value_name = "SD", default_value_t = 0.01)]
    pub frf_model_error: f64,
    /// Tolerances of machine and measurement
    #[arg(long, value_enum, default_value = "fit")]
    pub tolerances: ToleranceName,
    /// Lowest and highest frequency of FRFs (Hz)
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Bootstrap samples over lines, and as many over positions; 0 for none
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub bootstrap: u16,
    /// Keep these parameters at their start values
    #[arg(long, value_name = "PARAMETERS", value_delimiter = ',')]
    pub freeze: Vec<String>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Searches from different seeds
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub repeats: u16,
    /// Threads; all cores by default. The result does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// Quantities by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum QuantityName {
    /// Displacement over force
    Receptance,
    /// Velocity over force
    Mobility,
    /// Acceleration over force
    Accelerance,
}

impl QuantityName {
    /// The quantity of this name.
    pub fn quantity(self) -> Quantity {
        match self {
            QuantityName::Receptance => Quantity::Receptance,
            QuantityName::Mobility => Quantity::Mobility,
            QuantityName::Accelerance => Quantity::Accelerance,
        }
    }
}
