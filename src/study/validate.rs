//! Validation: prediction errors of an identified machine at held-out data, or on another set.

use std::collections::BTreeMap;
use std::path::Path;

use crate::identified::{check_identification, settings_of, tolerance_values};
use crate::motion_records::{add_simulated_gaps, list_positions, list_records};
use crate::{Study, StudyError, StudyResult, document_rows};
use identification::channels_of;
use identification::objective::{
    FrfObjective, FrfSettings, MISSING, ModeObjective, ModeSettings, PositionPrediction,
};
use measurement::MotionRecord;
use report::document::{IdentificationDocument, Input, PositionRow, ValidationDocument};
use report::vocabulary::{ObjectiveKind, Role};

/// What a validation checks. The default checks what the identification held out of its own set; everything
/// where it held out nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ValidationRequest {
    /// Names of the positions or records to check.
    pub positions: Option<Vec<String>>,
    /// File of the identification; absent for a result in memory.
    pub file: Option<Input>,
}

impl ValidationRequest {
    fn name(&self) -> String {
        self.file.as_ref().map_or_else(|| "the identification".into(), |file| file.path.clone())
    }
}

impl Study {
    /// Predicts what an identification held out, and returns the errors.
    ///
    /// # Errors  the identification is that of another machine; machine and set do not fit together.
    pub fn validate(&self, identified: &IdentificationDocument) -> StudyResult<ValidationDocument> {
        self.validate_with(identified, &ValidationRequest::default())
    }

    /// As [`Study::validate`], at chosen positions or on another set.
    ///
    /// # Errors  as [`Study::validate`]; a position is unknown.
    pub fn validate_with(
        &self,
        identified: &IdentificationDocument,
        request: &ValidationRequest,
    ) -> StudyResult<ValidationDocument> {
        check_identification(Path::new(&request.name()), identified)?;
        self.check_observations()?;
        if !self.is_machine_of(identified) {
            let title = &self.config.machine.title;
            let fault = format!(
                "is of another machine than «{title}»: text, overrides or removed effects of its description differ"
            );
            return Err(StudyError::input(request.name(), fault));
        }
        let warnings = self.changed_inputs(&identified.stamp.inputs);
        let mut document = if self.is_on_motion() {
            self.validate_records(identified, request, warnings)?
        } else {
            self.validate_responses(identified, request, warnings)?
        };
        document.stamp.inputs.extend(request.file.clone());
        Ok(document)
    }

    /// Whether an identification is on this measurement set. On another one the split does not hold, and gain
    /// and delays of channels are fitted anew.
    fn is_set_of(&self, identified: &IdentificationDocument) -> bool {
        identified.settings.measurements == self.set.path
    }

    fn validate_responses(
        &self,
        identified: &IdentificationDocument,
        request: &ValidationRequest,
        mut warnings: Vec<String>,
    ) -> StudyResult<ValidationDocument> {
        self.check_measured_band()?;
        let settings = &identified.settings;
        let (machine, values) = self.identified_machine(Path::new(&request.name()), identified)?;
        let (machine, values) = (&machine, &values);
        let whole_frfs = settings.objective == ObjectiveKind::Frf;
        let same_set = self.is_set_of(identified);
        // The split of the identification, where the set is the same.
        let split = if same_set {
            self.set.split(settings.positions.as_deref(), &settings.hold_out).ok()
        } else {
            None
        };
        let (fitted, left) = split.unzip();
        let (fitted_positions, fitted_frfs) =
            fitted.as_ref().map_or((&[][..], &[][..]), |fit| (fit.positions(), fit.frfs()));
        let held_out = match (&request.positions, left) {
            (Some(names), _) => self.set.to_predict(names)?,
            (None, Some(left)) if !left.is_empty() => left,
            (None, _) => self.set.everything_to_predict(),
        };
        if whole_frfs && held_out.frfs().is_empty() {
            let fault = "holds no FRF to check at these positions; the identification is on whole FRFs";
            return Err(StudyError::input(&self.set.path, fault));
        }
        let made = settings_of(identified);
        let rods = made.rods;
        // The gain belongs to a measurement set; for another set it is fitted.
        let own_gain = if same_set { identified.parameters.get("gain").map(|g| g.value) } else { None };
        let positions: BTreeMap<String, PositionRow> = if whole_frfs {
            let band_hz = made.band_hz.unwrap_or(FrfSettings::default().band_hz);
            let frf_settings = FrfSettings {
                rods,
                band_hz,
                model_error: if made.frf_model_error > 0.0 {
                    made.frf_model_error
                } else {
                    FrfSettings::default().model_error
                },
                ..FrfSettings::default()
            };
            let objective = FrfObjective::held_out(machine, &held_out, frf_settings)?;
            // Gains and delays belong to the channels of the set they were estimated on.
            let channels =
                if same_set { channels_of(machine, &tolerance_values(identified)) } else { Vec::new() };
            let objective = objective.calibrated(&channels);
            let gain = own_gain.unwrap_or_else(|| objective.best_gain(values));
            let mut frfs = Vec::new();
            for gap in objective.gaps(values, gain) {
                frfs.extend(document_rows::frfs(&self.set, &[gap], Role::of(fitted_frfs.contains(&gap.frf))));
            }
            document_rows::gathered(&frfs)
        } else {
            let mode_settings = ModeSettings { rods, ..ModeSettings::default() };
            let objective = ModeObjective::held_out(machine, &held_out, mode_settings, None)?;
            let predictions = objective.predict(values);
            let gain = own_gain.or_else(|| {
                Some(objective.amplitude_fit(&predictions))
                    .filter(|f| f.count > 0 && !same_set)
                    .map(|f| f.gain)
            });
            let row = |p: &PositionPrediction| {
                let name = self.set.positions[p.position].name.clone();
                let role = Role::of(fitted_positions.contains(&p.position));
                (name, document_rows::position(&self.set, p, role, gain, &identified.fit_positions))
            };
            predictions.iter().map(row).collect()
        };
        warnings.extend(document_rows::pairing_warnings(&positions));
        Ok(ValidationDocument {
            stamp: self.stamp("validation", identified.stamp.seed, true, warnings),
            largest_error: positions.values().filter_map(|p| p.largest_error(MISSING)).reduce(f64::max),
            largest_gap: positions.values().filter_map(|p| p.gap).reduce(f64::max),
            positions,
            records: BTreeMap::new(),
        })
    }

    fn validate_records(
        &self,
        identified: &IdentificationDocument,
        request: &ValidationRequest,
        mut warnings: Vec<String>,
    ) -> StudyResult<ValidationDocument> {
        let settings = &identified.settings;
        let values = self.identified_values(Path::new(&request.name()), identified)?;
        let simulated = match settings.objective {
            ObjectiveKind::InverseDynamics => false,
            ObjectiveKind::OutputError => true,
            other => {
                let fault = format!(
                    "holds motion records only, but {} was fitted by {other}; identify on motion records",
                    request.name()
                );
                return Err(StudyError::input(&self.set.path, fault));
            }
        };
        let machine = &self.config.machine;
        let all: Vec<usize> = (0..self.set.motions.len()).collect();
        let split = || self.set.split_motions(settings.positions.as_deref(), &settings.hold_out);
        let split = self.is_set_of(identified).then(split).transpose()?;
        let (fitted, held_out) =
            split.as_ref().map_or((&[][..], &all[..]), |(fit, held_out)| (fit, held_out));
        let chosen = match &request.positions {
            Some(names) => self.set.split_motions(Some(names), &[])?.0,
            None if !held_out.is_empty() => held_out.to_vec(),
            None => all.clone(),
        };
        let (motions, rigid, column_warnings) = self.preprocess_all()?;
        warnings.extend(column_warnings);
        let mut records = list_records(self, (&rigid, &values), &motions, chosen.iter().copied(), fitted);
        let own: Vec<&MotionRecord> = chosen.iter().map(|i| &self.set.motions[*i]).collect();
        let complete =
            !simulated || add_simulated_gaps(&mut records, (machine, &values), &own, &self.control)?;
        let positions =
            list_positions(
                &records,
                |r| if simulated { r.simulated_force_error } else { Some(r.force_error) },
            );
        Ok(ValidationDocument {
            stamp: self.stamp("validation", identified.stamp.seed, complete, warnings),
            largest_error: None,
            largest_gap: positions.values().filter_map(|p| p.gap).reduce(f64::max),
            positions,
            records,
        })
    }
}
