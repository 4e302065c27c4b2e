//! How sure an identification is: tolerances, minima beside the least, combinations, bootstraps.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What was known of a tolerance before it was fitted along.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PriorRow {
    /// Mean; median of a log-normal prior.
    pub mean: f64,
    /// Standard deviation; of the logarithm for a log-normal prior.
    pub sd: f64,
    /// `normal` or `log-normal`.
    #[serde(default = "normal")]
    pub kind: String,
}

fn normal() -> String {
    "normal".into()
}

/// A number that the description or the measurement states to a tolerance, as fitted along.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ToleranceRow {
    /// Unit; 1 for a relative change, a factor or a loss factor.
    pub unit: String,
    /// What was known of it.
    pub prior: PriorRow,
    /// Estimate.
    pub value: f64,
    /// Standard deviation of the estimate; of its logarithm for a log-normal prior.
    pub sd: f64,
}

impl ToleranceRow {
    /// Deviation of the estimate from the prior's mean, in standard deviations of the prior.
    pub fn deviation(&self) -> f64 {
        let PriorRow { mean, sd, kind } = &self.prior;
        if kind == "log-normal" { (self.value / mean).ln() / sd } else { (self.value - mean) / sd }
    }
}

/// A minimum of χ² that the data do not tell from the least.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BasinRow {
    /// Its cost.
    pub cost: f64,
    /// Searches that found it.
    pub count: usize,
    /// Parameters by id.
    pub values: BTreeMap<String, f64>,
}

/// Parameters of which the data see a combination better than each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CombinationRow {
    /// Ids of the two.
    pub parameters: [String; 2],
    /// `series`, `parallel`, `ratio` or `opposite`.
    pub kind: String,
    /// Their correlation.
    pub correlation: f64,
    /// Relative standard deviation of the combination.
    pub relative_sd: f64,
    /// In words.
    #[serde(alias = "says")]
    pub description: String,
}

/// Spread over bootstrap samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BootstrapRow {
    /// `lines` or `positions`.
    pub drawn: String,
    /// Samples.
    pub samples: usize,
    /// 2.5 and 97.5 % quantiles by parameter.
    pub interval95: BTreeMap<String, [f64; 2]>,
}
