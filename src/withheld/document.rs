//! `withheld.json`.

use schemars::JsonSchema;
use serde::Serialize;

use reference_simulator::{Kind, Strength};
use report::document::Stamp;

use super::answer::VerdictAnswer;
use super::judge::Judgement;
use super::score::Scores;
use super::seal::{Generator, Seal};

/// What was sealed before scoring.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SealRow {
    /// Digest of the generator.
    pub generator_sha256: String,
    /// Digest of the list of cases, each with that of its folder.
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
    /// Strength asked for.
    #[schemars(with = "Option<String>")]
    pub strength: Option<Strength>,
    /// Non-centrality of the dominant effect.
    pub noncentrality: Option<f64>,
    /// Verdict; kind `failed` where there is none.
    pub verdict: VerdictAnswer,
    /// The verdict is what the case calls for.
    pub right: bool,
    /// It names a set that holds the dominant effect; absent for cases without one.
    pub class: Option<bool>,
    /// The place is right; absent for cases without one.
    pub place_right: Option<bool>,
    /// The phase is right; absent for data without phases.
    pub phase_right: Option<bool>,
    /// What the truth can close; in motion what the chosen model closes without noise.
    pub closed_truth: Option<f64>,
    /// What the named effect closes.
    pub closed: Option<f64>,
    /// Its interval.
    pub closed95: Option<[f64; 2]>,
    /// Seconds.
    pub seconds: f64,
}

impl CaseRow {
    /// The row of a judged case.
    pub fn new(name: &str, judged: &Judgement) -> Self {
        let planted = !judged.truth.is_empty();
        Self {
            name: name.into(),
            kind: judged.kind,
            truth: judged.truth.clone(),
            strength: judged.strength,
            noncentrality: judged.noncentrality,
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
    /// What was sealed.
    pub seal: SealRow,
    /// Digest of the program that diagnosed.
    pub program_sha256: String,
    /// Further arguments that every diagnosis was given.
    pub ablation: Vec<String>,
    /// Diagnoses at a time, each on `threads_each` threads: what the seconds are counted under.
    pub jobs: usize,
    /// Threads of each diagnosis.
    pub threads_each: usize,
    /// Case folders sealed; fewer are listed where the check was stopped.
    pub sealed_cases: usize,
    /// Cases.
    pub cases: Vec<CaseRow>,
    /// Scores.
    pub scores: Scores,
}
