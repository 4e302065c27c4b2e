//! Result document of a model beside a network on what it leaves.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// How well a position was foretold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// Root mean square of foretold less measured tracking error (m).
    pub rmse_m: f64,
    /// Largest of it (m).
    pub largest_m: f64,
    /// Its largest over the largest measured tracking error.
    pub relative: f64,
}

/// One record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridRow {
    /// `fit` or `held_out`.
    pub role: String,
    /// The model.
    pub analytical: Score,
    /// The model and the network.
    pub hybrid: Score,
    /// The model with what was named and identified, where a result was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<Score>,
}

/// The network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NetworkRow {
    /// What it leaves of its examples (m).
    #[serde(alias = "left_m")]
    pub residual_m: f64,
    /// Examples.
    pub examples: usize,
    /// Evaluations of all trainings.
    pub evaluations: u64,
}

/// Contour error of one circle of two axes (m): distance from the commanded circle, largest over the whole of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContourRow {
    /// `fit` or `held_out`.
    pub role: String,
    /// Largest |contour error| measured.
    pub measured_m: f64,
    /// Largest difference between the model's contour error and the measured one.
    pub analytical_off_m: f64,
    /// The same with the network.
    pub hybrid_off_m: f64,
    /// The same of the model with what was named and identified.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics_off_m: Option<f64>,
}

/// `hybrid.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// The point whose travel is foretold.
    pub point: String,
    /// Records by name.
    pub records: BTreeMap<String, HybridRow>,
    /// The network.
    pub network: NetworkRow,
    /// Median over held-out records of hybrid over analytical RMSE: what a network can learn of the gap.
    pub median_ratio: Option<f64>,
    /// Median over held-out records of physics over hybrid RMSE: at most 1 where physics leaves the network nothing to win.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_physics_to_hybrid: Option<f64>,
    /// Circles of this axis and the one beside it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub contours: BTreeMap<String, ContourRow>,
}
