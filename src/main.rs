//! The command `jointid`.

use std::process::ExitCode;

fn main() -> ExitCode {
    jointid::cli::run()
}
