//! The command line: arguments, commands, exit codes.

// The arguments.
mod arguments;
mod command_line;

// One file or folder per command, `completions` and `man` together, `export` with `import`.
mod compare;
mod convergence;
mod diagnose;
mod effects;
mod friction;
mod hybrid;
mod identify;
mod import;
mod init;
mod manual;
mod peaks;
mod plan;
mod predict;
mod report;
mod schema;
mod simulate;
mod validate;
mod withheld;

// Shared by commands: searches, long work and messages.
mod long_work;
mod message;
mod outcome;
mod progress;
mod search;
mod terminal;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::FromArgMatches;

use command_line::{Arguments, Command, command};
use outcome::Outcome;
use study::blind_check::Program;

/// Runs the command of this process.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os(), None))
}

/// Runs the command with these arguments, the name of the program first. Returns its exit code: 0 done, 1 a limit was not met, 2 could not run, 3
/// stopped early. A faulty command line ends the process, as do `--help` and `--version`. `program` starts this program where it is not an executable of
/// its own.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>, program: Option<Program>) -> u8 {
    if let Some(program) = program {
        withheld::started_as(program);
    }
    std::sync::LazyLock::force(&terminal::BEGUN);
    let parsed = command().try_get_matches_from(arguments).and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = parsed.unwrap_or_else(|error| terminal::refuse(&error));
    long_work::watch_ctrl_c();
    long_work::start_threads();
    let outcome = match arguments.command {
        Command::Identify(given) => identify::run(&given),
        Command::Validate(given) => validate::run(&given),
        Command::Compare(given) => compare::run(&given),
        Command::Diagnose(given) => diagnose::run(&given),
        Command::Effects(given) => effects::run(&given),
        Command::Import(given) => import::import(&given),
        Command::Export(given) => import::export(&given),
        Command::Peaks(given) => peaks::run(&given),
        Command::Predict(given) => predict::run(&given),
        Command::Plan(given) => plan::run(&given),
        Command::Convergence(given) => convergence::run(&given),
        Command::Friction(given) => friction::run(&given),
        Command::Report(given) => report::run(&given),
        Command::Init(given) => init::run(&given),
        Command::Schema(given) => schema::run(&given),
        Command::Completions(given) => manual::completions(&given, command()),
        Command::Man(given) => manual::man(&given, command()),
        Command::Simulate(given) => simulate::run(&given),
        Command::Hybrid(given) => hybrid::run(&given),
        Command::Withheld(given) => withheld::run(&given),
    };
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::LimitNotMet) => 1,
        Ok(Outcome::Stopped) => 3,
        Err(message) => {
            terminal::failed(&message);
            2
        }
    }
}
