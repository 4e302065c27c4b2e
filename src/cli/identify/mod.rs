//! `jointid identify` on FRFs or modes, or on motion records, whichever the set holds.

pub mod arguments;
mod records;
mod responses;

use self::arguments::IdentifyArguments;
use crate::motion_records::has_only_motion_records;
use crate::outcome::CommandResult;
use crate::sources::load;

/// Runs the command.
pub fn run(given: &IdentifyArguments) -> CommandResult {
    let loaded = load(&given.sources)?;
    if has_only_motion_records(&loaded.set) { records::run(given, &loaded) } else { responses::run(given, &loaded) }
}
