//! `jointid simulate stiffness`: stiffness and natural frequencies over an operating variable.

use crate::arguments::{OutputArguments, Sources};
use crate::message::shown;
use crate::operating::{LoadArguments, nut_place, warn_of_result};
use crate::outcome::{CommandResult, deliver, prepare};
use crate::words::{Word, one_of};
use report::sweep_text;
use study::simulation::{StiffnessRequest, SweepVariable, stiffness};

/// Variables of a sweep, by name.
const VARIABLES: [Word<SweepVariable>; 4] = [
    ("position", SweepVariable::Position, "Nut position (m)"),
    ("velocity", SweepVariable::Velocity, "Velocity (m/s)"),
    ("acceleration", SweepVariable::Acceleration, "Acceleration (m/s²)"),
    ("force", SweepVariable::Force, "External force (N)"),
];

/// Arguments of `simulate stiffness`.
#[derive(Debug, clap::Args)]
pub struct StiffnessArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Variable to sweep
    #[arg(long, value_parser = one_of(&VARIABLES))]
    pub along: SweepVariable,
    /// Start of the sweep; by default 2 % of the stroke for positions
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// End of the sweep; by default 98 % of the stroke for positions
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Number of steps
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub steps: u32,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Point at which to compute the static stiffness
    #[arg(long, value_name = "POINT")]
    pub at: Option<String>,
    /// Nut position (m) of a second, identical axis in series with the first, as in a cross table
    #[arg(long, allow_negative_numbers = true, value_name = "M", requires = "at")]
    pub in_series_with_nut_m: Option<f64>,
    /// Number of natural frequencies above 0 to compute
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(0..=50))]
    pub orders: u16,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &StiffnessArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["stiffness.json"])?;
    let request = StiffnessRequest {
        along: given.along,
        from: given.from,
        to: given.to,
        steps: given.steps as usize,
        place: nut_place(given.nut_m),
        load: given.load.load(),
        at: given.at.clone(),
        in_series_with_nut_m: given.in_series_with_nut_m,
        orders: usize::from(given.orders),
    };
    let document = stiffness(&study, &request).map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    let text = sweep_text(&document, &study.machine().title);
    deliver(&given.output, folder.as_ref(), "stiffness.json", &document, &text)
}
