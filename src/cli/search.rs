//! Settings of a study from the arguments of a search.

use crate::arguments::{ObjectiveName, SearchArguments, ToleranceName, band};
use study::{ObjectiveKind, Settings};

/// Builds the settings of a study from its arguments.
pub fn settings(search: &SearchArguments) -> Result<Settings, String> {
    Ok(Settings {
        rods: search.rods.represent(),
        objective: search.objective.map(objective),
        frequency_model_error: search.frequency_model_error,
        amplitude_sd: search.amplitude_sd,
        frf_model_error: search.frf_model_error,
        fit_tolerances: search.tolerances == ToleranceName::Fit,
        band_hz: band(&search.band, "20,800")?,
        bootstrap: usize::from(search.bootstrap),
        freeze: search.freeze.clone(),
        seed: search.seed,
        repeats: usize::from(search.repeats),
    })
}

fn objective(name: ObjectiveName) -> ObjectiveKind {
    match name {
        ObjectiveName::LeastSquares => ObjectiveKind::LeastSquares,
        ObjectiveName::Eq26 => ObjectiveKind::Eq26,
        ObjectiveName::Frequencies => ObjectiveKind::Frequencies,
        ObjectiveName::Frf => ObjectiveKind::Frf,
        ObjectiveName::InverseDynamics => ObjectiveKind::InverseDynamics,
        ObjectiveName::OutputError => ObjectiveKind::OutputError,
    }
}
