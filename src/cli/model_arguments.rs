//! What can be said on the command line to simulations, friction and the lumped model's convergence.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::arguments::{ModelName, Output, QuantityName, SearchArguments, Sources};
use super::bode::BodeArguments;
use super::circle::CircleArguments;
use super::gain::GainArguments;
use super::hold::HoldArguments;
use super::motion::MotionArguments;
use super::servo_machine::MachineArguments;

/// What loads the machine.
#[derive(Debug, Clone, Copy, Args)]
pub struct LoadArguments {
    /// Velocity of the table (m/s), whose friction loads contacts
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²), whose inertia loads contacts
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub acceleration_m_s2: Option<f64>,
    /// Outside axial force (N) that loads contacts
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub force_n: Option<f64>,
}

/// `simulate matrices`.
#[derive(Debug, Args)]
pub struct MatricesArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Lumps per rod
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub lumps: u16,
    /// Eliminate points without inertia, which follow the others statically
    #[arg(long)]
    pub condense: bool,
    #[command(flatten)]
    pub output: Output,
}

/// What is swept, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Along {
    /// Nut position (m)
    Position,
    /// Velocity (m/s)
    Velocity,
    /// Acceleration (m/s²)
    Acceleration,
    /// Outside force (N)
    Force,
}

/// `simulate stiffness`.
#[derive(Debug, Args)]
pub struct StiffnessArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// What is swept
    #[arg(long, value_enum)]
    pub along: Along,
    /// Where it begins; 2 % of the stroke for positions
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Where it ends; 98 % of the stroke for positions
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Steps
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub steps: u32,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Point at which the static stiffness is wanted
    #[arg(long, value_name = "POINT")]
    pub at: Option<String>,
    /// Nut position of a second axis of the same kind in series with the first, as a cross table is
    #[arg(long, allow_negative_numbers = true, value_name = "M", requires = "at")]
    pub in_series_with_nut_m: Option<f64>,
    /// Natural frequencies above 0 to compute
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(0..=50))]
    pub orders: u16,
    #[command(flatten)]
    pub output: Output,
}

/// `simulate sensitivity`.
#[derive(Debug, Args)]
pub struct SensitivityArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Which natural frequency above 0, from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub order: u16,
    /// Joints; all with a stiffness by default
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub joint: Option<Vec<String>>,
    /// Least factor on the stiffness
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 0.5)]
    pub from: f64,
    /// Largest factor on the stiffness
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 1.5)]
    pub to: f64,
    /// Factors
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub steps: u16,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    #[command(flatten)]
    pub output: Output,
}

/// `simulate published`.
#[derive(Debug, Args)]
pub struct PublishedArguments {
    /// Print the table as Markdown
    #[arg(long)]
    pub markdown: bool,
    #[command(flatten)]
    pub output: Output,
}

/// `convergence`.
#[derive(Debug, Args)]
pub struct ConvergenceArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions to fit; all others are held out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Numbers of lumps per rod
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "5,10,20,40", value_parser = clap::value_parser!(u16).range(1..=500))]
    pub counts: Vec<u16>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: Output,
}

/// What is known of the scatter of friction measurements, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NoiseName {
    /// Equal in all runs
    Uniform,
    /// In proportion to the friction
    Proportional,
    /// A column force_sd_n (or torque_sd_nm) gives it
    Known,
}

/// `friction`.
#[derive(Debug, Args)]
pub struct FrictionArguments {
    /// Table with the columns velocity_m_s and force_n, or torque_nm; one run at constant velocity a line
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Lead of the screw (m per turn); needed with torque_nm
    #[arg(long, allow_negative_numbers = true, value_name = "M")]
    pub lead_m: Option<f64>,
    /// Efficiency between motor torque and screw
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 1.0)]
    pub efficiency: f64,
    /// What is known of the scatter; known where the table gives it, else uniform
    #[arg(long, value_enum)]
    pub noise: Option<NoiseName>,
    #[command(flatten)]
    pub output: Output,
}

/// `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// What to compute.
    #[command(subcommand)]
    pub what: Simulation,
}

/// What can be simulated.
#[derive(Debug, Subcommand)]
pub enum Simulation {
    /// Undamped natural frequencies and mode shapes at the start values
    #[command(after_help = "Example:\n  jointid simulate modes --nut-m 1.3 --json")]
    Modes(ModesArguments),
    /// Frequency response functions, as CSV or JSON
    #[command(after_help = "Example:\n  jointid simulate frf --position l1,l3 --quantity mobility > frf.csv")]
    Frf(FrfArguments),
    /// Mass, damping and stiffness matrices
    #[command(after_help = "Example:\n  jointid simulate matrices --config configs/twin-ball-screw.toml")]
    Matrices(MatricesArguments),
    /// Stiffness and natural frequencies along position, velocity, acceleration or force
    #[command(
        after_help = "Example:\n  jointid simulate stiffness --config configs/twin-ball-screw.toml --along velocity --from 0 --to 0.9 --at table"
    )]
    Stiffness(StiffnessArguments),
    /// How the stiffness of each joint moves a natural frequency
    #[command(after_help = "Example:\n  jointid simulate sensitivity --config configs/servo-axis.toml")]
    Sensitivity(SensitivityArguments),
    /// A driven axis in time, as CSV or JSON: references, or a measured record in closed loop
    #[command(
        after_help = "Example:\n  jointid simulate motion --config configs/emps.toml --reference s-curve --and-back > motion.csv\n  jointid simulate motion --config configs/emps.toml --measurements emps --record sweep --out results"
    )]
    Motion(MotionArguments),
    /// From command to position by frequency: linearised, and simulated with a sine
    #[command(after_help = "Example:\n  jointid simulate bode --config configs/servo-axis.toml --response slide")]
    Bode(BodeArguments),
    /// Time, static error, energy and cost of gains of the position loop
    #[command(after_help = "Example:\n  jointid simulate gain --config configs/servo-axis.toml --response slide")]
    Gain(GainArguments),
    /// The drive's loops as a spring and a damper at the point they hold, or an identified hold as gains
    #[command(
        after_help = "Example:\n  jointid simulate hold --config configs/servo-axis.toml\n  jointid simulate hold --result results/identification.json --constant 1.0 --lead-m 0.04"
    )]
    Hold(HoldArguments),
    /// Two axes on a circle: contour error by speed
    #[command(
        after_help = "Example:\n  jointid simulate circle --config configs/hybrid-axis.toml --response table --beside-set parameter.moving_mass.start=210"
    )]
    Circle(CircleArguments),
    /// Records of a «machine» that has what the model of configs/hybrid-axis.toml lacks, made by equations of its own
    #[command(
        after_help = "Example:\n  jointid simulate machine --out machine\n  jointid hybrid --config configs/hybrid-axis.toml --measurements machine/sines"
    )]
    Machine(MachineArguments),
    /// Every figure that the papers of the models print, beside ours
    #[command(after_help = "Example:\n  jointid simulate published --markdown")]
    Published(PublishedArguments),
}

/// `simulate modes`.
#[derive(Debug, Args)]
pub struct ModesArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// A position of the measurement set; mid-stroke by default
    #[arg(long, value_name = "NAME", conflicts_with = "nut_m")]
    pub position: Option<String>,
    /// Nut position from the left end of the screw (m)
    #[arg(long, value_name = "M")]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Highest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    pub max_hz: f64,
    /// How rods are represented
    #[arg(long, value_enum, default_value = "receptance")]
    pub model: ModelName,
    /// Lumps per rod of the lumped model
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=500))]
    pub lumps: u16,
    #[command(flatten)]
    pub output: Output,
}

/// `simulate frf`.
#[derive(Debug, Args)]
pub struct FrfArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions of the measurement set; all by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "nut_m")]
    pub position: Option<Vec<String>>,
    /// Nut position from the left end of the screw (m)
    #[arg(long, value_name = "M")]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Parameter values from this identification.json instead of the start values
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Lowest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub from_hz: f64,
    /// Highest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    pub to_hz: f64,
    /// Step (Hz)
    #[arg(long, value_name = "F", default_value_t = 0.5)]
    pub step_hz: f64,
    /// Point that responds; that of the measurement set by default
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Point that is excited; that of the measurement set by default
    #[arg(long, value_name = "POINT")]
    pub excitation: Option<String>,
    /// With the loops of the drive closed, which hold the machine
    #[arg(long)]
    pub closed_loop: bool,
    /// Quantity
    #[arg(long, value_enum, default_value = "receptance")]
    pub quantity: QuantityName,
    #[command(flatten)]
    pub output: Output,
}
