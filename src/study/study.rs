//! A study: a machine, its measurements, what is fitted, and how.

use std::path::Path;
use std::sync::Arc;

use crate::{Settings, StudyError, StudyResult};
use config::{MachineConfig, read_machine, read_machine_text};
use long_work::{Control, Journal};
use machine::Machine;
use measurement::{MeasurementSet, read_set_from};
use numeric::digest::digest_of;

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
    /// Whether the files that the manifest of the measurement set names may lie outside its folder.
    pub allow_outside: bool,
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
    /// Reads a machine's description and a measurement set. `configs/tian.toml` and `measurements/tian` are
    /// built in.
    ///
    /// # Errors  a file cannot be read, or does not describe a machine or a set.
    pub fn load(config: &str, measurements: &str) -> StudyResult<Self> {
        Study::open(&Sources {
            config: Some(config.into()),
            measurements: Some(measurements.into()),
            ..Sources::default()
        })
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

    /// Makes a study of a machine from the text (TOML) of its description, under a name for messages and
    /// documents, with overrides and effects taken out.
    ///
    /// # Errors  the text does not describe a machine; an override or a removed effect does not fit it.
    pub fn described(
        (name, text): (&str, &str),
        set: MeasurementSet,
        overrides: &[String],
        without: &[String],
    ) -> StudyResult<Self> {
        let config = read_machine_text(name, text, overrides, without)?;
        Ok(Study { overrides: overrides.to_vec(), without: without.to_vec(), ..Study::new(config, set) })
    }

    /// Reads machine and measurements with overrides and effects taken out.
    ///
    /// # Errors  as [`Study::load`]; neither the sources nor the description name a measurement set.
    pub fn open(sources: &Sources) -> StudyResult<Self> {
        let config = described(sources)?;
        let measurements = sources.measurements.clone().or_else(|| named_set(&config)).ok_or_else(|| {
            StudyError::input(
                &config.path,
                "names no measurement set; name the folder of one with measurements",
            )
        })?;
        Study::of(sources, config, read_set_from(&measurements, sources.allow_outside)?)
    }

    /// As [`Study::open`], for work that needs a machine and at most the positions of its set: a machine
    /// without a set is accepted.
    ///
    /// # Errors  as [`Study::load`].
    pub fn open_machine(sources: &Sources) -> StudyResult<Self> {
        let config = described(sources)?;
        let set = match sources.measurements.clone().or_else(|| named_set(&config)) {
            Some(measurements) => read_set_from(&measurements, sources.allow_outside)?,
            None => MeasurementSet::none(),
        };
        Study::of(sources, config, set)
    }

    fn of(sources: &Sources, mut config: MachineConfig, set: MeasurementSet) -> StudyResult<Self> {
        if sources.config.is_none()
            && sources.measurements.as_deref().is_some_and(|name| name != measurement::BENCH)
        {
            config.warnings.push(format!(
                "measurements without a machine: the machine is «{}» ({}); name yours as config",
                config.machine.title,
                config::BENCH
            ));
        }
        Ok(Study {
            overrides: sources.overrides.clone(),
            without: sources.without.clone(),
            ..Study::new(config, set)
        })
    }

    /// Chooses the positions or records to fit; all others are held out.
    ///
    /// # Errors  the set has no position or record of this name, or one is named twice.
    pub fn fit<N: Into<String>>(mut self, names: impl IntoIterator<Item = N>) -> StudyResult<Self> {
        self.fit = Some(names.into_iter().map(Into::into).collect());
        self.other_work().checked()
    }

    /// Chooses positions or records to hold out, in addition to those that are not fitted.
    ///
    /// # Errors  as [`Study::fit`].
    pub fn hold_out<N: Into<String>>(mut self, names: impl IntoIterator<Item = N>) -> StudyResult<Self> {
        self.hold_out = names.into_iter().map(Into::into).collect();
        self.other_work().checked()
    }

    /// Leaves the journal of a work, which is that of the study as it was.
    pub(crate) fn other_work(mut self) -> Self {
        self.control = self.control.with_journal(None);
        self
    }

    fn checked(self) -> StudyResult<Self> {
        self.check_observations()?;
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
        let mut config =
            read_machine_text(&self.config.path, &self.config.text, &self.overrides, &self.without)?;
        // Warnings about the sources still hold.
        let new: Vec<String> =
            config.warnings.into_iter().filter(|text| !self.config.warnings.contains(text)).collect();
        config.warnings = [self.config.warnings, new].concat();
        self.config = config;
        Ok(self.other_work())
    }

    /// Replaces the measurement set.
    #[must_use]
    pub fn with_measurements(self, set: MeasurementSet) -> Self {
        Study { set, ..self }.other_work()
    }

    /// Replaces the settings.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Study { settings, ..self }.other_work()
    }

    /// Replaces the control, which reports progress, can stop the work, and holds the journal of
    /// [`Study::resumable`].
    #[must_use]
    pub fn with_control(self, control: Control) -> Self {
        Study { control, ..self }
    }

    /// Keeps finished pieces of a work in a file, and takes over those that an earlier run of the same work
    /// has kept there. `work` tells works on this study apart: everything on which its result depends beside
    /// machine, measurements, split and settings. A study that is changed afterwards leaves the journal.
    ///
    /// # Errors  the file exists and cannot be read.
    pub fn resumable(self, path: &Path, work: &str) -> StudyResult<Self> {
        let journal = Journal::open(path, &self.key(work));
        let journal = journal.map_err(|e| {
            StudyError::input(
                path.display(),
                format!("the journal of finished work cannot be read: {e}; remove it"),
            )
        })?;
        let control = self.control.clone().with_journal(Some(Arc::new(journal)));
        Ok(self.with_control(control))
    }

    /// Returns a text of everything on which the result of a work depends, this build of the program
    /// included: another may compute other numbers.
    pub fn key(&self, work: &str) -> String {
        let Study { config, set, overrides, without, fit, hold_out, settings, control: _ } = self;
        // Machine and observations may have been made or changed in memory.
        let own = digest_of(&(&config.machine, &set.positions, &set.modes, &set.frfs, &set.motions));
        let of_set = (&set.quantity, &set.gain, &set.response, &set.excitation, &set.tolerance, &set.split);
        let build = std::env::current_exe()
            .and_then(std::fs::metadata)
            .and_then(|m| Ok((m.len(), m.modified()?)))
            .ok();
        let given = (
            env!("CARGO_PKG_VERSION"),
            build,
            work,
            overrides,
            without,
            fit,
            hold_out,
            settings,
            own,
            of_set,
        );
        let digests: Vec<String> = self.inputs().into_iter().map(|input| input.sha256).collect();
        format!("{given:?} {}", digests.join(" "))
    }

    /// Returns the machine as described.
    pub fn machine(&self) -> &Machine {
        &self.config.machine
    }

    /// Returns the text (TOML) of the machine's description, overrides and removed effects not applied.
    pub fn machine_description(&self) -> &str {
        &self.config.text
    }

    /// Returns title and file of the machine.
    pub fn machine_source(&self) -> (&str, &str) {
        (&self.config.machine.title, &self.config.path)
    }

    /// Returns the machine's file, its text, and what it holds beside the machine.
    pub fn config(&self) -> &MachineConfig {
        &self.config
    }

    /// Returns the overrides of the description.
    pub fn overrides(&self) -> &[String] {
        &self.overrides
    }

    /// Returns the names of positions and records to fit, where they were given.
    pub fn fitted(&self) -> Option<&[String]> {
        self.fit.as_deref()
    }

    /// Returns the names of positions and records to hold out.
    pub fn held_out(&self) -> &[String] {
        &self.hold_out
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

    /// Checks that there are data.
    ///
    /// # Errors  the set has no observations.
    pub(crate) fn check_observations(&self) -> StudyResult<()> {
        let is_empty = self.set.motions.is_empty() && self.set.frfs.is_empty() && self.set.modes.is_none();
        if is_empty {
            Err(StudyError::input(&self.set.path, "has no observations; name a set that does (measurements)"))
        } else {
            Ok(())
        }
    }

    /// Checks that the set has FRFs or modes, which a work needs.
    ///
    /// # Errors  it has no observations, or motion records only.
    pub(crate) fn check_responses(&self, work: &str) -> StudyResult<()> {
        self.check_observations()?;
        let fault = || format!("holds motion records only; {work} needs FRFs or modes");
        if self.is_on_motion() { Err(StudyError::input(&self.set.path, fault())) } else { Ok(()) }
    }

    /// Whether the set holds motion records, and neither FRFs nor modes.
    pub fn is_on_motion(&self) -> bool {
        !self.set.motions.is_empty() && self.set.frfs.is_empty() && self.set.modes.is_none()
    }
}

/// Reads the machine's description.
fn described(sources: &Sources) -> StudyResult<MachineConfig> {
    let path = sources.config.as_deref().unwrap_or(config::BENCH);
    Ok(read_machine(path, &sources.overrides, &sources.without)?)
}

/// Returns the measurement set that a description names.
pub(crate) fn named_set(config: &MachineConfig) -> Option<String> {
    config.measurements.as_ref().map(|name| format!("measurements/{name}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::{FrfArrays, Quantity, SetArrays};
    use num_complex::Complex64;

    fn arrays() -> SetArrays {
        let frequency_hz: Vec<f64> = (1..400).map(f64::from).collect();
        let value = vec![Complex64::new(1e-8, -1e-9); frequency_hz.len()];
        let frf = |name: &str| FrfArrays {
            position: Some(name.into()),
            frequency_hz: frequency_hz.clone(),
            value: value.clone(),
            ..FrfArrays::default()
        };
        SetArrays {
            title: "taps".into(),
            quantity: Some(Quantity::Receptance),
            response: Some("table".into()),
            excitation: Some("table".into()),
            nut_m: [("p1".to_string(), Some(0.5)), ("p2".to_string(), Some(0.9))].into(),
            frfs: vec![frf("p1"), frf("p2")],
            ..SetArrays::default()
        }
    }

    fn study(arrays: &SetArrays) -> Result<Study, String> {
        let machine = read_machine(config::BENCH, &[], &[]).map_err(|e| e.to_string())?;
        Ok(Study::new(machine, MeasurementSet::from_arrays(arrays).map_err(|e| e.to_string())?))
    }

    fn refusal(change: impl Fn(&mut SetArrays)) -> String {
        let mut changed = arrays();
        change(&mut changed);
        let found = study(&changed).and_then(|study| {
            study.fit(["p1"]).and_then(|study| study.identify()).map_err(|e| e.to_string())
        });
        found.err().unwrap_or_else(|| "accepted".into())
    }

    #[test]
    fn arrays_are_refused_with_record_and_key() {
        for (message, words) in [
            (refusal(|set| set.frfs.clear()), "taps: holds no observation at all"),
            (
                refusal(|set| set.frfs[1].value.truncate(398)),
                "frfs[1] (p2): value has 398 entries, frequency_hz has 399",
            ),
            (
                refusal(|set| set.frfs[0].coherence = Some(vec![0.9; 3])),
                "frfs[0] (p1): coherence has 3 entries",
            ),
            (
                refusal(|set| set.frfs[0].coherence = Some(vec![0.9; 399])),
                "frfs[0] (p1): has a coherence but no averages",
            ),
            (
                refusal(|set| set.frfs[0].frequency_hz.swap(3, 4)),
                "frfs[0] (p1): entry 4: frequency_hz 4 does not follow 5",
            ),
            (refusal(|set| set.frfs[0].value[7].re = f64::NAN), "frfs[0] (p1): value[14] is NaN"),
            (refusal(|set| set.quantity = None), "has no quantity, nor has the set"),
            (
                refusal(|set| set.response = Some("tabel".into())),
                "response = \"tabel\" is not a point of the machine",
            ),
            (refusal(|set| set.response = None), "has no response"),
            (
                refusal(|set| set.frfs[1].position = Some("p9".into())),
                "nut_m has no position «p9»; it has p1, p2",
            ),
        ] {
            assert!(message.contains(words), "«{message}» does not contain «{words}»");
        }
    }

    #[test]
    fn unknown_positions_and_results_of_other_machines_are_refused() {
        let own = study(&arrays()).unwrap();
        let message = own.clone().fit(["p1", "p7"]).err().unwrap().to_string();
        assert!(message.contains("no position or record «p7»; it has p1, p2"), "{message}");
        let bench = Study::load(config::BENCH, measurement::BENCH)
            .unwrap()
            .with_settings(Settings { repeats: 1, ..Settings::default() });
        let mut found = bench.fit(["l1", "l3"]).unwrap().identify().unwrap();
        found.parameters.remove("k_n");
        let message = own.validate(&found).err().unwrap().to_string();
        assert!(message.contains("has no parameter «k_n»"), "{message}");
    }

    /// A journal or cache of one study must not serve another: every part of a study enters its key.
    #[test]
    fn every_part_of_a_study_enters_its_key() {
        let own = study(&arrays()).unwrap();
        let key = |study: &Study| study.key("identify");
        let changed = |change: &dyn Fn(&mut SetArrays)| {
            let mut arrays = arrays();
            change(&mut arrays);
            study(&arrays).unwrap()
        };
        let machine_changed = {
            let mut config = read_machine(config::BENCH, &[], &[]).unwrap();
            config.machine.parameters[0].start *= 1.01;
            Study::new(config, own.set.clone())
        };
        let settings = own.settings.clone();
        let others = [
            machine_changed,
            changed(&|set| set.frfs[0].value[5] *= 1.0 + 1e-15),
            changed(&|set| set.nut_m = [("p1".to_string(), Some(0.6)), ("p2".to_string(), Some(0.9))].into()),
            changed(&|set| set.quantity = Some(Quantity::Mobility)),
            changed(&|set| set.response = Some("rotor".into())),
            changed(&|set| set.averages = Some(8)),
            changed(&|set| set.gain = measurement::Gain::Unknown),
            changed(&|set| set.split = Some(vec!["p1".into()])),
            changed(&|set| set.tolerance.gain *= 2.0),
            changed(&|set| set.frfs[0].relative_sd = Some(vec![0.01; 399])),
            own.clone().fit(["p1"]).unwrap(),
            own.clone().hold_out(["p1"]).unwrap(),
            own.clone().without(["rotor-hold"]).unwrap(),
            own.clone().with_settings(Settings { fit_tolerances: false, ..settings.clone() }),
            own.clone().with_settings(Settings { bootstrap: 100, ..settings.clone() }),
            own.clone().with_settings(Settings { freeze: vec!["k_n".into()], ..settings.clone() }),
            own.clone().with_settings(Settings { repeats: 1, ..settings.clone() }),
            own.clone().with_settings(Settings { frequency_model_error: 0.02, ..settings.clone() }),
            own.clone().with_settings(Settings { amplitude_sd: 0.2, ..settings.clone() }),
            own.clone().with_settings(Settings { frf_model_error: 0.02, ..settings.clone() }),
            own.clone().with_settings(Settings { band_hz: Some((10.0, 200.0)), ..settings.clone() }),
            own.clone()
                .with_settings(Settings { rods: dynamics::model::RodModel::Lumped(20), ..settings.clone() }),
            own.clone().with_settings(Settings {
                objective: Some(crate::ObjectiveKind::Frequencies),
                ..settings.clone()
            }),
            own.clone().with_settings(Settings { seed: 2, ..settings }),
        ];
        assert!(others.iter().all(|other| key(other) != key(&own)));
        assert_ne!(own.key("diagnose"), key(&own));
    }
}
