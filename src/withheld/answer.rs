//! What a diagnosis says of a case.

use std::collections::BTreeMap;

use schemars::JsonSchema;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use report::document::Input;

/// Two numbers; an end that is none (null stands for what is not finite) makes the whole unknown.
fn both_ends<'de, D: Deserializer<'de>>(source: D) -> Result<Option<[f64; 2]>, D::Error> {
    let ends: Option<[Option<f64>; 2]> = Option::deserialize(source)?;
    Ok(ends.and_then(|[low, high]| Some([low?, high?])))
}

/// A verdict as the document of a diagnosis states it. What else it holds is passed on as it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VerdictAnswer {
    /// `none`, `effect`, `ambiguous`, `unknown`, `wrong-parameter`, `measurement` or `insufficient`; `failed` where there is no verdict.
    pub kind: String,
    /// Ids, or combinations joined with `+`.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Interface at which something is missing.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub interface: Option<String>,
    /// Phase of a motion in which it is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
    /// Band in which it is missing.
    #[serde(default, deserialize_with = "both_ends", skip_serializing_if = "Option::is_none")]
    pub band_hz: Option<[f64; 2]>,
    /// Anything else.
    #[serde(flatten)]
    pub more: serde_json::Map<String, Value>,
}

impl VerdictAnswer {
    /// In place of a verdict that was not given.
    pub fn failed(reason: &str) -> Self {
        let more = serde_json::Map::from_iter([("reason".to_string(), Value::from(reason))]);
        Self { kind: "failed".into(), effects: Vec::new(), interface: None, phase: None, band_hz: None, more }
    }

    /// Ids that it names, each once, in its order. Only two kinds name effects.
    pub fn named(&self) -> Vec<&str> {
        let mut ids = Vec::new();
        if ["effect", "ambiguous"].contains(&self.kind.as_str()) {
            for id in self.effects.iter().flat_map(|entry| entry.split('+')).map(str::trim) {
                if !ids.contains(&id) {
                    ids.push(id);
                }
            }
        }
        ids
    }

    /// The one id it names, if it names one effect alone.
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
    /// Share of the gap that it closes on held-out positions.
    #[serde(default)]
    pub closed: Option<f64>,
    /// Its 95 % interval.
    #[serde(default, deserialize_with = "both_ends")]
    pub closed95: Option<[f64; 2]>,
}

/// A place where something may be missing.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct WhereAnswer {
    /// Interface.
    #[serde(default)]
    pub interface: Option<String>,
    /// Phase of a motion.
    #[serde(default)]
    pub phase: Option<String>,
}

/// The parts of the gap that are scored.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct GapAnswer {
    /// Gap in each phase of a motion.
    #[serde(default)]
    pub by_phase: BTreeMap<String, Option<f64>>,
}

/// The model that is chosen.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct ChosenAnswer {
    /// Ids joined with `+`.
    #[serde(default)]
    pub id: String,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Share of the gap that it closes on held-out positions.
    #[serde(default)]
    pub closed: Option<f64>,
    /// Its 95 % interval.
    #[serde(default, deserialize_with = "both_ends")]
    pub closed95: Option<[f64; 2]>,
}

/// What motion records say beside.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct MotionAnswer {
    /// Further points of each record.
    #[serde(default)]
    pub transmission: Vec<ChannelAnswer>,
}

/// A further point in a record.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ChannelAnswer {
    /// Column.
    pub column: String,
    /// Force (N or N·m) that its unit weighs as much as.
    #[serde(default)]
    pub weight: f64,
}

/// The parts of diagnosis.json that are scored.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DiagnosisAnswer {
    /// Name and version of the document's form.
    pub schema: String,
    /// Ran to its end.
    pub complete: bool,
    /// Files it rests on.
    #[serde(default)]
    pub inputs: Vec<Input>,
    /// Parts of the machine that were set otherwise.
    #[serde(default)]
    pub overrides: Vec<String>,
    /// Effects that were taken out of it.
    #[serde(default)]
    pub without: Vec<String>,
    /// Gaps.
    #[serde(default)]
    pub gap: GapAnswer,
    /// Places, best first.
    #[serde(default, rename = "where")]
    pub places: Vec<WhereAnswer>,
    /// Candidates, best first.
    #[serde(default)]
    pub effects: Vec<EffectAnswer>,
    /// Parameters of the machine as described.
    #[serde(default)]
    pub described: BTreeMap<String, f64>,
    /// The model that is chosen.
    #[serde(default)]
    pub chosen: ChosenAnswer,
    /// What motion records say beside.
    #[serde(default)]
    pub motion: Option<MotionAnswer>,
    /// Verdict.
    pub verdict: VerdictAnswer,
}

impl DiagnosisAnswer {
    /// Force that the unit of each column weighs as much as in its gaps.
    pub fn weights(&self) -> BTreeMap<String, f64> {
        self.motion.iter().flat_map(|m| &m.transmission).map(|c| (c.column.clone(), c.weight)).collect()
    }
}

/// One run of the diagnosis, as it is kept in `diagnoses`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name and version of the document's form.
    pub schema: String,
    /// Digest of the program that ran.
    pub program_sha256: String,
    /// Digest of the case folder.
    pub case_sha256: String,
    /// Arguments it was given.
    pub arguments: Vec<String>,
    /// Exit code; absent where a signal or the time limit ended it.
    pub exit_code: Option<i32>,
    /// Seconds it took.
    pub seconds: f64,
    /// What it said on stderr, its last lines.
    pub said: String,
    /// The document it printed, where it printed one.
    pub diagnosis: Option<Value>,
}

/// An answer to be judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The diagnosis, or why there is none.
    pub diagnosis: Result<DiagnosisAnswer, String>,
    /// Seconds it took.
    pub seconds: f64,
}

impl Run {
    /// Schema of a kept run.
    pub const SCHEMA: &str = "jointid/withheld-run/1";

    /// The answer, if the run ended well, its document can be read, and it rests on the files of its case; else a failure that says why.
    pub fn answer(&self, files: &[Input]) -> Answer {
        Answer { diagnosis: self.read(files), seconds: self.seconds }
    }

    fn read(&self, files: &[Input]) -> Result<DiagnosisAnswer, String> {
        let mut lines = self.said.lines().map(str::trim).rev().filter(|line| !line.is_empty());
        let last = lines.clone().next().unwrap_or("it said nothing");
        let last = lines.find(|line| ["jointid:", "error:"].iter().any(|begin| line.starts_with(begin))).unwrap_or(last);
        match self.exit_code {
            Some(0) => {}
            Some(code) => return Err(format!("exit code {code}: {last}")),
            None => return Err(format!("it did not end by itself: {last}")),
        }
        let document = self.diagnosis.clone().ok_or("it printed no JSON document")?;
        let diagnosis: DiagnosisAnswer = serde_json::from_value(document).map_err(|e| format!("its document cannot be read: {e}"))?;
        if !diagnosis.schema.starts_with("jointid/diagnosis/") {
            return Err(format!("its document is {}, not a diagnosis", diagnosis.schema));
        }
        if !diagnosis.complete {
            return Err("its document is not complete".into());
        }
        match files.iter().find(|file| !diagnosis.inputs.iter().any(|input| input.sha256 == file.sha256)) {
            Some(file) => Err(format!("its document does not rest on the case's {}", file.path)),
            None => Ok(diagnosis),
        }
    }
}
