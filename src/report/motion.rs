//! Result document of a simulated motion.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// Something that changed its form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EventRow {
    /// When (s).
    pub time_s: f64,
    /// `sticks`, `slides`, `reverses`, `closes` or `opens`.
    pub kind: String,
    /// Joint.
    pub joint: String,
    /// 1 forward or on the upper side, −1 backward or on the lower side, 0 neither.
    pub direction: i8,
}

/// Where the energy went (J).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EnergyBalance {
    /// Work of the drive.
    pub supplied_j: f64,
    /// Stored at the end less stored at the start.
    pub stored_j: f64,
    /// Lost in dampers and friction.
    pub lost_j: f64,
    /// What is missing between them, over what was turned over.
    pub imbalance: f64,
}

/// A simulated record beside the measured one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordRow {
    /// Name of the record.
    pub name: String,
    /// rms(simulated − measured)/rms(measured) of force or torque.
    pub force_gap: f64,
    /// The same of the tracking error.
    pub tracking_gap: f64,
}

/// When a loop left its bounds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Instability {
    /// When (s).
    pub time_s: f64,
    /// |command − position| then (m or rad).
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
    /// Where the nut stands at the start (m).
    pub nut_m: Option<f64>,
    /// Values of the parameters.
    pub parameters: BTreeMap<String, f64>,
    /// Columns of the table, by name, all of one length: `time_s`, `command_m`, `position_m`, `force_n` or `torque_nm`, `velocity_m_s`, and one
    /// for every point that moves, `NAME_m` or `NAME_rad`. Where the encoder reads an angle, `_rad` stands for `_m`.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Where the energy went.
    pub energy: EnergyBalance,
    /// Events in the order of time.
    pub events: Vec<EventRow>,
    /// The measured record, where one was simulated to its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordRow>,
    /// When the loop left its bounds, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unstable: Option<Instability>,
}
