//! Identification from FRFs, or from modes.

use crate::{Study, StudyResult, document_rows};
use identification::identify;
use identification::validation::cross_validation;
use report::certainty::{RepeatRow, SearchRow};
use report::document::IdentificationDocument;

impl Study {
    /// As [`Study::identify`], from FRFs or modes.
    pub(super) fn identify_from_responses(&self) -> StudyResult<IdentificationDocument> {
        let made = self.identification_settings()?;
        let (fit, held_out) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let (machine, control) = (&self.config.machine, &self.control);
        let mut found = identify(machine, &fit, &held_out, &made, control)?;
        // Where nothing is held out, each position is predicted by a fit without it.
        let alone = held_out.is_empty();
        let predicted = if alone && found.complete { cross_validation(machine, &fit, &made, &found, control)? } else { None };
        found.complete &= !control.stopped();
        let leave_one_out = predicted.is_some();
        if let Some(predicted) = predicted {
            (found.fitted, found.fitted_frfs) = (predicted.modes, predicted.frfs);
        }
        let whole = made.frf.is_some();
        let names = |positions: &[usize], frfs: &[usize]| document_rows::names(&self.set, positions, frfs, whole);
        let fit_positions = names(fit.positions(), fit.frfs());
        let positions = document_rows::positions(self, &found, &fit_positions);
        let frfs = document_rows::all_frfs(&self.set, &found);
        let mut warnings = found.warnings.clone();
        warnings.extend(document_rows::pairing_warnings(&positions));
        warnings.extend(found.combinations.iter().map(|c| c.text.clone()));
        warnings.extend(document_rows::passivity_warnings(machine, &self.set));
        warnings.extend(whole.then(|| document_rows::noise_warnings(&self.set)).into_iter().flatten());
        let mut derived = document_rows::derived(&positions, &frfs, leave_one_out);
        derived.extend(found.derived.iter().map(|d| (d.name.clone(), d.value)));
        derived.insert("chi_square".into(), found.chi_square);
        derived.insert("degrees_of_freedom".into(), found.degrees_of_freedom as f64);
        let interval = |d: &identification::DerivedEstimate| d.interval95.map(|(a, b)| (d.name.clone(), [a, b]));
        let free = found.free.iter().map(|i| machine.parameters[*i].id.clone());
        let gain = (found.certainty.sd.len() > found.free.len()).then(|| "gain".to_string());
        let repeat = |r: &identification::Repeat| RepeatRow {
            seed: r.seed,
            cost: r.found.cost,
            evaluations: r.found.evaluations,
            trace: r.found.trace.clone(),
        };
        Ok(IdentificationDocument {
            stamp: self.stamp("identification", made.seed, found.complete, warnings),
            machine: self.machine_text(),
            manifest: self.manifest(),
            settings: self.run_settings(&made),
            parameters: document_rows::parameters(self, &found, &fit_positions),
            tolerances: document_rows::tolerances(&found.tolerances),
            basins: document_rows::basins(&found),
            derived,
            derived_interval95: found.derived.iter().filter_map(interval).collect(),
            combinations: document_rows::combinations(machine, &found),
            bootstrap: document_rows::bootstraps(machine, &found),
            cost: found.cost,
            evaluations: found.evaluations,
            search: Some(SearchRow { starts: found.effort.starts, found: found.effort.found, required: found.effort.required }),
            searches_agree: found.agree,
            searches: found.repeats.iter().map(repeat).collect(),
            leave_one_out,
            fitted_parameters: free.chain(gain).collect(),
            correlation: found.certainty.correlation.clone(),
            held_out_positions: names(held_out.positions(), held_out.frfs()),
            fit_positions,
            positions,
            frfs,
            records: Default::default(),
            preprocessing: None,
            friction_curve: Vec::new(),
        })
    }
}
