//! The steps of a blind check: cases, seal, diagnoses, scores.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::closed_share::closed_share;
use super::diagnose_cases::{CaseAnswers, diagnose_cases};
use super::make_cases::make_cases;
use super::request::{BlindCheckRequest, Program};
use crate::withheld::{
    Answer, CASES, CaseRow, FOLLOW_UP, Generator, Judgement, QUIET, Seal, SealRow, WithheldDocument, judge,
    label_of, scores,
};
use long_work::Control;
use numeric::parallel::OrFirstError;
use reference_simulator::Label;
use report::document::{Input, Stamp};
use study::{StudyError, StudyResult};
use study::{document_input, stamp_files};

/// A blind check of the diagnosis in a folder, in three steps: [`BlindCheck::seal`],
/// [`BlindCheck::diagnose`], [`BlindCheck::score`].
///
/// The steps are separate so that the seal can be published before anything is scored. A later check in the
/// same folder uses the cases and the diagnoses that are there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlindCheck {
    folder: PathBuf,
    request: BlindCheckRequest,
}

impl BlindCheck {
    /// Prepares a check in a folder, which need not exist.
    ///
    /// # Errors  an additional argument of the diagnoses that the case determines, a combination or a number
    ///   of cases that does not exist.
    pub fn new(folder: &Path, request: BlindCheckRequest) -> StudyResult<Self> {
        request.check()?;
        Ok(BlindCheck { folder: folder.into(), request })
    }

    /// Returns the sealed cases of the folder, or makes them; `None` if that was stopped.
    ///
    /// # Errors  the folder holds other cases, or changed ones; a file cannot be written.
    pub fn seal(&self, control: &Control) -> StudyResult<Option<Seal>> {
        let (counts, cases) = self.request.planned()?;
        let layout = self.request.layout.map(|layouts| layouts.name().to_owned());
        let (arm, truth, seed) =
            (self.request.arm_name(), self.request.truth_name(), self.request.case_seed());
        if !["seal.json", "labels.json", CASES, QUIET].iter().any(|name| self.folder.join(name).exists()) {
            let generator = Generator {
                version: env!("CARGO_PKG_VERSION").into(),
                arm: arm.into(),
                truth: truth.into(),
                seed,
                counts,
                layout: layout.clone(),
                cases,
            };
            return make_cases(&self.folder, &generator, control);
        }
        let (seal, _) = Seal::verified(&self.folder)?;
        let there = &seal.generator;
        let other = self.request.seed.is_some() && seed != there.seed
            || self.request.arm.is_some() && arm != there.arm
            || self.request.cases.is_some() && (counts, cases) != (there.counts, there.cases)
            || layout.is_some() && layout != there.layout
            || self.request.truth.is_some() && truth != there.truth;
        if other {
            let fault = format!(
                "holds other cases ({}, arm {}, layout {}, truth {}, seed {}); omit cases, arm, layout, seed and truth to use them, or name another folder",
                there.cases,
                there.arm,
                there.layout.as_deref().unwrap_or("of the catalogue"),
                there.truth,
                there.seed
            );
            return Err(StudyError::input(self.folder.display(), fault));
        }
        Ok(Some(seal))
    }

    /// Diagnoses every case with a program, the command `jointid`, as a separate process that receives only
    /// the case's folder.
    ///
    /// After a stop the answers given before it are returned.
    ///
    /// # Errors  the program cannot be run, or a result cannot be written.
    pub fn diagnose(&self, program: &Program, seal: &Seal, control: &Control) -> StudyResult<CaseAnswers> {
        diagnose_cases((&self.folder, &self.place()), program, seal, &self.request, control)
    }

    /// Scores the answers. Labels are read now, after the diagnoses, and only if the sealed files are
    /// unchanged.
    ///
    /// # Errors  a sealed file was changed, or a file of a case cannot be read.
    pub fn score(&self, given: &CaseAnswers, control: &Control) -> StudyResult<WithheldDocument> {
        let (seal, labels) = Seal::verified(&self.folder)?;
        let complete = !control.stopped() && given.answers.len() == seal.cases.len();
        let judged = given
            .answers
            .par_iter()
            .map(|(name, answer)| self.judged(&seal, &labels, name, answer))
            .or_first_error()?;
        let (names, judgements): (Vec<String>, Vec<Judgement>) = judged.into_iter().flatten().unzip();
        let inputs: StudyResult<Vec<Input>> =
            ["seal.json", "labels.json"].iter().map(|name| document_input(&self.folder.join(name))).collect();
        Ok(WithheldDocument {
            stamp: Stamp {
                seed: seal.generator.seed,
                complete,
                ..stamp_files("withheld", inputs?, warnings(&seal, &judgements))
            },
            seal: SealRow::from(&seal),
            program_sha256: given.program_sha256.clone(),
            ablation: self.request.ablation.clone(),
            jobs: given.jobs,
            threads_each: given.threads_each,
            sealed_cases: seal.cases.len(),
            not_made: seal.not_made.clone(),
            refused_machines: labels.iter().map(|label| label.refused).sum(),
            cases: names
                .iter()
                .zip(&judgements)
                .map(|(name, judgement)| CaseRow::new(name, judgement))
                .collect(),
            scores: scores(&judgements),
        })
    }

    /// Returns the path of the document inside the folder; with additional arguments of the diagnoses in a
    /// folder of its own.
    pub fn document_path(&self) -> PathBuf {
        self.place().join("withheld.json")
    }

    /// Returns the location of answers and scores inside the folder.
    fn place(&self) -> PathBuf {
        if self.request.ablation.is_empty() {
            return PathBuf::new();
        }
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        let name: Vec<String> = self
            .request
            .ablation
            .iter()
            .map(|word| word.trim_start_matches('-').chars().map(plain).collect())
            .collect();
        Path::new("ablation").join(name.join("_"))
    }

    /// Judges the answer to a case folder; `None` without a label.
    fn judged(
        &self,
        seal: &Seal,
        labels: &[Label],
        name: &str,
        answer: &Answer,
    ) -> StudyResult<Option<(String, Judgement)>> {
        let Some(label) = label_of(labels, name) else { return Ok(None) };
        let mut judgement = judge(label, name.ends_with(FOLLOW_UP), answer);
        if seal.generator.arm == "motion" {
            let has_quiet = seal.cases.iter().any(|case| case.name == name && case.quiet_sha256.is_some());
            let diagnosis =
                answer.diagnosis.as_ref().ok().filter(|_| has_quiet && judgement.closed.is_some());
            judgement.closed_truth =
                diagnosis.map(|of| closed_share(&self.folder, name, of)).transpose()?.flatten();
        }
        Ok(Some((name.into(), judgement)))
    }
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
