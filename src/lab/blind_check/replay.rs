//! Replay: stored facts are judged again, by the rules as they are and with other numbers.

use std::path::Path;

use file_access::{MOST_DOCUMENT_BYTES, read_text};
use rayon::prelude::*;
use serde_json::Value;

use super::diagnose_cases::{DIAGNOSES, facts_file};
use crate::withheld::{Answer, CASES, FOLLOW_UP, Judgement, Run, Seal, files_of, judge, label_of};
use numeric::parallel::OrFirstError;
use reference_simulator::{Kind, Label};
use report::diagnosis::VerdictRow;
use study::{FactsDocument, Policy, StudyError, StudyResult};

/// A stored case: its facts, the answer that was given, and its label.
#[derive(Debug, Clone)]
pub struct StoredCase {
    name: String,
    facts: FactsDocument,
    answer: Answer,
    label: Label,
}

/// Counts over stored cases.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Replayed {
    /// Number of cases.
    pub cases: usize,
    /// Cases whose verdict differs from the one that was given, each with both.
    pub changed: Vec<String>,
    /// Cases whose facts do not suffice: a rule asks for what was not gathered.
    pub open: Vec<String>,
    /// Correct verdicts.
    pub right: usize,
    /// Cases whose verdict becomes correct, and is no longer correct.
    pub turned: [usize; 2],
    /// Verdicts that name one effect: those of an effect of the case, and all.
    pub single: [usize; 2],
    /// Machines that lack nothing: those on which a discrepancy is reported, and all.
    pub alarms: [usize; 2],
    /// Outside causes: those that are given the name of an effect, and all.
    pub outside: [usize; 2],
}

/// Reads the stored cases of a blind check whose facts were kept.
///
/// # Errors  the seal is broken; a file cannot be read, is cut or of another version.
pub fn stored_cases(folder: &Path) -> StudyResult<Vec<StoredCase>> {
    let (seal, labels) = Seal::verified(folder)?;
    let kept = folder.join(DIAGNOSES);
    let of = |case: &crate::withheld::SealedCase| -> StudyResult<Option<StoredCase>> {
        let path = facts_file(&kept, &case.name);
        let Some(label) = label_of(&labels, &case.name).filter(|_| path.exists()) else { return Ok(None) };
        let answer = kept.join(format!("{}.json", case.name));
        let fault = |fault: String| StudyError::input(answer.display(), fault);
        let text = read_text(&answer, MOST_DOCUMENT_BYTES).map_err(|error| fault(error.to_string()))?;
        let run: Run = serde_json::from_str(&text).map_err(|error| fault(error.to_string()))?;
        Ok(Some(StoredCase {
            name: case.name.clone(),
            facts: FactsDocument::read(&path)?,
            answer: run.answer(&files_of(&folder.join(CASES).join(&case.name))?),
            label: label.clone(),
        }))
    };
    let cases: Vec<Option<StoredCase>> = seal.cases.par_iter().map(of).or_first_error()?;
    let cases: Vec<StoredCase> = cases.into_iter().flatten().collect();
    if cases.is_empty() {
        let fault = "holds no facts; diagnose its cases with jointid lab withheld --facts";
        return Err(StudyError::input(kept.display(), fault));
    }
    Ok(cases)
}

/// Judges stored cases by the rules, without those of some names, and with numbers that a function changes.
pub fn replay(
    cases: &[StoredCase],
    left_out: &[String],
    changed: impl Fn(&Policy) -> Policy + Sync,
) -> Replayed {
    counted(cases, |facts| facts.judge(&changed(facts.policy()), left_out))
}

/// Judges stored cases by their probabilities.
pub fn by_evidence(cases: &[StoredCase]) -> Replayed {
    counted(cases, FactsDocument::by_evidence)
}

fn counted(cases: &[StoredCase], judged: impl Fn(&FactsDocument) -> Option<VerdictRow> + Sync) -> Replayed {
    let verdicts: Vec<Option<VerdictRow>> = cases.par_iter().map(|case| judged(&case.facts)).collect();
    let mut all = Replayed { cases: cases.len(), ..Replayed::default() };
    for (case, verdict) in cases.iter().zip(verdicts) {
        let Some(verdict) = verdict else {
            all.open.push(case.name.clone());
            continue;
        };
        let given = &case.facts.verdict;
        if stated(&verdict) != stated(given) {
            all.changed.push(format!("{}: {} -> {}", case.name, shown(given), shown(&verdict)));
        }
        all.add(case, &verdict);
    }
    all
}

/// What a verdict states.
fn stated(verdict: &VerdictRow) -> (String, &[String], &[String], Option<bool>) {
    (verdict.kind.to_string(), &verdict.effects, &verdict.faults, verdict.confirmed)
}

fn shown(verdict: &VerdictRow) -> String {
    let names = [verdict.effects.join(", "), verdict.faults.join(", ")].concat();
    let rule = verdict.rule.as_deref().unwrap_or_default();
    format!("{} {names} [{rule}]", verdict.kind).replace("  ", " ")
}

impl StoredCase {
    /// Compares a verdict with the label.
    fn judged(&self, verdict: &VerdictRow) -> Judgement {
        let mut answer = self.answer.clone();
        if let Ok(diagnosis) = &mut answer.diagnosis {
            let own = &mut diagnosis.verdict;
            own.kind = verdict.kind.to_string();
            own.effects.clone_from(&verdict.effects);
            own.faults.clone_from(&verdict.faults);
        }
        judge(&self.label, self.name.ends_with(FOLLOW_UP), &answer)
    }
}

impl Replayed {
    fn add(&mut self, case: &StoredCase, verdict: &VerdictRow) {
        let judged = case.judged(verdict);
        self.right += usize::from(judged.right);
        let was_right = case.judged(&case.facts.verdict).right;
        self.turned[0] += usize::from(judged.right && !was_right);
        self.turned[1] += usize::from(was_right && !judged.right);
        if let Some(is_right) = judged.single_right {
            self.single[0] += usize::from(is_right);
            self.single[1] += 1;
        }
        let counted = match judged.kind {
            Kind::Null => (&mut self.alarms, judged.claims),
            Kind::Unknown => (&mut self.outside, judged.names > 0),
            _ => return,
        };
        counted.0[0] += usize::from(counted.1);
        counted.0[1] += 1;
    }
}

/// Returns the names of the numbers that can be changed.
pub fn numbers(cases: &[StoredCase]) -> Vec<String> {
    let policy = cases.first().map(|case| serde_json::to_value(case.facts.policy()));
    let Some(Ok(Value::Object(fields))) = policy else { return Vec::new() };
    fields.into_iter().filter(|(_, value)| value.is_number()).map(|(name, _)| name).collect()
}

/// Returns a policy with one number changed by a function; `None` where it has no such number.
pub fn with_number(policy: &Policy, name: &str, change: impl Fn(f64) -> f64) -> Option<Policy> {
    let mut fields = serde_json::to_value(policy).ok()?;
    let value = fields.get_mut(name)?;
    let to = change(value.as_f64()?).min(f64::MAX);
    *value = if value.is_u64() { Value::from(to.round() as u64) } else { Value::from(to) };
    serde_json::from_value(fields).ok()
}
