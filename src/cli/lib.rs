//! The command line: arguments, commands, exit codes. The laboratory's program, which lies above, shares its
//! arguments, messages and long work.

// The arguments.
pub mod arguments;
mod command_line;
pub mod completion;
pub mod operating;

// One file or folder per command, `completions` and `man` together, `export` with `import`.
mod compare;
mod diagnose;
mod effects;
mod friction;
mod identify;
mod import;
mod init;
mod laboratory;
pub mod manual;
mod peaks;
mod plan;
mod predict;
mod report;
pub mod schema;
mod simulate;
mod validate;

// Shared by commands: searches, long work and messages.
pub mod long_work;
pub mod message;
pub mod outcome;
pub mod progress;
pub mod search;
pub mod terminal;
mod words;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::FromArgMatches;

use command_line::{Arguments, Command, command};
pub use command_line::{Group, grouped};
pub use outcome::exit_code;

/// Runs the command of this process.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs the command with these arguments, the name of the program first. Returns its exit code: 0 done, 1 a
/// limit was not met, 2 could not run, 3 stopped early. A faulty command line ends the process, as do
/// `--help` and `--version`; a command of the laboratory takes its place.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let words: Vec<OsString> = arguments.into_iter().collect();
    if let Some(forwarded) = words.get(1..).and_then(laboratory::requested) {
        return laboratory::run(&words[1..], forwarded);
    }
    let _run = ::report::Run::begin();
    exit_code(match begun::<Arguments>(command(), words.iter().cloned()).command {
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
        Command::Friction(given) => friction::run(&given),
        Command::Report(given) => report::run(&given),
        Command::Init(given) => init::run(&given),
        Command::Schema(given) => schema::run(&given, &study::schema_names(), study::schema),
        Command::Completions(given) => manual::completions(&given, "jointid"),
        Command::Man(given) => manual::man(&given, command()),
        Command::Simulate(given) => simulate::run(&given),
        Command::Lab(given) => return laboratory::run(&words[1..], &given.words),
    })
}

/// Parses the arguments of this process, and starts its threads and the watch for Ctrl-C. A faulty command
/// line ends the process, as does the answer to a shell that completes one.
pub fn begun<A: FromArgMatches>(command: clap::Command, arguments: impl IntoIterator<Item = OsString>) -> A {
    std::sync::LazyLock::force(&terminal::BEGUN);
    let words: Vec<OsString> = arguments.into_iter().collect();
    if completion::answered(&command, &words).unwrap_or_else(|error| error.exit()) {
        std::process::exit(0);
    }
    let parsed = command.try_get_matches_from(words).and_then(|matches| A::from_arg_matches(&matches));
    let arguments = parsed.unwrap_or_else(|error| terminal::refuse(&error));
    long_work::watch_ctrl_c();
    long_work::start_threads();
    arguments
}
