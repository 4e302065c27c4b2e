//! Inputs of a result: machine and measurements as read, and the stamp of its document.

use crate::arguments::Sources;
use crate::outcome::to_message;
use config::{MachineConfig, read_machine};
use measurement::{MeasurementSet, SourceFile, read_set};
use report::digest;
use report::document::{IdentificationDocument, Input, Stamp};

/// Machine and measurements.
pub struct Loaded {
    /// Overrides of the configuration.
    pub overrides: Vec<String>,
    /// Effects taken out of the machine.
    pub without: Vec<String>,
    /// The machine as configured.
    pub config: MachineConfig,
    /// The measurement set.
    pub set: MeasurementSet,
}

/// Reads machine and measurements.
pub fn load(sources: &Sources) -> Result<Loaded, String> {
    let mut config = read_machine(&sources.config, &sources.set, &sources.without).map_err(to_message)?;
    let set = read_set(&sources.measurements).map_err(to_message)?;
    if sources.config == config::BENCH && sources.measurements != measurement::BENCH {
        let title = &config.machine.title;
        config
            .warnings
            .push(format!("--measurements without --config: the machine is «{title}» ({}); name yours with --config", config::BENCH));
    }
    Ok(Loaded { config, set, overrides: sources.set.clone(), without: sources.without.clone() })
}

/// Reads the inputs of a document again, with additional overrides and effects taken out.
pub fn load_again(config: &str, measurements: &str, stamp: &Stamp, (set, without): (&[String], &[String])) -> Result<Loaded, String> {
    let (set, without) = ([&stamp.overrides[..], set].concat(), [&stamp.without[..], without].concat());
    load(&Sources { config: config.into(), measurements: measurements.into(), set, without })
}

/// Loads the machine and the set of an identification, with further overrides; a machine or set that the command line names replaces its own.
pub fn load_with_result(sources: &Sources, identified: &IdentificationDocument) -> Result<Loaded, String> {
    let chosen = |given: &str, default: &str, own: &str| if given == default { own.to_string() } else { given.to_string() };
    let config = chosen(&sources.config, config::BENCH, &identified.settings.config);
    let measurements = chosen(&sources.measurements, measurement::BENCH, &identified.settings.measurements);
    load_again(&config, &measurements, &identified.stamp, (&sources.set, &sources.without))
}

/// As [`load`], for commands that need a machine and at most the positions of its set.
///
/// The measurement set of the published bench, the default, is not read for other machines.
pub fn load_machine(sources: &Sources) -> Result<Loaded, String> {
    let config = read_machine(&sources.config, &sources.set, &sources.without).map_err(to_message)?;
    let other = sources.measurements == measurement::BENCH && !config.path.contains("tian");
    let set = if other { MeasurementSet::none() } else { read_set(&sources.measurements).map_err(to_message)? };
    Ok(Loaded { config, set, overrides: sources.set.clone(), without: sources.without.clone() })
}

/// Returns the input files of a run with their digests.
pub fn inputs(loaded: &Loaded) -> Vec<Input> {
    let config = Input { path: loaded.config.path.clone(), sha256: digest(loaded.config.text.as_bytes()) };
    std::iter::once(config).chain(set_inputs(&loaded.set)).collect()
}

fn set_inputs(set: &MeasurementSet) -> Vec<Input> {
    set.files.iter().map(digest_file).collect()
}

/// Describes a file that was read as an input.
pub fn digest_file(file: &SourceFile) -> Input {
    Input { path: file.path.clone(), sha256: digest(&file.bytes) }
}

/// Builds the stamp of a document.
pub fn stamp(schema: &str, seed: u64, complete: bool, loaded: &Loaded, warnings: Vec<String>) -> Stamp {
    let on_set = set_stamp(schema, &loaded.set);
    Stamp {
        seed,
        complete,
        inputs: inputs(loaded),
        overrides: loaded.overrides.clone(),
        without: loaded.without.clone(),
        warnings: on_set.warnings.into_iter().chain(loaded.config.warnings.iter().cloned()).chain(warnings).collect(),
        ..on_set
    }
}

/// Builds the stamp of a document on measurements alone.
pub fn set_stamp(schema: &str, set: &MeasurementSet) -> Stamp {
    stamp_files(schema, set_inputs(set), set.warnings.clone())
}

/// Builds the stamp of a document on these files, without a seed.
pub fn stamp_files(schema: &str, inputs: Vec<Input>, warnings: Vec<String>) -> Stamp {
    Stamp {
        schema: format!("jointid/{schema}/1"),
        tool_version: env!("CARGO_PKG_VERSION").into(),
        seed: 0,
        complete: true,
        inputs,
        overrides: Vec::new(),
        without: Vec::new(),
        warnings,
    }
}
