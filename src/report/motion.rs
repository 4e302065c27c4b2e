//! Result document of a simulated motion.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// A change of state of a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EventRow {
    /// Time (s).
    pub time_s: f64,
    /// `sticks`, `slides`, `reverses`, `closes` or `opens`.
    pub kind: String,
    /// Joint.
    pub joint: String,
    /// 1 forward or on the upper side, −1 backward or on the lower side, 0 neither.
    pub direction: i8,
}

/// Energy balance (J).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EnergyBalance {
    /// Work of the drive.
    pub supplied_j: f64,
    /// Stored energy at the end less that at the start.
    pub stored_j: f64,
    /// Dissipated in dampers and friction.
    pub lost_j: f64,
    /// |supplied − stored − lost| over the energy turned over.
    pub imbalance: f64,
}

/// Comparison of a simulated record with the measured one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordRow {
    /// Name of the record.
    pub name: String,
    /// rms(simulated − measured)/rms(measured) of force or torque.
    pub force_gap: f64,
    /// The same of the tracking error.
    pub tracking_gap: f64,
}

/// Divergence of an unstable loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Instability {
    /// Time (s) at which the tracking error exceeds its bound.
    pub time_s: f64,
    /// |command − position| at this time (m or rad).
    pub error: f64,
}

/// `motion.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// `s-curve`, `sine`, a file, or `record NAME`.
    pub reference: String,
    /// Nut position at the start (m).
    pub nut_m: Option<f64>,
    /// Values of the parameters.
    pub parameters: BTreeMap<String, f64>,
    /// Columns of the table, by name, all of one length: `time_s`, `command_m`, `position_m`, `force_n` or `torque_nm`, `velocity_m_s`, and one
    /// for every point that moves, `NAME_m` or `NAME_rad`. Where the encoder reads an angle, `_rad` replaces `_m`.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Energy balance.
    pub energy: EnergyBalance,
    /// Events in chronological order.
    pub events: Vec<EventRow>,
    /// Comparison with the measured record, where one was simulated to its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordRow>,
    /// Divergence of the loop, if it is unstable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unstable: Option<Instability>,
}
