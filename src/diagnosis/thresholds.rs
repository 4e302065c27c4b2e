//! Thresholds of significance by kind of data.

use super::evidence::Domain;

/// Thresholds of one kind of data. For FRFs, null simulations calibrate the misfit of a correct model. The
/// weights of modes are a model error that is hardly known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thresholds {
    /// Largest p-value of a significant candidate; the second of one that also improves the prediction of
    /// left-out positions.
    pub alpha: f64,
    pub cv_alpha: f64,
    /// Excess (misfit over the median of null simulations) above which a further effect is searched.
    pub continue_from: f64,
    /// Least share of the remaining χ² by which a further effect must reduce it: where the excess then falls
    /// to `continue_from`, and otherwise.
    pub next_share: (f64, f64),
    /// Least share of the nominal χ² by which a further effect must reduce it: the form of the first is known
    /// to about six percent in amplitude.
    pub form_error: f64,
    /// Excess above which an effect must explain a large share of χ².
    pub large_excess: f64,
    /// Excess above which a combination of effects is rejected.
    pub combination_excess: f64,
    /// Whether null simulations calibrate the misfit. Then a fit that agrees with them excludes one that does
    /// not, and a combination of effects must explain more than a generic impedance.
    pub calibrated: bool,
}

const FRF: Thresholds = Thresholds {
    alpha: 0.002,
    cv_alpha: 0.01,
    continue_from: 1.2,
    next_share: (0.25, 0.5),
    form_error: 0.004,
    large_excess: 2.0,
    combination_excess: 10.0,
    calibrated: true,
};
const MODES: Thresholds = Thresholds {
    alpha: 0.001,
    cv_alpha: 0.001,
    continue_from: 2.0,
    next_share: (0.4, 0.4),
    form_error: 0.0,
    large_excess: 5.0,
    combination_excess: f64::INFINITY,
    calibrated: false,
};

impl Thresholds {
    /// Returns the thresholds of a kind of data.
    pub fn of(domain: Domain) -> Self {
        match domain {
            Domain::Frf(_) => FRF,
            Domain::Modes(_) => MODES,
        }
    }

    /// Returns the difference of χ² attributable to model error: `of_gain`, at most the misfit beyond null
    /// simulations where these calibrate it.
    pub fn margin(&self, of_gain: f64, chi_square: f64, excess: f64) -> f64 {
        let beyond_nulls = chi_square * (1.0 - 1.0 / excess);
        if self.calibrated { of_gain.min(beyond_nulls) } else { of_gain }
    }
}
