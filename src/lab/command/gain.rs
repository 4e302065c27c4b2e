//! `jointid lab gain`: cycles with different gains of the position loop.

use crate::document::loops::gain_text;
use crate::simulation::{GainRequest, gain};
use cli::arguments::{OutputArguments, Sources};
use cli::message::shown;
use cli::operating::{nut_place, outcome, stoppable, warn_of_result};
use cli::outcome::{CommandResult, deliver, prepare};
use study::simulation::TravelProfile;

/// Arguments of `gain`.
#[derive(Debug, clap::Args)]
pub struct GainArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Smallest gain of the position loop (1/min)
    #[arg(long, value_name = "K", default_value_t = 500.0)]
    pub from_per_min: f64,
    /// Largest gain of the position loop (1/min)
    #[arg(long, value_name = "K", default_value_t = 12_000.0)]
    pub to_per_min: f64,
    /// Number of gains
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub points: u16,
    /// Point whose position is evaluated; by default the reading of the position encoder
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Travel (m)
    #[arg(long, value_name = "M", default_value_t = 0.3, allow_negative_numbers = true)]
    pub travel_m: f64,
    /// Largest velocity (m/s)
    #[arg(long, value_name = "V", default_value_t = 0.5)]
    pub velocity_m_s: f64,
    /// Largest acceleration (m/s²)
    #[arg(long, value_name = "A", default_value_t = 5.0)]
    pub acceleration_m_s2: f64,
    /// Largest jerk (m/s³)
    #[arg(long, value_name = "J", default_value_t = 200.0)]
    pub jerk_m_s3: f64,
    /// Rest before and after (s)
    #[arg(long, value_name = "S", default_value_t = 20.0)]
    pub rest_s: f64,
    /// Nut position at the start, from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &GainArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["gain.json"])?;
    let study = stoppable(study);
    let request = GainRequest {
        from_per_min: given.from_per_min,
        to_per_min: given.to_per_min,
        points: usize::from(given.points),
        response: given.response.clone(),
        travel: TravelProfile {
            travel_m: given.travel_m,
            velocity_m_s: given.velocity_m_s,
            acceleration_m_s2: given.acceleration_m_s2,
            jerk_m_s3: given.jerk_m_s3,
            rest_s: given.rest_s,
        },
        place: nut_place(given.nut_m),
    };
    let document = gain(&study, &request).map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    deliver(&given.output, folder.as_ref(), "gain.json", &document, &gain_text(&document))?;
    Ok(outcome(&document.stamp))
}
