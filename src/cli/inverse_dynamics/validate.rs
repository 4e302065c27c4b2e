//! `jointid validate` of an identification from motion records.

use std::collections::BTreeMap;

use super::identify::positions;
use crate::delivery::{CommandResult, Outcome, deliver, prepare, told, warn};
use crate::long_work::stop_flag;
use crate::sources::{Loaded, stamp};
use crate::validate::arguments::ValidateArguments;
use identification::simulated_gaps;
use measurement::MotionRecord;
use optimizer::Control;
use report::document::{Identification, Input, Validation};
use report::record::{RecordRow, records_table};

/// Runs the command.
pub fn validate(
    given: &ValidateArguments,
    (identified, input): (&Identification, Input),
    loaded: &Loaded,
    values: &[f64],
    warnings: Vec<String>,
) -> CommandResult {
    let simulated = match identified.settings.objective.as_str() {
        "inverse-dynamics" => false,
        "output-error" => true,
        other => {
            return Err(format!(
                "{}: holds motion records alone, but {} was fitted by {other}; identify on motion records",
                loaded.set.path,
                given.result.display()
            ));
        }
    };
    let machine = &loaded.config.machine;
    let same_set = given.measurements.is_none();
    let all: Vec<usize> = (0..loaded.set.motions.len()).collect();
    let (fitted, left) = if same_set {
        loaded.set.split_motions(identified.settings.positions.as_deref(), &identified.settings.hold_out).map_err(told)?
    } else {
        (Vec::new(), all.clone())
    };
    let chosen = match &given.positions {
        Some(names) => loaded.set.split_motions(Some(names), &[]).map_err(told)?.0,
        None if !left.is_empty() => left,
        None => all,
    };
    let (motions, rigid, told_of) = super::prepared(loaded)?;
    let warnings: Vec<String> = warnings.into_iter().chain(told_of).collect();
    let folder = prepare(&given.output)?;
    let control = Control::new(stop_flag(), None);
    let mut records: BTreeMap<String, RecordRow> = chosen
        .iter()
        .map(|at| {
            let role = if fitted.contains(at) { "fit" } else { "held_out" };
            let row = super::record_row(&rigid, machine, values, &motions[*at], loaded.set.motions[*at].samples(), role);
            (motions[*at].name.clone(), row)
        })
        .collect();
    let mut complete = true;
    if simulated {
        let own: Vec<&MotionRecord> = chosen.iter().map(|i| &loaded.set.motions[*i]).collect();
        for (record, gap) in own.iter().zip(simulated_gaps(machine, values, &own, &control).map_err(told)?) {
            complete &= gap.is_some();
            if let (Some(row), Some(gap)) = (records.get_mut(&record.name), gap) {
                row.simulated_force_error = Some(gap.force);
            }
        }
    }
    let positions = positions(&records, |r| if simulated { r.simulated_force_error } else { Some(r.force_error) });
    let largest_gap = positions.values().filter_map(|p| p.gap).reduce(f64::max);
    let mut stamped = stamp("validation", identified.stamp.seed, complete, loaded, warnings);
    stamped.inputs.push(input);
    let document = Validation { stamp: stamped, positions, largest_error: None, largest_gap };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "validation.json", &document, &records_table(&records))?;
    match (given.fail_above, largest_gap) {
        _ if !complete => Ok(Outcome::Stopped),
        (Some(limit), Some(largest)) if largest > limit => {
            if !given.output.quiet {
                eprintln!("jointid: the largest force error, {:.2} %, is above {:.2} %", 100.0 * largest, 100.0 * limit);
            }
            Ok(Outcome::LimitNotMet)
        }
        _ => Ok(Outcome::Done),
    }
}
