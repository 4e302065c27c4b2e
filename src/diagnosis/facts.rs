//! Facts: everything on which a verdict rests, as fits and simulations found it.
//!
//! Facts are gathered where a rule asks for them, and can be written and read again: rules then judge the
//! same facts without a fit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::data_kind::DataKind;
use super::null_distribution::NullDistribution;

/// Facts of one diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Kind of the data.
    pub data: DataKind,
    /// Number of compared numbers; of motion records that of samples without autocorrelation.
    pub count: f64,
    /// Number of unknowns of the nominal machine.
    pub unknowns: usize,
    /// Whether candidates are judged by the fitted positions alone, without cross-validation.
    pub in_sample: bool,
    /// Whether records or positions are held out.
    pub holds_out: bool,
    /// Least χ² of the nominal machine.
    pub chi_square: f64,
    /// Candidates, the largest reduction of χ² first; those without a fit last.
    pub candidates: Vec<CandidateFacts>,
    /// Generic impedances at interfaces that reduce χ² most, the largest reduction first.
    pub impedances: Vec<ImpedanceFacts>,
    /// Number of generic impedances at all interfaces.
    #[serde(default)]
    pub impedances_tried: usize,
    /// Null distribution.
    pub null: NullDistribution,
    /// Cross-validation losses: −2 ln of the predictive density of each left-out fit position, summed (χ² for
    /// modes and motion records, of these of left-out parts); null where it cannot be computed.
    pub left_out: Vec<Of<Option<f64>>>,
    /// What is missing beside chosen effects: one search for each effect that is added.
    pub beside: Vec<Beside>,
    /// −2 ln of the predictive density of held-out data.
    pub held_out_loss: Vec<Of<f64>>,
    /// Share of the squared held-out gap of the machine as described, above the noise floor, that a model
    /// closes; null where nothing is held out or the gap is noise.
    pub closed: Vec<Of<Option<f64>>>,
    /// Natural logarithm of the share of the parameters' ranges that the data leave to a model.
    #[serde(default)]
    pub log_occam: Vec<Of<f64>>,
    /// Number of the machine that a model moves farthest from its description.
    pub farthest: Vec<Of<Option<Farthest>>>,
    /// Fault that records show by themselves, without a model.
    pub fault_in_records: Option<FaultFacts>,
    /// Fault of a held-out record that is far off while all others are not.
    pub fault_held_out: Option<FaultFacts>,
    /// Whether a model leaves that fault.
    pub fault_held_out_remains: Vec<Of<bool>>,
    /// Held-out motion records that contradict the fitted ones beside a model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contradicting_held_out: Vec<Of<ContradictingHeldOut>>,
    /// Records that differ by noise and a factor alone; absent before it is asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_position: Option<Answer<OnePosition>>,
    /// Fault of the measuring chain of all records with which the nominal machine fits best.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chain: Option<Answer<ChainFacts>>,
    /// Pairs of records whose exchange reduces χ² most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exchanged: Option<Vec<ExchangedFacts>>,
    /// Record or channel that contradicts the others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Answer<ContradictionFacts>>,
    /// Reason why records are not those of one passive machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mismatch: Option<Answer<Remark>>,
}

/// A model of these facts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// The machine as described, with its tolerances.
    Nominal,
    /// With the candidate at this index.
    Candidate(usize),
    /// With the generic impedance at this index.
    Impedance(usize),
    /// The chosen model in a deeper minimum, which the search with this index beside it found.
    Deeper(usize),
    /// The chosen model with what this search, by its index, found at this index.
    With(usize, usize),
}

/// A figure of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Of<T> {
    /// The model.
    pub model: Model,
    /// The figure.
    pub value: T,
}

/// Answer to a question that was asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Answer<T> {
    /// What was found; null where there is nothing.
    pub found: Option<T>,
}

/// A number of the machine and its deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Farthest {
    /// Name of the number.
    pub name: String,
    /// Deviation in standard deviations of its tolerance.
    pub deviation: f64,
}

/// A reason in words, with a proposed measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Remark {
    /// Reason.
    pub reason: String,
    /// Proposed measurement.
    pub next_measurement: String,
}

/// A candidate: an effect, or a frozen parameter that is released.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CandidateFacts {
    /// Id of what is added last.
    pub id: String,
    /// Ids of all effects of its model.
    pub effects: Vec<String>,
    /// Ids of those that describe no other of them in more detail.
    pub names: Vec<String>,
    /// Points, joints and shafts that its model changes; «measurement», «drive» or «losses» without such a part.
    #[serde(default)]
    pub places: Vec<String>,
    /// Statement of a released parameter: its frozen value and its estimate; absent for an effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub released: Option<String>,
    /// Statement of a number of the description that it changes, with its estimate; absent for an effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// Stiffnesses of joints that its fit leaves at an end of their range.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_end: Vec<String>,
    /// Ids of effects that these data cannot tell from it, however they fit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resembles: Vec<String>,
    /// Test that tells the effect from others; absent where the library has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub discriminating_test: Option<String>,
    /// Number of parameters that its model adds to the machine as described.
    pub added: usize,
    /// Least χ²; null where it was not fitted.
    pub chi_square: Option<f64>,
    /// Reduction of χ²; 0 where the fit contradicts the meaning of the effect.
    pub gain: f64,
    /// Whether its fit is hardly different from that of another effect.
    pub is_limit: bool,
    /// Least χ² in the detail that the library has for it; absent before it is asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chi_square_in_detail: Option<f64>,
    /// Generic impedances in its place, beside chosen effects; absent before they are asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub impedances: Option<Vec<ImpedanceFacts>>,
}

/// A generic impedance at an interface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImpedanceFacts {
    /// Point or joint.
    pub interface: String,
    /// Word for its shape.
    pub shape: String,
    /// Number of its parameters, beside those of chosen effects.
    pub parameters: usize,
    /// Least χ².
    pub chi_square: f64,
    /// Reduction of χ².
    pub gain: f64,
}

/// What a search beside chosen effects found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Beside {
    /// The chosen model.
    pub of: Model,
    /// Its χ² after the search.
    pub chi_square: f64,
    /// Whether the search found a deeper minimum of it.
    pub is_deeper: bool,
    /// Candidates beside it.
    pub candidates: Vec<CandidateFacts>,
}

/// A fault of records, as a verdict states it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FaultFacts {
    /// Ids, `id@record` where one record is concerned; none for records without a known cause.
    pub ids: Vec<String>,
    /// Reason.
    pub reason: String,
    /// Proposed measurement.
    pub next_measurement: String,
    /// Whether the records are sound but say too little.
    pub is_insufficient: bool,
}

/// Held-out motion records that contradict the fitted ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContradictingHeldOut {
    /// All of them.
    pub fault: Option<FaultFacts>,
    /// Those that no imperfectly modelled effect explains.
    pub beyond_effects: Option<FaultFacts>,
}

/// A fault of the measuring chain of all records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChainFacts {
    /// Its id.
    pub id: String,
    /// The fault.
    pub fault: FaultFacts,
    /// Number of its parameters.
    pub parameters: usize,
    /// Least χ² of the nominal machine on the corrected records.
    pub chi_square: f64,
}

/// Records that differ by noise and a factor alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OnePosition {
    /// The fault: all were measured at the position where they fit best.
    pub fault: FaultFacts,
    /// Least χ² with all records there.
    pub chi_square: f64,
    /// Least χ² at their own positions.
    pub chi_square_at_own: f64,
}

/// Two records at each other's positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExchangedFacts {
    /// The fault.
    pub fault: FaultFacts,
    /// Least χ² of the nominal machine.
    pub chi_square: f64,
}

/// Records that contradict the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContradictionFacts {
    /// The fault, with its cause where one of the measuring chain was found.
    pub fault: FaultFacts,
    /// Misfit per compared number of the others, without these.
    pub rest: f64,
}

impl CandidateFacts {
    /// Returns χ²; infinite where it was not fitted.
    pub(super) fn chi_square(&self) -> f64 {
        self.chi_square.unwrap_or(f64::INFINITY)
    }
}

/// Returns the figure of a model; `None` where it was not asked for.
pub(super) fn of<T>(all: &[Of<T>], model: Model) -> Option<&T> {
    all.iter().find(|of| of.model == model).map(|of| &of.value)
}

impl Facts {
    /// Returns the cross-validation loss of a model; `None` where it was not asked for or cannot be computed.
    pub(super) fn left_out(&self, model: Model) -> Option<f64> {
        of(&self.left_out, model).copied().flatten()
    }

    /// Returns the misfit of the nominal machine over null simulations.
    pub(super) fn before(&self) -> f64 {
        self.excess(self.chi_square)
    }

    /// Returns a χ² over those of null simulations.
    pub(super) fn excess(&self, chi_square: f64) -> f64 {
        self.null.excess(chi_square / self.count)
    }

    /// Returns the generic impedance that reduces χ² most.
    pub(super) fn best_impedance(&self) -> Option<(usize, &ImpedanceFacts)> {
        let all = self.impedances.iter().enumerate();
        all.min_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square))
    }
}
