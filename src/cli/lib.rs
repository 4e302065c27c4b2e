//! The command line: arguments, one file per command, progress, exit codes.

mod arguments;
mod command_line;
mod common;
mod compare;
mod convergence;
mod diagnose;
mod friction;
mod hybrid;
mod identify;
mod import;
mod init;
mod inverse_dynamics;
mod manual;
mod peaks;
mod plan;
mod progress;
mod report;
mod rows;
mod schema;
mod simulate;
mod talk;
mod validate;
mod withheld;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use command_line::{Arguments, Command};
use common::Outcome;

/// Runs the command of this process and gives its exit code: 0 done, 1 a limit was not met, 2 could not run, 3 stopped early.
pub fn run() -> ExitCode {
    std::sync::LazyLock::force(&talk::BEGUN);
    let arguments = Arguments::parse();
    let outcome = match arguments.command {
        Command::Identify(given) => identify::run(&given),
        Command::Validate(given) => validate::run(&given),
        Command::Compare(given) => compare::run(&given),
        Command::Diagnose(given) => diagnose::run(&given),
        Command::Import(given) => import::import(&given),
        Command::Export(given) => import::export(&given),
        Command::Peaks(given) => peaks::run(&given),
        Command::Plan(given) => plan::run(&given),
        Command::Convergence(given) => convergence::run(&given),
        Command::Friction(given) => friction::run(&given),
        Command::Report(given) => report::run(&given),
        Command::Init(given) => init::run(&given),
        Command::Schema(given) => schema::run(&given),
        Command::Completions(given) => manual::completions(&given, Arguments::command()),
        Command::Man(given) => manual::man(&given, Arguments::command()),
        Command::Simulate(given) => simulate::run(&given),
        Command::Hybrid(given) => hybrid::run(&given),
        Command::Withheld(given) => withheld::run(&given),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::LimitNotMet) => ExitCode::from(1),
        Ok(Outcome::Stopped) => ExitCode::from(3),
        Err(message) => {
            talk::failed(&message);
            ExitCode::from(2)
        }
    }
}
