//! `jointid simulate modes`: undamped natural frequencies and mode shapes.

use crate::arguments::{OutputArguments, RodArguments, Sources};
use crate::completion;
use crate::message::shown;
use crate::operating::{LoadArguments, nut_place, warn_of_result};
use crate::outcome::{CommandResult, deliver, prepare};
use report::modes_text;
use study::simulation::{ModesRequest, Place, modes};

/// Arguments of `simulate modes`.
#[derive(Debug, clap::Args)]
pub struct ModesArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Position of the measurement set; mid-stroke by default
    #[arg(long, value_name = "NAME", add = completion::positions(), conflicts_with = "nut_m")]
    pub position: Option<String>,
    /// Nut position from the left end of the screw (m)
    #[arg(long, value_name = "M")]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Highest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    pub max_hz: f64,
    #[command(flatten)]
    pub rods: RodArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &ModesArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["modes.json"])?;
    let request = ModesRequest {
        place: given.position.clone().map_or_else(|| nut_place(given.nut_m), Place::Position),
        load: given.load.load(),
        max_hz: given.max_hz,
        rods: given.rods.represent(),
    };
    let document = modes(&study, &request).map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    deliver(
        &given.output,
        folder.as_ref(),
        "modes.json",
        &document,
        &modes_text(&document, &study.machine().title),
    )
}
