//! Result documents: what `--json` prints and `--out` holds.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::certainty::{BasinRow, BootstrapRow, CombinationRow, ToleranceRow};
use super::motion_row::{CurveRow, MotionRecordRow, PreprocessingRow};

/// A file a result rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Input {
    /// Path.
    pub path: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// What every document carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stamp {
    /// Name and version of the document's form.
    pub schema: String,
    /// Version of the program.
    pub tool_version: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Ran to its end.
    pub complete: bool,
    /// Files it rests on.
    pub inputs: Vec<Input>,
    /// Overrides of the configuration.
    #[serde(default)]
    pub overrides: Vec<String>,
    /// Effects taken out of the configuration.
    #[serde(default)]
    pub without: Vec<String>,
    /// What a person should know.
    pub warnings: Vec<String>,
}

/// How a result was made: enough to make it again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunSettings {
    /// Configuration.
    pub config: String,
    /// Measurement set.
    pub measurements: String,
    /// `receptance` or `lumped`.
    pub model: String,
    /// Lumps per rod of the lumped model.
    pub lumps: Option<usize>,
    /// `least-squares`, `eq26` or `frequencies`.
    pub objective: String,
    /// Relative standard deviation of a frequency that the model causes.
    pub frequency_model_error: f64,
    /// Standard deviation of ln(amplitude).
    pub amplitude_sd: f64,
    /// Standard deviation of ln H that the model causes.
    #[serde(default)]
    pub frf_model_error: f64,
    /// Lowest and highest frequency of FRFs (Hz), where it was limited.
    #[serde(default)]
    pub band_hz: Option<[f64; 2]>,
    /// `fit`: tolerances of machine and set were fitted along with whole FRFs; `none`: they were held.
    #[serde(default = "held")]
    pub tolerances: String,
    /// Positions and records asked to be fitted.
    #[serde(default)]
    pub positions: Option<Vec<String>>,
    /// Records and positions asked to be held out.
    #[serde(default)]
    pub hold_out: Vec<String>,
    /// Bootstrap samples.
    #[serde(default)]
    pub bootstrap: usize,
    /// Searches.
    pub repeats: usize,
    /// Parameters frozen.
    pub freeze: Vec<String>,
}

/// Results of versions that knew no tolerances held them.
fn held() -> String {
    "none".into()
}

/// An identified parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterRow {
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Lower end of its plausible range.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// 95 % interval.
    pub interval95: Option<[f64; 2]>,
    /// Whether the data determine it; absent for one that was not fitted.
    pub identifiable: Option<bool>,
    /// Whether it was fitted or kept its start value.
    pub fitted: bool,
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
}

/// One order at one position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OrderRow {
    /// Order.
    pub order: u32,
    /// Measured (Hz).
    pub measured_hz: Option<f64>,
    /// Predicted (Hz).
    pub predicted_hz: Option<f64>,
    /// (predicted − measured)/measured.
    pub relative_error: Option<f64>,
    /// Measured amplitude.
    pub measured_amplitude: Option<f64>,
    /// Predicted amplitude, gain included.
    pub predicted_amplitude: Option<f64>,
    /// Published prediction (Hz).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_hz: Option<f64>,
}

/// A predicted peak without a measured partner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LonePeak {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// How far it stands out: |H| over the higher of the neighbouring minima.
    pub prominence: f64,
    /// Whether it should have been seen.
    pub unexpected: bool,
}

/// One position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PositionRow {
    /// `fit` or `held_out`.
    pub role: String,
    /// Root of the summed squares of the relative frequency errors (Tian et al., Eq. 27).
    pub overall_error: Option<f64>,
    /// The same with predictions rounded to the resolution of the measurement, as the paper does.
    pub overall_error_rounded: Option<f64>,
    /// The published figure, rounded likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overall_error_published: Option<f64>,
    /// Orders.
    pub orders: Vec<OrderRow>,
    /// Predicted peaks of the band without a measured partner.
    pub lone_peaks: Vec<LonePeak>,
    /// Gap of its FRFs: root mean square of ln(measured/predicted), per component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// The gap that the noise alone leaves, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<f64>,
}

impl PositionRow {
    /// Largest relative frequency error; a measured order without a prediction, and a predicted peak that should have been seen,
    /// count as `missing`.
    pub fn largest_error(&self, missing: f64) -> Option<f64> {
        self.orders
            .iter()
            .filter_map(|o| match (o.measured_hz, o.relative_error) {
                (Some(_), Some(error)) => Some(error.abs()),
                (Some(_), None) => Some(missing),
                _ => None,
            })
            .chain(self.lone_peaks.iter().filter(|p| p.unexpected).map(|_| missing))
            .reduce(f64::max)
    }
}

/// One FRF.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrfRow {
    /// Position.
    pub position: Option<String>,
    /// Record.
    pub record: Option<String>,
    /// Point that responds.
    pub response: String,
    /// Point that is excited.
    pub excitation: String,
    /// `fit` or `held_out`.
    pub role: String,
    /// Root mean square of ln(measured/predicted), per component.
    pub gap: f64,
    /// The gap that the noise alone leaves, where it is known.
    pub noise_floor: Option<f64>,
    /// Lines compared.
    pub lines: usize,
    /// Share of its lines that were accepted.
    pub accepted_share: f64,
}

/// One search of several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RepeatRow {
    /// Seed.
    pub seed: u64,
    /// Least cost.
    pub cost: f64,
    /// Evaluations.
    pub evaluations: u64,
    /// Best cost after each generation.
    pub trace: Vec<f64>,
}

/// `identification.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IdentificationDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// How it was made.
    pub settings: RunSettings,
    /// Parameters by id.
    pub parameters: BTreeMap<String, ParameterRow>,
    /// Tolerances that were fitted along, by name; empty where they were held.
    #[serde(default)]
    pub tolerances: BTreeMap<String, ToleranceRow>,
    /// Minima of χ² within the 95 % limit of the least, the best first; absent where there is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub basins: Vec<BasinRow>,
    /// Quantities by name that follow from them.
    pub derived: BTreeMap<String, f64>,
    /// 95 % intervals of those that the machine names.
    #[serde(default)]
    pub derived_interval95: BTreeMap<String, [f64; 2]>,
    /// What the data determine only together.
    #[serde(default)]
    pub combinations: Vec<CombinationRow>,
    /// Bootstraps asked for.
    #[serde(default)]
    pub bootstrap: Vec<BootstrapRow>,
    /// Least cost.
    pub cost: f64,
    /// Evaluations of all searches.
    pub evaluations: u64,
    /// Whether the searches agree; absent for fewer than two.
    pub searches_agree: Option<bool>,
    /// The searches, best first.
    pub searches: Vec<RepeatRow>,
    /// Nothing was held out: the figures of each position or record are those of a fit without it.
    #[serde(default)]
    pub leave_one_out: bool,
    /// Ids in the order of `correlation`.
    pub fitted_parameters: Vec<String>,
    /// Correlations of the fitted parameters.
    pub correlation: Vec<Vec<f64>>,
    /// Positions fitted.
    pub fit_positions: Vec<String>,
    /// Positions held out.
    pub held_out_positions: Vec<String>,
    /// Positions by name; records where there are no positions.
    pub positions: BTreeMap<String, PositionRow>,
    /// FRFs, where whole FRFs were fitted.
    #[serde(default)]
    pub frfs: Vec<FrfRow>,
    /// Time records by name, where motion was fitted; `positions` holds them, too, with their force error as gap.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub records: BTreeMap<String, MotionRecordRow>,
    /// How records were filtered.
    #[serde(default, alias = "recipe", skip_serializing_if = "Option::is_none")]
    pub preprocessing: Option<PreprocessingRow>,
    /// The friction curve from constant speeds of the fitted records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub friction_curve: Vec<CurveRow>,
}

/// `validation.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ValidationDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Positions by name.
    pub positions: BTreeMap<String, PositionRow>,
    /// Largest relative frequency error; a measured order that is not predicted counts as 0.3.
    pub largest_error: Option<f64>,
    /// Largest gap of a position or record, for FRFs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_gap: Option<f64>,
}

/// One run of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonRun {
    /// Positions fitted.
    pub fit_positions: Vec<String>,
    /// Parameters by id.
    pub parameters: BTreeMap<String, ParameterRow>,
    /// Positions by name.
    pub positions: BTreeMap<String, PositionRow>,
    /// Root of the summed squares of the frequency errors over the positions that no run fitted with several; absent where one of
    /// their measured orders is not predicted.
    pub common_error: Option<f64>,
    /// The same of the published predictions.
    pub common_error_published: Option<f64>,
    /// For FRFs: the gap over the positions that no run fitted with several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub common_gap: Option<f64>,
    /// What a person should know of this run.
    pub warnings: Vec<String>,
}

/// `comparison.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Positions over which all runs are compared.
    pub common_positions: Vec<String>,
    /// Runs by name: `multi` and one for each single position.
    pub runs: BTreeMap<String, ComparisonRun>,
}

/// Score of an objective by leaving out one fit position after another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectiveRow {
    /// Objective.
    pub objective: String,
    /// Root mean square of the relative frequency errors at the positions left out.
    pub frequency_error: f64,
    /// Root mean square of ln(predicted/measured amplitude) there; absent where the objective knows no gain.
    pub ln_amplitude_error: Option<f64>,
    /// Measured modes that were not predicted.
    pub missing: usize,
}

/// `objectives.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectivesDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Positions left out one after another; held-out positions are not touched.
    pub positions: Vec<String>,
    /// Objectives, best first.
    pub objectives: Vec<ObjectiveRow>,
}

/// A mode in one record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakRow {
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Its standard deviation (Hz).
    pub frequency_sd_hz: Option<f64>,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Its standard deviation.
    pub damping_sd: Option<f64>,
    /// Amplitude in the measured quantity.
    pub amplitude: f64,
    /// Its standard deviation.
    pub amplitude_sd: Option<f64>,
    /// The amplitude is that of a maximum of |H|; else the mode's own share, which makes none.
    pub own_peak: bool,
    /// Share of the model orders at which the pole is stable.
    pub stable_share: f64,
}

/// Why a mode was found regular or not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EvidenceRow {
    /// Records that show it.
    #[serde(alias = "seen")]
    pub observed: usize,
    /// Records whose band covers it.
    pub expected: usize,
    /// Relative error of a frequency predicted from those of the other positions.
    pub roughness: Option<f64>,
    /// Median share of model orders at which its pole is stable.
    pub stability: f64,
    /// Median signal-to-noise ratio.
    pub signal_to_noise: f64,
    /// In words.
    pub reasons: Vec<String>,
}

/// A mode over the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakModeRow {
    /// Place in rising frequency, from 1; those without regularity follow the regular ones.
    pub order: usize,
    /// A real mode by its regularity over positions.
    pub regular: bool,
    /// Median natural frequency (Hz).
    pub frequency_hz: f64,
    /// Records that show it, by name.
    pub records: BTreeMap<String, PeakRow>,
    /// Why.
    pub evidence: EvidenceRow,
}

/// How a record was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakFitRow {
    /// Lines used.
    pub lines: usize,
    /// Root mean square of |fitted − measured| over |measured|.
    pub relative_misfit: f64,
    /// Modes found.
    pub modes: usize,
}

/// `peaks.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeaksDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Unit of the amplitudes; empty where FRFs of several quantities are tracked.
    #[serde(default)]
    pub amplitude_unit: String,
    /// Modes: the regular ones in rising frequency, then the others.
    pub modes: Vec<PeakModeRow>,
    /// Fits by record.
    pub fits: BTreeMap<String, PeakFitRow>,
}

/// One choice of measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChoiceRow {
    /// What to measure.
    pub measure: Vec<String>,
    /// Geometric mean over the parameters of the standard deviation left over that of the plausible range.
    pub score: f64,
    /// Parameters that it determines.
    pub determined: Vec<String>,
    /// Half the 95 % interval of each parameter, in its unit.
    pub half_width95: BTreeMap<String, f64>,
}

/// All choices of one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanRanking {
    /// Measurements chosen.
    pub count: usize,
    /// Rank (from 1) of the set's own split, where that is one of these choices.
    pub split_rank: Option<usize>,
    /// Choices, best first.
    pub choices: Vec<ChoiceRow>,
}

/// `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// `frf` or `modes`.
    pub data: String,
    /// Measurements made already.
    pub measured: Vec<String>,
    /// Parameters planned for.
    pub parameters: Vec<String>,
    /// Rankings by number of measurements.
    pub rankings: Vec<PlanRanking>,
}

/// `frf.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrfsDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// receptance, mobility or accelerance.
    pub quantity: String,
    /// Point that responds.
    pub response: String,
    /// Point that is excited.
    pub excitation: String,
    /// Whether the loops of the drive were closed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub closed_loop: bool,
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Real and imaginary parts by position.
    pub positions: BTreeMap<String, Vec<[f64; 2]>>,
}
