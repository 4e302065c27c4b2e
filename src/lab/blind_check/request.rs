//! What a blind check checks, and on which cases.

use std::ffi::OsString;
use std::path::PathBuf;

use super::layouts::{Arm, Layouts};
use super::make_cases::CasePlan;
use reference_simulator::{Counts, motion};
use study::{StudyError, StudyResult};

/// Origin of the cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaseOrigin {
    /// The reference simulator, which is independent of the models.
    Independent,
    /// The models under test themselves, whose scores are optimistic.
    Own,
}

/// Number of cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CaseCount {
    /// The quick plan: about 120 cases, 80 in motion.
    Quick,
    /// The full plan: about 1300 cases, 700 in motion.
    Full,
    /// This number, drawn evenly from the smallest plan that has as many.
    Count(usize),
}

/// The program that diagnoses the cases: the command `jointid`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    /// Command to start, with its first arguments.
    pub command: Vec<OsString>,
    /// File whose digest tells versions of the program apart.
    pub file: PathBuf,
}

/// Cases of a blind check, and how each is diagnosed. A choice that is absent accepts that of cases already
/// in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlindCheckRequest {
    /// Kind of data; FRFs by default.
    pub arm: Option<Arm>,
    /// Number of cases; the quick plan by default.
    pub cases: Option<CaseCount>,
    /// Seed of the cases and of every diagnosis; 1 by default.
    pub seed: Option<u64>,
    /// Layouts of the machines; those of the catalogue by default, so that the cases of a seed stay what they
    /// were.
    pub layout: Option<Layouts>,
    /// Origin of the cases; independent by default.
    pub truth: Option<CaseOrigin>,
    /// Additional command-line arguments of every diagnosis.
    pub ablation: Vec<String>,
    /// Number of diagnoses in parallel; all cores by default.
    pub jobs: Option<usize>,
    /// Time limit (s) after which a diagnosis counts as failed.
    pub time_limit_s: u64,
    /// Names of the cases to diagnose, whose answers are kept for the scores of a later run; empty: all.
    pub only: Vec<String>,
    /// Whether the facts of each verdict are kept beside its answer.
    pub facts: bool,
}

impl Default for BlindCheckRequest {
    fn default() -> Self {
        BlindCheckRequest {
            arm: None,
            cases: None,
            seed: None,
            layout: None,
            truth: None,
            ablation: Vec::new(),
            jobs: None,
            time_limit_s: 1800,
            only: Vec::new(),
            facts: false,
        }
    }
}

/// Arguments of a diagnosis that its case determines.
const OF_THE_CASE: [&str; 9] = [
    "--config",
    "--measurements",
    "--freeze",
    "--seed",
    "--json",
    "--out",
    "--positions",
    "--hold-out",
    "--facts",
];

impl BlindCheckRequest {
    /// Checks the request.
    ///
    /// # Errors  an additional argument that the case determines, a combination or a number of cases that
    ///   does not exist, no diagnosis in parallel.
    pub(crate) fn check(&self) -> StudyResult<()> {
        if let Some(word) = self
            .ablation
            .iter()
            .find(|word| OF_THE_CASE.iter().any(|own| word.split('=').next() == Some(own)))
        {
            return Err(StudyError::setting(
                "ablation",
                "",
                format!("{word} is given by the case; leave it out"),
            ));
        }
        if self.jobs == Some(0) {
            return Err(StudyError::setting("jobs", 0, "write a number of diagnoses from 1"));
        }
        if self.arm == Some(Arm::Motion) && self.truth == Some(CaseOrigin::Own) {
            let fault =
                "the models' own cases are hammer tests only; choose the arm of FRFs, or leave the truth out";
            return Err(StudyError::setting("truth", "own", fault));
        }
        let names = Layouts::names(self.arm.unwrap_or(Arm::Frf));
        if let Some(Layouts::One(name)) = self.layout
            && !names.contains(&name)
        {
            let fault = format!(
                "is no layout of the arm {}; write all or one of {}",
                self.arm_name(),
                names.join(", ")
            );
            return Err(StudyError::setting("layout", name, fault));
        }
        self.planned().map(|_| ())
    }

    /// Returns the seed of the cases.
    pub(crate) fn case_seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// Returns the name of the arm.
    pub(crate) fn arm_name(&self) -> &'static str {
        match self.arm {
            None | Some(Arm::Frf) => "frf",
            Some(Arm::Motion) => "motion",
        }
    }

    /// Returns the name of the origin of the cases.
    pub(crate) fn truth_name(&self) -> &'static str {
        match self.truth {
            None | Some(CaseOrigin::Independent) => "independent",
            Some(CaseOrigin::Own) => "own",
        }
    }

    /// Returns the requested plan, and how many of its cases to make.
    ///
    /// # Errors  more cases than the full plan has.
    pub(crate) fn planned(&self) -> StudyResult<(Counts, usize)> {
        let counts = match self.arm {
            None | Some(Arm::Frf) => [Counts::QUICK, Counts::FULL],
            Some(Arm::Motion) => [motion::QUICK, motion::FULL],
        };
        let [quick, full] = counts.map(|counts| {
            (counts, CasePlan::new(self.arm_name(), self.layout, &counts, self.case_seed()).len())
        });
        match self.cases.unwrap_or(CaseCount::Quick) {
            CaseCount::Quick => Ok(quick),
            CaseCount::Full => Ok(full),
            CaseCount::Count(0) => {
                Err(StudyError::setting("cases", 0, "write quick, full or a number of cases from 1"))
            }
            CaseCount::Count(count) if count <= quick.1 => Ok((quick.0, count)),
            CaseCount::Count(count) if count <= full.1 => Ok((full.0, count)),
            CaseCount::Count(count) => {
                Err(StudyError::setting("cases", count, format!("the full plan has {}; write full", full.1)))
            }
        }
    }
}
