//! Identification from FRFs, or from modes.

use std::collections::BTreeMap;

use crate::{Study, StudyResult, document_rows};
use config::{MachineConfig, read_machine_text};
use identification::validation::cross_validation;
use identification::{IdentificationSettings, identify};
use measurement::{FitSet, HoldOutSet, MisplacedMode, misplaced_modes, with_fitting_orders};
use report::certainty::{RepeatRow, SearchRow};
use report::document::{IdentificationDocument, MisplacedModeRow, RenumberedRow};

impl Study {
    /// As [`Study::identify`], from FRFs or modes.
    pub(super) fn identify_from_responses(&self) -> StudyResult<IdentificationDocument> {
        let mut made = self.identification_settings()?;
        let of_loops = self.check_commanded()?;
        let (fit, held_out) = self.set.split(self.fit.as_deref(), &self.hold_out)?;
        let (machine, control) = (&self.config.machine, &self.control);
        made.contained = self.contained_fits(&made, (&fit, &held_out))?;
        let misplaced = if made.frf.is_some() { Vec::new() } else { misplaced_modes(&self.set) };
        let mut found = identify(machine, &fit, &held_out, &made, control)?;
        let renumbered = self.renumbered(&misplaced, &made)?;
        // Where nothing is held out, each position is predicted by a fit without it.
        let alone = held_out.is_empty();
        let predicted = if alone && found.complete {
            cross_validation(machine, &fit, &made, &found, control)?
        } else {
            None
        };
        found.complete &= !control.stopped();
        let leave_one_out = predicted.is_some();
        if let Some(predicted) = predicted {
            (found.fitted, found.fitted_frfs) = (predicted.modes, predicted.frfs);
        }
        let whole = made.frf.is_some();
        let names =
            |positions: &[usize], frfs: &[usize]| document_rows::names(&self.set, positions, frfs, whole);
        let fit_positions = names(fit.positions(), fit.frfs());
        let positions = document_rows::positions(self, &found, &fit_positions);
        let frfs = document_rows::all_frfs(&self.set, &found);
        let mut warnings = found.warnings.clone();
        warnings.extend(of_loops);
        warnings.extend(document_rows::pairing_warnings(&positions));
        let remedy = "a prior of one of them, such as a catalogue value, distinguishes them, or a measurement that plan proposes";
        warnings.extend(found.combinations.iter().map(|c| format!("{}; {remedy}", c.text)));
        warnings.extend(document_rows::passivity_warnings(machine, &self.set));
        let modes = self.natural_modes(&found)?;
        if whole {
            warnings.extend(document_rows::noise_warnings(&self.set));
            warnings.extend(self.modeless_warning(&modes));
        }
        warnings.splice(0..0, renumbered.iter().map(|r| r.warning(found.cost)));
        let mut derived = document_rows::derived(&positions, &frfs, leave_one_out);
        derived.extend(found.derived.iter().map(|d| (d.name.clone(), d.value)));
        derived.insert("chi_square".into(), found.chi_square);
        derived.insert("degrees_of_freedom".into(), found.degrees_of_freedom as f64);
        let interval =
            |d: &identification::DerivedEstimate| d.interval95.map(|(a, b)| (d.name.clone(), [a, b]));
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
            renumbered,
            derived,
            derived_interval95: found.derived.iter().filter_map(interval).collect(),
            combinations: document_rows::combinations(machine, &found),
            bootstrap: document_rows::bootstraps(machine, &found),
            cost: found.cost,
            evaluations: found.evaluations,
            search: Some(SearchRow {
                starts: found.effort.starts,
                found: found.effort.found,
                required: found.effort.required,
            }),
            searches_agree: found.agree,
            searches: found.repeats.iter().map(repeat).collect(),
            leave_one_out,
            fitted_parameters: free.chain(gain).collect(),
            correlation: found.certainty.correlation.clone(),
            held_out_positions: names(held_out.positions(), held_out.frfs()),
            fit_positions,
            positions,
            modes,
            posterior: found.posterior.as_ref().map(document_rows::posterior),
            frfs,
            ..IdentificationDocument::default()
        })
    }

    /// Fits the machine without its effects, and without each of them. Returns the values by name. An effect that
    /// another needs stays.
    fn contained_fits(
        &self,
        made: &IdentificationSettings,
        (fit, held_out): (&FitSet<'_>, &HoldOutSet<'_>),
    ) -> StudyResult<Vec<BTreeMap<String, f64>>> {
        let effects = &self.config.machine.effects;
        let singles = effects.iter().filter(|_| effects.len() > 1).map(std::slice::from_ref);
        let mut fits = Vec::new();
        for removed in std::iter::once(&effects[..]).filter(|all| !all.is_empty()).chain(singles) {
            let without = [&self.without, removed].concat();
            let MachineConfig { path, text, .. } = &self.config;
            let Ok(smaller) = read_machine_text(path, text, &self.overrides, &without) else { continue };
            let machine = smaller.machine;
            let plan = IdentificationSettings {
                frozen: made.frozen.iter().filter(|id| machine.parameter(id).is_some()).cloned().collect(),
                repeats: 1,
                profile: false,
                bootstrap: 0,
                contained: fits.clone(),
                ..made.clone()
            };
            let Ok(found) = identify(
                &machine,
                fit,
                held_out,
                &plan,
                &self.control.within(&format!("without {}", without.join("+"))),
            ) else {
                continue;
            };
            let names = found.machine.parameters.iter().map(|p| p.name().to_string());
            fits.push(names.zip(found.values.iter().copied()).collect());
        }
        Ok(fits)
    }

    /// Fits the set with misplaced modes at the orders they fit; `None` where there are none.
    fn renumbered(
        &self,
        misplaced: &[MisplacedMode],
        made: &IdentificationSettings,
    ) -> StudyResult<Option<RenumberedRow>> {
        if misplaced.is_empty() {
            return Ok(None);
        }
        let of = |m: &MisplacedMode| MisplacedModeRow {
            position: self.set.positions[m.position].name.clone(),
            order: m.order,
            frequency_hz: m.frequency_hz,
            fits_order: m.fits,
        };
        let row = RenumberedRow {
            modes: misplaced.iter().map(of).collect(),
            cost: None,
            parameters: BTreeMap::new(),
        };
        let set = with_fitting_orders(&self.set, misplaced);
        let (fit, held_out) = set.split(self.fit.as_deref(), &self.hold_out)?;
        if !misplaced.iter().any(|m| fit.positions().contains(&m.position)) {
            return Ok(Some(row));
        }
        let machine = &self.config.machine;
        let found = identify(machine, &fit, &held_out, made, &self.control.within("renumbered"))?;
        let names = document_rows::names(&self.set, fit.positions(), &[], false);
        Ok(Some(RenumberedRow {
            cost: Some(found.cost),
            parameters: document_rows::parameters(self, &found, &names),
            ..row
        }))
    }
}
