//! Reads `identification.json`.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::Path;

use crate::outcome::to_message;
use crate::sources::Loaded;
use config::MachineConfig;
use identification::held_at;
use machine::{Machine, ParameterValues};
use report::digest;
use report::document::{IdentificationDocument, Input};

/// Allowance for rounding at the bounds of a range, relative to the bound of larger magnitude (1).
const ROUNDING: f64 = 1e-9;
/// Numbers of masses per rod of the lumped model, as `--lumps` accepts them.
const LUMPS: RangeInclusive<usize> = 1..=500;

/// Reads `identification.json`. Returns the document, and its file with digest as an input of another document.
pub fn read_identification(path: &Path) -> Result<(IdentificationDocument, Input), String> {
    let bytes = std::fs::read(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => format!("{}: there is no such file; run identify with --out first", path.display()),
        _ if path.is_dir() => format!("{}: is a folder; name the identification.json in it", path.display()),
        _ => format!("{}: {e}", path.display()),
    })?;
    let document = serde_json::from_slice(&bytes);
    let document = document.map_err(|e| format!("{}, line {}: is not a result of `identify`: {e}", path.display(), e.line()))?;
    Ok((document, Input { path: path.display().to_string(), sha256: digest(&bytes) }))
}

/// Checks the schema of an identification, its number of lumps, and that every value lies in its range.
///
/// # Errors  a message that names file and key.
pub fn check_identification(path: &Path, identified: &IdentificationDocument) -> Result<(), String> {
    if identified.stamp.schema != "jointid/identification/1" {
        return Err(format!(
            "{}: is a {}, not a jointid/identification/1; name the identification.json of identify",
            path.display(),
            identified.stamp.schema
        ));
    }
    if let Some(lumps) = identified.settings.lumps.filter(|lumps| !LUMPS.contains(lumps)) {
        return Err(format!(
            "{}: settings.lumps is {lumps}, but a rod has {} to {} lumps; identify again",
            path.display(),
            LUMPS.start(),
            LUMPS.end()
        ));
    }
    for (id, row) in &identified.parameters {
        let slack = ROUNDING * row.upper.abs().max(row.lower.abs());
        if !(row.value >= row.lower - slack && row.value <= row.upper + slack) {
            return Err(format!(
                "{}: parameters.{id}.value is {} {unit}, outside {} … {} {unit}; identify again",
                path.display(),
                row.value,
                row.lower,
                row.upper,
                unit = row.unit
            ));
        }
    }
    Ok(())
}

/// Builds the machine as identified, with tolerances held at their estimates.
///
/// Returns it with the values of its parameters, in its order. `configured_values` are the values of the parameters of the configured machine, and
/// come first. Parameters that the tolerances add follow.
pub fn identified_machine(
    identified: &IdentificationDocument,
    loaded: &Loaded,
    configured_values: &[f64],
) -> Result<(Machine, ParameterValues), String> {
    let machine = held_at(&loaded.config.machine, &loaded.set.nuts_m(), &tolerances(identified)).map_err(to_message)?;
    let added = machine.parameters.iter().skip(configured_values.len()).map(|p| p.start);
    let values = ParameterValues(configured_values.iter().copied().chain(added).collect());
    Ok((machine, values))
}

/// Returns the estimates of the tolerances by name.
pub fn tolerances(identified: &IdentificationDocument) -> BTreeMap<String, f64> {
    identified.tolerances.iter().map(|(name, row)| (name.clone(), row.value)).collect()
}

/// Returns the identified values of all parameters of a configured machine, in its order.
pub fn identified_values(path: &Path, identified: &IdentificationDocument, config: &MachineConfig) -> Result<ParameterValues, String> {
    let value = |id: &String| {
        let row = identified.parameters.get(id);
        row.map(|row| row.value)
            .ok_or_else(|| format!("{}: has no parameter «{id}», which {} has; identify again", path.display(), config.path))
    };
    config.machine.parameters.iter().map(|p| value(&p.id)).collect::<Result<_, _>>().map(ParameterValues)
}
