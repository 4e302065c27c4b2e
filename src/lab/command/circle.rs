//! `jointid lab circle`: contour error of two axes on a circle.

use crate::document::loops::circles_text;
use crate::simulation::{CircleRequest, circle};
use cli::arguments::{OutputArguments, Sources};
use cli::message::shown;
use cli::operating::{outcome, stoppable};
use cli::outcome::{CommandResult, deliver, prepare, warn};

/// Arguments of `circle`.
#[derive(Debug, clap::Args)]
pub struct CircleArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Configuration of the second axis; that of the first by default
    #[arg(long, alias = "beside-config", value_name = "FILE")]
    pub second_axis_config: Option<String>,
    /// Override one key of the second axis's configuration, e.g. parameter.k_s.start=1e5
    #[arg(long, alias = "beside-set", value_name = "KEY=VALUE")]
    pub second_axis_set: Vec<String>,
    /// Angular speeds (rad/min), comma-separated
    #[arg(
        long,
        value_name = "W",
        value_delimiter = ',',
        default_value = "60,80,100,120",
        allow_negative_numbers = true
    )]
    pub speed_rad_min: Vec<f64>,
    /// Radius (m)
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub radius_m: f64,
    /// Revolutions at full speed
    #[arg(long, value_name = "N", default_value_t = 2.0, allow_negative_numbers = true)]
    pub turns: f64,
    /// Point whose travel is evaluated; by default the reading of the position encoders
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &CircleArguments) -> CommandResult {
    let first = given.sources.open_machine()?;
    let second = Sources {
        config: given.second_axis_config.clone().or_else(|| given.sources.config.clone()),
        set: given.sources.set.iter().chain(&given.second_axis_set).cloned().collect(),
        ..given.sources.clone()
    };
    let second = second.open_machine()?;
    let folder = prepare(&given.output, &["circle.json"])?;
    let request = CircleRequest {
        speed_rad_min: given.speed_rad_min.clone(),
        radius_m: given.radius_m,
        turns: given.turns,
        response: given.response.clone(),
    };
    let document = circle(&stoppable(first), &second, &request).map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "circle.json", &document, &circles_text(&document))?;
    Ok(outcome(&document.stamp))
}
