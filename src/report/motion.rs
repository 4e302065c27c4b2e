//! Result document of a simulated motion.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// A change of state of a joint with friction or backlash.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EventRow {
    /// Time from the start of the motion (s).
    pub time_s: f64,
    /// `sticks`, `slides` or `reverses` for friction; `closes` or `opens` for backlash.
    pub kind: String,
    /// Name of the joint.
    pub joint: String,
    /// 1 forward or at the upper side of the backlash, −1 backward or at the lower side, 0 neither.
    pub direction: i8,
}

/// Energy balance of the motion (J).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EnergyBalance {
    /// Work of the drive (J).
    pub supplied_j: f64,
    /// Energy stored at the end minus that at the start (J).
    pub stored_j: f64,
    /// Energy dissipated in dampers, friction and windings (J).
    pub lost_j: f64,
    /// |supplied − stored − lost| over the sum of initially stored energy and |work| of the drive in each step (1).
    pub imbalance: f64,
}

/// Prediction errors of a simulated record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordRow {
    /// Name of the record.
    pub name: String,
    /// rms(simulated − measured)/rms(measured) of force or torque (1).
    pub force_gap: f64,
    /// rms(simulated − measured)/rms(measured) of the tracking error (1).
    pub tracking_gap: f64,
}

/// Divergence of an unstable control loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Instability {
    /// Time at which the tracking error exceeds its limit (s).
    pub time_s: f64,
    /// |command − position| at this time (m or rad).
    pub error: f64,
}

/// Simulated motion (`motion.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Command: `s-curve`, `sine`, the path of a file, or `record NAME`.
    pub reference: String,
    /// Position of the nut at the start (m).
    pub nut_m: Option<f64>,
    /// Values of the parameters by id, each in its unit.
    pub parameters: BTreeMap<String, f64>,
    /// Signals by name, all of one length: `time_s`, `command_m`, `position_m`, `force_n` or `torque_nm`,
    /// `velocity_m_s`. In addition one for every point that moves, `NAME_m` or `NAME_rad`. Where the encoder
    /// reads an angle, `_rad` replaces `_m`.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Energy balance of the motion.
    pub energy: EnergyBalance,
    /// Changes of state of the joints, in chronological order.
    pub events: Vec<EventRow>,
    /// Prediction errors of the record, where a record was simulated to its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordRow>,
    /// Divergence of the control loop; absent where the loop is stable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unstable: Option<Instability>,
}
