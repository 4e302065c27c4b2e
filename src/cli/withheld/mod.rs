//! `jointid withheld`: makes and seals cases, diagnoses each with the public command, and scores the answers.

pub mod arguments;
mod closed_share;
mod diagnose_cases;
mod make_cases;
mod own_cases;

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use self::arguments::{ArmName, CasesAsked, TruthName, WithheldArguments};
use crate::long_work::{on_threads, stop_flag};
use crate::outcome::{CommandResult, Outcome, deliver, prepare, print_out, to_message, warn};
use crate::sources::{document_input, stamp_files};
use numeric::parallel::OrFirstError;
use reference_simulator::{Counts, Label, motion};
use report::document::Stamp;
use report::to_json;
use withheld::{
    Answer, CASES, CaseRow, FOLLOW_UP, Generator, Judgement, QUIET, Seal, SealRow, WithheldDocument, judge, scores, scores_text,
};

/// Runs the command.
pub fn run(given: &WithheldArguments) -> CommandResult {
    if given.cases_only && given.output.out.is_none() {
        return Err("--cases-only requires a folder for the cases; name one with --out".into());
    }
    let ablation = ablation(&given.ablation)?;
    let kept = prepare(&given.output)?;
    let folder = CaseFolder::new(given.output.out.as_deref())?;
    let stop = stop_flag();
    let Some(seal) = sealed(given, folder.path(), &stop)? else {
        eprintln!("stopped before all cases were made; the same command resumes from there if it has an --out");
        return Ok(Outcome::Stopped);
    };
    // Printed before anything is scored; to stderr where stdout is for the document.
    match (given.output.json, given.output.quiet) {
        (false, _) => print_out(&seal.summary_text())?,
        (true, false) => eprint!("{}", seal.summary_text()),
        (true, true) => {}
    }
    if given.cases_only {
        if given.output.json {
            print_out(&to_json(&seal)?)?;
        }
        return Ok(Outcome::Done);
    }
    let place = place(&ablation);
    let plan = diagnose_cases::DiagnosisRunner::new(folder.path(), &place, &seal, &ablation, given)?;
    let answers = plan.all(&seal, &stop, given.output.quiet)?;
    // Labels are read after the diagnoses, and only if the sealed files are unchanged.
    let (seal, labels) = Seal::verified(folder.path())?;
    let complete = !stop.load(Ordering::Relaxed) && answers.len() == seal.cases.len();
    let judged: Result<Vec<Option<(String, Judgement)>>, String> = answers
        .par_iter()
        .map(|(name, answer)| {
            let Some((name, mut judgement)) = judged(&labels, name, answer) else { return Ok(None) };
            if seal.generator.arm == "motion" {
                let has_quiet = seal.cases.iter().any(|case| case.name == name && case.quiet_sha256.is_some());
                let diagnosis = answer.diagnosis.as_ref().ok().filter(|_| has_quiet && judgement.closed.is_some());
                judgement.closed_truth = diagnosis.map(|of| closed_share::closed(folder.path(), &name, of)).transpose()?.flatten();
            }
            Ok(Some((name, judgement)))
        })
        .or_first_error();
    let judged: Vec<(String, Judgement)> = judged?.into_iter().flatten().collect();
    let judgements: Vec<Judgement> = judged.iter().map(|(_, j)| j.clone()).collect();
    let inputs = ["seal.json", "labels.json"].map(|name| document_input(&folder.path().join(name)));
    let inputs = inputs.into_iter().collect::<Result<_, _>>()?;
    let document = WithheldDocument {
        stamp: Stamp { seed: seal.generator.seed, complete, ..stamp_files("withheld", inputs, warnings(&seal, &judgements)) },
        seal: SealRow::from(&seal),
        program_sha256: plan.program_sha256.clone(),
        ablation,
        jobs: plan.jobs,
        threads_each: plan.threads_each,
        sealed_cases: seal.cases.len(),
        cases: judged.iter().map(|(name, j)| CaseRow::new(name, j)).collect(),
        scores: scores(&judgements),
    };
    warn(&given.output, &document.stamp.warnings);
    let file = place.join("withheld.json");
    deliver(&given.output, kept.as_ref(), &file.to_string_lossy(), &document, &text(&document))?;
    Ok(if complete { Outcome::Done } else { Outcome::Stopped })
}

fn judged(labels: &[Label], name: &str, answer: &Answer) -> Option<(String, Judgement)> {
    let label = withheld::label_of(labels, name)?;
    Some((name.to_string(), judge(label, name.ends_with(FOLLOW_UP), answer)))
}

fn text(document: &WithheldDocument) -> String {
    let mut text = scores_text(&document.scores);
    if !document.stamp.complete {
        text = format!("\nStopped early: {} of {} case folders are diagnosed.\n{text}", document.cases.len(), document.sealed_cases);
    }
    text + &format!("\n{} diagnoses in parallel, on {} threads each\n", document.jobs, document.threads_each)
}

fn warnings(seal: &Seal, judged: &[Judgement]) -> Vec<String> {
    let mut warnings: Vec<String> = seal.not_made.iter().map(|why| format!("not made: {why}")).collect();
    if seal.generator.version != env!("CARGO_PKG_VERSION") {
        warnings.push(format!("the cases were made by version {}", seal.generator.version));
    }
    if seal.generator.truth == "own" {
        warnings.push(
            "the cases come from the models under test: these scores are optimistic, and only for comparison with independent cases".into(),
        );
    }
    let failed: Vec<&Judgement> = judged.iter().filter(|j| !j.answered).collect();
    if let Some(first) = failed.first() {
        let why = first.verdict.more.get("reason").and_then(|r| r.as_str()).unwrap_or_default();
        warnings.push(format!("{} of {} diagnoses failed; the first: {why}", failed.len(), judged.len()));
    }
    warnings
}

/// Splits the additional arguments of every diagnosis into words, and refuses those that the case determines.
fn ablation(text: &str) -> Result<Vec<String>, String> {
    let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
    let own = ["--config", "--measurements", "--freeze", "--seed", "--json", "--out", "--positions", "--hold-out"];
    match words.iter().find(|word| own.iter().any(|o| word.split('=').next() == Some(o))) {
        Some(word) => Err(format!("--ablation: {word} is given by the case; leave it out")),
        None => Ok(words),
    }
}

/// Returns the location of answers and scores inside the folder: that of the cases, or for an ablation a folder of its own.
fn place(ablation: &[String]) -> PathBuf {
    if ablation.is_empty() {
        return PathBuf::new();
    }
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let name: Vec<String> = ablation.iter().map(|word| word.trim_start_matches('-').chars().map(plain).collect()).collect();
    Path::new("ablation").join(name.join("_"))
}

/// Returns the name of an arm.
fn arm_name(arm: ArmName) -> &'static str {
    match arm {
        ArmName::Frf => "frf",
        ArmName::Motion => "motion",
    }
}

/// Returns the requested plan, and how many of its cases to make.
fn planned(arm: ArmName, cases: CasesAsked, seed: u64) -> Result<(Counts, usize), String> {
    let counts = match arm {
        ArmName::Frf => [Counts::QUICK, Counts::FULL],
        ArmName::Motion => [motion::QUICK, motion::FULL],
    };
    let [quick, full] = counts.map(|counts| (counts, make_cases::Plans::new(arm_name(arm), &counts, seed).len()));
    match cases {
        CasesAsked::Quick => Ok(quick),
        CasesAsked::Full => Ok(full),
        CasesAsked::Count(count) if count <= quick.1 => Ok((quick.0, count)),
        CasesAsked::Count(count) if count <= full.1 => Ok((full.0, count)),
        CasesAsked::Count(count) => Err(format!("--cases {count}: the full plan has {}; write full", full.1)),
    }
}

/// Returns the sealed cases of the folder, or makes them; `None` if that was stopped.
fn sealed(given: &WithheldArguments, folder: &Path, stop: &make_cases::Flag) -> Result<Option<Seal>, String> {
    let truth = |name| if name == TruthName::Own { "own" } else { "independent" };
    let seed = given.seed.unwrap_or(1);
    let arm = given.arm.unwrap_or(ArmName::Frf);
    if arm == ArmName::Motion && given.truth == Some(TruthName::Own) {
        return Err("--truth own: the models' own cases are hammer tests only; leave out --arm motion or --truth".into());
    }
    let (counts, cases) = planned(arm, given.cases.unwrap_or(CasesAsked::Quick), seed)?;
    if ["seal.json", "labels.json", CASES, QUIET].iter().any(|name| folder.join(name).exists()) {
        let (seal, _) = Seal::verified(folder)?;
        let there = &seal.generator;
        let other = given.seed.is_some_and(|seed| seed != there.seed)
            || given.arm.is_some_and(|arm| arm_name(arm) != there.arm)
            || given.cases.is_some() && (counts, cases) != (there.counts, there.cases)
            || given.truth.is_some_and(|name| truth(name) != there.truth);
        if other {
            return Err(format!(
                "{}: holds other cases ({}, arm {}, truth {}, seed {}); omit --cases, --arm, --seed and --truth to use them, or name another --out",
                folder.display(),
                there.cases,
                there.arm,
                there.truth,
                there.seed
            ));
        }
        return Ok(Some(seal));
    }
    let (arm, truth) = (arm_name(arm).to_string(), truth(given.truth.unwrap_or(TruthName::Independent)).to_string());
    let generator = Generator { version: env!("CARGO_PKG_VERSION").into(), arm, truth, seed, counts, cases };
    on_threads(given.jobs, || make_cases::make(folder, &generator, stop, given.output.quiet))?
}

/// The folder of a check. Without --out it is temporary, and removed at the end.
struct CaseFolder {
    path: PathBuf,
    temporary: bool,
}

impl CaseFolder {
    fn new(requested: Option<&Path>) -> Result<Self, String> {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_err(to_message)?;
        let name = format!("jointid-withheld-{}-{}", std::process::id(), now.as_nanos());
        let path = requested.map_or_else(|| std::env::temp_dir().join(name), Path::to_path_buf);
        Ok(Self { path, temporary: requested.is_none() })
    }

    fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for CaseFolder {
    fn drop(&mut self) {
        if self.temporary {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}
