//! `jointid validate`.

use std::collections::BTreeMap;
use std::path::Path;

use super::arguments::{Sources, ValidateArguments};
use super::common::{CommandResult, Outcome, deliver, document_input, load, prepare, read_document, stamp, told, warn};
use super::rows;
use crate::measurement::HoldOutSet;
use crate::model::Rods;
use crate::objective::{MISSING, ModeObjective, ModeSettings};
use crate::report::document::{Identification, Validation};
use crate::report::positions_table;

/// Runs the command.
pub fn run(given: &ValidateArguments) -> CommandResult {
    if let Some(limit) = given.fail_above.filter(|l| !(*l > 0.0)) {
        return Err(format!("--fail-above {limit}: write a share above 0, such as 0.03"));
    }
    let identified: Identification = read_document(&given.result)?;
    check_identification(&given.result, &identified)?;
    let settings = &identified.settings;
    let sources = Sources {
        config: settings.config.clone(),
        measurements: given.measurements.clone().unwrap_or_else(|| settings.measurements.clone()),
        set: identified.stamp.overrides.clone(),
        without: identified.stamp.without.clone(),
    };
    let loaded = load(&sources)?;
    let machine = &loaded.config.machine;
    let mut warnings = Vec::new();
    for now in stamp("validation", 0, true, &loaded, Vec::new()).inputs {
        if identified.stamp.inputs.iter().any(|i| i.path == now.path && i.sha256 != now.sha256) {
            warnings.push(format!("{} has changed since the identification; identify again if the change matters", now.path));
        }
    }
    let mut values = machine.start();
    for (at, parameter) in machine.parameters.iter().enumerate() {
        let row = identified.parameters.get(&parameter.id).ok_or_else(|| {
            format!("{}: has no parameter «{}», which {} has; identify again", given.result.display(), parameter.id, sources.config)
        })?;
        values[at] = row.value;
    }
    let chosen = match &given.positions {
        Some(names) => names.clone(),
        None if given.measurements.is_none() && !identified.held_out_positions.is_empty() => identified.held_out_positions.clone(),
        None => loaded.set.positions.iter().map(|p| p.name.clone()).collect(),
    };
    let indices = loaded.set.positions_named(&chosen).map_err(told)?;
    let folder = prepare(&given.output)?;
    let mode_settings = ModeSettings { rods: settings.lumps.map_or(Rods::Exact, Rods::Lumped), ..ModeSettings::default() };
    let objective =
        ModeObjective::held_out(machine, &HoldOutSet { set: &loaded.set, positions: indices }, mode_settings, None).map_err(told)?;
    let predictions = objective.predict(&values);
    // The gain belongs to a measurement set: another set has its own.
    let gain = match given.measurements {
        None => identified.parameters.get("gain").map(|g| g.value),
        Some(_) => Some(objective.amplitude_fit(&predictions)).filter(|fit| fit.count > 0).map(|fit| fit.gain),
    };
    let positions: BTreeMap<_, _> = predictions
        .iter()
        .map(|p| {
            let name = loaded.set.positions[p.position].name.clone();
            let role = if given.measurements.is_none() && identified.fit_positions.contains(&name) { "fit" } else { "held_out" };
            (name, rows::position(&loaded.set, p, role, gain, &identified.fit_positions))
        })
        .collect();
    warnings.extend(rows::pairing_warnings(&positions));
    let largest = positions.values().filter_map(|p| p.largest_error(MISSING)).reduce(f64::max);
    let mut stamped = stamp("validation", identified.stamp.seed, true, &loaded, warnings);
    stamped.inputs.push(document_input(&given.result)?);
    let document = Validation { stamp: stamped, positions, largest_error: largest };
    let mut text = positions_table(&document.positions);
    if let Some(largest) = largest {
        text += &format!("\nlargest frequency error: {:.2} %\n", 100.0 * largest);
    }
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "validation.json", &document, &text)?;
    match (given.fail_above, largest) {
        (Some(limit), Some(largest)) if largest > limit => {
            if !given.output.quiet {
                eprintln!("jointid: the largest frequency error, {:.2} %, is above {:.2} %", 100.0 * largest, 100.0 * limit);
            }
            Ok(Outcome::LimitNotMet)
        }
        _ => Ok(Outcome::Done),
    }
}

/// Refuses a document of another form, and values outside their own ranges.
pub fn check_identification(path: &Path, identified: &Identification) -> Result<(), String> {
    if identified.stamp.schema != "jointid/identification/1" {
        return Err(format!(
            "{}: is a {}, not a jointid/identification/1; name the identification.json of identify",
            path.display(),
            identified.stamp.schema
        ));
    }
    for (id, row) in &identified.parameters {
        // A hair beyond the range is rounding.
        let slack = 1e-9 * row.upper.abs().max(row.lower.abs());
        if !(row.value >= row.lower - slack && row.value <= row.upper + slack) {
            return Err(format!(
                "{}: parameters.{id}.value is {}, outside {} … {}; identify again",
                path.display(),
                row.value,
                row.lower,
                row.upper
            ));
        }
    }
    Ok(())
}
