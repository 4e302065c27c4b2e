//! `jointid simulate frf`: frequency response functions of a machine.

use std::path::PathBuf;

use crate::arguments::{OutputArguments, QUANTITIES, Sources};
use crate::completion;
use crate::message::shown;
use crate::operating::{LoadArguments, warn_of_result};
use crate::outcome::{CommandResult, deliver, prepare, used};
use crate::terminal;
use crate::words::one_of;
use report::frfs_csv;
use study::Quantity;
use study::simulation::{FrfRequest, Place, frf, identified_frf};

/// Arguments of `simulate frf`.
#[derive(Debug, clap::Args)]
pub struct FrfArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions of the measurement set, comma-separated; all by default
    #[arg(long, value_name = "NAMES", value_delimiter = ',', add = completion::positions(), conflicts_with = "nut_m")]
    pub position: Option<Vec<String>>,
    /// Nut position from the left end of the screw (m)
    #[arg(long, value_name = "M")]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Machine, set and parameter values from this identification.json; --config and --measurements replace
    /// its own
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Lowest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub from_hz: f64,
    /// Highest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    pub to_hz: f64,
    /// Frequency step (Hz)
    #[arg(long, value_name = "F", default_value_t = 0.5)]
    pub step_hz: f64,
    /// Response point; that of the measurement set by default
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Excitation point; that of the measurement set by default
    #[arg(long, value_name = "POINT")]
    pub excitation: Option<String>,
    /// Close the loops of the drive, which hold the machine
    #[arg(long)]
    pub closed_loop: bool,
    /// Add what identify expects beyond the description: journals, nut lengths, losses, guide damping and the
    /// integral action of a hold, at the medians of their priors. By default the machine is exactly as
    /// described
    #[arg(long, conflicts_with = "result")]
    pub with_tolerances: bool,
    /// Quantity to compute
    #[arg(long, value_parser = one_of(&QUANTITIES), default_value = "receptance")]
    pub quantity: Quantity,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &FrfArguments) -> CommandResult {
    let (study, identified) = match &given.result {
        None => (given.sources.open_machine()?, None),
        Some(path) => {
            let (study, document, input) = given.sources.open_result(path)?;
            (study, Some((path, document, input)))
        }
    };
    let request = FrfRequest {
        places: match &given.position {
            Some(names) => names.iter().cloned().map(Place::Position).collect(),
            None => given.nut_m.map(Place::Nut).into_iter().collect(),
        },
        load: given.load.load(),
        from_hz: given.from_hz,
        to_hz: given.to_hz,
        step_hz: given.step_hz,
        lines_hz: None,
        response: given.response.clone(),
        excitation: given.excitation.clone(),
        closed_loop: given.closed_loop,
        with_tolerances: given.with_tolerances,
        quantity: given.quantity,
    };
    let folder = prepare(&given.output, &["frf.json"])?;
    let document = match &identified {
        None => frf(&study, &request),
        Some((path, document, input)) => identified_frf(&study, path, (document, input), &request),
    };
    let document = document.map_err(shown)?;
    if let Some(path) = given.result.as_ref().filter(|_| !given.output.json && !given.output.quiet) {
        terminal::say(&used(&study, path));
    }
    warn_of_result(&given.output, &document.stamp);
    let positions = || study.measurements().positions.iter().map(|p| p.name.clone()).collect();
    let order = given.position.clone().unwrap_or_else(positions);
    deliver(&given.output, folder.as_ref(), "frf.json", &document, &frfs_csv(&document, &order))
}
