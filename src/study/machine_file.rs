//! Machine files of results: an identified machine, and a machine with the effect that a diagnosis names.

use std::collections::BTreeMap;

use crate::identified::estimates;
use crate::study::named_set;
use crate::{Study, StudyError, StudyResult};
use config::{Found, machine_as_found, read_machine};
use machine::Estimate;
use report::diagnosis::DiagnosisDocument;
use report::document::IdentificationDocument;
use report::vocabulary::VerdictKind;

impl Study {
    /// Returns the description of the machine as identified (TOML): parameters start at their estimates, and
    /// the estimates of tolerances that were fitted along are its priors.
    ///
    /// # Errors  as [`Study::predict_with`].
    pub fn machine_of_identification(
        &self,
        identified: &IdentificationDocument,
        name: &str,
    ) -> StudyResult<String> {
        let study = self.with_posterior_of(identified, name)?;
        let values = identified.parameters.iter().map(|(id, row)| (id.clone(), row.value)).collect();
        let nuts_m = study.set.nuts_m();
        let described = study.config.machine.with_tolerances(&nuts_m).map_err(StudyError::impossible)?;
        let is_of_machine =
            |name: &str| described.parameters.iter().any(|p| p.is_tolerance() && p.name() == name);
        let mut held: BTreeMap<String, Estimate> = estimates(identified);
        held.retain(|name, _| is_of_machine(name));
        let tolerances = (!held.is_empty()).then_some((nuts_m, held));
        let what = if tolerances.is_some() { ", estimates of tolerances ([fitted])" } else { "" };
        let heading = format!("Identified machine: parameters start at the estimates of {name}{what}.");
        let measurements_sha256 = study.data_files().map(|input| input.sha256).collect();
        study.machine_text_of(Found { values, tolerances, measurements_sha256, ..Found::default() }, &heading)
    }

    /// Returns the description of the machine with the effect that a diagnosis names (TOML); its parameters
    /// start at the values that the diagnosis found.
    ///
    /// # Errors  the verdict names no effect, or more than one explanation; the diagnosis is not complete, or
    ///   is that of another machine.
    pub fn machine_of_diagnosis(&self, diagnosis: &DiagnosisDocument) -> StudyResult<String> {
        let verdict = &diagnosis.verdict;
        if !diagnosis.stamp.complete {
            return Err(StudyError::impossible(
                "the diagnosis was stopped early, and names no effect to apply; run it to its end",
            ));
        }
        let named = match &verdict.effects[..] {
            [named] if verdict.kind == VerdictKind::Effect => named,
            named => {
                let alike = if named.is_empty() { String::new() } else { format!(" ({})", named.join(", ")) };
                let next = verdict
                    .next_measurement
                    .as_ref()
                    .map_or_else(String::new, |next| format!("; next measurement: {next}"));
                let fault = format!(
                    "the verdict «{}»{alike} names no single effect to apply: no machine is written{next}",
                    verdict.kind
                );
                return Err(StudyError::impossible(fault));
            }
        };
        // The chosen model contains the named effects and what describes them in more detail.
        let effects: Vec<String> = diagnosis.chosen.effects().map(String::from).collect();
        let detail = effects
            .iter()
            .filter(|id| !named.split('+').any(|other| other == *id))
            .fold(String::new(), |all, id| format!("{all}, with {id}"));
        let heading = format!(
            "Machine with {named}, the effect that a diagnosis with {} names{detail}.",
            diagnosis.measurements
        );
        self.machine_text_of(
            Found { values: diagnosis.chosen.parameters.clone(), effects, ..Found::default() },
            &heading,
        )
    }

    /// Returns the study with the machine of a file, and with its own measurements, split and settings.
    ///
    /// # Errors  the file does not describe a machine.
    pub fn with_machine_file(&self, path: &str) -> StudyResult<Study> {
        let study = Study {
            config: read_machine(path, &[], &[])?,
            overrides: Vec::new(),
            without: Vec::new(),
            ..self.clone()
        };
        Ok(study.other_work())
    }

    fn machine_text_of(&self, found: Found, heading: &str) -> StudyResult<String> {
        let keeps_measurements = named_set(&self.config).is_some_and(|named| named == self.set.path);
        Ok(machine_as_found(&self.config, &self.overrides, &Found { keeps_measurements, ..found }, heading)?)
    }
}
