//! Weights and options of mode objectives.

use dynamics::model::RodModel;

/// The function of the deviations to minimise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Σ r²: relative frequency errors over σ_f and ln-amplitude errors over σ_lnA.
    LeastSquares,
    /// √Σ[(Δf/f)² + (ΔA/A)²] as printed. Source: Tian et al., Eq. 26.
    Eq26,
    /// [`Objective::LeastSquares`] on the frequencies alone.
    Frequencies,
}

/// Weights and options of a mode objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeSettings {
    /// Function of the deviations.
    pub objective: Objective,
    /// Relative standard deviation of a frequency by model error (1).
    pub frequency_model_error: f64,
    /// Standard deviation of ln(amplitude) (1).
    pub amplitude_sd: f64,
    /// How rods are represented.
    pub rods: RodModel,
}

impl Default for ModeSettings {
    /// Model errors of 1 % of a frequency, in addition to its scatter, and σ_lnA = 0.13, from the published
    /// bench.
    fn default() -> Self {
        ModeSettings {
            objective: Objective::LeastSquares,
            frequency_model_error: 0.01,
            amplitude_sd: 0.13,
            rods: RodModel::Exact,
        }
    }
}

impl ModeSettings {
    /// Returns the standard deviation of the relative error of a predicted frequency against one measured with
    /// a relative scatter: model error and scatter are independent.
    pub(crate) fn frequency_sd(&self, scatter: f64) -> f64 {
        scatter.hypot(self.frequency_model_error)
    }
}
