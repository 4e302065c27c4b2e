//! `jointid validate`: on FRFs or modes, or on motion records, as the set holds.

pub mod arguments;
mod records;
mod responses;

use self::arguments::ValidateArguments;
use crate::identified::{check_identification, identified_values, read_identification};
use crate::motion_records::has_only_motion_records;
use crate::outcome::CommandResult;
use crate::sources::{load_again, stamp};

/// Runs the command.
pub fn run(given: &ValidateArguments) -> CommandResult {
    if let Some(limit) = given.fail_above.filter(|l| !(*l > 0.0)) {
        return Err(format!("--fail-above {limit}: write a share above 0, such as 0.03"));
    }
    let (identified, input) = read_identification(&given.result)?;
    check_identification(&given.result, &identified)?;
    let settings = &identified.settings;
    let measurements = given.measurements.as_ref().unwrap_or(&settings.measurements);
    let loaded = load_again(&settings.config, measurements, &identified.stamp, (&[], &[]))?;
    let mut warnings = Vec::new();
    for now in stamp("validation", 0, true, &loaded, Vec::new()).inputs {
        if identified.stamp.inputs.iter().any(|i| i.path == now.path && i.sha256 != now.sha256) {
            warnings.push(format!("{} has changed since the identification; identify again if the change matters", now.path));
        }
    }
    let values = identified_values(&given.result, &identified, &loaded.config)?;
    let run = if has_only_motion_records(&loaded.set) { records::run } else { responses::run };
    run(given, (&identified, input), &loaded, &values, warnings)
}
