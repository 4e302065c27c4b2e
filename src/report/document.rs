//! Result documents of identification, validation and measurement: printed as JSON or written into the result
//! folder.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::certainty::{
    BasinRow, BootstrapRow, CombinationRow, PosteriorRow, RepeatRow, SearchRow, ToleranceRow,
};
use super::motion_row::{CurveRow, MotionRecordRow, PreprocessingRow};
pub use super::parameter::ParameterRow;
pub use super::plan::{ChoiceRow, PlanDocument, PlanRanking};
use super::prediction::NaturalMode;
pub use super::provenance::{Input, MachineText, Stamp};
use super::vocabulary::{ObjectiveKind, Role, ToleranceUse};

/// Settings of an identification, sufficient to repeat it with the seed of the stamp.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunSettings {
    /// File of the machine configuration.
    pub config: String,
    /// Folder of the measurement set.
    pub measurements: String,
    /// Model of the rods: `receptance` (exact wave solution) or `lumped`.
    pub model: String,
    /// Number of masses per rod of the lumped model; absent for `receptance`.
    pub lumps: Option<usize>,
    /// Objective: `least-squares`, `eq26` or `frequencies` for modes, `frf`, `inverse-dynamics` or
    /// `output-error` for motion records.
    pub objective: ObjectiveKind,
    /// Relative standard deviation of natural frequencies due to model error (1).
    pub frequency_model_error: f64,
    /// Standard deviation of ln(amplitude) (1).
    pub amplitude_sd: f64,
    /// Standard deviation of ln H due to model error, in addition to the noise (1).
    #[serde(default = "usual_model_error")]
    pub frf_model_error: f64,
    /// Lowest and highest fitted frequency of FRFs (Hz); absent without a limit.
    #[serde(default)]
    pub band_hz: Option<[f64; 2]>,
    /// `fit`: tolerances of machine and set were fitted jointly with the parameters (whole FRFs only);
    /// `none`: they were held.
    #[serde(default)]
    pub tolerances: ToleranceUse,
    /// Names of the positions and records requested for the fit; absent where none were named.
    #[serde(default)]
    pub positions: Option<Vec<String>>,
    /// Names of the positions and records requested to be held out.
    #[serde(default)]
    pub hold_out: Vec<String>,
    /// Number of bootstrap samples over lines, and as many over positions; 0 for no bootstrap.
    #[serde(default)]
    pub bootstrap: usize,
    /// Number of times that the best minimum has to be found from new starts.
    pub repeats: usize,
    /// Ids of parameters held at their start values.
    pub freeze: Vec<String>,
}

/// Value for documents that do not state it: the default (1).
fn usual_model_error() -> f64 {
    0.01
}

/// One mode at one position.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OrderRow {
    /// Mode number, from 1.
    pub order: u32,
    /// Measured natural frequency (Hz).
    pub measured_hz: Option<f64>,
    /// Predicted natural frequency (Hz).
    pub predicted_hz: Option<f64>,
    /// Relative frequency error (predicted − measured)/measured (1).
    pub relative_error: Option<f64>,
    /// Measured amplitude of the mode, in the unit of the measurement set.
    pub measured_amplitude: Option<f64>,
    /// Predicted amplitude times the gain, in the unit of the measured amplitude.
    pub predicted_amplitude: Option<f64>,
    /// Natural frequency predicted in the publication of the data (Hz).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_hz: Option<f64>,
}

/// A predicted peak without a measured mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LonePeak {
    /// Predicted natural frequency (Hz).
    pub frequency_hz: f64,
    /// Prominence: |H| at the peak over |H| at the higher of the two neighbouring minima (1).
    pub prominence: f64,
    /// Whether the measurement should show it: it lies in the measured band and is at least as prominent as
    /// the least prominent peak read.
    pub unexpected: bool,
}

/// Prediction errors at one position. For whole FRFs and motion records, only `role`, `gap` and `noise_floor`
/// are given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PositionRow {
    /// `fit`: used in the fit; `held_out`: predicted only.
    pub role: Role,
    /// Root sum of squares of the relative frequency errors (1; Tian et al., Eq. 27). Absent where a measured
    /// mode has no prediction.
    pub overall_error: Option<f64>,
    /// `overall_error` with predictions rounded to the frequency resolution of the measurement, as Tian et
    /// al. round them (1).
    pub overall_error_rounded: Option<f64>,
    /// `overall_error` of the published predictions, which are rounded to the same resolution (1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overall_error_published: Option<f64>,
    /// Modes in ascending number.
    pub orders: Vec<OrderRow>,
    /// Predicted peaks of the band without a measured mode.
    pub lone_peaks: Vec<LonePeak>,
    /// Gap: root mean square of ln(measured/predicted) over log-magnitude and phase (1); for motion records
    /// the relative force error (1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Gap due to measurement noise alone (1), where the noise is stated or estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<f64>,
}

impl PositionRow {
    /// Returns the row of a position, FRFs or record of which the gap and its noise floor are known (1).
    pub fn of_gap(role: Role, gap: Option<f64>, noise_floor: Option<f64>) -> Self {
        PositionRow {
            role,
            overall_error: None,
            overall_error_rounded: None,
            overall_error_published: None,
            orders: Vec::new(),
            lone_peaks: Vec::new(),
            gap,
            noise_floor,
        }
    }

    /// Returns the largest relative frequency error (1). A measured mode without a prediction and an
    /// unexpected peak count as `missing` (30 %).
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

/// Prediction error of one FRF.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrfRow {
    /// Name of the position; absent for a record without one.
    pub position: Option<String>,
    /// Name of the record, where it has one.
    pub record: Option<String>,
    /// Name of the point that responds.
    pub response: String,
    /// Name of the point that is excited.
    pub excitation: String,
    /// `fit`: used in the fit; `held_out`: predicted only.
    pub role: Role,
    /// Gap: root mean square of ln(measured/predicted) over log-magnitude and phase (1).
    pub gap: f64,
    /// Gap due to measurement noise alone (1), where the noise is stated or estimated.
    pub noise_floor: Option<f64>,
    /// Origin of the noise: `coherence` or `relative_sd` where stated, else estimated from `repeats` or
    /// `neighbouring lines`, or `unknown`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub noise_source: String,
    /// Number of frequency lines compared.
    pub lines: usize,
    /// Share of the recorded frequency lines whose coherence is accepted (1).
    pub accepted_share: f64,
}

/// A mode whose order does not fit its course over the positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MisplacedModeRow {
    /// Name of the position.
    pub position: String,
    /// Order under which the mode is entered.
    pub order: u32,
    /// Measured natural frequency (Hz).
    pub frequency_hz: f64,
    /// Order whose course over the other positions the mode continues; absent for a mode that continues none.
    pub fits_order: Option<u32>,
}

/// Misplaced modes, and the fit with the orders that they fit. Modes that fit none are left out of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RenumberedRow {
    /// The misplaced modes.
    pub modes: Vec<MisplacedModeRow>,
    /// Minimum of the objective with the fitting orders, to compare with `cost` of the document (1); absent
    /// where no fitted position is concerned.
    pub cost: Option<f64>,
    /// Estimates with the fitting orders, by parameter id.
    pub parameters: BTreeMap<String, ParameterRow>,
}

/// Result of an identification (`identification.json`).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IdentificationDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// SHA-256 digest of all other keys (hexadecimal): a document that was changed afterwards is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub content_sha256: Option<String>,
    /// Description of the machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineText>,
    /// Manifest of the measurement set; absent for a set that was not read from files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manifest: Option<Input>,
    /// Settings of the identification.
    pub settings: RunSettings,
    /// Estimates by parameter id; `gain` is the factor of the measuring chain.
    pub parameters: BTreeMap<String, ParameterRow>,
    /// Estimates of the tolerances fitted jointly with the parameters, by name; empty where they were held.
    #[serde(default)]
    pub tolerances: BTreeMap<String, ToleranceRow>,
    /// Minima whose χ² lies within the 95 % limit of the lowest, in ascending χ²; absent for a single
    /// minimum.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub basins: Vec<BasinRow>,
    /// Modes under a wrong order, and the fit with the orders that they fit; absent where all orders fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub renumbered: Option<RenumberedRow>,
    /// Derived quantities by name: those of the machine description, largest errors and gaps, χ² and its
    /// degrees of freedom.
    pub derived: BTreeMap<String, f64>,
    /// 95 % confidence intervals of the derived quantities of the machine description, by name.
    #[serde(default)]
    pub derived_interval95: BTreeMap<String, [f64; 2]>,
    /// Pairs of parameters whose combination is determined better than each parameter.
    #[serde(default)]
    pub combinations: Vec<CombinationRow>,
    /// Intervals by bootstrap, where it was requested.
    #[serde(default)]
    pub bootstrap: Vec<BootstrapRow>,
    /// Minimum of the objective (1): χ²; for `eq26` its value; for motion records Σ residual²/Σ measured².
    pub cost: f64,
    /// Number of evaluations of the objective in all searches.
    pub evaluations: u64,
    /// How far the global search went; absent for motion records, which need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search: Option<SearchRow>,
    /// Whether the best minimum was found as often as required; absent where once was enough, or the search
    /// was stopped.
    pub searches_agree: Option<bool>,
    /// Rounds of the search in ascending cost.
    pub searches: Vec<RepeatRow>,
    /// Whether the errors of each position or record are those of a fit without it, because none was held
    /// out.
    #[serde(default)]
    pub leave_one_out: bool,
    /// Ids of the rows and columns of `correlation`, `gain` included where it is estimated.
    pub fitted_parameters: Vec<String>,
    /// Correlation matrix of the fitted parameters (1), by rows.
    pub correlation: Vec<Vec<f64>>,
    /// Names of the fitted positions or records.
    pub fit_positions: Vec<String>,
    /// Names of the positions or records held out.
    pub held_out_positions: Vec<String>,
    /// Prediction errors by position, or by record where there are no positions.
    pub positions: BTreeMap<String, PositionRow>,
    /// Natural modes of the identified machine by position; absent for motion records.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub modes: BTreeMap<String, Vec<NaturalMode>>,
    /// Minima and covariance of all fitted coordinates, from which predictions and comparisons are made;
    /// absent where χ² is no likelihood.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorRow>,
    /// Prediction errors by FRF, where whole FRFs were fitted.
    #[serde(default)]
    pub frfs: Vec<FrfRow>,
    /// Prediction errors of motion records by name. `positions` contains them, too, with the force error as
    /// gap.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub records: BTreeMap<String, MotionRecordRow>,
    /// Filter and decimation of motion records.
    // Former key `recipe`, still read.
    #[serde(default, alias = "recipe", skip_serializing_if = "Option::is_none")]
    pub preprocessing: Option<PreprocessingRow>,
    /// Friction curve: forces at the constant speeds of the fitted records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub friction_curve: Vec<CurveRow>,
}

/// Prediction errors of an identified machine (`validation.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ValidationDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Prediction errors by position or record.
    pub positions: BTreeMap<String, PositionRow>,
    /// Largest relative frequency error (1). A measured mode without a prediction and an unexpected peak
    /// count as 30 %.
    pub largest_error: Option<f64>,
    /// Largest gap of a position or record (1), for FRFs and motion records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_gap: Option<f64>,
    /// Prediction errors of motion records by name. `positions` contains them, too, with the force error as
    /// gap.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub records: BTreeMap<String, MotionRecordRow>,
}

/// An identification from one choice of fitted positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonRun {
    /// Names of the fitted positions.
    pub fit_positions: Vec<String>,
    /// Estimates by parameter id.
    pub parameters: BTreeMap<String, ParameterRow>,
    /// Prediction errors by position.
    pub positions: BTreeMap<String, PositionRow>,
    /// Root sum of squares of the relative frequency errors at the common positions (1), which are held out
    /// of every run. Absent where a measured mode there has no prediction.
    pub common_error: Option<f64>,
    /// `common_error` of the published predictions (1).
    pub common_error_published: Option<f64>,
    /// Gap at the common positions (1), for FRFs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub common_gap: Option<f64>,
    /// Warnings of this run, one sentence each.
    pub warnings: Vec<String>,
}

/// Comparison of a multi-position identification with single-position ones (`comparison.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Names of the positions held out of every run, at which the runs are compared.
    pub common_positions: Vec<String>,
    /// Identifications by name: `multi`, and one named after each single position.
    pub runs: BTreeMap<String, ComparisonRun>,
}

/// Cross-validation score of one objective, with one fit position left out after another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectiveRow {
    /// Objective: `least-squares`, `eq26` or `frequencies`.
    pub objective: ObjectiveKind,
    /// Root mean square of the relative frequency errors at the positions left out (1); a mode without a
    /// prediction counts as 30 %.
    pub frequency_error: f64,
    /// Root mean square of ln(predicted/measured amplitude) at these positions (1); absent for an objective
    /// without a gain.
    pub ln_amplitude_error: Option<f64>,
    /// Number of measured modes without a prediction.
    pub missing: usize,
}

/// Cross-validation of the objectives (`objectives.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectivesDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Names of the positions left out one after another; held-out positions are not used.
    pub positions: Vec<String>,
    /// Scores in ascending frequency error.
    pub objectives: Vec<ObjectiveRow>,
}

/// Modal parameters of one mode in one record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakRow {
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Standard deviation of the natural frequency (Hz).
    pub frequency_sd_hz: Option<f64>,
    /// Damping ratio (1).
    pub damping_ratio: f64,
    /// Standard deviation of the damping ratio (1).
    pub damping_sd: Option<f64>,
    /// Amplitude, in the unit of the measured quantity.
    pub amplitude: f64,
    /// Standard deviation of the amplitude, in the same unit.
    pub amplitude_sd: Option<f64>,
    /// Whether `amplitude` is a local maximum of |H|; otherwise it is the contribution of the mode alone.
    pub own_peak: bool,
    /// Share of the model orders at which the pole is stable (1).
    pub stable_share: f64,
}

/// Evidence that a mode is a structural one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EvidenceRow {
    /// Number of records in which it is identified.
    // Former key, still read.
    #[serde(alias = "seen")]
    pub observed: usize,
    /// Number of records whose band covers it.
    pub expected: usize,
    /// Relative error of a frequency predicted from those of the other positions (1, root mean square).
    pub roughness: Option<f64>,
    /// Median share of the model orders at which the pole is stable (1).
    pub stability: f64,
    /// Median signal-to-noise ratio of the mode (1).
    pub signal_to_noise: f64,
    /// Criteria with their values, one sentence each.
    pub reasons: Vec<String>,
}

/// A mode tracked over the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakModeRow {
    /// Mode number in ascending frequency, from 1; irregular modes follow the regular ones.
    pub order: usize,
    /// Whether the frequency varies smoothly with position, as for a structural mode.
    pub regular: bool,
    /// Median natural frequency over the records (Hz).
    pub frequency_hz: f64,
    /// Modal parameters by record in which the mode is identified.
    pub records: BTreeMap<String, PeakRow>,
    /// Evidence for `regular`.
    pub evidence: EvidenceRow,
}

/// Modal fit of one record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakFitRow {
    /// Number of frequency lines fitted.
    pub lines: usize,
    /// Root mean square of |fitted − measured|/|measured| (1).
    pub relative_misfit: f64,
    /// Number of modes identified.
    pub modes: usize,
}

/// Modes of a measurement set (`peaks.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeaksDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Unit of the amplitudes; empty for FRFs of several quantities.
    #[serde(default)]
    pub amplitude_unit: String,
    /// Regular modes in ascending frequency, then the irregular ones.
    pub modes: Vec<PeakModeRow>,
    /// Modal fits by record.
    pub fits: BTreeMap<String, PeakFitRow>,
}

/// Predicted FRFs (`frf.json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FrfsDocument {
    /// Schema, inputs, overrides and warnings of the document.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Quantity of the FRF: `receptance`, `mobility` or `accelerance`.
    pub quantity: String,
    /// Name of the point that responds.
    pub response: String,
    /// Name of the point that is excited.
    pub excitation: String,
    /// Whether the control loops of the drive are closed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub closed_loop: bool,
    /// Whether the machine has the tolerances that an identification expects, at the medians of their priors;
    /// otherwise it is exactly as described.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub with_tolerances: bool,
    /// Frequencies (Hz).
    pub frequency_hz: Vec<f64>,
    /// Real and imaginary part at each frequency (SI units of `quantity`), by position.
    pub positions: BTreeMap<String, Vec<[f64; 2]>>,
}
