//! Settings of a search: from its arguments, and as its document keeps them.

use crate::arguments::{ModelName, ObjectiveName, SearchArguments, Sources, ToleranceName};
use crate::sources::Loaded;
use identification::IdentificationSettings;
use identification::objective::{FrfSettings, ModeSettings, Objective};
use measurement::MeasurementSet;
use optimizer::Strategy;
use report::document::RunSettings;
use study::{ObjectiveKind, Settings};

/// Returns the objective of this name.
pub fn objective(name: ObjectiveName) -> Objective {
    match name {
        ObjectiveName::LeastSquares => Objective::LeastSquares,
        ObjectiveName::Eq26 => Objective::Eq26,
        ObjectiveName::Frequencies => Objective::Frequencies,
        ObjectiveName::Frf | ObjectiveName::InverseDynamics | ObjectiveName::OutputError => Objective::LeastSquares,
    }
}

/// Whether whole FRFs are fitted: on request, or by default where the set has some.
pub fn fits_frfs(search: &SearchArguments, set: &MeasurementSet) -> bool {
    search.objective.map_or(!set.frfs.is_empty(), |o| o == ObjectiveName::Frf)
}

/// Returns the requested band (Hz).
fn band_hz(search: &SearchArguments) -> Result<(f64, f64), String> {
    match search.band[..] {
        [] => Ok(FrfSettings::default().band_hz),
        [from, to] if from >= 0.0 && to > from => Ok((from, to)),
        _ => Err(format!("--band {}: write the lowest and the highest frequency in Hz, such as --band 20,800", listed(&search.band))),
    }
}

fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// Returns the name of an objective.
pub fn objective_word(objective: Objective) -> &'static str {
    match objective {
        Objective::LeastSquares => "least-squares",
        Objective::Eq26 => "eq26",
        Objective::Frequencies => "frequencies",
    }
}

/// Returns the settings of a study from the arguments of its search.
pub fn study_settings(search: &SearchArguments) -> Result<Settings, String> {
    let band_hz = match search.band[..] {
        [] => None,
        [from, to] => Some((from, to)),
        _ => return Err(format!("--band {}: write the lowest and the highest frequency in Hz, such as 20,800", listed(&search.band))),
    };
    Ok(Settings {
        rods: search.rods.represent(),
        objective: search.objective.map(|name| match name {
            ObjectiveName::LeastSquares => ObjectiveKind::LeastSquares,
            ObjectiveName::Eq26 => ObjectiveKind::Eq26,
            ObjectiveName::Frequencies => ObjectiveKind::Frequencies,
            ObjectiveName::Frf => ObjectiveKind::Frf,
            ObjectiveName::InverseDynamics => ObjectiveKind::InverseDynamics,
            ObjectiveName::OutputError => ObjectiveKind::OutputError,
        }),
        frequency_model_error: search.frequency_model_error,
        amplitude_sd: search.amplitude_sd,
        frf_model_error: search.frf_model_error,
        fit_tolerances: search.tolerances == ToleranceName::Fit,
        band_hz,
        bootstrap: usize::from(search.bootstrap),
        freeze: search.freeze.clone(),
        seed: search.seed,
        repeats: usize::from(search.repeats),
    })
}

/// Builds the settings of an identification from its arguments.
pub fn plan(search: &SearchArguments, set: &MeasurementSet) -> Result<IdentificationSettings, String> {
    for (key, x) in [("--frequency-model-error", search.frequency_model_error), ("--amplitude-sd", search.amplitude_sd)] {
        if !(1e-6..=1e3).contains(&x) {
            return Err(format!("{key} {x}: write a number above 0, from 1e-6 to 1000"));
        }
    }
    if !(0.0..=1e3).contains(&search.frf_model_error) {
        return Err(format!("--frf-model-error {}: write 0 or a positive number, such as 0.01", search.frf_model_error));
    }
    if (1..50).contains(&search.bootstrap) {
        return Err(format!("--bootstrap {}: too few for 95 % intervals; draw at least 50", search.bootstrap));
    }
    let frf = FrfSettings {
        model_error: search.frf_model_error,
        band_hz: band_hz(search)?,
        rods: search.rods.represent(),
        ..FrfSettings::default()
    };
    Ok(IdentificationSettings {
        settings: ModeSettings {
            objective: search.objective.map_or(Objective::LeastSquares, objective),
            frequency_model_error: search.frequency_model_error,
            amplitude_sd: search.amplitude_sd,
            rods: search.rods.represent(),
        },
        tolerances: search.tolerances == ToleranceName::Fit,
        frozen: search.freeze.clone(),
        seed: search.seed,
        repeats: usize::from(search.repeats),
        strategy: Strategy::CurrentToPbest,
        frf: fits_frfs(search, set).then_some(frf),
        near: None,
        profile: true,
        bootstrap: usize::from(search.bootstrap),
    })
}

/// Returns the settings of a run, as its document keeps them.
pub fn settings(sources: &Sources, search: &SearchArguments, plan: &IdentificationSettings) -> RunSettings {
    let lumped = search.rods.model == ModelName::Lumped;
    RunSettings {
        config: sources.config.clone(),
        measurements: sources.measurements.clone(),
        model: if lumped { "lumped" } else { "receptance" }.into(),
        lumps: lumped.then_some(usize::from(search.rods.lumps)),
        objective: plan.frf.map_or_else(|| objective_word(plan.settings.objective), |_| "frf").into(),
        frf_model_error: search.frf_model_error,
        tolerances: if plan.frf.is_some() && plan.tolerances { "fit" } else { "none" }.into(),
        band_hz: plan.frf.map(|f| f.band_hz).filter(|b| *b != FrfSettings::default().band_hz).map(|b| [b.0, b.1.min(f64::MAX)]),
        positions: None,
        hold_out: Vec::new(),
        bootstrap: plan.bootstrap,
        frequency_model_error: search.frequency_model_error,
        amplitude_sd: search.amplitude_sd,
        repeats: usize::from(search.repeats),
        freeze: search.freeze.clone(),
    }
}

/// Checks that the machine has the parameters to freeze.
pub fn check_frozen(loaded: &Loaded, frozen: &[String]) -> Result<(), String> {
    let parameters = &loaded.config.machine.parameters;
    match frozen.iter().find(|id| !parameters.iter().any(|p| p.id == **id)) {
        None => Ok(()),
        Some(id) => {
            let known: Vec<&str> = parameters.iter().map(|p| p.id.as_str()).collect();
            Err(format!("--freeze: the machine has no parameter «{id}»; there are {}", known.join(", ")))
        }
    }
}
