//! `jointid simulate machine`.

use std::path::PathBuf;

use crate::outcome::{CommandResult, Outcome, to_message};
use reference_simulator::servo::{Axis, Circle, Feed, Missing, Sensors, write_circles, write_sines};

/// What the machine has and the model of `configs/hybrid-axis.toml` lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Lacking {
    /// The screw has grown by heat
    Growth,
    /// Its lead errs with every turn
    LeadError,
    /// The motor's torque ripples
    Ripple,
    /// Friction is elastic before it slides
    Presliding,
}

/// `simulate machine`.
#[derive(Debug, clap::Args)]
pub struct MachineArguments {
    /// Folder for the sets `sines`, `circles/x` and `circles/y`
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What it has that the model lacks; all by default
    #[arg(long, value_enum, value_name = "NAMES", value_delimiter = ',', conflicts_with = "nothing")]
    pub with: Option<Vec<Lacking>>,
    /// It has nothing that the model lacks
    #[arg(long)]
    pub nothing: bool,
    /// Seed of its noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Runs the command.
pub fn run(given: &MachineArguments) -> CommandResult {
    let all = [Lacking::Growth, Lacking::LeadError, Lacking::Ripple, Lacking::Presliding];
    let with = if given.nothing { Vec::new() } else { given.with.clone().unwrap_or(all.to_vec()) };
    let pared = |axis: Axis| {
        let (usual, none) = (axis.missing, Missing::none());
        let has = |what: Lacking| with.contains(&what);
        let missing = Missing {
            growth: if has(Lacking::Growth) { usual.growth } else { none.growth },
            lead_error_m: if has(Lacking::LeadError) { usual.lead_error_m } else { none.lead_error_m },
            ripple_nm: if has(Lacking::Ripple) { usual.ripple_nm } else { none.ripple_nm },
            presliding_m: if has(Lacking::Presliding) { usual.presliding_m } else { none.presliding_m },
            ..usual
        };
        Axis { missing, ..axis }
    };
    let (x, y) = (pared(Axis::x()), pared(Axis::y()));
    let (sines, circles) = (given.out.join("sines"), given.out.join("circles"));
    for folder in [&sines, &circles] {
        if folder.exists() {
            return Err(format!("{}: is there already; name a folder without it", folder.display()));
        }
    }
    let sensors = Sensors::default();
    write_sines(&sines, &x, &sensors, &Feed::standard(), given.seed).map_err(to_message)?;
    write_circles(&circles, [&x, &y], &sensors, &Circle::standard(), given.seed).map_err(to_message)?;
    println!("{}: F1000 … F6000, sines of 0.1 m", sines.display());
    println!("{}: circle-60 … circle-120 of two axes, radius 0.05 m", circles.display());
    Ok(Outcome::Done)
}
