//! `jointid simulate`: one module per simulation.

mod bode;
mod circle;
mod frf;
mod gain;
mod hold;
mod matrices;
mod modes;
mod motion;
mod operating;
mod published;
mod sensitivity;
mod servo_machine;
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
    /// Mass, damping and stiffness matrices
    #[command(after_help = "Example:\n  jointid simulate matrices --config configs/twin-ball-screw.toml")]
    Matrices(matrices::MatricesArguments),
    /// Stiffness and frequencies over position, velocity or load
    #[command(
        after_help = "Example:\n  jointid simulate stiffness --config configs/twin-ball-screw.toml --along velocity --from 0 --to 0.9 --at table"
    )]
    Stiffness(stiffness::StiffnessArguments),
    /// Sensitivity of a natural frequency to the stiffness of each joint
    #[command(after_help = "Example:\n  jointid simulate sensitivity --config configs/servo-axis.toml")]
    Sensitivity(sensitivity::SensitivityArguments),
    /// Motion of the driven axis, along a reference or a record
    #[command(
        after_help = "Example:\n  jointid simulate motion --config configs/emps.toml --reference s-curve --and-back > motion.csv\n  jointid simulate motion --config configs/emps.toml --measurements emps --record sweep --out results"
    )]
    Motion(motion::MotionArguments),
    /// Frequency response from command to position
    #[command(after_help = "Example:\n  jointid simulate bode --config configs/servo-axis.toml --response slide")]
    Bode(bode::BodeArguments),
    /// Time, error, energy and cost over the position loop's gain
    #[command(after_help = "Example:\n  jointid simulate gain --config configs/servo-axis.toml --response slide")]
    Gain(gain::GainArguments),
    /// Stiffness and damping of the loops at the driven point
    #[command(
        after_help = "Example:\n  jointid simulate hold --config configs/servo-axis.toml\n  jointid simulate hold --result results/identification.json --constant 1.0 --lead-m 0.04"
    )]
    Hold(hold::HoldArguments),
    /// Contour error of two axes on a circle over speed
    #[command(
        after_help = "Example:\n  jointid simulate circle --config configs/hybrid-axis.toml --response table --second-axis-set parameter.moving_mass.start=210"
    )]
    Circle(circle::CircleArguments),
    /// Records of an independent axis with effects that models lack
    #[command(
        after_help = "Example:\n  jointid simulate machine --out machine\n  jointid hybrid --config configs/hybrid-axis.toml --measurements machine/sines"
    )]
    Machine(servo_machine::MachineArguments),
    /// Published figures next to ours
    #[command(after_help = "Example:\n  jointid simulate published --markdown")]
    Published(published::PublishedArguments),
}

/// Runs the command.
pub fn run(given: &SimulateArguments) -> CommandResult {
    match &given.what {
        Simulation::Modes(given) => modes::run(given),
        Simulation::Frf(given) => frf::run(given),
        Simulation::Matrices(given) => matrices::run(given),
        Simulation::Stiffness(given) => stiffness::run(given),
        Simulation::Sensitivity(given) => sensitivity::run(given),
        Simulation::Motion(given) => motion::run(given),
        Simulation::Bode(given) => bode::run(given),
        Simulation::Gain(given) => gain::run(given),
        Simulation::Hold(given) => hold::run(given),
        Simulation::Circle(given) => circle::run(given),
        Simulation::Machine(given) => servo_machine::run(given),
        Simulation::Published(given) => published::run(given),
    }
}
