//! The command line of the laboratory: all commands, each with its arguments.

mod circle;
mod convergence;
mod gain;
mod hybrid;
mod machine;
mod matrices;
mod published;
mod replay;
mod sensitivity;
mod withheld;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use cli::manual::{self, CompletionsArguments, ManArguments};
use cli::{Group, grouped};

/// Examines the method of jointid, and repeats what the papers print
#[derive(Debug, Parser)]
#[command(
    name = "jointid-lab",
    bin_name = "jointid lab",
    version,
    propagate_version = true,
    disable_help_subcommand = true,
    after_help = "Example:\n  jointid lab withheld --out blind --cases quick\n\n«jointid lab COMMAND --help» explains a command."
)]
struct Arguments {
    /// Command to run
    #[command(subcommand)]
    command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
enum Command {
    /// Check the diagnosis blindly on cases with sealed causes
    #[command(
        after_help = "Example:\n  jointid lab withheld --out blind --cases quick\n  jointid lab withheld --out moved --arm motion\n  jointid lab withheld --out blind --ablation '--exclude table-mass'"
    )]
    Withheld(withheld::arguments::WithheldArguments),
    /// Judge stored facts of a blind check again
    #[command(
        after_help = "Example:\n  jointid lab withheld --out blind --cases quick --facts\n  jointid lab replay blind --times 0.5"
    )]
    Replay(replay::ReplayArguments),
    /// Compare the lumped model with the exact one
    #[command(after_help = "Example:\n  jointid lab convergence --positions l1,l3,l5 --counts 5,10,20,40")]
    Convergence(convergence::ConvergenceArguments),
    /// Records of an independent axis with effects that models lack
    #[command(
        after_help = "Example:\n  jointid lab machine --out machine\n  jointid lab hybrid --config configs/hybrid-axis.toml --measurements machine/sines"
    )]
    Machine(machine::MachineArguments),
    /// Compare motion predicted by model, neural network and effects
    #[command(
        after_help = "Example:\n  jointid lab machine --out machine\n  jointid lab hybrid --config configs/hybrid-axis.toml --measurements machine/sines\n  jointid lab hybrid --config configs/hybrid-axis.toml --measurements machine/circles/x --second-axis machine/circles/y"
    )]
    Hybrid(hybrid::HybridArguments),
    /// Published figures next to ours
    #[command(after_help = "Example:\n  jointid lab published --markdown")]
    Published(published::PublishedArguments),
    /// Mass, damping and stiffness matrices
    #[command(after_help = "Example:\n  jointid lab matrices --config configs/twin-ball-screw.toml")]
    Matrices(matrices::MatricesArguments),
    /// Sensitivity of a natural frequency to the stiffness of each joint
    #[command(after_help = "Example:\n  jointid lab sensitivity --config configs/servo-axis.toml")]
    Sensitivity(sensitivity::SensitivityArguments),
    /// Time, error, energy and cost over the position loop's gain
    #[command(after_help = "Example:\n  jointid lab gain --config configs/servo-axis.toml --response slide")]
    Gain(gain::GainArguments),
    /// Contour error of two axes on a circle over speed
    #[command(
        after_help = "Example:\n  jointid lab circle --config configs/hybrid-axis.toml --response table --second-axis-set parameter.moving_mass.start=210"
    )]
    Circle(circle::CircleArguments),
    /// Print the JSON Schema of a document of the laboratory
    #[command(after_help = "Example:\n  jointid lab schema withheld")]
    Schema(cli::schema::SchemaArguments),
    /// Print shell completions of the program jointid-lab
    #[command(
        after_help = "Example:\n  jointid lab completions bash > ~/.local/share/bash-completion/completions/jointid-lab"
    )]
    Completions(CompletionsArguments),
    /// Write man pages
    #[command(after_help = "Example:\n  jointid lab man --out ~/.local/share/man/man1")]
    Man(ManArguments),
}

/// The commands by heading.
const COMMANDS: [Group; 3] = [
    ("Checks of the method", &["withheld", "replay", "convergence", "machine", "hybrid"]),
    ("Figures of the papers", &["published", "matrices", "sensitivity", "gain", "circle"]),
    ("Files", &["schema", "completions", "man"]),
];

/// The command line, with commands listed by heading.
fn command() -> clap::Command {
    grouped(Arguments::command(), &COMMANDS)
}

/// Runs the command of this process. After the word `jointid` the words are those of the product, which the
/// blind check runs as a process of its own.
pub fn run() -> ExitCode {
    let mut words = std::env::args_os().peekable();
    let own = words.next().unwrap_or_default();
    if words.peek().is_some_and(|word| word == withheld::PRODUCT) {
        return cli::run_with(words).into();
    }
    let _run = file_access::Run::begin();
    let outcome = match cli::begun::<Arguments>(command(), std::iter::once(own).chain(words)).command {
        Command::Withheld(given) => withheld::run(&given),
        Command::Replay(given) => replay::run(&given),
        Command::Convergence(given) => convergence::run(&given),
        Command::Machine(given) => machine::run(&given),
        Command::Hybrid(given) => hybrid::run(&given),
        Command::Published(given) => published::run(&given),
        Command::Matrices(given) => matrices::run(&given),
        Command::Sensitivity(given) => sensitivity::run(&given),
        Command::Gain(given) => gain::run(&given),
        Command::Circle(given) => circle::run(&given),
        Command::Schema(given) => {
            cli::schema::run(&given, &crate::document::SCHEMAS, crate::document::schema)
        }
        Command::Completions(given) => manual::completions(&given, "jointid-lab"),
        Command::Man(given) => manual::man(&given, command()),
    };
    cli::exit_code(outcome).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_stands_under_a_heading_and_in_one_line() {
        let root = command();
        let sorted = |mut ids: Vec<String>| {
            ids.sort_unstable();
            ids
        };
        let listed = COMMANDS.iter().flat_map(|(_, ids)| ids.iter().map(ToString::to_string)).collect();
        assert_eq!(
            sorted(listed),
            sorted(root.get_subcommands().map(|sub| sub.get_name().to_string()).collect())
        );
        for sub in root.get_subcommands() {
            let about = sub.get_about().unwrap().to_string();
            assert!(about.chars().count() <= 65, "{}: {about}", sub.get_name());
        }
    }
}
