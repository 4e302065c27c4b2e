//! Prediction of travel by a model, with a neural network trained on its residual; with two axes also of
//! circles.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::simulation::contour_error;
use config::{read_machine, read_machine_text};
use dynamics::motion::{SimulationSettings, simulate_record};
use identification::neural_residual::{Example, NeuralResidual, Trained};
use long_work::Control;
use machine::{Machine, ParameterValues, Point};
use measurement::MotionRecord;
use numeric::parallel::OrFirstError;
use numeric::statistics::quantile;
use report::document::Input;
use report::hybrid::{ContourRow, HybridDocument, HybridRow, NeuralResidualRow, PhysicsRow, Score};
use study::{Study, StudyError, StudyResult, check_identification, read_identification};

/// Stride of the training examples among the samples of a record.
const EXAMPLE_STRIDE: usize = 4;
/// Number of starts of a training, each from other random weights.
const STARTS: usize = 6;

/// Comparison of models that predict the travel of an axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HybridRequest {
    /// Names of the records to fit, on both axes; all others are held out. Where absent, those of each study.
    pub fit: Option<Vec<String>>,
    /// Names of records to hold out, on both axes. Where empty, those of each study.
    pub hold_out: Vec<String>,
    /// `identification.json` of the machine with the diagnosed effects, to compare with the network.
    pub result: Option<PathBuf>,
    /// `identification.json` of the second axis with the diagnosed effects.
    pub second_axis_result: Option<PathBuf>,
    /// Seed of the network's initial weights.
    pub seed: u64,
}

impl Default for HybridRequest {
    fn default() -> Self {
        HybridRequest { fit: None, hold_out: Vec::new(), result: None, second_axis_result: None, seed: 1 }
    }
}

impl HybridRequest {
    /// Returns a text of everything on which the work depends beside the first axis: the request, the second
    /// axis, and the content of the results.
    ///
    /// # Errors  a result cannot be read.
    pub fn work(&self, second: Option<&Study>) -> StudyResult<String> {
        let results = [&self.result, &self.second_axis_result].into_iter().flatten();
        let results =
            results.map(|path| Ok(read_identification(path)?.1)).collect::<StudyResult<Vec<Input>>>()?;
        Ok(format!(
            "hybrid {self:?} {results:?} {}",
            second.map(|axis| axis.key("second axis")).unwrap_or_default()
        ))
    }
}

/// Predicts the travel of an axis by its machine, and by the machine with a neural network. Records with the
/// same name in the set of a second axis form circles. Progress and stop are those of the first study.
///
/// # Errors  a set has no motion record or no column with the travel of a point; a result does not fit its
///   machine; a simulation diverges or is
/// stopped.
pub fn hybrid(
    study: &Study,
    second_axis: Option<&Study>,
    request: &HybridRequest,
) -> StudyResult<HybridDocument> {
    let identified = |path: &PathBuf, axis: &Study| Physics::read(path, axis, study.overrides());
    let physics = request.result.as_ref().map(|path| identified(path, study)).transpose()?;
    let second_physics = request
        .second_axis_result
        .as_ref()
        .zip(second_axis)
        .map(|(path, axis)| identified(path, axis))
        .transpose()?;
    let runs = |axis: &Study, with: bool| axis.measurements().motions.len() * if with { 2 } else { 1 };
    let count =
        runs(study, physics.is_some()) + second_axis.map_or(0, |axis| runs(axis, second_physics.is_some()));
    let step = study.control().steps("simulate records", count);
    let first = predict_axis(study, physics.as_ref(), request, (study.control(), &step), "first")?;
    let second = second_axis
        .map(|axis| predict_axis(axis, second_physics.as_ref(), request, (study.control(), &step), "second"))
        .transpose()?;
    let contours = second.as_ref().map(|second| contours(&first, second)).unwrap_or_default();
    let mut stamp = study.stamp("hybrid", request.seed, !study.control().stopped(), Vec::new());
    stamp.inputs.extend(second_axis.iter().flat_map(|axis| axis.inputs()));
    let named = |physics: Option<Physics>, axis: Option<&Study>| {
        Some((physics?, &axis?.measurements().path)).map(|(p, set)| p.named(set))
    };
    let (physics, second_physics) = (named(physics, Some(study)), named(second_physics, second_axis));
    stamp.inputs.extend([&physics, &second_physics].into_iter().flatten().map(|(_, input)| input.clone()));
    if second.is_some() && contours.is_empty() {
        stamp.warnings.push("no record has the same name and length in both sets: there is no circle".into());
    }
    let records: BTreeMap<String, HybridRow> =
        first.records.iter().map(|r| (r.name.clone(), row(r))).collect();
    let held_out = || records.values().filter(|r| r.role == "held_out");
    Ok(HybridDocument {
        point: first.point,
        network: NeuralResidualRow {
            residual_m: first.trained.residual_m,
            examples: first.examples,
            evaluations: first.trained.evaluations,
        },
        median_ratio: quantile(held_out().map(|r| r.hybrid.rmse_m / r.analytical.rmse_m), 0.5),
        median_physics_to_hybrid: quantile(
            held_out().filter_map(|r| Some(r.physics?.rmse_m / r.hybrid.rmse_m)),
            0.5,
        ),
        physics: physics.map(|(row, _)| row),
        second_physics: second_physics.map(|(row, _)| row),
        contours,
        stamp,
        records,
    })
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

/// The machine as identified with the diagnosed effects.
struct Physics {
    machine: Machine,
    values: ParameterValues,
    input: Input,
    config: String,
}

impl Physics {
    /// Reads a result, and the machine that it describes with further overrides.
    fn read(path: &Path, axis: &Study, overrides: &[String]) -> StudyResult<Self> {
        let (found, input) = read_identification(path)?;
        check_identification(path, &found)?;
        let (overrides, without) = ([&found.stamp.overrides, overrides].concat(), &found.stamp.without);
        let config = match &found.machine {
            Some(machine) => read_machine_text(&machine.path, &machine.text, &overrides, without)?,
            None => read_machine(&found.settings.config, &overrides, without)?,
        };
        let described = Study::new(config, axis.measurements().clone());
        let values = described.identified_values(path, &found)?;
        Ok(Physics {
            machine: described.machine().clone(),
            values,
            input,
            config: described.config().path.clone(),
        })
    }

    /// Returns what it is, for the document, and its file.
    fn named(self, measurements: &str) -> (PhysicsRow, Input) {
        let row = PhysicsRow {
            result: self.input.path.clone(),
            machine: self.machine.title,
            config: self.config,
            measurements: measurements.into(),
        };
        (row, self.input)
    }
}

/// Simulates all records of a set, and trains the network on the fitted ones.
fn predict_axis(
    study: &Study,
    physics: Option<&Physics>,
    request: &HybridRequest,
    (control, step): (&Control, &(impl Fn() + Sync)),
    part: &str,
) -> StudyResult<HybridAxis> {
    let (machine, set) = (&study.machine(), study.measurements());
    if set.motions.is_empty() {
        return Err(StudyError::input(&set.path, "holds no [[motion]] record; name a set that does"));
    }
    let hold_out = if request.hold_out.is_empty() { study.held_out() } else { &request.hold_out };
    let (fit, _) = set.split_motions(request.fit.as_deref().or(study.fitted()), hold_out)?;
    let fit = &fit[..];
    let column = |p: &&Point| set.motions.iter().all(|m| m.others.contains_key(&format!("{}_m", p.name)));
    let point = machine.points.iter().find(column).ok_or_else(|| {
        let names: Vec<String> =
            machine.points.iter().filter(|p| !p.fixed).map(|p| format!("{}_m", p.name)).collect();
        let fault = format!(
            "its records have no column with the travel of a point; add one, such as {}",
            names.join(" or ")
        );
        StudyError::input(&set.path, fault)
    })?;
    let column = format!("{}_m", point.name);
    let kept = |machine: &Machine, values: &[f64], record: &MotionRecord, what: &str| {
        let name = format!("{part} {what} {}", record.name);
        let found = control.try_cached(&name, || predict(machine, values, record, &point.name, control));
        step();
        found
    };
    let records: StudyResult<Vec<PredictedTravel>> = set
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
            let example = |i: usize| Example {
                command: r.command[i],
                modelled: r.analytical[i],
                deviation: r.measured[i] - r.analytical[i],
            };
            (0..r.measured.len()).step_by(EXAMPLE_STRIDE).map(example).collect::<Vec<_>>()
        })
        .collect();
    let trained = NeuralResidual::train(&examples, request.seed, STARTS, control.stop());
    let trained = trained.map_err(|e| StudyError::input(&set.path, e.to_string()))?;
    for r in &mut records {
        let predict_hybrid = |(c, a): (&f64, &f64)| a + trained.network.deviation(*c, *a);
        r.hybrid = r.command.iter().zip(&r.analytical).map(predict_hybrid).collect();
    }
    Ok(HybridAxis { point: point.name.clone(), records, trained, examples: examples.len() })
}

/// Simulates the command of a record. Returns the travel of a point from its initial position.
fn predict(
    machine: &Machine,
    values: &[f64],
    record: &MotionRecord,
    point: &str,
    control: &Control,
) -> StudyResult<Vec<f64>> {
    let fault = |text: String| StudyError::Impossible(format!("record {}: {text}", record.name));
    let go_on = || !control.stopped();
    let (trace, _) = simulate_record(machine, values, record, &SimulationSettings::default(), &go_on)
        .map_err(|e| fault(e.to_string()))?;
    if let Some((time_s, error)) = trace.unstable {
        return Err(fault(format!(
            "the control loop diverges at {time_s} s, with a tracking error of {error:.3e} m"
        )));
    }
    let at = trace
        .points
        .iter()
        .position(|p| p == point)
        .ok_or_else(|| StudyError::Impossible(format!("point «{point}» has no inertia; give it one")))?;
    if !trace.complete {
        return Err(StudyError::Stopped);
    }
    let every = (trace.samples.len() - 1) / (record.samples() - 1);
    Ok(trace.samples.iter().step_by(every).take(record.samples()).map(|s| s.points[at]).collect())
}

fn score(predicted: &[f64], r: &PredictedTravel) -> Score {
    let off: Vec<f64> = predicted.iter().zip(&r.measured).map(|(a, b)| a - b).collect();
    let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0_f64, |m, x| m.max(x.abs()));
    let largest_m = largest(&mut off.iter().copied());
    let tracking = largest(&mut r.command.iter().zip(&r.measured).map(|(c, m)| c - m));
    Score {
        rmse_m: (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt(),
        largest_m,
        relative: largest_m / tracking,
    }
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
    let pair = |r: &'_ PredictedTravel| {
        second.records.iter().find(|s| s.name == r.name && s.measured.len() == r.measured.len())
    };
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
