//! A study: a machine, its measurements, what is fitted, and how.

use std::path::Path;
use std::sync::Arc;

use crate::{Settings, StudyError, StudyResult};
use config::{MachineConfig, read_machine, read_machine_text};
use machine::Machine;
use measurement::{MeasurementSet, read_set};
use optimizer::{Control, Journal};

/// Where machine and measurements come from. The default is the published bench, which is built in.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sources {
    /// File of the machine's description; that of the published bench where absent.
    pub config: Option<String>,
    /// Folder of the measurement set; where absent, the one that the machine's description names.
    pub measurements: Option<String>,
    /// Overrides of the description, each as `key.path=value`.
    pub overrides: Vec<String>,
    /// Effects to take out of the description.
    pub without: Vec<String>,
}

/// A machine with its measurements, what is fitted, and how.
#[derive(Clone)]
pub struct Study {
    /// The machine as described.
    pub(crate) config: MachineConfig,
    /// The measurement set.
    pub(crate) set: MeasurementSet,
    /// Overrides of the description.
    pub(crate) overrides: Vec<String>,
    /// Effects taken out of the description.
    pub(crate) without: Vec<String>,
    /// Names of positions and records to fit, where they were given.
    pub(crate) fit: Option<Vec<String>>,
    /// Names of positions and records to hold out.
    pub(crate) hold_out: Vec<String>,
    pub(crate) settings: Settings,
    pub(crate) control: Control,
}

impl Study {
    /// Reads a machine's description and a measurement set. `configs/tian.toml` and `measurements/tian` are built in.
    ///
    /// # Errors  a file cannot be read, or does not describe a machine or a set.
    pub fn load(config: &str, measurements: &str) -> StudyResult<Self> {
        Study::open(&Sources { config: Some(config.into()), measurements: Some(measurements.into()), ..Sources::default() })
    }

    /// Makes a study from values in memory.
    pub fn new(machine: MachineConfig, set: MeasurementSet) -> Self {
        Study {
            config: machine,
            set,
            overrides: Vec::new(),
            without: Vec::new(),
            fit: None,
            hold_out: Vec::new(),
            settings: Settings::default(),
            control: Control::default(),
        }
    }

    /// Reads machine and measurements with overrides and effects taken out.
    ///
    /// # Errors  as [`Study::load`]; neither the sources nor the description name a measurement set.
    pub fn open(sources: &Sources) -> StudyResult<Self> {
        let config = described(sources)?;
        let measurements = sources
            .measurements
            .clone()
            .or_else(|| named_set(&config))
            .ok_or_else(|| StudyError::input(&config.path, "names no measurement set; name the folder of one with measurements"))?;
        Study::of(sources, config, read_set(&measurements)?)
    }

    /// As [`Study::open`], for work that needs a machine and at most the positions of its set: a machine without a set is accepted.
    ///
    /// # Errors  as [`Study::load`].
    pub fn open_machine(sources: &Sources) -> StudyResult<Self> {
        let config = described(sources)?;
        let set = match sources.measurements.clone().or_else(|| named_set(&config)) {
            Some(measurements) => read_set(&measurements)?,
            None => MeasurementSet::none(),
        };
        Study::of(sources, config, set)
    }

    fn of(sources: &Sources, mut config: MachineConfig, set: MeasurementSet) -> StudyResult<Self> {
        if sources.config.is_none() && sources.measurements.as_deref().is_some_and(|name| name != measurement::BENCH) {
            config.warnings.push(format!(
                "measurements without a machine: the machine is «{}» ({}); name yours as config",
                config.machine.title,
                config::BENCH
            ));
        }
        Ok(Study { overrides: sources.overrides.clone(), without: sources.without.clone(), ..Study::new(config, set) })
    }

    /// Chooses the positions or records to fit; all others are held out.
    ///
    /// # Errors  the set has no position or record of this name, or one is named twice.
    pub fn fit<N: Into<String>>(mut self, names: impl IntoIterator<Item = N>) -> StudyResult<Self> {
        self.fit = Some(names.into_iter().map(Into::into).collect());
        self.checked()
    }

    /// Chooses positions or records to hold out, in addition to those that are not fitted.
    ///
    /// # Errors  as [`Study::fit`].
    pub fn hold_out<N: Into<String>>(mut self, names: impl IntoIterator<Item = N>) -> StudyResult<Self> {
        self.hold_out = names.into_iter().map(Into::into).collect();
        self.checked()
    }

    fn checked(self) -> StudyResult<Self> {
        if self.is_on_motion() {
            self.set.split_motions(self.fit.as_deref(), &self.hold_out)?;
        } else {
            self.set.split(self.fit.as_deref(), &self.hold_out)?;
        }
        Ok(self)
    }

    /// Takes effects out of the machine's description, as if it had never contained them.
    ///
    /// # Errors  the description does not contain an effect.
    pub fn without<N: Into<String>>(mut self, effects: impl IntoIterator<Item = N>) -> StudyResult<Self> {
        self.without.extend(effects.into_iter().map(Into::into));
        self.config = read_machine_text(&self.config.path, &self.config.text, &self.overrides, &self.without)?;
        Ok(self)
    }

    /// Replaces the settings.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Study { settings, ..self }
    }

    /// Replaces the control, which reports progress and can stop the work.
    #[must_use]
    pub fn with_control(self, control: Control) -> Self {
        Study { control, ..self }
    }

    /// Keeps finished pieces of a work in a file, and takes over those that an earlier run of the same work has kept there. `work` tells works on
    /// this study apart: everything on which its result depends beside machine, measurements, split and settings.
    ///
    /// # Errors  the file exists and cannot be read.
    pub fn resumable(self, path: &Path, work: &str) -> StudyResult<Self> {
        let journal = Journal::open(path, &self.key(work));
        let journal = journal.map_err(|e| StudyError::input(path.display(), format!("cannot be read: {e}; remove it")))?;
        let control = self.control.clone().with_journal(Some(Arc::new(journal)));
        Ok(self.with_control(control))
    }

    /// Returns a text of everything on which the result of a work depends, this build of the program included: another may compute other numbers.
    pub(crate) fn key(&self, work: &str) -> String {
        let Study { config: _, set: _, overrides, without, fit, hold_out, settings, control: _ } = self;
        let build = std::env::current_exe().and_then(std::fs::metadata).and_then(|m| Ok((m.len(), m.modified()?))).ok();
        let given = (env!("CARGO_PKG_VERSION"), build, work, overrides, without, fit, hold_out, settings);
        let digests: Vec<String> = self.inputs().into_iter().map(|input| input.sha256).collect();
        format!("{given:?} {}", digests.join(" "))
    }

    /// Returns the machine as described.
    pub fn machine(&self) -> &Machine {
        &self.config.machine
    }

    /// Returns the measurement set.
    pub fn measurements(&self) -> &MeasurementSet {
        &self.set
    }

    /// Returns the settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the control.
    pub fn control(&self) -> &Control {
        &self.control
    }

    /// Whether the set holds motion records, and neither FRFs nor modes.
    pub(crate) fn is_on_motion(&self) -> bool {
        !self.set.motions.is_empty() && self.set.frfs.is_empty() && self.set.modes.is_none()
    }
}

/// Reads the machine's description.
fn described(sources: &Sources) -> StudyResult<MachineConfig> {
    let path = sources.config.as_deref().unwrap_or(config::BENCH);
    Ok(read_machine(path, &sources.overrides, &sources.without)?)
}

/// Returns the measurement set that a description names.
fn named_set(config: &MachineConfig) -> Option<String> {
    config.measurements.as_ref().map(|name| format!("measurements/{name}"))
}
