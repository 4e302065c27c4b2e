//! The command `jointid`.

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
