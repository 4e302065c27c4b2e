//! `jointid simulate machine`: records of the independent servo simulation.

use std::path::PathBuf;

use crate::outcome::{CommandResult, Outcome, to_message};
use reference_simulator::servo::{Axis, Circle, Feed, Missing, Sensors, write_circles, write_sines};

/// Effects that the machine has and the model of `configs/hybrid-axis.toml` lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MissingEffect {
    /// Thermal expansion of the screw
    Growth,
    /// Lead error, periodic with the revolution of the screw
    LeadError,
    /// Torque ripple of the motor
    Ripple,
    /// Presliding: friction that is elastic before it slides
    Presliding,
}

/// Arguments of `simulate machine`.
#[derive(Debug, clap::Args)]
pub struct MachineArguments {
    /// Folder for the sets `sines`, `circles/x` and `circles/y`
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Effects that the model lacks, comma-separated; all by default
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
    let all = [MissingEffect::Growth, MissingEffect::LeadError, MissingEffect::Ripple, MissingEffect::Presliding];
    let with = if given.nothing { Vec::new() } else { given.with.clone().unwrap_or(all.to_vec()) };
    let with_effects = |axis: Axis| {
        let (usual, none) = (axis.missing, Missing::none());
        let has = |what: MissingEffect| with.contains(&what);
        let missing = Missing {
            growth: if has(MissingEffect::Growth) { usual.growth } else { none.growth },
            lead_error_m: if has(MissingEffect::LeadError) { usual.lead_error_m } else { none.lead_error_m },
            ripple_nm: if has(MissingEffect::Ripple) { usual.ripple_nm } else { none.ripple_nm },
            presliding_m: if has(MissingEffect::Presliding) { usual.presliding_m } else { none.presliding_m },
            ..usual
        };
        Axis { missing, ..axis }
    };
    let (x, y) = (with_effects(Axis::x()), with_effects(Axis::y()));
    let (sines, circles) = (given.out.join("sines"), given.out.join("circles"));
    for folder in [&sines, &circles] {
        if folder.exists() {
            return Err(format!("{}: already exists; name another folder", folder.display()));
        }
    }
    let sensors = Sensors::default();
    write_sines(&sines, &x, &sensors, &Feed::standard(), given.seed).map_err(to_message)?;
    write_circles(&circles, [&x, &y], &sensors, &Circle::standard(), given.seed).map_err(to_message)?;
    println!("{}: F1000 … F6000, sines of 0.1 m", sines.display());
    println!("{}: circle-60 … circle-120 of two axes, radius 0.05 m", circles.display());
    Ok(Outcome::Done)
}
