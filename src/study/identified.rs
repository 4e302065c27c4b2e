//! Reads `identification.json`.

use std::ops::RangeInclusive;
use std::path::Path;

use crate::{Study, StudyError, StudyResult};
use report::digest;
use report::document::{IdentificationDocument, Input};

/// Allowance for rounding at the bounds of a range, relative to the bound of larger magnitude (1).
const ROUNDING: f64 = 1e-9;
/// Numbers of masses per rod of the lumped model.
const LUMPS: RangeInclusive<usize> = 1..=500;

/// Reads `identification.json`. Returns the document, and its file with digest as an input of another document.
///
/// # Errors  there is no such file, or it is no result of an identification.
pub fn read_identification(path: &Path) -> StudyResult<(IdentificationDocument, Input)> {
    let shown = path.display();
    let bytes = std::fs::read(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => StudyError::input(&shown, "there is no such file; run identify with --out first"),
        _ if path.is_dir() => StudyError::input(&shown, "is a folder; name the identification.json in it"),
        _ => StudyError::input(&shown, e.to_string()),
    })?;
    let document = serde_json::from_slice(&bytes);
    let document =
        document.map_err(|e| StudyError::input(format!("{shown}, line {}", e.line()), format!("is not a result of `identify`: {e}")))?;
    Ok((document, Input { path: shown.to_string(), sha256: digest(&bytes) }))
}

/// Checks the schema of an identification, its number of lumps, and that every value lies in its range.
///
/// # Errors  a message that names file and key.
pub fn check_identification(path: &Path, identified: &IdentificationDocument) -> StudyResult<()> {
    let refused = |fault: String| Err(StudyError::input(path.display(), fault));
    if identified.stamp.schema != "jointid/identification/1" {
        let schema = &identified.stamp.schema;
        return refused(format!("is a {schema}, not a jointid/identification/1; name the identification.json of identify"));
    }
    if let Some(lumps) = identified.settings.lumps.filter(|lumps| !LUMPS.contains(lumps)) {
        let (from, to) = (LUMPS.start(), LUMPS.end());
        return refused(format!("settings.lumps is {lumps}, but a rod has {from} to {to} lumps; identify again"));
    }
    for (id, row) in &identified.parameters {
        let slack = ROUNDING * row.upper.abs().max(row.lower.abs());
        if !(row.value >= row.lower - slack && row.value <= row.upper + slack) {
            return refused(format!(
                "parameters.{id}.value is {} {unit}, outside {} … {} {unit}; identify again",
                row.value,
                row.lower,
                row.upper,
                unit = row.unit
            ));
        }
    }
    Ok(())
}

impl Study {
    /// Returns the identified values of all parameters of the machine as described, in its order.
    ///
    /// # Errors  the result has no value of a parameter.
    pub fn identified_values(&self, path: &Path, identified: &IdentificationDocument) -> StudyResult<Vec<f64>> {
        let value = |id: &String| {
            let fault = || format!("has no parameter «{id}», which {} has; identify again", self.config.path);
            identified.parameters.get(id).map(|row| row.value).ok_or_else(|| StudyError::input(path.display(), fault()))
        };
        self.config.machine.parameters.iter().map(|p| value(&p.id)).collect()
    }
}
