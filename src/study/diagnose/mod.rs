//! Diagnosis: where model and machine disagree, which effect the description lacks, and how far including it
//! closes the gap.

mod effects;
mod facts;
mod learnable;
mod records;
mod residual_map;
mod responses;

use std::path::PathBuf;

pub use self::facts::FactsDocument;
use crate::{Study, StudyError, StudyResult};
pub use diagnosis::{Ablation, Policy, rules};
use diagnosis::{NullDistribution, Trial};
use numeric::statistics::median;
use report::diagnosis::{DiagnosisDocument, NullRow, RuleRow};

/// Where null simulations are cached.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum NullCache {
    /// Nowhere: they are simulated anew.
    #[default]
    None,
    /// In the platform's folder for caches.
    Platform,
    /// In this folder.
    Folder(PathBuf),
}

impl NullCache {
    fn folder(&self) -> Option<PathBuf> {
        match self {
            NullCache::None => None,
            NullCache::Folder(folder) => Some(folder.clone()),
            NullCache::Platform => platform_folder(),
        }
    }
}

/// Returns the platform's folder for caches.
fn platform_folder() -> Option<PathBuf> {
    let var = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = var("XDG_CACHE_HOME").or_else(|| var("LOCALAPPDATA")).or_else(|| {
        let home = var("HOME")?;
        Some(if cfg!(target_os = "macos") { home.join("Library/Caches") } else { home.join(".cache") })
    })?;
    Some(base.join("jointid"))
}

/// Candidates and method of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnosisRequest {
    /// Ids of the candidate effects; empty for all that apply.
    pub effects: Vec<String>,
    /// Ids of effects to leave out of the candidates.
    pub exclude: Vec<String>,
    /// Number of null simulations whose fits are made in full; 25 times as many for motion records.
    pub nulls: usize,
    /// Where null simulations are cached.
    pub cache: NullCache,
    /// Parts of the method to disable.
    pub ablated: Vec<Ablation>,
    /// Whether the facts are to hold what rules with other numbers may ask for, too.
    pub all_facts: bool,
}

impl Default for DiagnosisRequest {
    fn default() -> Self {
        DiagnosisRequest {
            effects: Vec::new(),
            exclude: Vec::new(),
            nulls: 40,
            cache: NullCache::None,
            ablated: Vec::new(),
            all_facts: false,
        }
    }
}

/// Returns the row of a rule and what came of it.
fn rule_row(Trial { rule, when, held, figures }: &Trial) -> RuleRow {
    RuleRow { rule: rule.clone(), when: when.clone(), held: *held, figures: figures.clone() }
}

/// Returns the laws of null simulations; `None` without draws.
fn null_row(null: &NullDistribution) -> Option<NullRow> {
    let of = |all: &[f64]| median(all.iter().copied());
    Some(NullRow {
        linear_draws: null.largest.len(),
        linear_median: of(&null.largest)?,
        fitted_draws: null.fitted.len(),
        fitted_median: of(&null.fitted),
        factor: null.factor(),
    })
}

impl Study {
    /// Diagnoses the discrepancy between machine and data with all effects that apply.
    ///
    /// # Errors  as [`Study::identify`]; fewer than two positions are fitted.
    pub fn diagnose(&self) -> StudyResult<DiagnosisDocument> {
        self.diagnose_with(&DiagnosisRequest::default())
    }

    /// As [`Study::diagnose`], with chosen candidates and method.
    ///
    /// # Errors  as [`Study::diagnose`]; an effect is unknown.
    pub fn diagnose_with(&self, request: &DiagnosisRequest) -> StudyResult<DiagnosisDocument> {
        Ok(self.diagnose_with_facts(request)?.0)
    }

    /// As [`Study::diagnose_with`], with everything on which the verdict rests; `None` for motion records that do
    /// not determine the machine.
    ///
    /// # Errors  as [`Study::diagnose_with`].
    pub fn diagnose_with_facts(
        &self,
        request: &DiagnosisRequest,
    ) -> StudyResult<(DiagnosisDocument, Option<FactsDocument>)> {
        self.check_observations()?;
        self.check_effects("effects", &request.effects)?;
        self.check_effects("exclude", &request.exclude)?;
        if !(20..=2000).contains(&request.nulls) {
            return Err(StudyError::setting(
                "nulls",
                request.nulls,
                "write a number of null simulations from 20 to 2000",
            ));
        }
        if self.is_on_motion() {
            return self.diagnose_records(request);
        }
        self.diagnose_responses(request).map(|(document, facts)| (document, Some(facts)))
    }
}
