//! `jointid simulate bode`: frequency response from command to position.

use crate::arguments::{OutputArguments, Sources};
use crate::long_work::stop_flag;
use crate::message::shown;
use crate::operating::{nut_place, outcome, warn_of_result};
use crate::outcome::{CommandResult, deliver, prepare};
use crate::progress::WorkProgress;
use report::bode_text;
use study::Control;
use study::simulation::{BodeRequest, bode};

/// Arguments of `simulate bode`.
#[derive(Debug, clap::Args)]
pub struct BodeArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Lowest frequency (Hz)
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub from_hz: f64,
    /// Highest frequency (Hz); half the velocity loop's rate by default
    #[arg(long, value_name = "F")]
    pub to_hz: Option<f64>,
    /// Number of frequencies, evenly spaced in their logarithm
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(2..=2000))]
    pub points: u16,
    /// Amplitude of the simulated command (m or rad)
    #[arg(long, value_name = "M", default_value_t = 1e-5)]
    pub amplitude_m: f64,
    /// Point whose travel is the output; by default the reading of the position encoder
    #[arg(long, value_name = "POINT")]
    pub response: Option<String>,
    /// Linearise only, without simulating
    #[arg(long)]
    pub linear: bool,
    /// Simulate without friction and backlash, as in the linearisation
    #[arg(long, conflicts_with = "linear")]
    pub smooth: bool,
    /// Nut position from the left end of the screw (m); mid-stroke by default
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub nut_m: Option<f64>,
    /// Lumps per rod
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub lumps: u16,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &BodeArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["bode.json"])?;
    let request = BodeRequest {
        from_hz: given.from_hz,
        to_hz: given.to_hz,
        points: usize::from(given.points),
        amplitude_m: given.amplitude_m,
        response: given.response.clone(),
        linear: given.linear,
        smooth: given.smooth,
        place: nut_place(given.nut_m),
        lumps: usize::from(given.lumps),
    };
    let progress = WorkProgress::begin(given.output.quiet || given.linear, "simulate");
    let study = study.with_control(Control::new(stop_flag(), Some(progress.watcher())));
    let found = bode(&study, &request);
    progress.end();
    let document = found.map_err(shown)?;
    warn_of_result(&given.output, &document.stamp);
    deliver(&given.output, folder.as_ref(), "bode.json", &document, &bode_text(&document))?;
    Ok(outcome(&document.stamp))
}
