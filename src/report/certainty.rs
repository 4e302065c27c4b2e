//! Uncertainty of an identification: tolerances, minima next to the lowest, combinations, bootstraps.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::vocabulary::PriorKind;

/// Prior of a tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PriorRow {
    /// Mean of a normal prior, median of a log-normal one (in the unit of the tolerance).
    pub mean: f64,
    /// Standard deviation of a normal or half-normal prior (in the unit of the tolerance); of the logarithm
    /// for a log-normal one (1).
    pub sd: f64,
    /// Distribution: `normal`, `log-normal` or `half-normal`, whose value is a size.
    #[serde(default)]
    pub kind: PriorKind,
}

/// Estimate of a tolerance of the description or the measurement, fitted jointly with the parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ToleranceRow {
    /// Unit of prior and estimate; 1 for a relative change, a factor or a loss factor.
    pub unit: String,
    /// Prior of the tolerance.
    pub prior: PriorRow,
    /// Estimate (in `unit`).
    pub value: f64,
    /// Standard deviation of the estimate (in `unit`); of its logarithm for a log-normal prior (1).
    pub sd: f64,
}

impl ToleranceRow {
    /// Returns the deviation of the estimate from the mean of the prior, in standard deviations of the prior.
    pub fn deviation(&self) -> f64 {
        let PriorRow { mean, sd, kind } = &self.prior;
        if *kind == PriorKind::LogNormal { (self.value / mean).ln() / sd } else { (self.value - mean) / sd }
    }
}

/// How far the global search went: rounds of new spread starts, until the best minimum was found as often as
/// required.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SearchRow {
    /// Number of spread starts.
    pub starts: usize,
    /// Number of starts that ended in the best minimum.
    pub found: usize,
    /// Number of times that the best minimum had to be found.
    pub required: usize,
}

/// One round of searches from new spread starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RepeatRow {
    /// Seed of this round.
    pub seed: u64,
    /// Minimum of the objective that this round found, as `cost` of the document.
    pub cost: f64,
    /// Number of evaluations of the objective.
    pub evaluations: u64,
    /// Lowest cost after each generation or start; for whole FRFs the mean square of ln(measured/predicted)
    /// on few lines over a variance of 0.09.
    pub trace: Vec<f64>,
}

/// A minimum of χ² that the data do not distinguish from the lowest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BasinRow {
    /// χ² at the minimum (1).
    pub cost: f64,
    /// Number of searches that found it.
    pub count: usize,
    /// Values of the fitted parameters by id, each in its unit.
    pub values: BTreeMap<String, f64>,
}

/// A coordinate of the posterior: a fitted parameter, a tolerance, or a quantity of the measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CoordinateRow {
    /// Id of the parameter, or name of the tolerance.
    pub name: String,
    /// Whether it belongs to the machine; otherwise to the measurement.
    pub of_machine: bool,
    /// Centre and standard deviation of its prior in the unit interval of its range; absent without a prior.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<[f64; 2]>,
}

/// A residual of a fit of modes about its minima, from which two tests are fitted jointly. A frequency's is
/// relative (1); that of an amplitude, or of modes that one side lacks, is in its standard deviations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualRow {
    /// Name of the position.
    pub position: String,
    /// Nut position (m); absent where the machine has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nut_m: Option<f64>,
    /// Order of the mode whose frequency it compares; absent for another residual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<u32>,
    /// Standard deviation by model error; 0 for another residual.
    pub model_sd: f64,
    /// Standard deviation by rounding and stated scatter; 1 for another residual.
    pub scatter_sd: f64,
    /// Whether `modes.csv` states the scatter of the frequency.
    pub scatter_stated: bool,
    /// Residual at each minimum.
    pub deviations: Vec<f64>,
    /// Derivative with respect to each coordinate.
    pub slopes: Vec<f64>,
}

/// Minima of χ² and covariance of all fitted coordinates, tolerances included, each in the unit interval of
/// its range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PosteriorRow {
    /// The coordinates.
    pub coordinates: Vec<CoordinateRow>,
    /// Coordinates of each minimum that the data do not distinguish, the best first.
    pub minima: Vec<Vec<f64>>,
    /// Covariance about the best minimum: rows of the lower triangle.
    pub covariance: Vec<Vec<f64>>,
    /// Factor of the variance of the data, by misfit and correlation of the residuals (1).
    pub variance: f64,
    /// Residuals of modes; absent for whole FRFs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub residuals: Vec<ResidualRow>,
}

/// Two correlated parameters whose combination is determined better than each parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CombinationRow {
    /// Ids of the two parameters.
    pub parameters: [String; 2],
    /// Combination that the data determine: `series`, `parallel`, `ratio` or `opposite`.
    pub kind: String,
    /// Correlation of the two estimates (1).
    pub correlation: f64,
    /// Relative standard deviation of the combination (1).
    pub relative_sd: f64,
    /// Explanation for the user.
    // Former key, still read.
    #[serde(alias = "says")]
    pub description: String,
}

/// Intervals of the parameters by bootstrap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BootstrapRow {
    /// Unit of resampling: `lines` (frequency lines or modes of a position) or `positions` (positions or
    /// records).
    pub drawn: String,
    /// Number of bootstrap samples.
    pub samples: usize,
    /// 2.5 and 97.5 % quantiles by parameter id, in the unit of the parameter.
    pub interval95: BTreeMap<String, [f64; 2]>,
}
