//! `jointid validate` on motion records.

use super::arguments::ValidateArguments;
use crate::long_work::stop_flag;
use crate::motion_records::{add_simulated_gaps, list_positions, list_records, preprocess_all};
use crate::outcome::{CommandResult, Outcome, deliver, prepare, to_message, warn};
use crate::sources::{Loaded, stamp};
use measurement::MotionRecord;
use optimizer::Control;
use report::document::{IdentificationDocument, Input, ValidationDocument};
use report::record::records_table;

/// Runs the command.
pub fn run(
    given: &ValidateArguments,
    (identified, input): (&IdentificationDocument, Input),
    loaded: &Loaded,
    values: &[f64],
    warnings: Vec<String>,
) -> CommandResult {
    let simulated = match identified.settings.objective.as_str() {
        "inverse-dynamics" => false,
        "output-error" => true,
        other => {
            return Err(format!(
                "{}: holds motion records only, but {} was fitted by {other}; identify on motion records",
                loaded.set.path,
                given.result.display()
            ));
        }
    };
    let machine = &loaded.config.machine;
    let same_set = given.measurements.is_none();
    let all: Vec<usize> = (0..loaded.set.motions.len()).collect();
    let split = || loaded.set.split_motions(identified.settings.positions.as_deref(), &identified.settings.hold_out).map_err(to_message);
    let split = same_set.then(split).transpose()?;
    let (fitted, held_out) = split.as_ref().map_or((&[][..], &all[..]), |split| (split.fit(), split.held_out()));
    let chosen = match &given.positions {
        Some(names) => loaded.set.split_motions(Some(names), &[]).map_err(to_message)?.fit().to_vec(),
        None if !held_out.is_empty() => held_out.to_vec(),
        None => all.clone(),
    };
    let (motions, rigid, column_warnings) = preprocess_all(loaded)?;
    let warnings: Vec<String> = warnings.into_iter().chain(column_warnings).collect();
    let folder = prepare(&given.output)?;
    let control = Control::new(stop_flag(), None);
    let mut records = list_records(loaded, (&rigid, values), &motions, chosen.iter().copied(), fitted);
    let own: Vec<&MotionRecord> = chosen.iter().map(|i| &loaded.set.motions[*i]).collect();
    let complete = !simulated || add_simulated_gaps(&mut records, (machine, values), &own, &control)?;
    let positions = list_positions(&records, |r| if simulated { r.simulated_force_error } else { Some(r.force_error) });
    let largest_gap = positions.values().filter_map(|p| p.gap).reduce(f64::max);
    let mut stamped = stamp("validation", identified.stamp.seed, complete, loaded, warnings);
    stamped.inputs.push(input);
    let document = ValidationDocument { stamp: stamped, positions, largest_error: None, largest_gap };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "validation.json", &document, &records_table(&records))?;
    Ok(if complete { given.judge("force error", largest_gap) } else { Outcome::Stopped })
}
