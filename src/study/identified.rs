//! Reads `identification.json`, and reopens its machine and measurements.

use std::collections::BTreeMap;
use std::path::Path;

use crate::settings::LUMPS;
use crate::{ObjectiveKind, Settings, Sources, Study, StudyError, StudyResult};
use config::{read_machine, read_machine_text};
use dynamics::model::RodModel;
use file_access::{MOST_DOCUMENT_BYTES, MOST_TEXT_BYTES, ReadFault, read_file, shortened};
use machine::{Estimate, Machine, ParameterValues};
use measurement::read_set_from;
use report::certainty::ToleranceRow;
use report::diagnosis::DiagnosisDocument;
use report::document::{IdentificationDocument, Input, MachineText, Stamp};
use report::vocabulary::ToleranceUse;
use report::{UniqueKeys, content_fault, digest};
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Allowance for rounding at the bounds of a range, relative to the bound of larger magnitude (1).
const ROUNDING: f64 = 1e-9;

/// Reads `identification.json`. Returns the document, and its file with digest as an input of another
/// document.
///
/// # Errors  the file cannot be read, is no result of an identification, or was changed since.
pub fn read_identification(path: &Path) -> StudyResult<(IdentificationDocument, Input)> {
    let (document, input) = read_result(path, "identification", "identify")?;
    check_identification(path, &document)?;
    Ok((document, input))
}

/// Reads the text of a result of a kind, such as `identification`, as the files are read; `name` is its name in
/// messages.
///
/// # Errors  as [`read_identification`] and [`read_diagnosis`].
pub fn result_of_text<T: DeserializeOwned>(name: &str, text: &str, kind: &str) -> StudyResult<T> {
    result_document(Path::new(name), text.as_bytes(), kind)
}

/// Reads `diagnosis.json`, as [`read_identification`].
///
/// # Errors  the file cannot be read, or is no result of a diagnosis.
pub fn read_diagnosis(path: &Path) -> StudyResult<(DiagnosisDocument, Input)> {
    read_result(path, "diagnosis", "diagnose")
}

/// Reads a result document of a kind, which a command writes.
fn read_result<T: DeserializeOwned>(path: &Path, kind: &str, command: &str) -> StudyResult<(T, Input)> {
    let fault = |fault: ReadFault| match fault {
        ReadFault::Folder => format!("is a folder; name the {kind}.json in it"),
        fault if fault.is_missing() => format!("{fault}; run {command} with an output folder first"),
        fault => fault.to_string(),
    };
    let bytes =
        read_file(path, MOST_DOCUMENT_BYTES).map_err(|e| StudyError::input(path.display(), fault(e)))?;
    let document = result_document(path, &bytes, kind)?;
    Ok((document, Input { path: path.display().to_string(), sha256: digest(&bytes) }))
}

/// Parses a result document of a kind, such as `identification`. A message quotes nothing of a file that is
/// none.
///
/// # Errors  the file is no JSON, a document of another kind, or one that lacks keys; a key is written twice; a
///   identification is of another version or was changed since.
pub(crate) fn result_document<T: DeserializeOwned>(path: &Path, bytes: &[u8], kind: &str) -> StudyResult<T> {
    let fault = |text: String| StudyError::input(path.display(), text);
    let invalid = |e: serde_json::Error| {
        let found = if e.is_data() { shortened(&e.to_string(), 200) } else { "no valid JSON".to_string() };
        let line = format!("{}, line {}", path.display(), e.line());
        StudyError::Impossible(format!("{line}: is not a result document: {found}"))
    };
    serde_json::from_slice::<UniqueKeys>(bytes).map_err(invalid)?;
    let value: Value = serde_json::from_slice(bytes).map_err(invalid)?;
    let expected = format!("jointid/{kind}/1");
    match value.get("schema").and_then(Value::as_str) {
        Some(schema) if schema == expected => {}
        Some(schema) if schema.starts_with("jointid/") => {
            let schema = shortened(schema, 60);
            return Err(fault(format!(
                "is a {schema}, not a {expected}; name one of this kind, or make it again with this version"
            )));
        }
        _ => return Err(fault(format!("is not a result document: `schema` is not {expected}"))),
    }
    if kind == "identification" {
        let version = value.get("tool_version").and_then(Value::as_str).unwrap_or_default();
        check_version(&path.display().to_string(), version, "identify")?;
        if let Some(found) = content_fault(&value) {
            return Err(fault(format!("{found}; identify again")));
        }
    }
    serde_json::from_value(value)
        .map_err(|e| fault(format!("is no {expected}: {}", shortened(&e.to_string(), 200))))
}

/// Checks that a result was written by this version; `command` makes it.
fn check_version(path: &str, version: &str, command: &str) -> StudyResult<()> {
    let own = env!("CARGO_PKG_VERSION");
    if version == own {
        return Ok(());
    }
    let version = shortened(version, 40);
    Err(StudyError::input(path, format!("was written by version {version}, this is {own}; {command} again")))
}

/// Checks that a result was written by this version and is complete. `of` names it and the command that makes
/// it, such as an identification and identify.
///
/// # Errors  the result is of another version, or was stopped early.
pub(crate) fn check_current(path: &str, stamp: &Stamp, of: (&str, &str)) -> StudyResult<()> {
    check_version(path, &stamp.tool_version, of.1)?;
    if !stamp.complete {
        return Err(StudyError::input(
            path,
            format!("is not complete: the {} was stopped early; run it to its end", of.0),
        ));
    }
    Ok(())
}

/// Checks the schema of an identification, its number of lumps, and that every value lies in its range.
///
/// # Errors  a message that names file and key.
pub fn check_identification(path: &Path, identified: &IdentificationDocument) -> StudyResult<()> {
    let fault = |text: String| Err(StudyError::input(path.display(), text));
    if identified.stamp.schema != "jointid/identification/1" {
        let schema = &identified.stamp.schema;
        return fault(format!(
            "is a {schema}, not a jointid/identification/1; name the identification.json of identify"
        ));
    }
    if let Some(lumps) = identified.settings.lumps.filter(|lumps| !LUMPS.contains(lumps)) {
        let (least, most) = (LUMPS.start(), LUMPS.end());
        return fault(format!(
            "settings.lumps is {lumps}, but a rod has {least} to {most} lumps; identify again"
        ));
    }
    for (id, row) in &identified.parameters {
        let slack = ROUNDING * row.upper.abs().max(row.lower.abs());
        if !(row.value >= row.lower - slack && row.value <= row.upper + slack) {
            let unit = &row.unit;
            return fault(format!(
                "parameters.{id}.value is {} {unit}, outside {} … {} {unit}; identify again",
                row.value, row.lower, row.upper
            ));
        }
    }
    Ok(())
}

impl Study {
    /// Reopens machine and measurements of an identification with further overrides; a machine or set that
    /// the sources name replaces its own.
    ///
    /// # Errors  the result cannot be read or is damaged; its measurement set cannot be read.
    pub fn open_with_result(
        sources: &Sources,
        path: &Path,
    ) -> StudyResult<(Self, IdentificationDocument, Input)> {
        let (document, input) = read_identification(path)?;
        check_identification(path, &document)?;
        let study = match &sources.config {
            None => Study::of_identification(&document, sources)?,
            // Overrides and removed effects of the result are those of its own machine.
            Some(_) => {
                let measurements =
                    sources.measurements.clone().or_else(|| Some(document.settings.measurements.clone()));
                Study::open(&Sources { measurements, ..sources.clone() })?
            }
        };
        Ok((study, document, input))
    }

    /// Reopens machine and measurements of an identification, with its split and settings; a set that the
    /// sources name replaces its own.
    ///
    /// # Errors  its machine or its measurement set cannot be read.
    pub(crate) fn of_identification(
        document: &IdentificationDocument,
        sources: &Sources,
    ) -> StudyResult<Self> {
        let settings = &document.settings;
        let measurements = sources.measurements.as_ref().unwrap_or(&settings.measurements);
        let study = Study::reopened(
            (document.machine.as_ref(), &settings.config),
            measurements,
            &document.stamp,
            sources,
        )?;
        let mut study = Study {
            fit: settings.positions.clone(),
            hold_out: settings.hold_out.clone(),
            settings: settings_of(document),
            ..study
        };
        study.config.warnings.extend(study.outdated_machine());
        Ok(study)
    }

    /// Reads the machine that a document embeds, else that of its path, and a measurement set; with the
    /// overrides of its stamp and those of the sources.
    pub(crate) fn reopened(
        (embedded, config): (Option<&MachineText>, &str),
        measurements: &str,
        stamp: &Stamp,
        sources: &Sources,
    ) -> StudyResult<Self> {
        let overrides = [&stamp.overrides[..], &sources.overrides].concat();
        let without = [&stamp.without[..], &sources.without].concat();
        let config = match embedded {
            Some(machine) => read_machine_text(&machine.path, &machine.text, &overrides, &without)?,
            None => read_machine(config, &overrides, &without)?,
        };
        Ok(Study {
            overrides,
            without,
            ..Study::new(config, read_set_from(measurements, sources.allow_outside)?)
        })
    }

    /// Builds the machine as identified, with tolerances held at their estimates. Returns it with the values
    /// of its parameters, in its order.
    ///
    /// # Errors  the identification belongs to another machine.
    pub fn identified_machine(
        &self,
        path: &Path,
        identified: &IdentificationDocument,
    ) -> StudyResult<(Machine, ParameterValues)> {
        let values = self.identified_values(path, identified)?;
        let machine = &self.config.machine;
        let held = estimates(identified);
        if held.is_empty() {
            return Ok((machine.clone(), values));
        }
        // Gains, delays and nut positions among the tolerances are those of the measurement.
        let (machine, _) = machine.with_tolerances_held(&self.set.nuts_m(), &held)?;
        Ok((machine, values))
    }

    /// Returns the identified values of all parameters of the machine as described, in its order.
    ///
    /// # Errors  the identification lacks a parameter: it belongs to another machine.
    pub fn identified_values(
        &self,
        path: &Path,
        identified: &IdentificationDocument,
    ) -> StudyResult<ParameterValues> {
        let value = |id: &String| {
            let row = identified.parameters.get(id);
            row.map(|row| row.value).ok_or_else(|| {
                let fault =
                    format!("has no parameter «{id}», which {} has; identify again", self.config.path);
                StudyError::input(path.display(), fault)
            })
        };
        self.config
            .machine
            .parameters
            .iter()
            .map(|p| value(&p.id))
            .collect::<StudyResult<_>>()
            .map(ParameterValues)
    }

    /// Returns a warning where the machine's file has changed since the result that embeds its description.
    pub(crate) fn outdated_machine(&self) -> Option<String> {
        let path = &self.config.path;
        let now = read_file(Path::new(path), MOST_TEXT_BYTES).ok()?;
        (digest(&now) != digest(self.config.text.as_bytes())).then(|| {
            format!("{path} has changed since the result was written; the machine is that of the result")
        })
    }

    /// Whether an identification is one of this machine: of the same description, overrides and removed
    /// effects. A result of an older version, which embeds no description, counts as such.
    pub(crate) fn is_machine_of(&self, identified: &IdentificationDocument) -> bool {
        let stamp = &identified.stamp;
        let same = |machine: &MachineText| {
            machine.text == self.config.text
                && stamp.overrides == self.overrides
                && stamp.without == self.without
        };
        identified.machine.as_ref().is_none_or(same)
    }

    /// Returns warnings about files of machine and measurements that differ from those of a result.
    pub(crate) fn changed_inputs(&self, then: &[Input]) -> Vec<String> {
        let differs = |now: &&Input| then.iter().any(|i| i.path == now.path && i.sha256 != now.sha256);
        let changed = |now: &Input| {
            format!("{} has changed since the identification; identify again if the change matters", now.path)
        };
        self.inputs().iter().filter(differs).map(changed).collect()
    }
}

/// Returns the estimates of the tolerances by name.
pub(crate) fn estimates(identified: &IdentificationDocument) -> BTreeMap<String, Estimate> {
    let of = |row: &ToleranceRow| Estimate { value: row.value, sd: Some(row.sd) };
    identified.tolerances.iter().map(|(name, row)| (name.clone(), of(row))).collect()
}

/// Returns the estimated values of the tolerances by name.
pub(crate) fn tolerance_values(identified: &IdentificationDocument) -> BTreeMap<String, f64> {
    identified.tolerances.iter().map(|(name, row)| (name.clone(), row.value)).collect()
}

/// Returns the settings of an identification.
pub(crate) fn settings_of(identified: &IdentificationDocument) -> Settings {
    let stated = &identified.settings;
    Settings {
        rods: stated.lumps.map_or(RodModel::Exact, RodModel::Lumped),
        objective: Some(stated.objective),
        frequency_model_error: stated.frequency_model_error,
        amplitude_sd: stated.amplitude_sd,
        frf_model_error: stated.frf_model_error,
        // Tolerances are fitted along with whole FRFs only.
        fit_tolerances: stated.tolerances == ToleranceUse::Fit || stated.objective != ObjectiveKind::Frf,
        band_hz: stated.band_hz.map(|[from, to]| (from, to)),
        bootstrap: stated.bootstrap,
        freeze: stated.freeze.clone(),
        seed: identified.stamp.seed,
        repeats: stated.repeats,
    }
}
