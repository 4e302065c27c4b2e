//! `jointid diagnose` on FRFs or modes; on motion records if the set holds neither.

pub mod arguments;
mod effects;
mod learnable;
mod records;
mod responses;

use self::arguments::DiagnoseArguments;
use crate::motion_records::has_only_motion_records;
use crate::outcome::CommandResult;
use crate::sources::load;

/// Runs the command.
pub fn run(given: &DiagnoseArguments) -> CommandResult {
    let loaded = load(&given.sources)?;
    if has_only_motion_records(&loaded.set) { records::run(given, &loaded) } else { responses::run(given, &loaded) }
}
