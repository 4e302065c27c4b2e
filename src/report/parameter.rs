//! Estimate of a parameter in the documents.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::certainty::PriorRow;
use super::terminal::figure;
use super::vocabulary::PriorKind;

/// Estimate of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterRow {
    /// Estimate; start value of a parameter that was not fitted (in `unit`).
    pub value: f64,
    /// Unit of value, bounds and interval.
    pub unit: String,
    /// Lower bound of the plausible range (in `unit`).
    pub lower: f64,
    /// Upper bound of the plausible range (in `unit`).
    pub upper: f64,
    /// 95 % confidence interval (in `unit`); absent where none was computed.
    pub interval95: Option<[f64; 2]>,
    /// The parts of `interval95` in ascending order, where the data accept several ranges of values (in
    /// `unit`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals95: Vec<[f64; 2]>,
    /// Whether the parameter is identifiable from the data; absent for one that was not fitted, or that
    /// depends on what `depends_on` lists.
    pub identifiable: Option<bool>,
    /// Whether the parameter would be identifiable, but the fit is not that of the machine: its value depends
    /// on what `depends_on` lists.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub depends_on_discrepancy: bool,
    /// What shows that the fit is not that of the machine.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depends_on: Vec<String>,
    /// Prior that the machine's description states and the fit used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<PriorRow>,
    /// Whether the parameter was fitted; otherwise it kept its start value.
    pub fitted: bool,
    /// Physical meaning of the parameter.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Value that the publication of the data prints for a fit to the same positions (in `unit`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<f64>,
}

impl ParameterRow {
    /// Returns its prior in words; `None` without one.
    pub fn prior_text(&self) -> Option<String> {
        let PriorRow { mean, sd, kind } = self.prior.as_ref()?;
        let spread = match kind {
            PriorKind::LogNormal => format!("within a factor of {}", figure(sd.exp())),
            PriorKind::Normal | PriorKind::HalfNormal => format!("± {} {}", figure(*sd), self.unit),
        };
        Some(format!("{} {} {spread} (68 %)", figure(*mean), self.unit))
    }

    /// Returns the parts of the 95 % interval in ascending order; empty where none was computed.
    pub fn parts(&self) -> Vec<[f64; 2]> {
        if self.intervals95.is_empty() {
            self.interval95.into_iter().collect()
        } else {
            self.intervals95.clone()
        }
    }
}
