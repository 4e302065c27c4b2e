//! `jointid compare`: multi-position against single-position identification, or objectives against each other.

use std::collections::BTreeMap;

use crate::arguments::{OutputArguments, SearchArguments, Sources};
use crate::document_rows;
use crate::long_work::{control, finish, on_threads};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::progress::WorkProgress;
use crate::search::{objective_word, plan};
use crate::sources::{Loaded, load, stamp};
use identification::objective::Objective;
use identification::validation::leave_one_out;
use identification::{IdentificationSettings, identify};
use measurement::FitSet;
use numeric::statistics::root_sum_square;
use optimizer::Control;
use report::document::{ComparisonDocument, ComparisonRun, ObjectiveRow, ObjectivesDocument, OrderRow};
use report::{gap_summary_table, objectives_table, summary_table};

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions of the multi-position identification, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Positions to identify one by one, comma-separated; by default the fit positions except the first, as in the paper
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub single: Option<Vec<String>>,
    /// Compare objectives instead, by leave-one-out cross-validation over the fit positions
    #[arg(long, conflicts_with = "single")]
    pub objectives: bool,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &CompareArguments) -> CommandResult {
    let loaded = load(&given.sources)?;
    let plan = plan(&given.search, &loaded.set)?;
    let (fit, held_out) = loaded.set.split(given.positions.as_deref(), &[]).map_err(to_message)?;
    let folder = prepare(&given.output)?;
    // One multi-position run and one run per single position; or three objectives, each with one run per position left out.
    let runs = if given.objectives { 3 * fit.leave_one_out(false).len() } else { 1 + given.single.as_ref().map_or(2, Vec::len) };
    let searches = runs * plan.repeats;
    let progress = WorkProgress::searches(given.output.quiet, "compare", searches);
    let control = control(&given.output, folder.as_ref(), &progress, &loaded)?;
    if given.objectives {
        if loaded.set.modes.is_none() {
            return Err(format!(
                "{}: has no modes, on which --objectives compares; name a set with modes, or omit --objectives",
                loaded.set.path
            ));
        }
        let plan = IdentificationSettings { frf: None, ..plan };
        let scores = on_threads(given.search.threads, || compare_objectives(&loaded, &fit, &plan, &control))?;
        progress.end();
        let (document, complete) = scores?;
        deliver(&given.output, folder.as_ref(), "objectives.json", &document, &objectives_table(&document))?;
        return Ok(finish(&given.output, &control, complete));
    }
    let whole = plan.frf.is_some();
    let multi = document_rows::names(&loaded.set, fit.positions(), fit.frfs(), whole);
    let singles: Vec<String> = match &given.single {
        Some(names) => names.clone(),
        None => multi.iter().skip(usize::from(multi.len() > 1)).cloned().collect(),
    };
    loaded.set.split(Some(&singles), &[]).map_err(to_message)?;
    if singles.iter().any(|s| s == "multi") {
        return Err("--single multi: this name is reserved for the multi-position run; rename the position".into());
    }
    let mut common = document_rows::names(&loaded.set, held_out.positions(), held_out.frfs(), whole);
    common.retain(|n| !singles.contains(n));
    if common.is_empty() {
        return Err("no position is held out of all runs to compare them on; name fewer --positions or --single".into());
    }
    let mut runs = BTreeMap::new();
    let mut complete = true;
    let plans = std::iter::once(("multi".to_string(), multi)).chain(singles.into_iter().map(|s| (s.clone(), vec![s])));
    for (key, names) in plans {
        progress.now(&format!("identify {}", names.join(",")));
        let run = on_threads(given.search.threads, || identify_on(&loaded, &names, &common, &plan, &control))??;
        complete &= run.1;
        runs.insert(key, run.0);
        if control.stopped() {
            break;
        }
    }
    progress.end();
    let warnings: Vec<String> =
        runs.iter().flat_map(|(k, r): (&String, &ComparisonRun)| r.warnings.iter().map(move |w| format!("{k}: {w}"))).collect();
    let document =
        ComparisonDocument { stamp: stamp("comparison", plan.seed, complete, &loaded, warnings), common_positions: common, runs };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "comparison.json", &document, &text(&document))?;
    Ok(finish(&given.output, &control, complete))
}

fn text(document: &ComparisonDocument) -> String {
    let mut text =
        String::from("Frequency errors at the positions that no run has fitted, and over all of them\n(root of the summed squares)\n\n");
    if document.runs.values().any(|r| r.common_gap.is_some()) {
        return String::from("Gap of whole FRFs at the positions and records that no run has fitted, and over all of them\n\n")
            + &gap_summary_table(document);
    }
    text += &summary_table(document);
    text
}

/// Identifies on the named positions. Returns the run, and whether it ran to completion.
fn identify_on(
    loaded: &Loaded,
    names: &[String],
    common: &[String],
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<(ComparisonRun, bool), String> {
    let (fit, held_out) = loaded.set.split(Some(names), &[]).map_err(to_message)?;
    let machine = &loaded.config.machine;
    let found = identify(machine, &fit, &held_out, plan, control).map_err(to_message)?;
    let positions = document_rows::positions(loaded, &found, names);
    let over_common = |predicted: &dyn Fn(&OrderRow) -> Option<f64>| -> Option<f64> {
        let orders: Vec<&OrderRow> = common.iter().filter_map(|c| positions.get(c)).flat_map(|p| &p.orders).collect();
        let measured = orders.iter().filter(|o| o.measured_hz.is_some());
        let errors: Option<Vec<f64>> = measured.map(|o| Some(predicted(o)? / o.measured_hz? - 1.0)).collect();
        root_sum_square(errors?)
    };
    let run = ComparisonRun {
        fit_positions: names.to_vec(),
        parameters: document_rows::parameters(machine, &found),
        common_gap: {
            let all = document_rows::all_frfs(&loaded.set, &found);
            document_rows::gap_over(
                all.iter()
                    .filter(|r| r.role == "held_out" && r.position.as_ref().or(r.record.as_ref()).is_some_and(|n| common.contains(n))),
            )
        },
        common_error: over_common(&|o| o.predicted_hz),
        common_error_published: over_common(&|o| o.published_hz),
        warnings: found.warnings.iter().cloned().chain(document_rows::pairing_warnings(&positions)).collect(),
        positions,
    };
    Ok((run, found.complete))
}

fn compare_objectives(
    loaded: &Loaded,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<(ObjectivesDocument, bool), String> {
    let all = [Objective::LeastSquares, Objective::Eq26, Objective::Frequencies];
    let scores = leave_one_out(&loaded.config.machine, fit, plan, &all, control).map_err(to_message)?;
    let complete = !control.stopped();
    let document = ObjectivesDocument {
        stamp: stamp("objectives", plan.seed, complete, loaded, Vec::new()),
        positions: fit
            .leave_one_out(false)
            .iter()
            .flat_map(|(_, left)| left.positions())
            .map(|i| loaded.set.positions[*i].name.clone())
            .collect(),
        objectives: scores
            .into_iter()
            .map(|s| ObjectiveRow {
                objective: objective_word(s.objective).into(),
                frequency_error: s.frequency_error,
                ln_amplitude_error: s.ln_amplitude_error,
                missing: s.missing,
            })
            .collect(),
    };
    Ok((document, complete))
}
