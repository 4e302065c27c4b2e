//! `jointid simulate hold`: impedance of the drive's loops, or gains from an identified spring and damper.

use std::path::{Path, PathBuf};

use crate::arguments::{OutputArguments, Sources};
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare, used, warn};
use report::{hold_gains_text, hold_text};
use study::simulation::{GainsRequest, gains_of_identified, hold, impedance_units};

/// Arguments of `simulate hold`.
#[derive(Debug, clap::Args)]
pub struct HoldArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Frequencies (Hz), comma-separated
    #[arg(long, value_name = "F", value_delimiter = ',', default_value = "1,2,5,10,20,50,100,200,400")]
    pub at_hz: Vec<f64>,
    /// identification.json whose k_s and c_s are converted to gains
    #[arg(long, value_name = "FILE", requires = "constant", requires = "lead_m")]
    pub result: Option<PathBuf>,
    /// With --result: torque per output of the velocity loop (N·m/A or N·m/V)
    #[arg(long, value_name = "G", requires = "result", allow_negative_numbers = true)]
    pub constant: Option<f64>,
    /// With --result: lead of the screw (m per revolution)
    #[arg(long, value_name = "M", requires = "result", allow_negative_numbers = true)]
    pub lead_m: Option<f64>,
    /// With --result: parameters of stiffness and damping, comma-separated
    #[arg(long, value_name = "IDS", value_delimiter = ',', default_value = "k_s,c_s")]
    pub ids: Vec<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &HoldArguments) -> CommandResult {
    match &given.result {
        Some(path) => from_result(given, path),
        None => from_gains(given),
    }
}

fn from_gains(given: &HoldArguments) -> CommandResult {
    let study = given.sources.open_machine()?;
    let folder = prepare(&given.output, &["hold.json"])?;
    let document = hold(&study, &given.at_hz).map_err(shown)?;
    let text = hold_text(&document, impedance_units(&study));
    deliver(&given.output, folder.as_ref(), "hold.json", &document, &text)
}

fn from_result(given: &HoldArguments, path: &Path) -> CommandResult {
    let (study, ..) = given.sources.open_result(path)?;
    let folder = prepare(&given.output, &["hold.json"])?;
    let (constant, lead_m) = (given.constant.unwrap_or(f64::NAN), given.lead_m.unwrap_or(f64::NAN));
    let request = GainsRequest { constant, lead_m, ids: given.ids.clone() };
    let document = gains_of_identified(&study, path, &request).map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    let text = document
        .gains
        .as_ref()
        .map_or_else(String::new, |gains| used(&study, path) + &hold_gains_text(gains, &given.ids));
    deliver(&given.output, folder.as_ref(), "hold.json", &document, &text)
}
