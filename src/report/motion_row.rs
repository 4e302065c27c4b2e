//! Rows of motion records in result documents.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::vocabulary::{Direction, MisfitBy, Role};

/// Prediction errors of one motion record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionRecordRow {
    /// `fit`: used in the fit; `held_out`: predicted only.
    pub role: Role,
    /// rms(predicted − measured)/rms(measured) of force or torque (1), by inverse dynamics.
    pub force_error: f64,
    /// rms(simulated − measured)/rms(measured) of force or torque (1), with the closed loop simulated; absent
    /// without simulation.
    #[serde(default)]
    pub simulated_force_error: Option<f64>,
    /// Force error due to noise alone (1), where the command repeats.
    #[serde(default)]
    pub noise_floor: Option<f64>,
    /// Force error by phase of the motion, relative to the root mean square of the whole record (1).
    #[serde(default)]
    pub by_phase: BTreeMap<String, f64>,
    /// Errors of the extra measurement channels, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub transmission: BTreeMap<String, TransmissionRow>,
    /// Number of samples read.
    pub samples: usize,
    /// Number of samples compared, after decimation.
    pub compared: usize,
    /// Period of the command (s), where it repeats.
    #[serde(default)]
    pub period_s: Option<f64>,
}

/// Error of the transmission error of an extra measurement channel.
///
/// The transmission error is the reading minus that of the rigid machine at the position of the encoder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TransmissionRow {
    /// Unit of the channel: m or rad.
    pub unit: String,
    /// rms(predicted − measured) of the transmission error without its offset (in `unit`).
    // Former key, still read.
    #[serde(alias = "left")]
    pub residual: f64,
    /// `residual` over rms(measured) of the transmission error (1).
    pub gap: f64,
    /// rms(predicted − measured)/rms(measured) of the tracking error, command minus reading, without its mean
    /// (1).
    #[serde(default)]
    pub tracking_gap: Option<f64>,
    /// Number of samples compared: those in motion, except after a reversal.
    pub compared: usize,
}

/// Held-out residual of a neural network, a reference for the chosen model.
///
/// The network is trained on the residual of the machine as described in the fitted records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearnableRow {
    /// Column of an extra measurement channel.
    pub column: String,
    /// Unit of the channel: m or rad.
    pub unit: String,
    /// Held-out rms residual of the transmission error with the machine as described (in `unit`).
    pub before: f64,
    /// Held-out rms residual of the machine as described with the neural network (in `unit`).
    pub with_network: f64,
    /// Held-out rms residual of the chosen model (in `unit`).
    pub after: f64,
}

/// An extra measurement channel of one record, before and after a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelRow {
    /// Name of the record.
    pub record: String,
    /// Column of the channel.
    pub column: String,
    /// Weight of the channel in gaps of force and channel together: force per unit of the column (N/m, N/rad,
    /// N·m/m or N·m/rad).
    #[serde(default)]
    pub weight: f64,
    /// Errors with the machine as described.
    pub before: TransmissionRow,
    /// Errors with the chosen model.
    pub after: TransmissionRow,
}

/// Filter and decimation of motion records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PreprocessingRow {
    /// Cut-off frequency of the Butterworth filter of the position (Hz), applied forward and backward.
    pub cutoff_hz: f64,
    /// Order of the Butterworth filter.
    pub order: usize,
    /// Number of samples dropped at the beginning of a record.
    pub dropped: usize,
    /// Decimation factor n: every n-th sample is kept.
    pub decimation: usize,
}

/// An interval of constant speed, as a point of the friction curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurveRow {
    /// Name of the record.
    pub record: String,
    /// Mean velocity (m/s).
    pub velocity_m_s: f64,
    /// Mean force (N) or torque (N·m), minus that of the mean acceleration.
    pub load: f64,
    /// Standard deviation of `load` (N or N·m), from the two halves of the interval.
    pub sd: f64,
    /// Force or torque of the machine at this velocity (N or N·m).
    #[serde(default)]
    pub predicted: Option<f64>,
}

/// Misfit of one cell: the samples of a record in one phase of the motion, range of speed, or range of
/// position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MisfitRow {
    /// Name of the record.
    pub record: String,
    /// Column of an extra measurement channel; absent for the force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Variable that defines the cell: `phase`, `speed_m_s` or `position_m`.
    pub by: MisfitBy,
    /// Name of the phase, for a cell by phase.
    #[serde(default)]
    pub phase: Option<String>,
    /// Lower and upper end of the cell (m/s or m), for a cell by speed or position.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
    /// Direction of motion: `forward`, `backward` or `both`.
    pub direction: Direction,
    /// Number of samples in the cell.
    pub samples: usize,
    /// Root mean square of the residual in the cell over that of the force, or transmission error, of the
    /// record (1).
    pub gap: f64,
    /// Share of the cell in the sum of squared residuals of the channel (1).
    pub share: f64,
    /// Mean of measured minus predicted load (N or N·m) or transmission error (m or rad).
    pub mean: f64,
}

/// Delay and force factor of the measuring chain of a record, relative to the chosen model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuringChainRow {
    /// Name of the record.
    pub record: String,
    /// `fit`: used in the fit; `held_out`: predicted only.
    pub role: Role,
    /// Force error of the machine as described (1).
    pub gap_before: f64,
    /// Force error of the chosen model (1).
    pub gap_after: f64,
    /// Force error of the chosen model with delay and factor of this record (1).
    pub gap_own_chain: f64,
    /// Delay of the recorded position after the recorded force (s).
    pub delay_s: f64,
    /// 95 % confidence interval of the delay (s).
    pub delay95_s: [f64; 2],
    /// Recorded force over force of the model (1).
    pub factor: f64,
}

/// Force or torque of a record over time, decimated for charts; one period where the command repeats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TraceRow {
    /// Name of the record.
    pub record: String,
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Measured force (N) or torque (N·m).
    pub measured: Vec<f64>,
    /// Measured minus predicted force or torque with the machine as described (N or N·m).
    pub before: Vec<f64>,
    /// Measured minus predicted force or torque with the chosen model (N or N·m).
    pub after: Vec<f64>,
    /// Phase of the motion at each sample, as an index into `phases`.
    pub phase: Vec<u8>,
}

/// Results of a diagnosis for motion records.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionRows {
    /// Unit of the load: `N` for force, `N*m` for torque.
    pub unit: String,
    /// Misfit of the machine as described, by cell.
    // Former key, still read.
    #[serde(alias = "cells")]
    pub misfit_map: Vec<MisfitRow>,
    /// Gaps and measuring chain of each record.
    pub records: Vec<MeasuringChainRow>,
    /// Explanations of held-out records that contradict the fitted ones, one sentence each.
    pub contradictions: Vec<String>,
    /// Friction curve: forces at the constant speeds of the fitted records.
    pub friction_curve: Vec<CurveRow>,
    /// Names of the phases of the motion.
    pub phases: Vec<String>,
    /// Force or torque over time, by record.
    pub traces: Vec<TraceRow>,
    /// Extra measurement channels before and after the diagnosis.
    /// With them the gaps of the document combine force and transmission errors, each in units of its noise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transmission: Vec<ChannelRow>,
    /// Held-out residuals of a neural network on the extra channels, where records are held out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub learnable: Vec<LearnableRow>,
}
