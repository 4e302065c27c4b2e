//! `jointid identify` on motion records.

use std::collections::BTreeMap;

use crate::arguments::ObjectiveName;
use crate::delivery::{CommandResult, deliver, prepare, told, warn};
use crate::identify::arguments::IdentifyArguments;
use crate::long_work::{control, ended, on_threads};
use crate::progress::Progress;
use crate::search::{check_frozen, plan, settings};
use crate::sources::{Loaded, stamp};
use dynamics::inverse_dynamics::{Estimated, Fit, Motion, correlation, estimate_weighed, free_parameters, recorded, unseen};
use identification::{output_error, simulated_gaps};
use measurement::MotionRecord;
use report::document::{Identification, ParameterRow, PositionRow, Settings};
use report::record::RecordRow;
use report::{parameters_table, wrapped};

/// Runs the command.
pub fn identify(given: &IdentifyArguments, loaded: &Loaded) -> CommandResult {
    let simulated = match given.search.objective {
        None | Some(ObjectiveName::InverseDynamics) => false,
        Some(ObjectiveName::OutputError) => true,
        Some(_) => {
            return Err(format!("--objective: {} holds motion records alone; write inverse-dynamics or output-error", loaded.set.path));
        }
    };
    let plan = plan(&given.search, &loaded.set)?;
    let machine = &loaded.config.machine;
    check_frozen(loaded, &plan.frozen)?;
    let (fit, held_out) = loaded.set.split_motions(given.split.positions.as_deref(), &given.split.hold_out).map_err(told)?;
    let (mut motions, rigid, mut warnings) = super::prepared(loaded)?;
    let folder = prepare(&given.output)?;
    let asked = free_parameters(machine, &plan.frozen).map_err(told)?;
    let unseen = unseen(&rigid, machine, &asked, &fit.iter().map(|i| &motions[*i]).collect::<Vec<&Motion>>());
    let free: Vec<usize> = asked.into_iter().filter(|i| !unseen.contains(i)).collect();
    if free.is_empty() {
        return Err("--freeze: keeps every parameter of the machine; leave one free".into());
    }
    let progress = Progress::begin(given.output.quiet, "identify");
    let control = control(&given.output, folder.as_ref(), &progress, loaded)?;
    let ran = on_threads(given.search.threads, || {
        let mut found = estimate_weighed(&rigid, machine, &free, &mut motions, &fit)?;
        let fitted: Vec<&Motion> = fit.iter().map(|i| &motions[*i]).collect();
        let mut complete = true;
        let mut estimates = found.estimates(machine, &free, &fitted);
        if simulated {
            progress.now("simulate");
            let records: Vec<&MotionRecord> = fit.iter().map(|i| &loaded.set.motions[*i]).collect();
            let closed = output_error(machine, &found.values, &free, &records, &control)?;
            complete = closed.complete;
            let length = |i: &usize| (loaded.set.motions[*i].samples(), motions[*i].period.map(|p| p * motions[*i].recipe.factor));
            let lengths: Vec<(usize, Option<usize>)> = fit.iter().map(length).collect();
            found = Fit {
                squares: closed.residual.norm_squared(),
                values: closed.values,
                free: free.clone(),
                residual: closed.residual,
                derivatives: closed.derivatives,
                evaluations: found.evaluations + closed.evaluations,
            };
            estimates = found.estimates_of(machine, &free, &lengths);
        }
        Ok::<_, dynamics::inverse_dynamics::InverseError>((found, estimates, complete))
    })?;
    let (found, mut estimates, mut complete) = ran.map_err(told)?;
    let fitted: Vec<&Motion> = fit.iter().map(|i| &motions[*i]).collect();
    let shown_nowhere = |i: &usize| Estimated { parameter: *i, value: found.values[*i], interval: None, at_bound: false };
    estimates.extend(unseen.iter().map(shown_nowhere));
    let values = &found.values;
    let role = |at: &usize| if fit.contains(at) { "fit" } else { "held_out" };
    let mut records: BTreeMap<String, RecordRow> = (0..motions.len())
        .map(|at| {
            let row = super::record_row(&rigid, machine, values, &motions[at], loaded.set.motions[at].samples(), role(&at));
            (motions[at].name.clone(), row)
        })
        .collect();
    if simulated {
        let all: Vec<&MotionRecord> = loaded.set.motions.iter().collect();
        let gaps = on_threads(given.search.threads, || simulated_gaps(machine, values, &all, &control))?.map_err(told)?;
        for (record, gap) in all.iter().zip(gaps) {
            complete &= gap.is_some();
            if let (Some(row), Some(gap)) = (records.get_mut(&record.name), gap) {
                row.simulated_force_error = Some(gap.force);
            }
        }
    }
    progress.end();
    let error = |r: &RecordRow| if simulated { r.simulated_force_error } else { Some(r.force_error) };
    let level = if simulated {
        let all = fit.iter().flat_map(|i| loaded.set.motions[*i].load.samples());
        all.map(|x| x * x).sum::<f64>()
    } else {
        recorded(&fitted).norm_squared()
    };
    if !unseen.is_empty() {
        let ids: Vec<&str> = unseen.iter().map(|i| machine.parameters[*i].id.as_str()).collect();
        warnings.push(format!("neither the force nor a further point shows {}: left at the start", ids.join(", ")));
    }
    for e in estimates.iter().filter(|e| e.at_bound) {
        let p = &machine.parameters[e.parameter];
        warnings.push(format!("{} stands at an end of its range, {} … {} {}", p.id, p.lower, p.upper, p.unit));
    }
    let document = Identification {
        stamp: stamp("identification", plan.seed, complete, loaded, warnings),
        settings: Settings {
            objective: if simulated { "output-error" } else { "inverse-dynamics" }.into(),
            positions: given.split.positions.clone(),
            hold_out: given.split.hold_out.clone(),
            ..settings(&given.sources, &given.search, &plan)
        },
        parameters: parameter_rows(loaded, values, &estimates),
        derived: derived(&records, error),
        derived_interval95: BTreeMap::new(),
        combinations: Vec::new(),
        bootstrap: Vec::new(),
        cost: found.squares / level,
        evaluations: found.evaluations,
        searches_agree: None,
        searches: Vec::new(),
        leave_one_out: false,
        fitted_parameters: free.iter().map(|i| machine.parameters[*i].id.clone()).collect(),
        correlation: correlation(&found.derivatives),
        fit_positions: super::names(&loaded.set, &fit),
        held_out_positions: super::names(&loaded.set, &held_out),
        positions: positions(&records, error),
        frfs: Vec::new(),
        recipe: motions.first().map(|m| super::recipe_row(&m.recipe)),
        friction_curve: super::curve_rows(&rigid, machine, values, &fitted),
        records,
    };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "identification.json", &document, &text(loaded, &document))?;
    Ok(ended(&given.output, &control, document.stamp.complete))
}

fn parameter_rows(loaded: &Loaded, values: &[f64], estimates: &[Estimated]) -> BTreeMap<String, ParameterRow> {
    let parameters = &loaded.config.machine.parameters;
    let row = |(at, p): (usize, &machine::Parameter)| {
        let found = estimates.iter().find(|e| e.parameter == at);
        let interval = found.and_then(|e| e.interval).map(|i| [values[at] - i.half95, values[at] + i.half95]);
        // Seen where the interval is narrower than the range.
        let seen = found.map(|_| interval.is_some_and(|[a, b]| b - a < 0.5 * (p.upper - p.lower)));
        let row = ParameterRow {
            value: values[at],
            unit: p.unit.clone(),
            lower: p.lower,
            upper: p.upper,
            interval95: interval,
            identifiable: seen,
            fitted: found.is_some(),
        };
        (p.id.clone(), row)
    };
    parameters.iter().enumerate().map(row).collect()
}

/// Records where documents have positions: their force error is their gap.
pub(super) fn positions(records: &BTreeMap<String, RecordRow>, error: impl Fn(&RecordRow) -> Option<f64>) -> BTreeMap<String, PositionRow> {
    let row = |(name, r): (&String, &RecordRow)| {
        let row = PositionRow {
            role: r.role.clone(),
            overall_error: None,
            overall_error_rounded: None,
            overall_error_published: None,
            orders: Vec::new(),
            lone_peaks: Vec::new(),
            gap: error(r),
            noise_floor: r.noise_floor,
        };
        (name.clone(), row)
    };
    records.iter().map(row).collect()
}

fn derived(records: &BTreeMap<String, RecordRow>, error: impl Fn(&RecordRow) -> Option<f64>) -> BTreeMap<String, f64> {
    let over = |role: &str| {
        let own = records.values().filter(|r| r.role == role).filter_map(|r| Some((error(r)?, r.compared)));
        numeric::statistics::root_mean_square_of_parts(own)
    };
    [("gap_fit", over("fit")), ("gap_held_out", over("held_out"))].into_iter().filter_map(|(k, x)| Some((k.to_string(), x?))).collect()
}

fn text(loaded: &Loaded, document: &Identification) -> String {
    let held_out = if document.held_out_positions.is_empty() { "nothing".into() } else { document.held_out_positions.join(", ") };
    let mut text = format!(
        "{}\n{}\n{}\n{}",
        loaded.config.machine.title,
        wrapped(&format!("fitted on {} by {}, held out {held_out}", document.fit_positions.join(", "), document.settings.objective)),
        parameters_table(&document.parameters),
        report::record::records_table(&document.records)
    );
    if !document.stamp.complete {
        text += "stopped early: this is what was known\n";
    }
    text
}
