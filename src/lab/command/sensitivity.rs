//! `jointid lab sensitivity`: a natural frequency over the stiffness of each joint.

use crate::document::sensitivity::sensitivity_text;
use crate::simulation::{SensitivityRequest, sensitivity};
use cli::arguments::{OutputArguments, Sources};
use cli::message::shown;
use cli::operating::{LoadArguments, nut_place, warn_of_result};
use cli::outcome::{CommandResult, deliver, prepare};

/// Arguments of `sensitivity`.
#[derive(Debug, clap::Args)]
pub struct SensitivityArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Number of the natural frequency above 0, from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub order: u16,
    /// Joints, comma-separated; all with a stiffness by default
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub joint: Option<Vec<String>>,
    /// Smallest factor on the stiffness
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 0.5)]
    pub from: f64,
    /// Largest factor on the stiffness
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 1.5)]
    pub to: f64,
    /// Number of factors
    #[arg(long, value_name = "N", default_value_t = 11, value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub steps: u16,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub load: LoadArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &SensitivityArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["sensitivity.json"])?;
    let request = SensitivityRequest {
        order: usize::from(given.order),
        joints: given.joint.clone(),
        from: given.from,
        to: given.to,
        steps: usize::from(given.steps),
        place: nut_place(given.nut_m),
        load: given.load.load(),
    };
    let document = sensitivity(&study, &request).map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    let text = sensitivity_text(&document, &study.machine().title);
    deliver(&given.output, folder.as_ref(), "sensitivity.json", &document, &text)
}
