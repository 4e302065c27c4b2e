//! Settings of a study from the arguments of a search.

use crate::arguments::{SearchArguments, band};
use report::vocabulary::ToleranceUse;
use study::Settings;

/// Builds the settings of a study from its arguments.
pub fn settings(search: &SearchArguments) -> Result<Settings, String> {
    Ok(Settings {
        rods: search.rods.represent(),
        objective: search.objective,
        frequency_model_error: search.frequency_model_error,
        amplitude_sd: search.amplitude_sd,
        frf_model_error: search.frf_model_error,
        fit_tolerances: search.tolerances == ToleranceUse::Fit,
        band_hz: band(&search.band, "20,800")?,
        bootstrap: usize::from(search.bootstrap),
        freeze: search.freeze.clone(),
        seed: search.seed,
        repeats: usize::from(search.repeats),
    })
}
