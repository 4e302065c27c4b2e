//! `jointid hybrid`: a model, a neural network trained on its residual, and two axes on a circle.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayon::prelude::*;

use crate::arguments::{OutputArguments, Sources, SplitArguments};
use crate::identified::{check_identification, identified_values, read_identification};
use crate::long_work::{control, finish};
use crate::outcome::{CommandResult, deliver, prepare, to_message, warn};
use crate::progress::WorkProgress;
use crate::sources::{Loaded, inputs, load, load_again, stamp};
use dynamics::motion::{SimulationSettings, contour_error, simulate_record};
use identification::neural_residual::{Example, NeuralResidual, Trained};
use machine::{Machine, ParameterValues};
use measurement::MotionRecord;
use numeric::parallel::OrFirstError;
use numeric::statistics::quantile;
use optimizer::Control;
use report::columns;
use report::hybrid::{ContourRow, HybridDocument, HybridRow, NeuralResidualRow, Score};

/// Stride of the training examples among the samples of a record.
const EXAMPLE_STRIDE: usize = 4;
/// Number of starts of a training, each from other random weights.
const STARTS: usize = 6;
/// RMSE of the paper's Tab. 3 (µm), analytical and hybrid, by record.
const PUBLISHED: [(&str, f64, f64); 6] = [
    ("F1000", 2.91, 1.87),
    ("F2000", 2.83, 2.33),
    ("F3000", 3.15, 1.72),
    ("F4000", 3.84, 1.41),
    ("F5000", 4.89, 1.64),
    ("F6000", 6.21, 2.63),
];
/// Largest contour errors of its Tab. 4 (µm), analytical and hybrid, by record.
const PUBLISHED_CIRCLES: [(&str, f64, f64); 4] =
    [("circle-60", 7.19, 6.57), ("circle-80", 8.62, 5.34), ("circle-100", 10.26, 4.10), ("circle-120", 12.54, 6.95)];

/// Arguments of `hybrid`.
#[derive(Debug, clap::Args)]
pub struct HybridArguments {
    #[command(flatten)]
    pub sources: Sources,
    #[command(flatten)]
    pub split: SplitArguments,
    /// identification.json of the machine with the diagnosed effects, to compare with the network
    #[arg(long, value_name = "FILE")]
    pub result: Option<PathBuf>,
    /// Folder of a second axis's measurement set; records with the same name in both sets form circles
    #[arg(long, alias = "beside", value_name = "DIR")]
    pub second_axis: Option<String>,
    /// Override one key of the second axis's configuration, e.g. parameter.k_s.start=1e5
    #[arg(long, alias = "beside-set", value_name = "KEY=VALUE", requires = "second_axis")]
    pub second_axis_set: Vec<String>,
    /// identification.json of the second axis with the diagnosed effects
    #[arg(long, alias = "beside-result", value_name = "FILE", requires = "second_axis", requires = "result")]
    pub second_axis_result: Option<PathBuf>,
    /// Seed of the network's initial weights
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Measured and predicted travel of an axis's point by record, with the trained network.
struct HybridAxis {
    point: String,
    records: Vec<PredictedTravel>,
    trained: Trained,
    examples: usize,
}

struct PredictedTravel {
    name: String,
    fits: bool,
    command: Vec<f64>,
    measured: Vec<f64>,
    analytical: Vec<f64>,
    hybrid: Vec<f64>,
    physics: Option<Vec<f64>>,
}

/// Runs the command.
pub fn run(given: &HybridArguments) -> CommandResult {
    let loaded = load(&given.sources)?;
    let second_axis = match &given.second_axis {
        None => None,
        Some(set) => Some(load(&Sources {
            measurements: set.clone(),
            set: given.sources.set.iter().chain(&given.second_axis_set).cloned().collect(),
            ..given.sources.clone()
        })?),
    };
    let physics = given.result.as_ref().map(|path| identified(path, given, &loaded)).transpose()?;
    let second_physics =
        given.second_axis_result.as_ref().zip(second_axis.as_ref()).map(|(path, l)| identified(path, given, l)).transpose()?;
    let folder = prepare(&given.output)?;
    let runs = |l: &Loaded, with: bool| l.set.motions.len() * if with { 2 } else { 1 };
    let count = runs(&loaded, physics.is_some()) + second_axis.as_ref().map_or(0, |l| runs(l, second_physics.is_some()));
    let progress = WorkProgress::counted(given.output.quiet, "simulate records", count);
    let control = control(&given.output, folder.as_ref(), &progress, &loaded)?;
    let first = axis(given, &loaded, physics.as_ref(), (&control, &progress), "first");
    let second =
        first.as_ref().ok().and(second_axis.as_ref()).map(|l| axis(given, l, second_physics.as_ref(), (&control, &progress), "second"));
    progress.end();
    let (first, second) = (first?, second.transpose()?);
    let complete = !control.stopped();
    let contours = second.as_ref().map(|second| contours(&first, second)).unwrap_or_default();
    let mut stamp = stamp("hybrid", given.seed, complete, &loaded, Vec::new());
    stamp.inputs.extend(second_axis.iter().flat_map(inputs));
    stamp.inputs.extend(physics.map(|p| p.input));
    stamp.inputs.extend(second_physics.map(|p| p.input));
    if second.is_some() && contours.is_empty() {
        stamp.warnings.push("no record has the same name and length in both sets: there is no circle".into());
    }
    let records: BTreeMap<String, HybridRow> = first.records.iter().map(|r| (r.name.clone(), row(r))).collect();
    let held_out = || records.values().filter(|r| r.role == "held_out");
    let document = HybridDocument {
        point: first.point.clone(),
        network: NeuralResidualRow {
            residual_m: first.trained.residual_m,
            examples: first.examples,
            evaluations: first.trained.evaluations,
        },
        median_ratio: quantile(held_out().map(|r| r.hybrid.rmse_m / r.analytical.rmse_m), 0.5),
        median_physics_to_hybrid: quantile(held_out().filter_map(|r| Some(r.physics?.rmse_m / r.hybrid.rmse_m)), 0.5),
        contours,
        stamp,
        records,
    };
    warn(&given.output, &document.stamp.warnings);
    deliver(&given.output, folder.as_ref(), "hybrid.json", &document, &text(&document))?;
    Ok(finish(&given.output, &control, complete))
}

/// The machine as identified with the diagnosed effects.
struct Physics {
    machine: Machine,
    values: ParameterValues,
    input: report::document::Input,
}

fn identified(path: &std::path::Path, given: &HybridArguments, axis: &Loaded) -> Result<Physics, String> {
    let (found, input) = read_identification(path)?;
    check_identification(path, &found)?;
    let loaded = load_again(&found.settings.config, &axis.set.path, &found.stamp, (&given.sources.set, &[]))?;
    let values = identified_values(path, &found, &loaded.config)?;
    Ok(Physics { machine: loaded.config.machine, values, input })
}

/// Simulates all records of a set, and trains the network on the fitted ones.
fn axis(
    given: &HybridArguments,
    loaded: &Loaded,
    physics: Option<&Physics>,
    (control, progress): (&Control, &WorkProgress),
    part: &str,
) -> Result<HybridAxis, String> {
    let machine = &loaded.config.machine;
    let set = &loaded.set;
    if set.motions.is_empty() {
        return Err(format!("{}: holds no [[motion]] record; name a set that does with --measurements", set.path));
    }
    let split = set.split_motions(given.split.positions.as_deref(), &given.split.hold_out).map_err(to_message)?;
    let fit = split.fit();
    let column = |p: &&machine::Point| set.motions.iter().all(|m| m.others.contains_key(&format!("{}_m", p.name)));
    let point = machine.points.iter().find(column).ok_or_else(|| {
        let names: Vec<String> = machine.points.iter().filter(|p| !p.fixed).map(|p| format!("{}_m", p.name)).collect();
        format!("{}: its records have no column with the travel of a point; add one, such as {}", set.path, names.join(" or "))
    })?;
    let column = format!("{}_m", point.name);
    let kept = |machine: &Machine, values: &[f64], record: &MotionRecord, what: &str| {
        let name = format!("{part} {what} {}", record.name);
        let found = control.try_cached(&name, || predict(machine, values, record, &point.name, control));
        progress.step();
        found
    };
    let records: Result<Vec<PredictedTravel>, String> = set
        .motions
        .par_iter()
        .enumerate()
        .map(|(at, record)| {
            let analytical = kept(machine, &machine.start(), record, "analytical")?;
            let physics = physics.map(|p| kept(&p.machine, &p.values, record, "physics")).transpose()?;
            Ok(PredictedTravel {
                name: record.name.clone(),
                fits: fit.contains(&at),
                command: record.command_m.clone(),
                measured: record.others[&column].clone(),
                hybrid: Vec::new(),
                analytical,
                physics,
            })
        })
        .or_first_error();
    let mut records = records?;
    let examples: Vec<Example> = records
        .iter()
        .filter(|r| r.fits)
        .flat_map(|r| {
            let example =
                |i: usize| Example { command: r.command[i], modelled: r.analytical[i], deviation: r.measured[i] - r.analytical[i] };
            (0..r.measured.len()).step_by(EXAMPLE_STRIDE).map(example).collect::<Vec<_>>()
        })
        .collect();
    let trained = NeuralResidual::train(&examples, given.seed, STARTS, control.stop()).map_err(|e| format!("{}: {e}", set.path))?;
    for r in &mut records {
        let predict_hybrid = |(c, a): (&f64, &f64)| a + trained.network.deviation(*c, *a);
        r.hybrid = r.command.iter().zip(&r.analytical).map(predict_hybrid).collect();
    }
    Ok(HybridAxis { point: point.name.clone(), records, trained, examples: examples.len() })
}

/// Simulates the command of a record. Returns the travel of a point from its initial position.
fn predict(machine: &Machine, values: &[f64], record: &MotionRecord, point: &str, control: &Control) -> Result<Vec<f64>, String> {
    let go_on = || !control.stopped();
    let (trace, _) = simulate_record(machine, values, record, &SimulationSettings::default(), &go_on)
        .map_err(|e| format!("record {}: {e}", record.name))?;
    if let Some((time_s, error)) = trace.unstable {
        return Err(format!("record {}: the control loop diverges at {time_s} s, with a tracking error of {error:.3e} m", record.name));
    }
    let at = trace.points.iter().position(|p| p == point).ok_or_else(|| format!("point «{point}» has no inertia; give it one"))?;
    if !trace.complete {
        return Err("stopped before all records were simulated; there is no result yet".into());
    }
    let every = (trace.samples.len() - 1) / (record.samples() - 1);
    Ok(trace.samples.iter().step_by(every).take(record.samples()).map(|s| s.points[at]).collect())
}

fn score(predicted: &[f64], r: &PredictedTravel) -> Score {
    let off: Vec<f64> = predicted.iter().zip(&r.measured).map(|(a, b)| a - b).collect();
    let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0_f64, |m, x| m.max(x.abs()));
    let largest_m = largest(&mut off.iter().copied());
    let tracking = largest(&mut r.command.iter().zip(&r.measured).map(|(c, m)| c - m));
    Score { rmse_m: (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt(), largest_m, relative: largest_m / tracking }
}

fn role(fits: bool) -> String {
    if fits { "fit" } else { "held_out" }.into()
}

fn row(r: &PredictedTravel) -> HybridRow {
    HybridRow {
        role: role(r.fits),
        analytical: score(&r.analytical, r),
        hybrid: score(&r.hybrid, r),
        physics: r.physics.as_ref().map(|p| score(p, r)),
    }
}

/// Fits a circle to points by least squares. Returns its centre and radius.
fn circle(x: &[f64], y: &[f64]) -> Option<(f64, f64, f64)> {
    let row = |i: usize| [x[i], y[i], 1.0];
    let design = nalgebra::DMatrix::from_fn(x.len(), 3, |i, j| row(i)[j]);
    let right = nalgebra::DVector::from_fn(x.len(), |i, _| x[i] * x[i] + y[i] * y[i]);
    let solved = (design.transpose() * &design).lu().solve(&(design.transpose() * right))?;
    let (a, b) = (0.5 * solved[0], 0.5 * solved[1]);
    Some((a, b, (solved[2] + a * a + b * b).sqrt()))
}

/// Computes the contour errors of the records that both axes have.
fn contours(first: &HybridAxis, second: &HybridAxis) -> BTreeMap<String, ContourRow> {
    let pair = |r: &'_ PredictedTravel| second.records.iter().find(|s| s.name == r.name && s.measured.len() == r.measured.len());
    let row = |x: &PredictedTravel, y: &PredictedTravel| {
        let (a, b, radius) = circle(&x.command, &y.command)?;
        let error = |x: &[f64], y: &[f64]| contour_error(x, y, [a, b], radius);
        // Records whose commands do not form a circle have no contour error.
        let largest = |e: &[f64]| e.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
        if largest(&error(&x.command, &y.command)) > 1e-3 * radius {
            return None;
        }
        let measured = error(&x.measured, &y.measured);
        let off = |x: &[f64], y: &[f64]| {
            let predicted = error(x, y);
            largest(&predicted.iter().zip(&measured).map(|(a, b)| a - b).collect::<Vec<f64>>())
        };
        Some(ContourRow {
            role: role(x.fits && y.fits),
            measured_m: largest(&measured),
            analytical_off_m: off(&x.analytical, &y.analytical),
            hybrid_off_m: off(&x.hybrid, &y.hybrid),
            physics_off_m: x.physics.as_ref().zip(y.physics.as_ref()).map(|(x, y)| off(x, y)),
        })
    };
    first.records.iter().filter_map(|x| Some((x.name.clone(), row(x, pair(x)?)?))).collect()
}

fn text(document: &HybridDocument) -> String {
    let um = |x: f64| format!("{:.2}", 1e6 * x);
    let physics = document.records.values().any(|r| r.physics.is_some());
    let published = |of: &[(&str, f64, f64)], name: &str| {
        of.iter().find(|p| p.0 == name).map_or_else(String::new, |(_, a, h)| format!("{a:.2} / {h:.2}"))
    };
    let mut heads: Vec<String> = ["record", "role", "model RMSE µm", "with network"].map(String::from).to_vec();
    if physics {
        heads.push("with physics".into());
    }
    heads.push("paper".into());
    let cells = |(name, r): (&String, &HybridRow)| {
        let mut cells = vec![name.clone(), r.role.replace('_', " "), um(r.analytical.rmse_m), um(r.hybrid.rmse_m)];
        if physics {
            cells.push(r.physics.map_or_else(|| "–".into(), |p| um(p.rmse_m)));
        }
        cells.push(published(&PUBLISHED, name));
        cells
    };
    let mut text = format!("travel of «{}», predicted from the command\n", document.point);
    text += &columns(&heads, document.records.iter().map(cells));
    if let Some(ratio) = document.median_ratio {
        text += &format!("\nheld out, median: with the network the error is {:.0} % of the model's\n", 100.0 * ratio);
    }
    if let Some(ratio) = document.median_physics_to_hybrid {
        text += &match ratio {
            r if r <= 1.2 => {
                format!(
                    "the error with physics is {:.0} % of that with the network: physics lacks nothing that the network learns\n",
                    100.0 * r
                )
            }
            r => format!("the error with physics is {:.0} % of that with the network: an effect is still missing\n", 100.0 * r),
        };
    }
    if !document.contours.is_empty() {
        let mut heads: Vec<String> = ["circle", "role", "contour error µm", "model error µm", "with network"].map(String::from).to_vec();
        let physics = document.contours.values().any(|c| c.physics_off_m.is_some());
        if physics {
            heads.push("with physics".into());
        }
        heads.push("paper".into());
        let cells = |(name, c): (&String, &ContourRow)| {
            let mut cells = vec![name.clone(), c.role.replace('_', " "), um(c.measured_m), um(c.analytical_off_m), um(c.hybrid_off_m)];
            if physics {
                cells.push(c.physics_off_m.map_or_else(|| "–".into(), um));
            }
            cells.push(published(&PUBLISHED_CIRCLES, name));
            cells
        };
        text += "\nlargest contour errors\n";
        text += &columns(&heads, document.contours.iter().map(cells));
    }
    text
}
