//! Parameters from motion by the output error: the closed loop is simulated with each record's command, and its force set against the recorded one.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use dynamics::inverse_dynamics::{InverseError, bounded_step, dependent};
use dynamics::motion::{MotionError, RecordGap, Settings, simulate_record};
use machine::Machine;
use measurement::MotionRecord;
use numeric::parallel::OrFirstError;
use optimizer::Control;

/// What the output error gave.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputError {
    /// Values of all parameters of the machine.
    pub values: Vec<f64>,
    /// Recorded less simulated force (N or N·m), record after record.
    pub residual: DVector<f64>,
    /// Derivatives of the simulated force with the free parameters.
    pub derivatives: DMatrix<f64>,
    /// Simulations of all records.
    pub evaluations: u64,
    /// Settled, not stopped.
    pub complete: bool,
}

/// Most steps, the relative gain at which they end, and the step of differences as a share of a parameter's range.
const STEPS: usize = 8;
const GAIN: f64 = 1e-5;
const STEP: f64 = 1e-4;

/// Fits the free parameters from a place by Gauss–Newton steps, shortened where they do not gain.
///
/// # Errors  as [`simulate_record`]; a loop that leaves its bounds at the start; parameters that these records cannot tell apart.
pub fn output_error(
    machine: &Machine,
    start: &[f64],
    free: &[usize],
    records: &[&MotionRecord],
    control: &Control,
) -> Result<OutputError, InverseError> {
    let simulated = |values: &[f64]| simulated(machine, values, records, control);
    let told = |e: MotionError| InverseError::Data(e.to_string());
    let y =
        DVector::from_iterator(records.iter().map(|r| r.samples()).sum(), records.iter().flat_map(|r| r.load.samples().iter().copied()));
    let stopped = || InverseError::Data("stopped before the first simulation had ended".into());
    let mut values = start.to_vec();
    let mut force = simulated(&values).map_err(told)?.ok_or_else(stopped)?;
    let mut evaluations = 1;
    let mut derivatives = DMatrix::zeros(y.len(), free.len());
    let mut complete = false;
    for _ in 0..STEPS {
        let beside = |index: usize| {
            let p = &machine.parameters[index];
            let unit = p.to_unit(values[index]);
            p.from_unit(if unit + STEP <= 1.0 { unit + STEP } else { unit - STEP })
        };
        let columns: Result<Vec<Option<DVector<f64>>>, MotionError> = free
            .par_iter()
            .map(|&index| {
                let mut moved = values.clone();
                moved[index] = beside(index);
                Ok(simulated(&moved)?.map(|there| (there - &force) / (moved[index] - values[index])))
            })
            .or_first_error();
        evaluations += free.len() as u64;
        let Some(columns) = columns.map_err(told)?.into_iter().collect::<Option<Vec<_>>>() else { break };
        derivatives = DMatrix::from_columns(&columns);
        let residual = &y - &force;
        let squares = residual.norm_squared();
        let step = bounded_step(machine, &values, free, &derivatives, &residual).ok_or_else(|| dependent(machine, free, &derivatives))?;
        let mut share = 1.0;
        let mut next = None;
        while next.is_none() && share > 0.1 && !control.stopped() {
            let mut moved = values.clone();
            for (&index, delta) in free.iter().zip(&step) {
                let p = &machine.parameters[index];
                moved[index] = (moved[index] + share * delta).clamp(p.lower, p.upper);
            }
            evaluations += 1;
            // A loop that does not hold there is no better.
            let there = simulated(&moved).ok().flatten();
            next = there.filter(|there| (&y - there).norm_squared() < squares).map(|there| (moved, there));
            share *= 0.5;
        }
        if control.stopped() {
            break;
        }
        let Some((moved, there)) = next else {
            complete = true;
            break;
        };
        let gain = squares - (&y - &there).norm_squared();
        (values, force) = (moved, there);
        if gain <= GAIN * squares {
            complete = true;
            break;
        }
    }
    Ok(OutputError { values, residual: y - force, derivatives, evaluations, complete: complete && !control.stopped() })
}

/// Simulated force of records, one after another; `None` where it was stopped.
fn simulated(machine: &Machine, values: &[f64], records: &[&MotionRecord], control: &Control) -> Result<Option<DVector<f64>>, MotionError> {
    let mut all = Vec::new();
    for record in records {
        let (trace, _) = simulate_record(machine, values, record, &Settings::default(), &|| !control.stopped())?;
        if let Some((time_s, error)) = trace.unstable {
            return Err(MotionError::Input(format!(
                "record {}: the simulated loop leaves its bounds at {time_s:.4} s, {error:.3e} off its command; start from other parameters",
                record.name
            )));
        }
        if !trace.complete {
            return Ok(None);
        }
        let every = (record.step_s / machine.drive.as_ref().map_or(record.step_s, |d| d.velocity.period_s)).round() as usize;
        all.extend((0..record.samples()).map(|i| trace.samples.get(i * every).map_or(f64::NAN, |s| s.force)));
    }
    Ok(Some(DVector::from_vec(all)))
}

/// Gaps of records with values of the parameters, where each ran to its end.
///
/// # Errors  as [`simulate_record`].
pub fn simulated_gaps(
    machine: &Machine,
    values: &[f64],
    records: &[&MotionRecord],
    control: &Control,
) -> Result<Vec<Option<RecordGap>>, MotionError> {
    let each = |record: &&MotionRecord| Ok(simulate_record(machine, values, record, &Settings::default(), &|| !control.stopped())?.1);
    records.par_iter().map(each).or_first_error()
}
