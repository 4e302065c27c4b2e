//! An identification read back from its document.

use std::collections::BTreeMap;
use std::path::Path;

use crate::outcome::to_message;
use crate::sources::Loaded;
use config::MachineConfig;
use identification::held_at;
use machine::Machine;
use report::digest;
use report::document::{IdentificationDocument, Input};

/// Reads an identification; it is an input of another document, by the digest of the very bytes that were read.
pub fn read_identification(path: &Path) -> Result<(IdentificationDocument, Input), String> {
    let bytes = std::fs::read(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => format!("{}: there is no such file; run identify with --out first", path.display()),
        _ if path.is_dir() => format!("{}: is a folder; name the identification.json in it", path.display()),
        _ => format!("{}: {e}", path.display()),
    })?;
    let document = serde_json::from_slice(&bytes);
    let document = document.map_err(|e| format!("{}, line {}: is no result of identify: {e}", path.display(), e.line()))?;
    Ok((document, Input { path: path.display().to_string(), sha256: digest(&bytes) }))
}

/// Refuses a document of another form, and values outside their own ranges.
pub fn check_identification(path: &Path, identified: &IdentificationDocument) -> Result<(), String> {
    if identified.stamp.schema != "jointid/identification/1" {
        return Err(format!(
            "{}: is a {}, not a jointid/identification/1; name the identification.json of identify",
            path.display(),
            identified.stamp.schema
        ));
    }
    if let Some(lumps) = identified.settings.lumps.filter(|lumps| !(1..=500).contains(lumps)) {
        return Err(format!("{}: settings.lumps is {lumps}; there are 1 to 500 lumps per rod; identify again", path.display()));
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

/// The machine as it was identified, tolerances held at their estimates, and the values of its parameters in its order, of which the first are `own`.
pub fn identified_machine(identified: &IdentificationDocument, loaded: &Loaded, own: &[f64]) -> Result<(Machine, Vec<f64>), String> {
    let machine = held_at(&loaded.config.machine, &loaded.set.nuts_m(), &tolerances(identified)).map_err(to_message)?;
    let further = machine.parameters.iter().skip(own.len()).map(|p| p.start);
    let values = own.iter().copied().chain(further).collect();
    Ok((machine, values))
}

/// Estimates of its tolerances by name.
pub fn tolerances(identified: &IdentificationDocument) -> BTreeMap<String, f64> {
    identified.tolerances.iter().map(|(name, row)| (name.clone(), row.value)).collect()
}

/// Identified values of all parameters of a configured machine, in its order.
pub fn identified_values(path: &Path, identified: &IdentificationDocument, config: &MachineConfig) -> Result<Vec<f64>, String> {
    let value = |id: &String| {
        let row = identified.parameters.get(id);
        row.map(|row| row.value)
            .ok_or_else(|| format!("{}: has no parameter «{id}», which {} has; identify again", path.display(), config.path))
    };
    config.machine.parameters.iter().map(|p| value(&p.id)).collect()
}
