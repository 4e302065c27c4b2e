//! `withheld.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use reference_simulator::{Kind, Strength};
use report::document::Stamp;

use super::answer::VerdictAnswer;
use super::judge::Judgement;
use super::score::Scores;
use super::seal::{Generator, Seal};

/// Digests and generator of the sealed cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SealRow {
    /// Digest of the generator.
    pub generator_sha256: String,
    /// Digest of the list of cases, which contains the digest of each folder.
    pub cases_sha256: String,
    /// Digest of the labels.
    pub labels_sha256: String,
    /// Generator.
    pub generator: Generator,
}

impl From<&Seal> for SealRow {
    fn from(seal: &Seal) -> Self {
        Self {
            generator_sha256: seal.generator_sha256.clone(),
            cases_sha256: seal.cases_sha256.clone(),
            labels_sha256: seal.labels_sha256.clone(),
            generator: seal.generator.clone(),
        }
    }
}

/// One case with its verdict.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CaseRow {
    /// Name.
    pub name: String,
    /// Kind of the case.
    #[schemars(with = "String")]
    pub kind: Kind,
    /// Effects, the dominant one first.
    pub truth: Vec<String>,
    /// Specified strength.
    #[schemars(with = "Option<String>")]
    pub strength: Option<Strength>,
    /// Non-centrality of the dominant effect.
    pub noncentrality: Option<f64>,
    /// Non-centrality of the dominant effect at the given positions after a fit of joints and tolerances.
    pub fitted_noncentrality: Option<f64>,
    /// Layout of the machine; absent for machines of the catalogue.
    pub layout: Option<String>,
    /// Whether an effect of the library imitates the outside cause within noise and tolerances; absent for
    /// other causes.
    pub imitated: Option<bool>,
    /// Verdict; kind `failed` without a diagnosis.
    pub verdict: VerdictAnswer,
    /// Whether the verdict is correct for this kind of case.
    pub right: bool,
    /// Whether it names a set that contains the dominant effect; absent for cases without an effect.
    pub class: Option<bool>,
    /// Whether the location is correct; absent for cases without an effect.
    pub place_right: Option<bool>,
    /// Whether the phase is correct; absent for data without phases.
    pub phase_right: Option<bool>,
    /// Share of the gap closed by the true effects; for motion, by the chosen model without noise.
    pub closed_truth: Option<f64>,
    /// Share of the gap closed by the named effect.
    pub closed: Option<f64>,
    /// 95 % interval of that share.
    pub closed95: Option<[f64; 2]>,
    /// Duration (s).
    pub seconds: f64,
}

impl CaseRow {
    /// Builds the row of a judged case.
    pub fn new(name: &str, judged: &Judgement) -> Self {
        let planted = !judged.truth.is_empty();
        Self {
            name: name.into(),
            kind: judged.kind,
            truth: judged.truth.clone(),
            strength: judged.strength,
            noncentrality: judged.noncentrality,
            fitted_noncentrality: judged.size,
            layout: judged.layout.clone(),
            imitated: (judged.kind == Kind::Unknown).then_some(judged.imitated),
            verdict: judged.verdict.clone(),
            right: judged.right,
            class: planted.then_some(judged.class),
            place_right: planted.then_some(judged.place_right),
            phase_right: judged.phase_right,
            closed_truth: judged.closed_truth,
            closed: judged.closed,
            closed95: judged.closed95,
            seconds: judged.seconds,
        }
    }
}

/// `withheld.json`.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct WithheldDocument {
    /// Stamp.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Seal of the cases.
    pub seal: SealRow,
    /// Digest of the diagnosing program.
    pub program_sha256: String,
    /// Extra arguments of every diagnosis.
    pub ablation: Vec<String>,
    /// Number of simultaneous diagnoses, each on `threads_each` threads: the conditions of the durations.
    pub jobs: usize,
    /// Threads of each diagnosis.
    pub threads_each: usize,
    /// Number of sealed case folders; fewer are listed if the check was stopped.
    pub sealed_cases: usize,
    /// Cases of the plan that could not be made, with reasons.
    pub not_made: Vec<String>,
    /// Machines drawn and refused before those of the cases: their responses ring too long, or the effect
    /// cannot have the asked size on them.
    pub refused_machines: usize,
    /// Cases.
    pub cases: Vec<CaseRow>,
    /// Scores.
    pub scores: Scores,
}
