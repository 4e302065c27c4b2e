//! `diagnosis.json` as it is read: only verdict, gap and effects must be there; all else may be absent.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;

/// The gap in a frequency band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BandGap {
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz); absent where it is not limited.
    #[serde(default)]
    pub to_hz: Option<f64>,
    /// Gap.
    pub gap: Option<f64>,
}

/// The gap between measurement and model, and where it lies.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapRow {
    /// Of what was fitted.
    #[serde(default)]
    pub fit: Option<f64>,
    /// Of what was held out.
    #[serde(default)]
    pub held_out: Option<f64>,
    /// By position.
    #[serde(default)]
    pub by_position: BTreeMap<String, Option<f64>>,
    /// By band.
    #[serde(default)]
    pub by_band: Vec<BandGap>,
    /// By mode.
    #[serde(default)]
    pub by_mode: Vec<serde_json::Value>,
    /// By phase of a motion.
    #[serde(default)]
    pub by_phase: BTreeMap<String, Option<f64>>,
}

/// What a free change at one interface leaves of the gap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WhereRow {
    /// Interface.
    pub interface: String,
    /// Gap left on what was held out.
    #[serde(default)]
    pub gap_held_out: Option<f64>,
    /// What the change looks like over frequency.
    #[serde(default)]
    pub shape: Option<String>,
}

/// An effect that was considered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectRow {
    /// Id.
    pub id: String,
    /// `tried`, `failed` or `not-applicable`.
    pub status: String,
    /// Gap on what was held out, without the effect.
    #[serde(default)]
    pub gap_held_out_before: Option<f64>,
    /// The same with it.
    #[serde(default)]
    pub gap_held_out_after: Option<f64>,
    /// Share of the gap above the noise that it closes.
    #[serde(default)]
    pub closed: Option<f64>,
    /// 95 % interval of that share; an end is absent where it is not limited.
    #[serde(default)]
    pub closed95: Option<[Option<f64>; 2]>,
    /// Chance of as much without the effect.
    #[serde(default)]
    pub p_value: Option<f64>,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Belongs to the verdict.
    #[serde(default)]
    pub selected: bool,
}

/// The verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VerdictRow {
    /// `none`, `effect`, `ambiguous`, `unknown`, `wrong-parameter`, `measurement` or `insufficient`.
    pub kind: String,
    /// Effects that explain the gap, or that cannot be told apart.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Why.
    #[serde(default)]
    pub reason: String,
    /// What to measure next.
    #[serde(default)]
    pub next_measurement: Option<String>,
}

/// The gap of one position, channel and band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualCell {
    /// Position.
    #[serde(default)]
    pub position: Option<String>,
    /// Response and excitation.
    #[serde(default)]
    pub channel: Option<String>,
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz); absent where it is not limited.
    #[serde(default)]
    pub to_hz: Option<f64>,
    /// Gap.
    pub gap: Option<f64>,
}

/// The change of dynamic stiffness that an interface would need.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DeltaZ {
    /// Interface.
    pub interface: String,
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Real parts.
    pub real: Vec<Option<f64>>,
    /// Imaginary parts.
    pub imag: Vec<Option<f64>>,
}

/// `diagnosis.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Diagnosis {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// `frf`, `modes` or `motion`.
    #[serde(default)]
    pub domain: String,
    /// The gap that the noise alone leaves.
    #[serde(default)]
    pub noise_floor: Option<f64>,
    /// The gap.
    #[serde(default)]
    pub gap: GapRow,
    /// Where it comes from, best first.
    #[serde(default, rename = "where")]
    pub places: Vec<WhereRow>,
    /// Effects considered, best first.
    #[serde(default)]
    pub effects: Vec<EffectRow>,
    /// The verdict.
    pub verdict: VerdictRow,
    /// Gaps by position, channel and band.
    #[serde(default)]
    pub residual_map: Vec<ResidualCell>,
    /// Changes of dynamic stiffness by interface.
    #[serde(default)]
    pub delta_z: Vec<DeltaZ>,
}
