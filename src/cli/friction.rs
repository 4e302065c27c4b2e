//! `jointid friction`: fits a Stribeck curve to friction at constant velocities.

use std::path::PathBuf;

use crate::arguments::OutputArguments;
use crate::message::shown;
use crate::outcome::{CommandResult, deliver, prepare, warn};
use crate::words::{Word, one_of};
use report::friction_text;
use study::{FrictionRequest, StribeckNoise, friction};

/// Noise models of friction measurements, by name.
const NOISES: [Word<StribeckNoise>; 3] = [
    ("uniform", StribeckNoise::Uniform, "The same standard deviation in all runs"),
    ("proportional", StribeckNoise::Proportional, "Standard deviation proportional to the friction"),
    ("known", StribeckNoise::Known, "Standard deviations from the column force_sd_n (or torque_sd_nm)"),
];

/// Arguments of `friction`.
#[derive(Debug, clap::Args)]
pub struct FrictionArguments {
    /// Table with the columns velocity_m_s and force_n (or torque_nm), one run at constant velocity per line
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,
    /// Lead of the screw (m per revolution); required with torque_nm
    #[arg(long, allow_negative_numbers = true, value_name = "M")]
    pub lead_m: Option<f64>,
    /// Efficiency between motor torque and screw, above 0 and at most 1
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value_t = 1.0)]
    pub efficiency: f64,
    /// Noise model of the measurements; by default known where the table has standard deviations, else
    /// uniform
    #[arg(long, value_parser = one_of(&NOISES))]
    pub noise: Option<StribeckNoise>,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &FrictionArguments) -> CommandResult {
    let folder = prepare(&given.output, &["friction.json"])?;
    let document = friction(&given.request()).map_err(shown)?;
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "friction.json", &document, &friction_text(&document))
}

impl FrictionArguments {
    fn request(&self) -> FrictionRequest {
        FrictionRequest {
            path: self.data.display().to_string(),
            lead_m: self.lead_m,
            efficiency: self.efficiency,
            noise: self.noise,
        }
    }
}
