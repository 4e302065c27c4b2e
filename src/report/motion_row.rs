//! Rows that documents hold of motion records.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One record of an identification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionRecordRow {
    /// `fit` or `held_out`.
    pub role: String,
    /// rms(predicted − measured)/rms(measured) of force or torque, by inverse dynamics.
    pub force_error: f64,
    /// The same of the closed loop simulated with the record's command, where that was done.
    #[serde(default)]
    pub simulated_force_error: Option<f64>,
    /// The gap that the noise alone leaves, where the command repeats.
    #[serde(default)]
    pub noise_floor: Option<f64>,
    /// Force error by phase of the motion, each over the rms of the whole record.
    #[serde(default)]
    pub by_phase: BTreeMap<String, f64>,
    /// Further points, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub transmission: BTreeMap<String, TransmissionRow>,
    /// Samples read.
    pub samples: usize,
    /// Samples compared, after thinning.
    pub compared: usize,
    /// Time after which the command repeats (s).
    #[serde(default)]
    pub period_s: Option<f64>,
}

/// What is left of the transmission error at a further point: its reading less that of the rigid machine at the encoder's position.
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
    /// Samples compared: those that move, but for what follows a turn.
    pub compared: usize,
}

/// What a network, trained on what the machine leaves of the fitted records, leaves of those held out: physics is set against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearnableRow {
    /// Column of a further point.
    pub column: String,
    /// m or rad.
    pub unit: String,
    /// Root mean square of what the machine as described leaves of the transmission error, held out.
    pub before: f64,
    /// The same with the network.
    pub with_network: f64,
    /// The same of the chosen model.
    pub after: f64,
}

/// A further point in a record of a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelRow {
    /// Record.
    pub record: String,
    /// Column.
    pub column: String,
    /// Force (N or N·m) that its unit weighs as much as in gaps of force and column together.
    #[serde(default)]
    pub weight: f64,
    /// With the machine as described.
    pub before: TransmissionRow,
    /// With the chosen model.
    pub after: TransmissionRow,
}

/// How records were filtered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PreprocessingRow {
    /// Cut-off of the position's filter (Hz), Butterworth, forward and backward.
    pub cutoff_hz: f64,
    /// Its order.
    pub order: usize,
    /// Samples dropped at the beginning.
    pub dropped: usize,
    /// Every so many samples one was kept.
    pub decimation: usize,
}

/// One stretch at constant speed.
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
    /// What the machine predicts there.
    #[serde(default)]
    pub predicted: Option<f64>,
}

/// A part of a record's samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MisfitRow {
    /// Record.
    pub record: String,
    /// Column of a further point; absent for the force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// `phase`, `speed_m_s` or `position_m`.
    pub by: String,
    /// Phase, where it is made by phases.
    #[serde(default)]
    pub phase: Option<String>,
    /// From and to, where it is made by speed or position.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
    /// `forward`, `backward` or `both`.
    pub direction: String,
    /// Samples.
    pub samples: usize,
    /// Root mean square of the misfit there over that of the record's force (transmission error of a further point).
    pub gap: f64,
    /// Share of the squared misfit of the record's channel.
    pub share: f64,
    /// Mean of measured less predicted (N or N·m; m or rad of a further point).
    pub mean: f64,
}

/// What a record says of its measuring chain beside the chosen model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChainRow {
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
    /// By how much its position comes after its force (s).
    pub delay_s: f64,
    /// 95 % interval.
    pub delay95_s: [f64; 2],
    /// What its force is of the model's.
    pub factor: f64,
}

/// A record's force over time, thinned to be drawn.
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
    /// Phase of each sample, by its place in `phases`.
    pub phase: Vec<u8>,
}

/// What a diagnosis says of motion records beside the rest.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionRows {
    /// Unit of force or torque.
    pub unit: String,
    /// Cells of the misfit of the machine as described.
    #[serde(alias = "cells")]
    pub misfit_map: Vec<MisfitRow>,
    /// Records and their measuring chains.
    pub records: Vec<ChainRow>,
    /// Held-out records that contradict the fitted ones, in words.
    pub contradictions: Vec<String>,
    /// The friction curve from constant speeds.
    pub friction_curve: Vec<CurveRow>,
    /// Names of phases.
    pub phases: Vec<String>,
    /// Force over time.
    pub traces: Vec<TraceRow>,
    /// Further points. The gaps of the document are then those of force and transmission errors together, each in units of its own noise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transmission: Vec<ChannelRow>,
    /// What of them can be learnt at all, where records were held out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub learnable: Vec<LearnableRow>,
}
