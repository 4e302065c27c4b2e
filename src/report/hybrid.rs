//! Result document of a model and a neural network trained on its residual. The laboratory writes it, the
//! page draws it.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// Error of the predicted travel of one record: predicted minus measured travel of the point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// Root mean square of predicted minus measured travel (m).
    pub rmse_m: f64,
    /// Largest |predicted − measured travel| (m).
    pub largest_m: f64,
    /// `largest_m` over the largest measured tracking error |command − travel| (1).
    pub relative: f64,
}

/// Errors of one record, each with its root mean square (RMSE) and its maximum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridRow {
    /// `fit`: used in the fit; `held_out`: predicted only.
    pub role: String,
    /// Error of the physical model alone.
    pub analytical: Score,
    /// Error of the physical model with the neural network.
    pub hybrid: Score,
    /// Error of the model with the diagnosed effects as identified, where a result is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<Score>,
}

/// Training of the neural network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NeuralResidualRow {
    /// Root mean square of the residual of model and neural network over the training samples (m).
    // Former key, still read.
    #[serde(alias = "left_m")]
    pub residual_m: f64,
    /// Number of training samples.
    pub examples: usize,
    /// Number of evaluations of the objective in all trainings.
    pub evaluations: u64,
}

/// Contour error of one circle of two axes: distance from the commanded circle (m). Each figure is the
/// maximum over the circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContourRow {
    /// `fit`: used in the fit of both axes; `held_out`: predicted only.
    pub role: String,
    /// Largest |contour error| measured (m).
    pub measured_m: f64,
    /// Largest contour error difference |predicted − measured| of the physical model (m).
    pub analytical_off_m: f64,
    /// Largest contour error difference of the physical model with the neural network (m).
    pub hybrid_off_m: f64,
    /// Largest contour error difference of the model with the diagnosed effects as identified (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics_off_m: Option<f64>,
}

/// The machine with the diagnosed effects as identified, and where it comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PhysicsRow {
    /// Path of the identification.json.
    pub result: String,
    /// Title of its machine.
    pub machine: String,
    /// Path of the machine's configuration.
    pub config: String,
    /// Measurement set whose records it predicts.
    pub measurements: String,
}

/// Prediction of travel by a model, with and without a neural network (`hybrid.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HybridDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Name of the point whose travel is predicted.
    pub point: String,
    /// Errors of the first axis by record.
    pub records: BTreeMap<String, HybridRow>,
    /// Neural network of the first axis; the second axis has its own.
    pub network: NeuralResidualRow,
    /// Machine with the diagnosed effects, where a result is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physics: Option<PhysicsRow>,
    /// The same of the second axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_physics: Option<PhysicsRow>,
    /// Median over held-out records of RMSE(with network)/RMSE(model) (1); absent where none is held out.
    pub median_ratio: Option<f64>,
    /// Median over held-out records of RMSE(with diagnosed effects)/RMSE(with network) (1).
    /// At most 1 where the identified effects predict as well as the network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_physics_to_hybrid: Option<f64>,
    /// Contour errors by circle: records of the same name in the sets of both axes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub contours: BTreeMap<String, ContourRow>,
}
