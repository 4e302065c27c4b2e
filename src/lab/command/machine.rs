//! `jointid lab machine`: records of the independent servo simulation.

use std::path::PathBuf;

use crate::simulation::{MissingEffect, ServoMachineRequest, write_servo_machine};
use cli::message::shown;
use cli::outcome::{CommandResult, Outcome, print_out};

/// Arguments of `machine`.
#[derive(Debug, clap::Args)]
pub struct MachineArguments {
    /// Folder for the sets `sines`, `circles/x` and `circles/y`
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Effects that the model lacks, comma-separated; growth, lead-error, ripple and presliding by default
    #[arg(long, value_enum, value_name = "NAMES", value_delimiter = ',', conflicts_with = "nothing")]
    pub with: Option<Vec<MissingEffect>>,
    /// Simulate no effect that the model lacks
    #[arg(long)]
    pub nothing: bool,
    /// Seed of the measurement noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Runs the command.
pub fn run(given: &MachineArguments) -> CommandResult {
    let common = if given.nothing { Vec::new() } else { MissingEffect::COMMON.to_vec() };
    let effects = given.with.clone().unwrap_or(common);
    let request = ServoMachineRequest { out: given.out.clone(), effects, seed: given.seed };
    let sets = write_servo_machine(&request).map_err(shown)?;
    let (sines, circles) = (sets.sines.display(), sets.circles.display());
    print_out(&format!(
        "{sines}: F1000 … F6000, sines of 0.1 m\n{circles}: circle-60 … circle-120 of two axes, radius 0.05 m\n"
    ))?;
    Ok(Outcome::Done)
}
