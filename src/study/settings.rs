//! Settings of a study, and their checks.

use std::ops::RangeInclusive;

use crate::{StudyError, StudyResult};
use dynamics::model::RodModel;
use identification::objective::{FrfSettings, ModeSettings, Objective};
use identification::{IdentificationSettings, REPEATS};
use measurement::MeasurementSet;
use report::vocabulary::ObjectiveKind;

/// Numbers of masses per rod of the lumped model.
pub(crate) const LUMPS: RangeInclusive<usize> = 1..=500;

/// Settings of identification and diagnosis. The defaults suit an ordinary axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Model of the rods.
    pub rods: RodModel,
    /// What to minimise; by default whole FRFs where the set has some, inverse dynamics for motion records,
    /// else least squares.
    pub objective: Option<ObjectiveKind>,
    /// Relative standard deviation of natural frequencies due to model error (1).
    pub frequency_model_error: f64,
    /// Standard deviation of ln(amplitude) (1).
    pub amplitude_sd: f64,
    /// Standard deviation of ln H due to model error, in addition to the noise (1).
    pub frf_model_error: f64,
    /// Whether tolerances of machine and measurement are fitted along with whole FRFs, each with its prior.
    pub fit_tolerances: bool,
    /// Lowest and highest frequency of FRFs (Hz); all lines by default.
    pub band_hz: Option<(f64, f64)>,
    /// Number of bootstrap samples over lines, and as many over positions; 0: none.
    pub bootstrap: usize,
    /// Ids of parameters held at their start values.
    pub freeze: Vec<String>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of times that the best minimum has to be found from new starts.
    pub repeats: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            rods: RodModel::Exact,
            objective: None,
            frequency_model_error: 0.01,
            amplitude_sd: 0.13,
            frf_model_error: 0.01,
            fit_tolerances: true,
            band_hz: None,
            bootstrap: 0,
            freeze: Vec::new(),
            seed: 1,
            repeats: REPEATS,
        }
    }
}

impl Settings {
    /// Whether whole FRFs are fitted: on request, or by default where the set has some.
    pub(crate) fn fits_frfs(&self, set: &MeasurementSet) -> bool {
        self.objective.map_or(!set.frfs.is_empty(), |o| o == ObjectiveKind::Frf)
    }

    /// Checks the settings, and builds those of an identification.
    ///
    /// # Errors  a number outside its range.
    pub(crate) fn identification(&self, set: &MeasurementSet) -> StudyResult<IdentificationSettings> {
        for (key, x) in
            [("frequency_model_error", self.frequency_model_error), ("amplitude_sd", self.amplitude_sd)]
        {
            if !(1e-6..=1e3).contains(&x) {
                return Err(StudyError::setting(key, x, "write a number above 0, from 1e-6 to 1000"));
            }
        }
        if !(0.0..=1e3).contains(&self.frf_model_error) {
            return Err(StudyError::setting(
                "frf_model_error",
                self.frf_model_error,
                "write 0 or a positive number, such as 0.01",
            ));
        }
        if (1..50).contains(&self.bootstrap) {
            return Err(StudyError::setting(
                "bootstrap",
                self.bootstrap,
                "too few for 95 % intervals; draw at least 50",
            ));
        }
        if !(1..=100).contains(&self.repeats) {
            return Err(StudyError::setting(
                "repeats",
                self.repeats,
                "write how often the best minimum has to be found, from 1 to 100",
            ));
        }
        if let RodModel::Lumped(lumps) = self.rods
            && !LUMPS.contains(&lumps)
        {
            return Err(StudyError::setting(
                "lumps",
                lumps,
                format!("a rod has {} to {} masses", LUMPS.start(), LUMPS.end()),
            ));
        }
        let band_hz = match self.band_hz {
            None => FrfSettings::default().band_hz,
            Some((from, to)) if from >= 0.0 && to > from => (from, to),
            Some((from, to)) => {
                let fault = "write the lowest and the highest frequency in Hz, such as 20,800";
                return Err(StudyError::setting("band_hz", format!("{from},{to}"), fault));
            }
        };
        let frf = FrfSettings {
            model_error: self.frf_model_error,
            band_hz,
            rods: self.rods,
            ..FrfSettings::default()
        };
        Ok(IdentificationSettings {
            settings: ModeSettings {
                objective: self.objective.map_or(Objective::LeastSquares, objective),
                frequency_model_error: self.frequency_model_error,
                amplitude_sd: self.amplitude_sd,
                rods: self.rods,
            },
            tolerances: self.fit_tolerances,
            frozen: self.freeze.clone(),
            seed: self.seed,
            repeats: self.repeats,
            frf: self.fits_frfs(set).then_some(frf),
            near: None,
            contained: Vec::new(),
            profile: true,
            bootstrap: self.bootstrap,
        })
    }
}

/// Checks a band of frequencies (Hz) above 0.
pub(crate) fn checked_band((from, to): (f64, f64)) -> StudyResult<(f64, f64)> {
    if from > 0.0 && to > from && to.is_finite() {
        return Ok((from, to));
    }
    Err(StudyError::setting(
        "band_hz",
        "",
        "write the lowest and the highest frequency in Hz, such as 5,1000",
    ))
}

/// Returns the kind of an objective on modes.
pub(crate) fn kind_of_modes(objective: Objective) -> ObjectiveKind {
    match objective {
        Objective::LeastSquares => ObjectiveKind::LeastSquares,
        Objective::Eq26 => ObjectiveKind::Eq26,
        Objective::Frequencies => ObjectiveKind::Frequencies,
    }
}

fn objective(kind: ObjectiveKind) -> Objective {
    match kind {
        ObjectiveKind::Eq26 => Objective::Eq26,
        ObjectiveKind::Frequencies => Objective::Frequencies,
        ObjectiveKind::LeastSquares
        | ObjectiveKind::Frf
        | ObjectiveKind::InverseDynamics
        | ObjectiveKind::OutputError => Objective::LeastSquares,
    }
}
