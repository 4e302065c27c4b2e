//! Result document of a model and a network trained on its residual.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// Prediction error of a position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// Root mean square of predicted less measured tracking error (m).
    pub rmse_m: f64,
    /// Largest absolute difference (m).
    pub largest_m: f64,
    /// Largest absolute difference over the largest measured tracking error.
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
    /// The model with the diagnosed effects as identified, where a result is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<Score>,
}

/// The network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NeuralResidualRow {
    /// Root mean square of its residual on the examples (m).
    #[serde(alias = "left_m")]
    pub residual_m: f64,
    /// Number of examples.
    pub examples: usize,
    /// Number of evaluations of all trainings.
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
    /// The same of the model with the diagnosed effects as identified.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics_off_m: Option<f64>,
}

/// `hybrid.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// The point whose travel is predicted.
    pub point: String,
    /// Records by name.
    pub records: BTreeMap<String, HybridRow>,
    /// The network.
    pub network: NeuralResidualRow,
    /// Median over held-out records of hybrid over analytical RMSE: the share of the error that a network cannot learn.
    pub median_ratio: Option<f64>,
    /// Median over held-out records of physics over hybrid RMSE: at most 1 where the identified physics predicts as well as the network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_physics_to_hybrid: Option<f64>,
    /// Circles of this axis and the second axis, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub contours: BTreeMap<String, ContourRow>,
}
