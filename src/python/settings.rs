//! Settings of a study from a dictionary.

use pyo3::prelude::*;
use study::{RodModel, Settings};

use crate::error::word;

/// Settings as given; those that are `None` keep their default.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct GivenSettings {
    lumps: Option<usize>,
    objective: Option<String>,
    frequency_model_error: Option<f64>,
    amplitude_sd: Option<f64>,
    frf_model_error: Option<f64>,
    tolerances: Option<bool>,
    band_hz: Option<(f64, f64)>,
    bootstrap: Option<usize>,
    freeze: Option<Vec<String>>,
    seed: Option<u64>,
    repeats: Option<usize>,
}

impl GivenSettings {
    /// Builds the settings of the library.
    ///
    /// # Errors  the objective is unknown.
    pub fn settings(self) -> PyResult<Settings> {
        let usual = Settings::default();
        Ok(Settings {
            rods: self.lumps.map_or(usual.rods, RodModel::Lumped),
            objective: word("objective", self.objective.as_deref())?,
            frequency_model_error: self.frequency_model_error.unwrap_or(usual.frequency_model_error),
            amplitude_sd: self.amplitude_sd.unwrap_or(usual.amplitude_sd),
            frf_model_error: self.frf_model_error.unwrap_or(usual.frf_model_error),
            fit_tolerances: self.tolerances.unwrap_or(usual.fit_tolerances),
            band_hz: self.band_hz,
            bootstrap: self.bootstrap.unwrap_or(usual.bootstrap),
            freeze: self.freeze.unwrap_or(usual.freeze),
            seed: self.seed.unwrap_or(usual.seed),
            repeats: self.repeats.unwrap_or(usual.repeats),
        })
    }
}
