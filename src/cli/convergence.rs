//! `jointid convergence`: the lumped model against the number of lumps.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use super::arguments::ConvergenceArguments;
use super::common::{CommandResult, Loaded, Outcome, deliver, load, on_threads, plan, prepare, stamp, stop_flag, told, warn};
use super::progress::Progress;
use super::rows;
use crate::identification::{Plan, identify};
use crate::machine::{Machine, Operating};
use crate::measurement::{FitSet, HoldOutSet};
use crate::model::{Rods, Structure, undamped_modes};
use crate::optimizer::Control;
use crate::report::simulation::{Convergence, ConvergenceRow};

/// Highest frequency that is compared (Hz).
const HIGHEST_HZ: f64 = 2000.0;
/// Natural frequencies that are compared.
const COMPARED: usize = 4;

/// Runs the command.
pub fn run(given: &ConvergenceArguments) -> CommandResult {
    let mut counts = given.counts.clone();
    counts.sort_unstable();
    counts.dedup();
    if counts.len() != given.counts.len() {
        return Err("--counts: a number stands twice; name each once".into());
    }
    let loaded = load(&given.sources)?;
    let machine = &loaded.config.machine;
    if machine.shafts.is_empty() {
        return Err(format!("{}: has no [[shaft]] to be lumped; the model is the same for any number of lumps", loaded.config.path));
    }
    let asked = plan(&given.search, &loaded.set)?;
    let (fit, held_out) = loaded.set.split(given.positions.as_deref(), &[]).map_err(told)?;
    let folder = prepare(&given.output)?;
    let progress = Progress::begin(given.output.quiet, "convergence");
    let control = Control::new(stop_flag(), Some(progress.watcher()));
    let first = fit.positions.first().map(|p| Operating::at(loaded.set.positions[*p].nut_m));
    let condition = first.unwrap_or_else(|| Operating::at(machine.stroke_m().map(|s| 0.5 * s)));
    machine.check_operating("the first position", &condition).map_err(told)?;
    let mut rows = Vec::new();
    for rods in counts.iter().map(|n| Rods::Lumped(usize::from(*n))).chain([Rods::Exact]) {
        let row = row(&loaded, (&fit, &held_out), &asked, rods, &condition, given.search.threads, &control)?;
        rows.push(row);
        if control.stopped() {
            break;
        }
    }
    progress.end();
    let complete = !control.stopped();
    let document = Convergence {
        stamp: stamp("convergence", asked.seed, complete, &loaded, Vec::new()),
        nut_m: condition.nut_m,
        fit_positions: fit.positions.iter().map(|p| loaded.set.positions[*p].name.clone()).collect(),
        rows,
    };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "convergence.json", &document, &text(machine, &document))?;
    Ok(if complete { Outcome::Done } else { Outcome::Stopped })
}

fn row(
    loaded: &Loaded,
    (fit, held_out): (&FitSet<'_>, &HoldOutSet<'_>),
    asked: &Plan,
    rods: Rods,
    condition: &Operating,
    threads: Option<u16>,
    control: &Control,
) -> Result<ConvergenceRow, String> {
    let machine = &loaded.config.machine;
    let mut plan = asked.clone();
    plan.settings.rods = rods;
    if let Some(frf) = &mut plan.frf {
        frf.rods = rods;
    }
    let found = on_threads(threads, || identify(machine, fit, held_out, &plan, control))?.map_err(told)?;
    let fit_names: Vec<String> = fit.positions.iter().map(|p| loaded.set.positions[*p].name.clone()).collect();
    let positions = rows::positions(loaded, &found, &fit_names);
    let held_out_errors: BTreeMap<String, f64> =
        positions.iter().filter(|(_, row)| row.role != "fit").filter_map(|(name, row)| Some((name.clone(), row.overall_error?))).collect();
    Ok(ConvergenceRow {
        lumps: match rods {
            Rods::Exact => None,
            Rods::Lumped(lumps) => Some(lumps),
        },
        frequencies_hz: frequencies_hz(machine, rods, condition)?,
        parameters: machine.parameters.iter().zip(&found.values).map(|(p, x)| (p.id.clone(), *x)).collect(),
        fitted: found.free.iter().map(|i| machine.parameters[*i].id.clone()).collect(),
        cost: found.cost,
        held_out_errors,
    })
}

/// The first natural frequencies above 0 at the start values.
fn frequencies_hz(machine: &Machine, rods: Rods, condition: &Operating) -> Result<Vec<f64>, String> {
    let moving = machine.points.iter().position(|p| !p.fixed).ok_or("the machine has no point that moves")?;
    let structure = Arc::new(Structure::new(machine, moving, moving, rods).map_err(told)?);
    let mut network = structure.network();
    network.update(machine, &machine.start(), condition);
    let modes = undamped_modes(&network, HIGHEST_HZ, &mut structure.workspace());
    Ok(modes.iter().map(|m| m.frequency_hz).filter(|f| *f > 0.0).take(COMPARED).collect())
}

fn text(machine: &Machine, document: &Convergence) -> String {
    let exact = document.rows.iter().find(|row| row.lumps.is_none());
    let label = |row: &ConvergenceRow| row.lumps.map_or_else(|| "exact".to_string(), |n| n.to_string());
    let mut text = format!("{}\n\nnatural frequencies at the start values (Hz), and what is missing to the exact rod\n", machine.title);
    for row in &document.rows {
        let _ = write!(text, "{:>6}", label(row));
        for (at, f) in row.frequencies_hz.iter().enumerate() {
            let error = exact.and_then(|e| e.frequencies_hz.get(at)).map_or(f64::NAN, |e| f / e - 1.0);
            let _ = write!(text, " {f:>10.4} {:>9}", if row.lumps.is_some() { format!("{error:+.1e}") } else { String::new() });
        }
        text = text.trim_end().to_string() + "\n";
    }
    let stiff: Vec<&String> = exact.or(document.rows.last()).map(|row| row.fitted.iter().collect()).unwrap_or_default();
    let _ = writeln!(text, "\nidentified on {}, difference to the exact rod in %", document.fit_positions.join(", "));
    for id in stiff {
        let _ = write!(text, "{id:>6}");
        for row in &document.rows {
            let x = row.parameters.get(id).copied().unwrap_or(f64::NAN);
            let reference = exact.and_then(|e| e.parameters.get(id)).copied().unwrap_or(f64::NAN);
            let cell = if row.lumps.is_some() { format!("{x:.4e} {:+.2}", 100.0 * (x / reference - 1.0)) } else { format!("{x:.4e}") };
            let _ = write!(text, " {cell:>18}");
        }
        text.push('\n');
    }
    let _ = writeln!(text, "\nheld-out errors (Tian et al., Eq. 27) in %");
    for row in &document.rows {
        let _ = write!(text, "{:>6}", label(row));
        for (name, error) in &row.held_out_errors {
            let _ = write!(text, "  {name} {:.2}", 100.0 * error);
        }
        text.push('\n');
    }
    text
}
