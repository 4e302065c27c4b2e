//! What can be said on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

pub use super::file_arguments::{CompletionsArguments, InitArguments, ManArguments, ReportArguments, SchemaArguments};
pub use super::hybrid::HybridArguments;
pub use super::model_arguments::{
    Along, ConvergenceArguments, FrfArguments, FrictionArguments, LoadArguments, MatricesArguments, ModesArguments, NoiseName,
    PublishedArguments, SensitivityArguments, SimulateArguments, Simulation, StiffnessArguments,
};
pub use super::withheld::arguments::WithheldArguments;

/// Joint stiffness and damping of ball-screw feed drives from hammer tests.
#[derive(Debug, Parser)]
#[command(
    name = "jointid",
    version,
    max_term_width = 80,
    propagate_version = true,
    after_help = "Example, with the published bench that comes with the program:\n  jointid identify --positions l1,l3,l5 --out results\n  jointid report results"
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Identify joint parameters from some positions and predict the others
    #[command(after_help = "Example:\n  jointid identify --positions l1,l3,l5 --out results")]
    Identify(IdentifyArguments),
    /// Check an identification at held-out positions, or on another set
    #[command(after_help = "Example:\n  jointid validate --result results/identification.json --positions l2,l4,l6 --fail-above 0.03")]
    Validate(ValidateArguments),
    /// Set multi-position against single-position identification
    #[command(after_help = "Example:\n  jointid compare --positions l1,l3,l5 --single l3,l5")]
    Compare(CompareArguments),
    /// Say where model and machine disagree, which effect is missing, and how far the gap closes
    #[command(
        after_help = "Example:\n  jointid diagnose --without rotor-hold --positions l1,l3,l5\n  jointid diagnose --config axis.toml --measurements axis --out results"
    )]
    Diagnose(DiagnoseArguments),
    /// Make a measurement set of universal files or tables
    #[command(
        after_help = "Example:\n  jointid import tap.uff --list\n  jointid import tap.uff --out bench --pattern 'pos {}' --nut-m l1=0.6"
    )]
    Import(ImportArguments),
    /// Write the FRFs of a measurement set as a universal file
    #[command(after_help = "Example:\n  jointid export --measurements bench --out bench.uff")]
    Export(ExportArguments),
    /// Take natural frequencies from FRFs and track them across positions
    #[command(after_help = "Example:\n  jointid peaks --measurements bench --out bench-peaks")]
    Peaks(PeaksArguments),
    /// Rank positions and responses by what measuring them would tell
    #[command(
        after_help = "Example:\n  jointid plan --choose 3 --data frf --noise 0.02\n  jointid plan --measured l1,l3 --channels table/table,rotor/table"
    )]
    Plan(PlanArguments),
    /// Set the lumped model against the exact one, for several numbers of lumps
    #[command(after_help = "Example:\n  jointid convergence --positions l1,l3,l5 --counts 5,10,20,40")]
    Convergence(ConvergenceArguments),
    /// Fit a Stribeck curve to friction measured at constant velocities
    #[command(after_help = "Example:\n  jointid friction --data axis-1.csv --lead-m 0.005 --efficiency 0.9")]
    Friction(FrictionArguments),
    /// Make one page that can be read anywhere of the results in a folder
    #[command(after_help = "Example:\n  jointid identify --positions l1,l3,l5 --out results\n  jointid report results")]
    Report(ReportArguments),
    /// Begin with a machine of your own: a commented configuration and an empty measurement set
    #[command(after_help = "Example:\n  jointid init my-axis")]
    Init(InitArguments),
    /// Print the JSON Schema of a file or result document
    #[command(after_help = "Example:\n  jointid schema machine > machine.schema.json\n  jointid schema --list")]
    Schema(SchemaArguments),
    /// Print the completions of a shell
    #[command(
        after_help = "Example:\n  jointid completions bash > ~/.local/share/bash-completion/completions/jointid\n  jointid completions zsh > ~/.zfunc/_jointid"
    )]
    Completions(CompletionsArguments),
    /// Write the manual pages
    #[command(after_help = "Example:\n  jointid man --out ~/.local/share/man/man1")]
    Man(ManArguments),
    /// Compute modes, FRFs, stiffness and sensitivity of a machine
    #[command(after_help = "Example:\n  jointid simulate modes --config configs/tian-as-published.toml --position l1")]
    Simulate(SimulateArguments),
    /// Foretell a record's motion by the model, by a network on what it leaves, and by what was named
    #[command(
        after_help = "Example:\n  jointid simulate machine --out machine\n  jointid hybrid --config configs/hybrid-axis.toml --measurements machine/sines\n  jointid hybrid --config configs/hybrid-axis.toml --measurements machine/circles/x --beside machine/circles/y"
    )]
    Hybrid(HybridArguments),
    /// Check the diagnosis blindly on cases whose causes are sealed
    #[command(
        after_help = "Example:\n  jointid withheld --out blind --cases quick\n  jointid withheld --out moved --arm motion\n  jointid withheld --out blind --ablation '--exclude table-mass'"
    )]
    Withheld(WithheldArguments),
}

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
pub struct Output {
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

/// How the search is run.
#[derive(Debug, Args)]
pub struct SearchArguments {
    /// How rods are represented
    #[arg(long, value_enum, default_value = "receptance")]
    pub model: ModelName,
    /// Lumps per rod of the lumped model
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=500))]
    pub lumps: u16,
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

/// `identify`.
#[derive(Debug, Args)]
pub struct IdentifyArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: Output,
}

/// `diagnose`.
#[derive(Debug, Args)]
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
    pub ablate: Vec<super::diagnose::MethodPart>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: Output,
}

/// `validate`.
#[derive(Debug, Args)]
pub struct ValidateArguments {
    /// The identification.json to check
    #[arg(long, value_name = "FILE")]
    pub result: PathBuf,
    /// Folder of the measurement set; that of the identification by default
    #[arg(long, value_name = "DIR")]
    pub measurements: Option<String>,
    /// Positions to check; those held out by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Exit with 1 if a relative frequency error, or for FRFs the gap of a record, is larger
    #[arg(long, value_name = "SHARE")]
    pub fail_above: Option<f64>,
    #[command(flatten)]
    pub output: Output,
}

/// `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions of the multi-position identification
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Positions identified each alone; by default the fit positions but the first, as the paper does
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub single: Option<Vec<String>>,
    /// Compare objectives instead, by leaving out one fit position after another
    #[arg(long, conflicts_with = "single")]
    pub objectives: bool,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: Output,
}

/// `peaks`.
#[derive(Debug, Args)]
pub struct PeaksArguments {
    /// Folder of the measurement set
    #[arg(long, value_name = "DIR")]
    pub measurements: String,
    /// Lowest and highest frequency (Hz)
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Fit the modes of --band alone, what lies outside as a background
    #[arg(long)]
    pub local: bool,
    /// Highest polynomial order of the stabilisation diagram
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u8).range(8..=120))]
    pub max_order: u8,
    /// Show peaks without regularity, too, and why
    #[arg(long)]
    pub all: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Kinds of data by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DataName {
    /// Natural frequencies and amplitudes
    Modes,
    /// Whole FRFs
    Frf,
}

/// `plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Parameter values from this identification.json instead of the start values
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// What is measured; frf where the set has FRFs
    #[arg(long, value_enum)]
    pub data: Option<DataName>,
    /// Measurements to choose at once; 2 and 3, or 1 beside those measured
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(1..=8))]
    pub choose: Vec<u8>,
    /// Measurements made already: positions, or position:response/excitation
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub measured: Vec<String>,
    /// Responses and excitations to choose from; those of the set by default
    #[arg(long, value_name = "POINT/POINT", value_delimiter = ',')]
    pub channels: Vec<String>,
    /// Relative standard deviation of an FRF line
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    pub noise: f64,
    /// Lowest and highest frequency (Hz)
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', num_args = 1)]
    pub band: Vec<f64>,
    /// Lines of an FRF
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u16).range(2..))]
    pub lines: u16,
    /// Keep these parameters at their values
    #[arg(long, value_name = "PARAMETERS", value_delimiter = ',')]
    pub freeze: Vec<String>,
    /// How rods are represented
    #[arg(long, value_enum, default_value = "receptance")]
    pub model: ModelName,
    /// Lumps per rod of the lumped model
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=500))]
    pub lumps: u16,
    /// Choices shown of each ranking
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub top: u16,
    #[command(flatten)]
    pub output: Output,
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

/// `import`.
#[derive(Debug, Args)]
pub struct ImportArguments {
    /// Universal files (dataset 58, 58b) or tables (.csv, .tsv)
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Folder of the new measurement set
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Show what the files hold, from their headers alone
    #[arg(long)]
    pub list: bool,
    /// Take the values of a file that ends inside its data
    #[arg(long)]
    pub accept_truncated: bool,
    /// Quantity, where the files do not say it
    #[arg(long, value_enum)]
    pub quantity: Option<QuantityName>,
    /// Position of all records
    #[arg(long, value_name = "NAME")]
    pub position: Option<String>,
    /// Position's name as {} in file names, ID lines or entities, e.g. 'pos {}'
    #[arg(long, value_name = "TEXT")]
    pub pattern: Option<String>,
    /// Table record,position,response,excitation
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Nut position of a position, e.g. l1=0.6
    #[arg(long, value_name = "NAME=M", value_delimiter = ',')]
    pub nut_m: Vec<String>,
    /// Point of the machine that responds, of all records
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Point of the machine that is excited, of all records
    #[arg(long, value_name = "POINT")]
    pub excitation: Option<String>,
    /// Records averaged for each FRF; needed to use a coherence
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub averages: Option<u32>,
    /// Title of the set
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Say nothing but results and errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// `export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Folder of the measurement set
    #[arg(long, value_name = "DIR")]
    pub measurements: String,
    /// File to write
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Dataset 58b, binary, instead of text
    #[arg(long)]
    pub binary: bool,
}
