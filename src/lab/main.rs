//! The command `jointid-lab`, which `jointid lab` runs.

use std::process::ExitCode;

fn main() -> ExitCode {
    lab::run()
}
