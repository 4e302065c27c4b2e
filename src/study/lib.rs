//! Studies: identification, validation, comparison, diagnosis and planning for a machine and its
//! measurements, and the documents of their results.

use std::collections::BTreeMap;

mod change;
mod commanded;
mod compare;
mod diagnose;
mod document_rows;
mod effects;
mod error;
mod files;
mod frequency_response;
mod friction;
mod identified;
mod identify;
mod import;
mod joint_fit;
mod machine_file;
mod modal_density;
mod motion_records;
mod no_mode;
mod page;
mod peaks;
mod plan;
mod predict;
mod run_settings;
mod settings;
pub mod simulation;
mod stamp;
mod study;
mod validate;

pub use change::compare_results;
pub use config::MachineConfig;
pub use diagnose::{Ablation, DiagnosisRequest, FactsDocument, NullCache, Policy, rules};
pub use document_rows::positions as position_rows;
pub use dynamics::model::RodModel;
pub use effects::effects;
pub use error::{FaultLocation, StudyError, StudyResult};
pub use files::{Template, schema, schema_names, templates};
pub use frequency_response::Evaluated;
pub use friction::{FrictionRequest, friction};
pub use identification::Drawing;
pub use identified::{check_identification, read_diagnosis, read_identification, result_of_text};
pub use import::{ExportedSet, FileContents, ImportRequest, ImportedSet, export, import, list_contents};
pub use long_work::{Control, Progress, Watcher};
pub use machine::contact::StribeckNoise;
pub use measurement::{
    ChannelTolerance, Condition, DriveEffort, FrfArrays, FrfNoise, Gain, MeasurementSet, MotionArrays,
    Quantity, SetArrays, SetWithoutNoise,
};
pub use page::page;
pub use peaks::{DiagramPole, Peaks, PeaksRequest, peaks, stabilisation};
pub use plan::{PlanRequest, PlannedData};
pub use predict::PredictionRequest;
pub use report::vocabulary::ObjectiveKind;
pub use settings::Settings;
pub use stamp::{document_input, stamp_files};
pub use study::{Sources, Study};
pub use validate::ValidationRequest;

/// Reads a measurement set from its folder; `measurements/tian` is built in.
///
/// # Errors  a file is missing or unreadable, a key is unknown or missing, a cell is not a number, there is
///   no observation.
pub fn read_set(folder: &str) -> StudyResult<MeasurementSet> {
    Ok(measurement::read_set(folder)?)
}

/// As [`read_set`]; with `allow_outside` the files that the manifest names may lie outside the folder.
///
/// # Errors  as [`read_set`].
pub fn read_set_from(folder: &str, allow_outside: bool) -> StudyResult<MeasurementSet> {
    Ok(measurement::read_set_from(folder, allow_outside)?)
}

/// Reads a measurement set from the contents of its files by name, `manifest.toml` among them. `path` names
/// the set in messages and documents.
///
/// # Errors  as [`read_set`].
pub fn read_set_files(path: &str, files: &BTreeMap<String, Vec<u8>>) -> StudyResult<MeasurementSet> {
    let missing = || std::io::Error::from(std::io::ErrorKind::NotFound);
    Ok(measurement::read_set_with(path, |file| files.get(file).cloned().ok_or_else(missing))?)
}

/// Makes a machine from the text (TOML) of its description, under a name for messages and documents.
///
/// # Errors  the text does not describe a machine; an override or a removed effect does not fit it.
pub fn machine_from_text(
    name: &str,
    text: &str,
    overrides: &[String],
    without: &[String],
) -> StudyResult<MachineConfig> {
    Ok(config::read_machine_text(name, text, overrides, without)?)
}

/// Reads the description of a machine; the descriptions in `configs` are built in.
///
/// # Errors  the file cannot be read, or does not describe a machine.
pub fn read_machine(path: &str) -> StudyResult<MachineConfig> {
    Ok(config::read_machine(path, &[], &[])?)
}
