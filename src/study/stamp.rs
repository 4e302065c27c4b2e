//! Provenance of documents: versions, seeds and digests of inputs.

use std::path::Path;

use crate::{Study, StudyError, StudyResult};
use config::MachineConfig;
use file_access::{MOST_DOCUMENT_BYTES, read_file};
use measurement::{MeasurementSet, SourceFile, level_warning};
use report::digest;
use report::document::{Input, MachineText, Stamp};

impl Study {
    /// Returns the files of machine and measurements, with their digests.
    pub fn inputs(&self) -> Vec<Input> {
        let config = Input { path: self.config.path.clone(), sha256: digest(self.config.text.as_bytes()) };
        std::iter::once(config).chain(set_inputs(&self.set)).collect()
    }

    /// Returns the description of the machine, as documents embed it; `None` for a machine without a text.
    pub(crate) fn machine_text(&self) -> Option<MachineText> {
        let MachineConfig { path, text, .. } = &self.config;
        (!text.is_empty()).then(|| MachineText { path: path.clone(), text: text.clone() })
    }

    /// Returns the manifest of the measurement set.
    pub(crate) fn manifest(&self) -> Option<Input> {
        self.set.files.iter().find(|file| file.path.ends_with("manifest.toml")).map(digest_file)
    }

    /// Returns the files of the measurements apart from the manifest.
    pub(crate) fn data_files(&self) -> impl Iterator<Item = Input> + '_ {
        self.set.files.iter().filter(|file| !file.path.ends_with("manifest.toml")).map(digest_file)
    }

    /// Warns where the machine's estimates of tolerances are from the measurements that are fitted.
    fn counted_twice(&self) -> Option<String> {
        let MachineConfig { path, fitted_from, .. } = &self.config;
        let twice =
            self.data_files().find(|input| fitted_from.contains(&input.sha256)).map(|input| input.path)?;
        Some(format!(
            "{path}: [fitted] holds estimates from {twice}, which are these measurements: fitted with them, they count twice; take the machine without [fitted], or other measurements"
        ))
    }

    /// Returns the warnings about machine and measurements as read.
    pub fn input_warnings(&self) -> Vec<String> {
        let level = (!self.machine().depends_on_level()).then(|| level_warning(&self.set.frfs)).flatten();
        self.set
            .warnings
            .iter()
            .chain(&self.config.warnings)
            .cloned()
            .chain(level)
            .chain(self.counted_twice())
            .collect()
    }

    /// Returns the warnings about implausible numbers of the machine.
    pub fn implausible_numbers(&self) -> &[String] {
        &self.config.implausible
    }

    /// Builds the stamp of a document on machine and measurements. Its warnings are those of the inputs, then
    /// the given ones.
    pub fn stamp(&self, schema: &str, seed: u64, complete: bool, warnings: Vec<String>) -> Stamp {
        let on_set = set_stamp(schema, &self.set);
        Stamp {
            seed,
            complete,
            inputs: self.inputs(),
            overrides: self.overrides.clone(),
            without: self.without.clone(),
            warnings: self.input_warnings().into_iter().chain(warnings).collect(),
            ..on_set
        }
    }
}

fn set_inputs(set: &MeasurementSet) -> Vec<Input> {
    set.files.iter().map(digest_file).collect()
}

/// Describes a file that was read as an input.
pub(crate) fn digest_file(file: &SourceFile) -> Input {
    Input { path: file.path.clone(), sha256: digest(file.bytes()) }
}

/// Builds the stamp of a document on measurements alone.
pub(crate) fn set_stamp(schema: &str, set: &MeasurementSet) -> Stamp {
    stamp_files(schema, set_inputs(set), set.warnings.clone())
}

/// Builds the stamp of a document on these files, without a seed.
pub fn stamp_files(schema: &str, inputs: Vec<Input>, warnings: Vec<String>) -> Stamp {
    Stamp {
        schema: format!("jointid/{schema}/1"),
        tool_version: env!("CARGO_PKG_VERSION").into(),
        complete: true,
        inputs,
        warnings,
        ..Stamp::default()
    }
}

/// Returns the path of the first input of one list that the other lacks, or has with other contents.
pub(crate) fn changed_input<'i>(one: &'i [Input], other: &'i [Input]) -> Option<&'i str> {
    let mut lacking = one
        .iter()
        .filter(|input| !other.contains(input))
        .chain(other.iter().filter(|input| !one.contains(input)));
    lacking.next().map(|input| input.path.as_str())
}

/// Describes a result document as an input of another.
///
/// # Errors  it cannot be read.
pub fn document_input(path: &Path) -> StudyResult<Input> {
    let bytes =
        read_file(path, MOST_DOCUMENT_BYTES).map_err(|e| StudyError::input(path.display(), e.to_string()))?;
    Ok(Input { path: path.display().to_string(), sha256: digest(&bytes) })
}
