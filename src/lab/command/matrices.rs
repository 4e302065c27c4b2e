//! `jointid lab matrices`: mass, damping and stiffness matrices.

use crate::document::matrices::matrices_text;
use crate::simulation::{MatricesRequest, matrices};
use cli::arguments::{OutputArguments, Sources};
use cli::message::shown;
use cli::operating::{LoadArguments, nut_place, warn_of_result};
use cli::outcome::{CommandResult, deliver, prepare};

/// Arguments of `matrices`.
#[derive(Debug, clap::Args)]
pub struct MatricesArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    /// Number of springs per rod of the lumped model, each with half of its mass at either end
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub lumps: u16,
    /// Eliminate points without inertia by static condensation
    #[arg(long)]
    pub condense: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &MatricesArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["matrices.json"])?;
    let request = MatricesRequest {
        place: nut_place(given.nut_m),
        load: given.load.load(),
        lumps: usize::from(given.lumps),
        condense: given.condense,
    };
    let document = matrices(&study, &request).map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    let text = matrices_text(&document, &study.machine().title);
    deliver(&given.output, folder.as_ref(), "matrices.json", &document, &text)
}
