//! Answers: the diagnoses of cases.

use std::collections::BTreeMap;

use schemars::JsonSchema;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::error::WithheldError;
use report::diagnosis::{chosen_effects, effect_ids};
use report::document::Input;

/// Reads an interval; an end that is null (not finite) makes the whole interval unknown.
fn both_ends<'de, D: Deserializer<'de>>(source: D) -> Result<Option<[f64; 2]>, D::Error> {
    let ends: Option<[Option<f64>; 2]> = Option::deserialize(source)?;
    Ok(ends.and_then(|[low, high]| Some([low?, high?])))
}

/// A verdict as stated in the document of a diagnosis. Its other fields are passed on unchanged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VerdictAnswer {
    /// `none`, `effect`, `ambiguous`, `unknown`, `wrong-parameter`, `measurement` or `insufficient`; `failed`
    /// where there is no verdict.
    pub kind: String,
    /// Ids, or combinations joined with `+`.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Interface at which an effect is missing.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub interface: Option<String>,
    /// Set of places that holds what is missing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<String>,
    /// Phase of the motion in which the effect is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
    /// Ids of faults of the measuring chain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<String>,
    /// Frequency band (Hz) in which the effect is missing.
    #[serde(default, deserialize_with = "both_ends", skip_serializing_if = "Option::is_none")]
    pub band_hz: Option<[f64; 2]>,
    /// Other fields.
    #[serde(flatten)]
    pub more: serde_json::Map<String, Value>,
}

impl VerdictAnswer {
    /// Returns the verdict of a failed diagnosis.
    pub fn failed(reason: &str) -> Self {
        let more = serde_json::Map::from_iter([("reason".to_string(), Value::from(reason))]);
        Self {
            kind: "failed".into(),
            effects: Vec::new(),
            interface: None,
            places: Vec::new(),
            phase: None,
            faults: Vec::new(),
            band_hz: None,
            more,
        }
    }

    /// Returns the named ids, each once, in their order. Only two kinds of verdict name effects.
    pub fn named(&self) -> Vec<&str> {
        let mut ids = Vec::new();
        if ["effect", "ambiguous"].contains(&self.kind.as_str()) {
            for id in self.effects.iter().flat_map(|entry| effect_ids(entry)) {
                if !ids.contains(&id) {
                    ids.push(id);
                }
            }
        }
        ids
    }

    /// Returns the id if the verdict names exactly one effect.
    pub fn single(&self) -> Option<&str> {
        match self.named()[..] {
            [id] if self.kind == "effect" => Some(id),
            _ => None,
        }
    }
}

/// A candidate of the ranked list.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EffectAnswer {
    /// Id, or a combination.
    pub id: String,
    /// `tried`, `failed` or `not-applicable`.
    #[serde(default)]
    pub status: String,
    /// Share of the gap that it closes on held-out data.
    #[serde(default)]
    pub closed: Option<f64>,
    /// 95 % interval of that share.
    #[serde(default, deserialize_with = "both_ends")]
    pub closed95: Option<[f64; 2]>,
}

/// A location where an effect may be missing.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct WhereAnswer {
    /// Interface.
    #[serde(default)]
    pub interface: Option<String>,
    /// Phase of the motion.
    #[serde(default)]
    pub phase: Option<String>,
}

/// The scored parts of the gap.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct GapAnswer {
    /// Gap in each phase of the motion.
    #[serde(default)]
    pub by_phase: BTreeMap<String, Option<f64>>,
}

/// The chosen model.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct ChosenAnswer {
    /// Ids joined with `+`.
    #[serde(default)]
    pub id: String,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Share of the gap that it closes on held-out data.
    #[serde(default)]
    pub closed: Option<f64>,
    /// 95 % interval of that share.
    #[serde(default, deserialize_with = "both_ends")]
    pub closed95: Option<[f64; 2]>,
}

/// Part of the document on motion records.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct MotionAnswer {
    /// Extra channels of each record.
    #[serde(default)]
    pub transmission: Vec<ChannelAnswer>,
}

/// An extra channel of a record.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ChannelAnswer {
    /// Name of the channel's column.
    pub column: String,
    /// Weight: force (N or N·m) per unit of the channel.
    #[serde(default)]
    pub weight: f64,
}

/// The scored parts of diagnosis.json.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DiagnosisAnswer {
    /// Name and version of the schema.
    pub schema: String,
    /// Whether the diagnosis ran to its end.
    pub complete: bool,
    /// Input files.
    #[serde(default)]
    pub inputs: Vec<Input>,
    /// Changed settings of the machine.
    #[serde(default)]
    pub overrides: Vec<String>,
    /// Effects removed from the machine.
    #[serde(default)]
    pub without: Vec<String>,
    /// Gaps.
    #[serde(default)]
    pub gap: GapAnswer,
    /// Locations, best first.
    #[serde(default, rename = "where")]
    pub places: Vec<WhereAnswer>,
    /// Candidates, best first.
    #[serde(default)]
    pub effects: Vec<EffectAnswer>,
    /// Parameters of the machine as described.
    #[serde(default)]
    pub described: BTreeMap<String, f64>,
    /// The chosen model.
    #[serde(default)]
    pub chosen: ChosenAnswer,
    /// Part on motion records.
    #[serde(default)]
    pub motion: Option<MotionAnswer>,
    /// Verdict.
    pub verdict: VerdictAnswer,
}

impl ChosenAnswer {
    /// Returns the ids of its effects; none for the machine as described.
    pub fn effects(&self) -> impl Iterator<Item = &str> {
        chosen_effects(&self.id)
    }
}

impl DiagnosisAnswer {
    /// Returns the weight (force per unit) of each extra channel's column.
    pub fn weights(&self) -> BTreeMap<String, f64> {
        self.motion.iter().flat_map(|m| &m.transmission).map(|c| (c.column.clone(), c.weight)).collect()
    }
}

/// One run of the diagnosis, as stored in `diagnoses`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name and version of the schema.
    pub schema: String,
    /// Digest of the diagnosing program.
    pub program_sha256: String,
    /// Digest of the case folder.
    pub case_sha256: String,
    /// Command-line arguments.
    pub arguments: Vec<String>,
    /// Exit code; absent where a signal or the time limit ended it.
    pub exit_code: Option<i32>,
    /// Duration (s).
    pub seconds: f64,
    /// Last lines of stderr.
    pub said: String,
    /// Printed document, if any.
    pub diagnosis: Option<Value>,
}

/// An answer to be judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The diagnosis, or the reason of its failure.
    pub diagnosis: Result<DiagnosisAnswer, WithheldError>,
    /// Duration (s).
    pub seconds: f64,
}

impl Run {
    /// Schema of a stored run.
    pub const SCHEMA: &str = "jointid/withheld-run/1";

    /// Returns the diagnosis if the run succeeded, its document is readable and complete, and its inputs
    /// include the files of the case; else a failure with its reason.
    pub fn answer(&self, files: &[Input]) -> Answer {
        Answer { diagnosis: self.read(files), seconds: self.seconds }
    }

    fn read(&self, files: &[Input]) -> Result<DiagnosisAnswer, WithheldError> {
        let no_answer = |reason: String| Err(WithheldError::Diagnosis(reason));
        let mut lines = self.said.lines().map(str::trim).rev().filter(|line| !line.is_empty());
        let last = lines.clone().next().unwrap_or("no output on stderr");
        let last = lines
            .find(|line| ["jointid:", "error:"].iter().any(|begin| line.starts_with(begin)))
            .unwrap_or(last);
        match self.exit_code {
            Some(0) => {}
            Some(code) => return no_answer(format!("exit code {code}: {last}")),
            None => {
                return no_answer(format!(
                    "the diagnosis did not end by itself (signal or time limit): {last}"
                ));
            }
        }
        let Some(document) = self.diagnosis.clone() else {
            return no_answer("the diagnosis printed no JSON document".into());
        };
        let diagnosis: DiagnosisAnswer = match serde_json::from_value(document) {
            Ok(diagnosis) => diagnosis,
            Err(error) => return no_answer(format!("the document of the diagnosis cannot be read: {error}")),
        };
        if !diagnosis.schema.starts_with("jointid/diagnosis/") {
            return no_answer(format!(
                "the printed document has schema {}, not a diagnosis",
                diagnosis.schema
            ));
        }
        if !diagnosis.complete {
            return no_answer("the document of the diagnosis is not complete".into());
        }
        match files.iter().find(|file| !diagnosis.inputs.iter().any(|input| input.sha256 == file.sha256)) {
            Some(file) => {
                no_answer(format!("the inputs of the diagnosis lack the case's file {}", file.path))
            }
            None => Ok(diagnosis),
        }
    }
}
