//! `jointid simulate`: one module per simulation.

mod bode;
mod frf;
mod hold;
mod modes;
mod motion;
mod stiffness;

use clap::{Args, Subcommand};

use crate::outcome::CommandResult;

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// What to compute.
    #[command(subcommand)]
    pub what: Simulation,
}

/// The simulations.
#[derive(Debug, Subcommand)]
pub enum Simulation {
    /// Undamped natural frequencies and mode shapes at the start values
    #[command(after_help = "Example:\n  jointid simulate modes --nut-m 1.3 --json")]
    Modes(modes::ModesArguments),
    /// Frequency response functions, as CSV or JSON
    #[command(after_help = "Example:\n  jointid simulate frf --position l1,l3 --quantity mobility > frf.csv")]
    Frf(frf::FrfArguments),
    /// Stiffness and frequencies over position, velocity or load
    #[command(
        after_help = "Example:\n  jointid simulate stiffness --config configs/twin-ball-screw.toml --along velocity --from 0 --to 0.9 --at table"
    )]
    Stiffness(stiffness::StiffnessArguments),
    /// Motion of the driven axis, along a reference or a record
    #[command(
        after_help = "Example:\n  jointid simulate motion --config configs/emps.toml --reference s-curve --and-back > motion.csv\n  jointid simulate motion --config configs/emps.toml --measurements emps --record sweep --out results"
    )]
    Motion(motion::MotionArguments),
    /// Frequency response from command to position
    #[command(
        after_help = "Example:\n  jointid simulate bode --config configs/servo-axis.toml --response slide"
    )]
    Bode(bode::BodeArguments),
    /// Stiffness and damping of the loops at the driven point
    #[command(
        after_help = "Example:\n  jointid simulate hold --config configs/servo-axis.toml\n  jointid simulate hold --result results/identification.json --constant 1.0 --lead-m 0.04"
    )]
    Hold(hold::HoldArguments),
}

/// Runs the command.
pub fn run(given: &SimulateArguments) -> CommandResult {
    match &given.what {
        Simulation::Modes(given) => modes::run(given),
        Simulation::Frf(given) => frf::run(given),
        Simulation::Stiffness(given) => stiffness::run(given),
        Simulation::Motion(given) => motion::run(given),
        Simulation::Bode(given) => bode::run(given),
        Simulation::Hold(given) => hold::run(given),
    }
}
