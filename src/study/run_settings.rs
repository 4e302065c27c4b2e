//! Settings of a study checked against its machine, and as documents keep them.

use crate::settings::kind_of_modes;
use crate::{Study, StudyError, StudyResult};
use dynamics::model::RodModel;
use identification::IdentificationSettings;
use identification::objective::FrfSettings;
use report::document::RunSettings;
use report::vocabulary::{ObjectiveKind, ToleranceUse};

impl Study {
    /// Checks that the machine has the parameters to freeze.
    pub(crate) fn check_frozen(&self) -> StudyResult<()> {
        let parameters = &self.config.machine.parameters;
        match self.settings.freeze.iter().find(|id| !parameters.iter().any(|p| p.id == **id)) {
            None => Ok(()),
            Some(id) => {
                let known: Vec<&str> = parameters.iter().map(|p| p.id.as_str()).collect();
                let fault = format!("the machine has no such parameter; it has {}", known.join(", "));
                Err(StudyError::setting("freeze", id, fault))
            }
        }
    }

    /// Returns the settings of a run, as its document keeps them.
    pub(crate) fn run_settings(&self, made: &IdentificationSettings) -> RunSettings {
        let lumps = match self.settings.rods {
            RodModel::Exact => None,
            RodModel::Lumped(lumps) => Some(lumps),
        };
        RunSettings {
            config: self.config.path.clone(),
            measurements: self.set.path.clone(),
            model: if lumps.is_some() { "lumped" } else { "receptance" }.into(),
            lumps,
            objective: if made.frf.is_some() {
                ObjectiveKind::Frf
            } else {
                kind_of_modes(made.settings.objective)
            },
            frf_model_error: self.settings.frf_model_error,
            tolerances: if made.frf.is_some() && made.tolerances {
                ToleranceUse::Fit
            } else {
                ToleranceUse::None
            },
            band_hz: made
                .frf
                .map(|f| f.band_hz)
                .filter(|b| *b != FrfSettings::default().band_hz)
                .map(|b| [b.0, b.1.min(f64::MAX)]),
            positions: self.fit.clone(),
            hold_out: self.hold_out.clone(),
            bootstrap: made.bootstrap,
            frequency_model_error: self.settings.frequency_model_error,
            amplitude_sd: self.settings.amplitude_sd,
            repeats: self.settings.repeats,
            freeze: self.settings.freeze.clone(),
        }
    }
}
