//! The document of a diagnosis.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::certainty::ToleranceRow;
use super::document::{Input, MachineText, Stamp};
use super::motion_row::MotionRows;
pub use super::null_row::NullRow;
use super::terminal::figure;
use super::vocabulary::{DataKind, EffectStatus, VerdictKind};

/// `diagnosis.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiagnosisDocument {
    /// Provenance.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Description of the machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineText>,
    /// Manifest of the measurement set; absent for a set that was not read from files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manifest: Option<Input>,
    /// Kind of data: `frf`, `modes` or `motion`.
    pub domain: DataKind,
    /// Path of the machine configuration.
    #[serde(default)]
    pub config: String,
    /// Path of the measurement set.
    #[serde(default)]
    pub measurements: String,
    /// Names of the fitted positions or records.
    #[serde(default)]
    pub fit_positions: Vec<String>,
    /// Names of the held-out positions or records.
    #[serde(default)]
    pub held_out_positions: Vec<String>,
    /// Gap (1) that noise alone leaves at held-out data; null where the noise is unknown.
    pub noise_floor: Option<f64>,
    /// Gaps of the machine as described.
    pub gap: GapRow,
    /// Misfit of the machine as described over the median of null simulations, at least 1 (1): χ² per
    /// compared number.
    #[serde(default)]
    pub misfit_over_null: f64,
    /// Null simulations, to which p-values refer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub null: Option<NullRow>,
    /// Location of the verdict, then generic impedances at interfaces, best first.
    #[serde(rename = "where")]
    pub places: Vec<WhereRow>,
    /// Residuals of the machine as described by position, channel and band.
    #[serde(default)]
    pub residual_map: Vec<ResidualCell>,
    /// Ratio of measured over predicted FRFs by channel.
    #[serde(default)]
    pub ratio: Vec<Ratio>,
    /// Missing dynamic stiffness at the best interfaces.
    #[serde(default)]
    pub delta_z: Vec<DeltaZ>,
    /// All candidates, best first: by χ² plus the cost of their flexibility.
    pub effects: Vec<EffectRow>,
    /// Values of the parameters of the machine as described.
    #[serde(default)]
    pub described: BTreeMap<String, f64>,
    /// Tolerances, fitted together with the chosen model, by name; empty where they are held.
    #[serde(default)]
    pub tolerances: BTreeMap<String, ToleranceRow>,
    /// Results on motion records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionRows>,
    /// Chosen model and its held-out gap.
    #[serde(default)]
    pub chosen: Chosen,
    /// Verdict.
    pub verdict: VerdictRow,
    /// Rules of the verdict in their order, and what came of each; empty for motion records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<RuleRow>,
}

/// Returns the ids of a combination of effects as documents state it: joined with `+`.
pub fn effect_ids(combination: &str) -> impl Iterator<Item = &str> {
    combination.split('+').map(str::trim)
}

/// Id of the chosen model where it is the machine as described.
const NOMINAL: &str = "nominal";

/// Returns the ids of the effects of a chosen model, given by its id; none for the machine as described.
pub fn chosen_effects(id: &str) -> impl Iterator<Item = &str> {
    effect_ids(id).filter(|id| *id != NOMINAL)
}

/// Returns a combination with a phrase between its effects.
pub(super) fn combination_text(combination: &str, between: &str) -> String {
    effect_ids(combination).collect::<Vec<_>>().join(between)
}

impl DiagnosisDocument {
    /// Returns the rows of the effects that the verdict names, in its order, those of a combination one after
    /// another.
    pub(super) fn named_effects(&self) -> impl Iterator<Item = &EffectRow> {
        let ids = self.verdict.effects.iter().flat_map(|combination| effect_ids(combination));
        ids.filter_map(|id| self.effects.iter().find(|row| row.id == id))
    }
}

/// Gaps (1).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapRow {
    /// Gap at fitted data.
    pub fit: Option<f64>,
    /// Gap at held-out data.
    pub held_out: Option<f64>,
    /// Gap by position or record.
    #[serde(default)]
    pub by_position: BTreeMap<String, f64>,
    /// Gap by frequency band, over all data.
    #[serde(default)]
    pub by_band: Vec<BandGap>,
    /// Gap of each mode over all data, from order 1; null for an order that is not observed.
    #[serde(default)]
    pub by_mode: Vec<Option<f64>>,
    /// Gap by phase of the motion.
    #[serde(default)]
    pub by_phase: BTreeMap<String, f64>,
}

/// Gap in a frequency band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BandGap {
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz).
    pub to_hz: f64,
    /// Gap (1).
    pub gap: f64,
}

/// Residual of one position, channel and band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualCell {
    /// Name of the position or record.
    pub position: String,
    /// Channel, as response/excitation.
    pub channel: String,
    /// Lowest frequency (Hz).
    pub from_hz: f64,
    /// Highest frequency (Hz).
    pub to_hz: f64,
    /// Gap (1).
    pub gap: f64,
    /// Mean of ln(measured/predicted) magnitude (1).
    #[serde(default)]
    pub log_ratio: f64,
    /// Mean phase of measured over predicted (rad).
    #[serde(default)]
    pub phase_rad: f64,
}

/// Pattern of measured over predicted in a channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ratio {
    /// Channel, as response/excitation.
    pub channel: String,
    /// Mean ratio of magnitudes (1).
    pub factor: f64,
    /// Slope of ln(ratio) over ln(frequency) (1).
    pub power: f64,
    /// Delay (s) that fits the phase best.
    pub delay_s: f64,
    /// Pattern in words.
    pub looks_like: String,
}

/// Missing dynamic stiffness of an interface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DeltaZ {
    /// Interface and shape.
    pub interface: String,
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Real part (N/m or N·m/rad).
    pub real: Vec<f64>,
    /// Imaginary part (N/m or N·m/rad).
    pub imag: Vec<f64>,
}

/// Shape of the [`WhereRow`] of a named effect.
pub const NAMED: &str = "other";

/// A location: that of the named effect, or a generic impedance at an interface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WhereRow {
    /// Name of the point or joint.
    pub interface: String,
    /// Quantity on which a free function of force or transmission error depends; for motion records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Shape of the generic impedance; `other` for the named effect.
    pub shape: String,
    /// Reduction of χ² (motion: of the squared error of the fitted records) over its value without it (1).
    #[serde(default, alias = "takes")]
    pub misfit_reduction: f64,
    /// Held-out gap with it (1).
    pub gap_held_out: Option<f64>,
}

impl WhereRow {
    /// Returns the location in words.
    pub fn place_text(&self) -> String {
        self.over
            .as_ref()
            .map_or_else(|| self.interface.clone(), |over| format!("{}, over {over}", self.interface))
    }

    /// Returns the shape in words.
    pub fn shape_text(&self) -> &str {
        if self.shape == NAMED && self.over.is_none() { "named effect" } else { &self.shape }
    }
}

/// A candidate effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectRow {
    /// Id of the effect.
    pub id: String,
    /// `tried`, `failed` or `not-applicable`.
    pub status: EffectStatus,
    /// Reason why it failed, does not apply or is no explanation.
    #[serde(default)]
    pub why: Option<String>,
    /// Held-out gap without it (1).
    pub gap_held_out_before: Option<f64>,
    /// Held-out gap with it (1).
    pub gap_held_out_after: Option<f64>,
    /// Share of the squared held-out gap above the noise floor that it closes (1); negative where the gap
    /// grows.
    pub closed: Option<f64>,
    /// Interval of `closed` in 95 of 100 repetitions of the test, for the effect that the verdict names
    /// first.
    #[serde(default)]
    pub closed95: Option<[f64; 2]>,
    /// Share of null simulations with a statistic as large (1).
    pub p_value: Option<f64>,
    /// Gap (1) by which it would have to change the fitted FRFs to be significant in nine of ten tests, in a form typical
    /// of it; null where parameters of the machine take it up, for modes and motion records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_from: Option<f64>,
    /// Reduction of χ² over its scale in null simulations and over the excess that it leaves (1).
    #[serde(default)]
    pub statistic: f64,
    /// Reduction of χ² (motion: of the squared prediction error at left-out parts) over its value without it (1).
    #[serde(default, alias = "takes")]
    pub misfit_reduction: f64,
    /// Estimates of its parameters, fitted together with the tolerances.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// 95 % intervals of these parameters of the effects that a verdict on FRFs names first, by profile
    /// likelihood.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters95: BTreeMap<String, [f64; 2]>,
    /// Units of these parameters.
    #[serde(default)]
    pub parameter_units: BTreeMap<String, String>,
    /// Ids of parameters at an end of their plausible range.
    #[serde(default)]
    pub parameters_at_bound: Vec<String>,
    /// Whether its best fit was found by a single search: a deeper minimum may exist.
    #[serde(default)]
    pub open: bool,
    /// Whether the verdict names it.
    pub selected: bool,
    /// Description of the effect.
    #[serde(default, alias = "says")]
    pub description: Option<String>,
}

/// Chosen model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Chosen {
    /// Id of the effect or combination; `nominal` for the machine as described.
    pub id: String,
    /// Values of all its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Held-out gap (1).
    pub gap_held_out: Option<f64>,
    /// Misfit with it over the median of null simulations (1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misfit_over_null: Option<f64>,
    /// Held-out gaps of FRFs without and with it, with tolerances fitted as nuisance parameters (1).
    #[serde(default, alias = "gap_held_out_beside_ordinary", skip_serializing_if = "Option::is_none")]
    pub gap_held_out_with_nuisances: Option<[Option<f64>; 2]>,
    /// Share of the squared held-out gap above the noise floor that it closes (1).
    pub closed: Option<f64>,
    /// Interval of `closed` in 95 of 100 repetitions of the test, simulated with the chosen model.
    #[serde(default)]
    pub closed95: Option<[f64; 2]>,
    /// Largest share of it that a generic impedance at one interface closes (1); of motion records a free
    /// function of one variable.
    pub ceiling: Option<f64>,
    /// Headline metrics before and after.
    #[serde(default, alias = "plain")]
    pub headline_metrics: Vec<HeadlineMetrics>,
}

impl Chosen {
    /// Returns the ids of its effects; none for the machine as described.
    pub fn effects(&self) -> impl Iterator<Item = &str> {
        chosen_effects(&self.id)
    }

    /// Whether it is the model as described, without an effect.
    pub fn is_nominal(&self) -> bool {
        self.id.is_empty() || self.id == NOMINAL
    }
}

/// A metric that an engineer quotes, before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeadlineMetrics {
    /// Name of the metric.
    pub figure: String,
    /// Value of the machine as described (1).
    pub before: f64,
    /// Value of the chosen model (1).
    pub after: f64,
}

/// Verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VerdictRow {
    /// Kind: `none`, `effect`, `ambiguous`, `unknown`, `wrong-parameter`, `measurement` or `insufficient`.
    pub kind: VerdictKind,
    /// Ids of effects or combinations.
    pub effects: Vec<String>,
    /// Ids of faults of the measuring chain, `id@record` where one record is concerned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<String>,
    /// Name of the rule that gave it last; absent for motion records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<String>,
    /// Whether held-out data speak for the named explanation for certain, false also where that leaves none;
    /// null where nothing is named or held out.
    #[serde(default)]
    pub confirmed: Option<bool>,
    /// Reason in words.
    pub reason: String,
    /// Proposed next measurement.
    #[serde(default)]
    pub next_measurement: Option<String>,
    /// Location of the named effect, or of the best generic impedance.
    #[serde(rename = "where")]
    #[serde(default)]
    pub place: Option<String>,
    /// Frequency band (Hz) with most of the change of the prediction.
    #[serde(default)]
    pub band_hz: Option<[f64; 2]>,
    /// Phase of the motion with the largest residual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
    /// Smallest set of points, joints and shafts that holds what is missing with a probability of 0.9, by the evidence of
    /// all explanations; those of the likeliest first. Empty where nothing is missing, for modes and motion records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<String>,
}

/// A rule of the verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RuleRow {
    /// Name.
    pub rule: String,
    /// Condition in words.
    pub when: String,
    /// Whether it held; null where a rule before it had decided, or where there was nothing to override.
    pub held: Option<bool>,
    /// Figures that it compared where it did not hold.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub figures: String,
}

impl VerdictRow {
    /// Returns the band in words.
    pub fn band_text(&self) -> Option<String> {
        self.band_hz
            .map(|[from, to]| format!("it changes the FRFs most from {} to {} Hz", figure(from), figure(to)))
    }
}
