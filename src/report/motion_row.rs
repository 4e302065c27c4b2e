//! Rows of motion records in result documents.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A record of an identification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionRecordRow {
    /// `fit` or `held_out`.
    pub role: String,
    /// rms(predicted − measured)/rms(measured) of force or torque, by inverse dynamics.
    pub force_error: f64,
    /// The same of the closed loop simulated with the record's command; absent where it was not simulated.
    #[serde(default)]
    pub simulated_force_error: Option<f64>,
    /// Gap due to noise alone, where the command repeats.
    #[serde(default)]
    pub noise_floor: Option<f64>,
    /// Force error by phase of the motion, each over the rms of the whole record.
    #[serde(default)]
    pub by_phase: BTreeMap<String, f64>,
    /// Additional measurement channels, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub transmission: BTreeMap<String, TransmissionRow>,
    /// Samples read.
    pub samples: usize,
    /// Samples compared, after thinning.
    pub compared: usize,
    /// Period of the command (s), where it repeats.
    #[serde(default)]
    pub period_s: Option<f64>,
}

/// Residual of the transmission error of an additional measurement channel.
///
/// The transmission error is the reading less that of the rigid machine at the encoder's position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TransmissionRow {
    /// m or rad.
    pub unit: String,
    /// rms(predicted − measured) in that unit, without an offset.
    #[serde(alias = "left")]
    pub residual: f64,
    /// The same over rms(measured).
    pub gap: f64,
    /// rms(predicted − measured)/rms(measured) of the tracking error there, command less reading, without its mean.
    #[serde(default)]
    pub tracking_gap: Option<f64>,
    /// Samples compared: those in motion, except after a reversal.
    pub compared: usize,
}

/// Residual of a network on held-out records, trained on the machine's residual of the fitted ones; a reference for the chosen model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearnableRow {
    /// Column of an additional measurement channel.
    pub column: String,
    /// m or rad.
    pub unit: String,
    /// Root mean square of the held-out residual of the transmission error, with the machine as described.
    pub before: f64,
    /// The same with the network.
    pub with_network: f64,
    /// The same of the chosen model.
    pub after: f64,
}

/// An additional measurement channel in a record of a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelRow {
    /// Record.
    pub record: String,
    /// Column.
    pub column: String,
    /// Force (N or N·m) of the same weight as one unit of the column, in gaps of force and column together.
    #[serde(default)]
    pub weight: f64,
    /// With the machine as described.
    pub before: TransmissionRow,
    /// With the chosen model.
    pub after: TransmissionRow,
}

/// Preprocessing of the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PreprocessingRow {
    /// Cut-off frequency of the position's Butterworth filter (Hz), applied forward and backward.
    pub cutoff_hz: f64,
    /// Order of the filter.
    pub order: usize,
    /// Samples dropped at the beginning.
    pub dropped: usize,
    /// Decimation: every n-th sample is kept.
    pub decimation: usize,
}

/// An interval at constant speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurveRow {
    /// Record.
    pub record: String,
    /// Mean velocity (m/s).
    pub velocity_m_s: f64,
    /// Mean force (N) or torque (N·m).
    pub load: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// Prediction of the machine at this velocity.
    #[serde(default)]
    pub predicted: Option<f64>,
}

/// Misfit of a part of a record's samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MisfitRow {
    /// Record.
    pub record: String,
    /// Column of an additional measurement channel; absent for the force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// `phase`, `speed_m_s` or `position_m`.
    pub by: String,
    /// Phase, where the parts are phases.
    #[serde(default)]
    pub phase: Option<String>,
    /// Lower and upper end, where the parts are ranges of speed or position.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
    /// `forward`, `backward` or `both`.
    pub direction: String,
    /// Samples.
    pub samples: usize,
    /// Root mean square of the misfit over that of the record's force (transmission error for an additional channel).
    pub gap: f64,
    /// Share of the squared misfit of the record's channel.
    pub share: f64,
    /// Mean of measured less predicted (N or N·m; m or rad for an additional channel).
    pub mean: f64,
}

/// Delay and force factor of a record's measuring chain, relative to the chosen model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuringChainRow {
    /// Record.
    pub record: String,
    /// `fit` or `held_out`.
    pub role: String,
    /// Gap with the machine as described.
    pub gap_before: f64,
    /// Gap with the chosen model.
    pub gap_after: f64,
    /// Gap with the chosen model and the record's own delay and factor.
    pub gap_own_chain: f64,
    /// Delay of the position after the force (s).
    pub delay_s: f64,
    /// 95 % interval of the delay.
    pub delay95_s: [f64; 2],
    /// Factor from the model's force to the record's.
    pub factor: f64,
}

/// A record's force over time, thinned for charts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TraceRow {
    /// Record.
    pub record: String,
    /// Time (s).
    pub time_s: Vec<f64>,
    /// Measured force or torque.
    pub measured: Vec<f64>,
    /// Measured less predicted, the machine as described.
    pub before: Vec<f64>,
    /// The same with the chosen model.
    pub after: Vec<f64>,
    /// Phase of each sample, as an index into `phases`.
    pub phase: Vec<u8>,
}

/// Part of a diagnosis that concerns motion records only.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionRows {
    /// Unit of force or torque.
    pub unit: String,
    /// Misfit of the machine as described, by part of the samples.
    #[serde(alias = "cells")]
    pub misfit_map: Vec<MisfitRow>,
    /// Records and their measuring chains.
    pub records: Vec<MeasuringChainRow>,
    /// Descriptions of held-out records that contradict the fitted ones.
    pub contradictions: Vec<String>,
    /// The friction curve from constant speeds.
    pub friction_curve: Vec<CurveRow>,
    /// Names of phases.
    pub phases: Vec<String>,
    /// Force over time.
    pub traces: Vec<TraceRow>,
    /// Additional measurement channels. With them the document's gaps are of force and transmission errors together, each in units of its noise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transmission: Vec<ChannelRow>,
    /// Residuals of a network on these channels, where records are held out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub learnable: Vec<LearnableRow>,
}
