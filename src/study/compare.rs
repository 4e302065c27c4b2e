//! Comparison of multi-position with single-position identification, and of objectives with each other.

use std::collections::BTreeMap;

use crate::settings::kind_of_modes;
use crate::{Study, StudyError, StudyResult, document_rows};
use identification::objective::Objective;
use identification::validation::leave_one_out;
use identification::{IdentificationSettings, identify};
use report::document::{ComparisonDocument, ComparisonRun, ObjectiveRow, ObjectivesDocument};
use report::vocabulary::Role;

/// Name of the multi-position run in a comparison.
const MULTI: &str = "multi";
/// Objectives that are compared.
const OBJECTIVES: [Objective; 3] = [Objective::LeastSquares, Objective::Eq26, Objective::Frequencies];

impl Study {
    /// Compares the identification from all fitted positions with one from each of them alone, except the
    /// first.
    ///
    /// # Errors  as [`Study::identify`]; no position is held out of all runs.
    pub fn compare(&self) -> StudyResult<ComparisonDocument> {
        self.compare_with(None)
    }

    /// Compares the identification from all fitted positions with one from each of the `single` positions
    /// alone.
    ///
    /// # Errors  as [`Study::compare`]; a name is unknown.
    pub fn compare_with(&self, single: Option<&[String]>) -> StudyResult<ComparisonDocument> {
        self.check_responses("a comparison")?;
        let made = self.identification_settings()?;
        let (fit, held_out) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let whole = made.frf.is_some();
        let multi = document_rows::names(&self.set, fit.positions(), fit.frfs(), whole);
        let singles: Vec<String> = match single {
            Some(names) => names.to_vec(),
            None => multi.iter().skip(usize::from(multi.len() > 1)).cloned().collect(),
        };
        self.set.split(Some(&singles), &[])?;
        if singles.iter().any(|s| s == MULTI) {
            let fault = "this name is reserved for the multi-position run; rename the position";
            return Err(StudyError::setting("single", MULTI, fault));
        }
        let mut common = document_rows::names(&self.set, held_out.positions(), held_out.frfs(), whole);
        common.retain(|n| !singles.contains(n));
        if common.is_empty() {
            let fault = "no position is held out of all runs to compare them on; name fewer positions to fit, or fewer single ones";
            return Err(StudyError::impossible(fault));
        }
        let mut runs = BTreeMap::new();
        let mut complete = true;
        let plans = std::iter::once((MULTI.to_string(), multi))
            .chain(singles.into_iter().map(|s| (s.clone(), vec![s])));
        for (key, names) in plans {
            self.control.begin(&format!("identify {}", names.join(",")));
            let run = self.run_on(&names, &common, &made)?;
            complete &= run.1;
            runs.insert(key, run.0);
            if self.control.stopped() {
                break;
            }
        }
        let warnings: Vec<String> = runs
            .iter()
            .flat_map(|(k, r): (&String, &ComparisonRun)| r.warnings.iter().map(move |w| format!("{k}: {w}")))
            .collect();
        Ok(ComparisonDocument {
            stamp: self.stamp("comparison", made.seed, complete, warnings),
            common_positions: common,
            runs,
        })
    }

    /// Returns the number of identifications of a comparison with this number of single positions, or of one
    /// of objectives: the length of its progress.
    ///
    /// # Errors  a name of the split is unknown.
    pub fn runs_of_comparison(&self, single: Option<usize>, of_objectives: bool) -> StudyResult<usize> {
        let (fit, _) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let positions = fit.leave_one_out(!of_objectives && self.settings.fits_frfs(&self.set)).len();
        Ok(if of_objectives {
            OBJECTIVES.len() * positions
        } else {
            1 + single.unwrap_or(positions.saturating_sub(1).max(1))
        })
    }

    /// Identifies on the named positions. Returns the run, and whether it ran to completion.
    fn run_on(
        &self,
        names: &[String],
        common: &[String],
        made: &IdentificationSettings,
    ) -> StudyResult<(ComparisonRun, bool)> {
        let (fit, held_out) = self.set.split(Some(names), &[])?;
        let machine = &self.config.machine;
        let found = identify(machine, &fit, &held_out, made, &self.control)?;
        let positions = document_rows::positions(self, &found, names);
        let orders = || common.iter().filter_map(|c| positions.get(c)).flat_map(|p| &p.orders);
        let frfs = document_rows::all_frfs(&self.set, &found);
        let is_common = |name: Option<&String>| name.is_some_and(|n| common.contains(n));
        let of_common = frfs
            .iter()
            .filter(|r| r.role == Role::HeldOut && is_common(r.position.as_ref().or(r.record.as_ref())));
        let run = ComparisonRun {
            fit_positions: names.to_vec(),
            parameters: document_rows::parameters(self, &found, names),
            common_gap: document_rows::gap_over(of_common),
            common_error: document_rows::overall(orders(), |o| o.predicted_hz),
            common_error_published: document_rows::overall(orders(), |o| o.published_hz),
            warnings: found
                .warnings
                .iter()
                .cloned()
                .chain(document_rows::pairing_warnings(&positions))
                .collect(),
            positions,
        };
        Ok((run, found.complete))
    }

    /// Compares the objectives on modes by leave-one-out cross-validation over the fitted positions.
    ///
    /// # Errors  as [`Study::identify`]; the set has no modes.
    pub fn compare_objectives(&self) -> StudyResult<ObjectivesDocument> {
        if self.set.modes.is_none() {
            return Err(StudyError::input(
                &self.set.path,
                "has no modes, on which objectives are compared; name a set with modes",
            ));
        }
        let made = IdentificationSettings { frf: None, ..self.identification_settings()? };
        let (fit, _) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let scores = leave_one_out(&self.config.machine, &fit, &made, &OBJECTIVES, &self.control)?;
        let complete = !self.control.stopped();
        let folds = fit.leave_one_out(false);
        Ok(ObjectivesDocument {
            stamp: self.stamp("objectives", made.seed, complete, Vec::new()),
            positions: folds
                .iter()
                .flat_map(|(_, left)| left.positions())
                .map(|i| self.set.positions[*i].name.clone())
                .collect(),
            objectives: scores
                .into_iter()
                .map(|s| ObjectiveRow {
                    objective: kind_of_modes(s.objective),
                    frequency_error: s.frequency_error,
                    ln_amplitude_error: s.ln_amplitude_error,
                    missing: s.missing,
                })
                .collect(),
        })
    }
}
