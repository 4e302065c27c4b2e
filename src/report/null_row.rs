//! Null simulations in the document of a diagnosis.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Null simulations: draws of the machine as described with tolerances and noise. A statistic is the largest
/// reduction of χ² of any candidate over its scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NullRow {
    /// Number of draws that are linear about the nominal fit.
    pub linear_draws: usize,
    /// Median of their statistics (1).
    pub linear_median: f64,
    /// Number of draws whose fits were made in full.
    pub fitted_draws: usize,
    /// Median of their statistics (1); null for modes.
    pub fitted_median: Option<f64>,
    /// Factor on the statistics of linear draws in p-values (1): ratio of the medians, at least 1.
    pub factor: f64,
}
