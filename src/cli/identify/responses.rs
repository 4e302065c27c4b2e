//! `jointid identify` on FRFs, or on modes.

use super::arguments::IdentifyArguments;
use crate::document_rows;
use crate::long_work::{control, finish, on_threads};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::progress::WorkProgress;
use crate::search::{plan, settings};
use crate::sources::{Loaded, stamp};
use identification::objective::ObjectiveError;
use identification::validation::cross_validation;
use identification::{Identification, identify};
use report::document::{self, RunSettings};
use report::{bootstrap_table, derived_table, frfs_table, moved_tolerances, parameters_table, positions_table, wrapped};

/// Runs the command.
pub fn run(given: &IdentifyArguments, loaded: &Loaded) -> CommandResult {
    let plan = plan(&given.search, &loaded.set)?;
    let (fit, held_out) = loaded.set.split(given.split.positions.as_deref(), &given.split.hold_out).map_err(to_message)?;
    let folder = prepare(&given.output)?;
    let progress = WorkProgress::searches(given.output.quiet, "identify", plan.repeats);
    let control = control(&given.output, folder.as_ref(), &progress, loaded)?;
    let machine = &loaded.config.machine;
    let run = || -> Result<_, ObjectiveError> {
        let mut found = identify(machine, &fit, &held_out, &plan, &control)?;
        // Where nothing is held out, each position is predicted by a fit without it.
        let alone = held_out.is_empty();
        let predicted = if alone && found.complete { cross_validation(machine, &fit, &plan, &found, &control)? } else { None };
        found.complete &= !control.stopped();
        let left_one_out = predicted.is_some();
        if let Some(predicted) = predicted {
            (found.fitted, found.fitted_frfs) = (predicted.modes, predicted.frfs);
        }
        Ok((found, left_one_out))
    };
    let ran = on_threads(given.search.threads, run)?;
    progress.end();
    let (found, leave_one_out) = ran.map_err(to_message)?;
    let whole = plan.frf.is_some();
    let names = |positions: &[usize], frfs: &[usize]| document_rows::names(&loaded.set, positions, frfs, whole);
    let fit_positions = names(fit.positions(), fit.frfs());
    let positions = document_rows::positions(loaded, &found, &fit_positions);
    let frfs = document_rows::all_frfs(&loaded.set, &found);
    let mut warnings = found.warnings.clone();
    warnings.extend(document_rows::pairing_warnings(&positions));
    warnings.extend(found.combinations.iter().map(|c| c.text.clone()));
    warnings.extend(document_rows::passivity_warnings(machine, &loaded.set));
    let document = document::IdentificationDocument {
        stamp: stamp("identification", plan.seed, found.complete, loaded, warnings),
        settings: RunSettings {
            positions: given.split.positions.clone(),
            hold_out: given.split.hold_out.clone(),
            ..settings(&given.sources, &given.search, &plan)
        },
        parameters: document_rows::parameters(machine, &found),
        tolerances: document_rows::tolerances(&found.tolerances),
        basins: document_rows::basins(&found),
        derived: {
            let mut derived = document_rows::derived(&positions, &frfs, leave_one_out);
            derived.extend(found.derived.iter().map(|d| (d.name.clone(), d.value)));
            derived.insert("chi_square".into(), found.chi_square);
            derived.insert("degrees_of_freedom".into(), found.degrees_of_freedom as f64);
            derived
        },
        derived_interval95: found
            .derived
            .iter()
            .filter_map(|d| Some((d.name.clone(), d.interval95?)))
            .map(|(n, (a, b))| (n, [a, b]))
            .collect(),
        combinations: document_rows::combinations(machine, &found),
        bootstrap: document_rows::bootstraps(machine, &found),
        cost: found.cost,
        evaluations: found.evaluations,
        searches_agree: found.agree,
        searches: found
            .repeats
            .iter()
            .map(|r| document::RepeatRow {
                seed: r.seed,
                cost: r.found.cost,
                evaluations: r.found.evaluations,
                trace: r.found.trace.clone(),
            })
            .collect(),
        leave_one_out,
        fitted_parameters: {
            let free = found.free.iter().map(|i| machine.parameters[*i].id.clone());
            free.chain((found.certainty.sd.len() > found.free.len()).then(|| "gain".to_string())).collect()
        },
        correlation: found.certainty.correlation.clone(),
        held_out_positions: names(held_out.positions(), held_out.frfs()),
        fit_positions,
        positions,
        frfs,
        records: Default::default(),
        preprocessing: None,
        friction_curve: Vec::new(),
    };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "identification.json", &document, &text(loaded, &document, &found))?;
    Ok(finish(&given.output, &control, found.complete))
}

fn text(loaded: &Loaded, document: &document::IdentificationDocument, found: &Identification) -> String {
    let heading = format!(
        "fitted on {}, held out {}",
        document.fit_positions.join(", "),
        match (document.held_out_positions.is_empty(), document.leave_one_out) {
            (false, _) => document.held_out_positions.join(", "),
            (true, false) => "nothing".into(),
            (true, true) => "nothing; each position is predicted by a fit without it".into(),
        }
    );
    let mut text = format!("{}\n{}\n", loaded.config.machine.title, wrapped(&heading));
    text += &parameters_table(&document.parameters);
    text.push('\n');
    if let Some(moved) = moved_tolerances(&document.tolerances) {
        text += &moved;
        text.push('\n');
    }
    text += &if document.frfs.is_empty() {
        positions_table(&document.positions, document.leave_one_out)
    } else {
        frfs_table(&document.frfs, document.leave_one_out)
    };
    text.push('\n');
    if !found.derived.is_empty() {
        text += &derived_table(
            &document.derived,
            &document.derived_interval95,
            &found.derived.iter().map(|d| d.name.clone()).collect::<Vec<_>>(),
        );
        text.push('\n');
    }
    if !document.bootstrap.is_empty() {
        text += &bootstrap_table(&document.bootstrap);
        text.push('\n');
    }
    let percent = |key: &str| document.derived.get(key).map(|x| format!("{:.2} %", 100.0 * x));
    for (key, which) in [("largest_frequency_error_held_out", "held out"), ("largest_frequency_error_left_out", "left out")] {
        if let Some(largest) = percent(key) {
            text += &format!("largest frequency error, {which}: {largest}\n");
        }
    }
    if let Some(rms) = document.derived.get("ln_amplitude_rms_fit") {
        text += &format!("amplitude error at fitted positions: {rms:.3} rms of ln(amplitude)\n");
    }
    text += &format!(
        "cost {:.6} after {} evaluations in {} {}\n",
        found.cost,
        found.evaluations,
        found.repeats.len(),
        match found.agree {
            Some(true) => "searches, which agree",
            Some(false) => "searches, which do not agree",
            None if found.repeats.len() == 1 => "search",
            None => "searches",
        }
    );
    if !found.complete {
        text += "stopped early: the result so far\n";
    }
    text
}
