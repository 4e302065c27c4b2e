//! Reads `identification.json`, and opens its machine and measurements again.

use std::ops::RangeInclusive;
use std::path::Path;

use crate::{Sources, Study, StudyError, StudyResult};
use identification::held_at;
use machine::Machine;
use report::digest;
use report::document::{IdentificationDocument, Input};

/// Allowance for rounding at the bounds of a range, relative to the bound of larger magnitude (1).
const ROUNDING: f64 = 1e-9;
/// Numbers of masses per rod of the lumped model.
const LUMPS: RangeInclusive<usize> = 1..=500;

/// Reads `identification.json`. Returns the document, and its file with digest as an input of another document.
///
/// # Errors  the file cannot be read, or is not a result of an identification.
pub fn read_identification(path: &Path) -> StudyResult<(IdentificationDocument, Input)> {
    let bytes = std::fs::read(path).map_err(|e| {
        let fault = match e.kind() {
            std::io::ErrorKind::NotFound => "there is no such file; run identify with --out first".to_string(),
            _ if path.is_dir() => "is a folder; name the identification.json in it".into(),
            _ => e.to_string(),
        };
        StudyError::input(path.display(), fault)
    })?;
    let document = serde_json::from_slice(&bytes);
    let document = document
        .map_err(|e| StudyError::input(format!("{}, line {}", path.display(), e.line()), format!("is not a result of `identify`: {e}")))?;
    Ok((document, Input { path: path.display().to_string(), sha256: digest(&bytes) }))
}

/// Checks the schema of an identification, its number of lumps, and that every value lies in its range.
///
/// # Errors  the file and the key that is at fault.
pub fn check_identification(path: &Path, identified: &IdentificationDocument) -> StudyResult<()> {
    let fault = |fault: String| Err(StudyError::input(path.display(), fault));
    if identified.stamp.schema != "jointid/identification/1" {
        let schema = &identified.stamp.schema;
        return fault(format!("is a {schema}, not a jointid/identification/1; name the identification.json of identify"));
    }
    if let Some(lumps) = identified.settings.lumps.filter(|lumps| !LUMPS.contains(lumps)) {
        let (least, most) = (LUMPS.start(), LUMPS.end());
        return fault(format!("settings.lumps is {lumps}, but a rod has {least} to {most} lumps; identify again"));
    }
    for (id, row) in &identified.parameters {
        let slack = ROUNDING * row.upper.abs().max(row.lower.abs());
        if !(row.value >= row.lower - slack && row.value <= row.upper + slack) {
            let (value, lower, upper, unit) = (row.value, row.lower, row.upper, &row.unit);
            return fault(format!("parameters.{id}.value is {value} {unit}, outside {lower} … {upper} {unit}; identify again"));
        }
    }
    Ok(())
}

impl Study {
    /// Opens machine and measurements of an identification again, with further overrides and effects taken out.
    ///
    /// # Errors  as [`read_identification`] and [`Study::open`].
    pub fn of_result(path: &Path, overrides: &[String], without: &[String]) -> StudyResult<(Study, IdentificationDocument, Input)> {
        let (document, input) = read_identification(path)?;
        let study = Study::open(&Sources {
            config: Some(document.settings.config.clone()),
            measurements: Some(document.settings.measurements.clone()),
            overrides: [&document.stamp.overrides[..], overrides].concat(),
            without: [&document.stamp.without[..], without].concat(),
        })?;
        Ok((study, document, input))
    }

    /// Returns the machine as identified, with tolerances held at their estimates, and the values of all its parameters, in its order.
    ///
    /// # Errors  the identification lacks a parameter of the machine.
    pub fn identified_machine(&self, path: &Path, identified: &IdentificationDocument) -> StudyResult<(Machine, Vec<f64>)> {
        let lacks = |id: &str| format!("has no parameter «{id}», which {} has; identify again", self.config.path);
        let value =
            |id: &str| identified.parameters.get(id).map(|row| row.value).ok_or_else(|| StudyError::input(path.display(), lacks(id)));
        let mut values = self.machine().parameters.iter().map(|p| value(&p.id)).collect::<StudyResult<Vec<f64>>>()?;
        let tolerances = identified.tolerances.iter().map(|(name, row)| (name.clone(), row.value)).collect();
        let machine = held_at(self.machine(), &self.set.nuts_m(), &tolerances)?;
        // The parameters that tolerances add follow those of the description.
        values.extend(machine.parameters.iter().skip(values.len()).map(|p| p.start));
        Ok((machine, values))
    }
}
