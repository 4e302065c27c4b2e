//! `jointid convergence`: the lumped model against the number of lumps.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::arguments::{OutputArguments, SearchArguments, Sources};
use crate::document_rows;
use crate::long_work::{control, finish, on_threads};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::progress::WorkProgress;
use crate::search::plan;
use crate::sources::{Loaded, load, stamp};
use dynamics::model::{RodModel, Structure, undamped_modes};
use identification::{IdentificationSettings, identify};
use machine::{Machine, Operating};
use measurement::{FitSet, HoldOutSet};
use optimizer::Control;
use report::simulation::{ConvergenceDocument, ConvergenceRow};
use report::{columns, wrapped};

/// Arguments of `convergence`.
#[derive(Debug, clap::Args)]
pub struct ConvergenceArguments {
    #[command(flatten)]
    pub sources: Sources,
    /// Positions to fit, comma-separated; all others are held out
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub positions: Option<Vec<String>>,
    /// Numbers of lumps per rod, comma-separated
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "5,10,20,40", value_parser = clap::value_parser!(u16).range(1..=500))]
    pub counts: Vec<u16>,
    #[command(flatten)]
    pub search: SearchArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Upper limit of the compared natural frequencies (Hz).
const HIGHEST_HZ: f64 = 2000.0;
/// Number of natural frequencies compared.
const COMPARED: usize = 4;

/// Runs the command.
pub fn run(given: &ConvergenceArguments) -> CommandResult {
    let mut counts = given.counts.clone();
    counts.sort_unstable();
    counts.dedup();
    if counts.len() != given.counts.len() {
        return Err("--counts: a number is listed twice; write each once".into());
    }
    let loaded = load(&given.sources)?;
    let machine = &loaded.config.machine;
    if machine.shafts.is_empty() {
        return Err(format!("{}: has no [[shaft]] to lump; name a machine that has one", loaded.config.path));
    }
    let requested = plan(&given.search, &loaded.set)?;
    let (fit, held_out) = loaded.set.split(given.positions.as_deref(), &[]).map_err(to_message)?;
    let folder = prepare(&given.output)?;
    let progress = WorkProgress::searches(given.output.quiet, "convergence", requested.repeats * (counts.len() + 1));
    let control = control(&given.output, folder.as_ref(), &progress, &loaded)?;
    let first = fit.positions().first().map(|p| Operating::at(loaded.set.positions[*p].nut_m));
    let condition = first.unwrap_or_else(|| Operating::at(machine.stroke_m().map(|s| 0.5 * s)));
    machine.check_operating("the first position", &condition).map_err(to_message)?;
    let mut rows = Vec::new();
    for rods in counts.iter().map(|n| RodModel::Lumped(usize::from(*n))).chain([RodModel::Exact]) {
        let row = row(&loaded, (&fit, &held_out), &requested, rods, &condition, given.search.threads, &control)?;
        rows.push(row);
        if control.stopped() {
            break;
        }
    }
    progress.end();
    let complete = !control.stopped();
    let document = ConvergenceDocument {
        stamp: stamp("convergence", requested.seed, complete, &loaded, Vec::new()),
        nut_m: condition.nut_m,
        fit_positions: fit.positions().iter().map(|p| loaded.set.positions[*p].name.clone()).collect(),
        rows,
    };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "convergence.json", &document, &text(machine, &document))?;
    Ok(finish(&given.output, &control, complete))
}

fn row(
    loaded: &Loaded,
    (fit, held_out): (&FitSet<'_>, &HoldOutSet<'_>),
    requested: &IdentificationSettings,
    rods: RodModel,
    condition: &Operating,
    threads: Option<u16>,
    control: &Control,
) -> Result<ConvergenceRow, String> {
    let machine = &loaded.config.machine;
    let mut plan = requested.clone();
    plan.settings.rods = rods;
    if let Some(frf) = &mut plan.frf {
        frf.rods = rods;
    }
    let found = on_threads(threads, || identify(machine, fit, held_out, &plan, control))?.map_err(to_message)?;
    let fit_names: Vec<String> = fit.positions().iter().map(|p| loaded.set.positions[*p].name.clone()).collect();
    let positions = document_rows::positions(loaded, &found, &fit_names);
    let held_out_errors: BTreeMap<String, f64> =
        positions.iter().filter(|(_, row)| row.role != "fit").filter_map(|(name, row)| Some((name.clone(), row.overall_error?))).collect();
    Ok(ConvergenceRow {
        lumps: match rods {
            RodModel::Exact => None,
            RodModel::Lumped(lumps) => Some(lumps),
        },
        frequencies_hz: frequencies_hz(machine, rods, condition)?,
        parameters: machine.parameters.iter().zip(&found.values).map(|(p, x)| (p.id.clone(), *x)).collect(),
        fitted: found.free.iter().map(|i| machine.parameters[*i].id.clone()).collect(),
        cost: found.cost,
        held_out_errors,
    })
}

/// Computes the first natural frequencies above 0 (Hz) at the start values.
fn frequencies_hz(machine: &Machine, rods: RodModel, condition: &Operating) -> Result<Vec<f64>, String> {
    let moving = machine.points.iter().position(|p| !p.fixed).ok_or("the machine has no point that moves")?;
    let structure = Arc::new(Structure::new(machine, moving, moving, rods).map_err(to_message)?);
    let mut model = structure.empty_model();
    model.update(machine, &machine.start(), condition);
    let modes = undamped_modes(&model, HIGHEST_HZ, &mut structure.workspace());
    Ok(modes.iter().map(|m| m.frequency_hz).filter(|f| *f > 0.0).take(COMPARED).collect())
}

fn text(machine: &Machine, document: &ConvergenceDocument) -> String {
    let exact = document.rows.iter().find(|row| row.lumps.is_none());
    let label = |row: &ConvergenceRow| row.lumps.map_or_else(|| "exact".to_string(), |n| n.to_string());
    let relative = |x: f64, reference: Option<&f64>| reference.map_or_else(|| "–".into(), |r| format!("{:+.1e}", x / r - 1.0));
    let frequencies = document.rows.iter().map(|row| {
        let cells = row.frequencies_hz.iter().enumerate().flat_map(|(at, f)| {
            let difference = exact.filter(|_| row.lumps.is_some()).map(|e| relative(*f, e.frequencies_hz.get(at)));
            [format!("{f:.3}"), difference.unwrap_or_default()]
        });
        std::iter::once(label(row)).chain(cells).collect()
    });
    let orders = exact.map_or(0, |e| e.frequencies_hz.len());
    let header = |cells: Vec<String>| [vec!["lumps".to_string()], cells].concat();
    let heads = header((1..=orders).flat_map(|k| [format!("order {k}"), "difference".into()]).collect());
    let mut text = format!("{}\n\n", machine.title);
    text += &wrapped("natural frequencies at the start values (Hz), and their relative differences from the exact rod");
    text += &columns(&heads, frequencies);
    let fitted: Vec<String> = exact.or(document.rows.last()).map(|row| row.fitted.clone()).unwrap_or_default();
    text += &format!("\nparameters identified on {}: differences from the exact rod in %\n", document.fit_positions.join(", "));
    let lumped = document.rows.iter().filter(|row| row.lumps.is_some());
    let values = lumped.map(|row| {
        let cell = |id: &String| match (row.parameters.get(id), exact.and_then(|e| e.parameters.get(id))) {
            (Some(x), Some(reference)) => format!("{:+.2}", 100.0 * (x / reference - 1.0)),
            _ => "–".into(),
        };
        std::iter::once(label(row)).chain(fitted.iter().map(cell)).collect()
    });
    let reference = exact.map(|row| {
        let cell = |id: &String| row.parameters.get(id).map_or_else(|| "–".into(), |x| format!("{x:.2e}"));
        std::iter::once("exact".to_string()).chain(fitted.iter().map(cell)).collect()
    });
    text += &columns(&header(fitted.clone()), values.chain(reference));
    let names: Vec<String> = exact.map(|row| row.held_out_errors.keys().cloned().collect()).unwrap_or_default();
    if !names.is_empty() {
        text += "\nheld-out errors (Tian et al., Eq. 27) in %\n";
        let errors = document.rows.iter().map(|row| {
            let cell = |name: &String| row.held_out_errors.get(name).map_or_else(|| "–".into(), |e| format!("{:.2}", 100.0 * e));
            std::iter::once(label(row)).chain(names.iter().map(cell)).collect()
        });
        text += &columns(&header(names.clone()), errors);
    }
    text
}
