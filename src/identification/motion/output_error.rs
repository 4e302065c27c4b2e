//! Output-error method: simulates the closed loop with each record's command and fits its force to the
//! recorded force.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::force_fit::{ForceFit, coordinates, unidentifiable};
use dynamics::inverse_dynamics::InverseError;
use dynamics::motion::{MotionError, RecordGap, SimulationSettings, simulate_record};
use long_work::Control;
use machine::{Machine, ParameterValues};
use measurement::MotionRecord;
use numeric::parallel::OrFirstError;
use optimizer::{GaussNewton, PredictionFunction};

/// Stopping rule of the fit, with few steps because simulations are expensive.
const STOP: GaussNewton = GaussNewton { steps: 8, lengths: 4, gain: 1e-5 };
/// Step of the differences, as a share of a parameter's range (1).
const STEP: f64 = 1e-4;

/// The simulated force of records, as a function to fit.
struct Loop<'a> {
    machine: &'a Machine,
    free: &'a [usize],
    records: &'a [&'a MotionRecord],
    control: &'a Control,
}

impl PredictionFunction for Loop<'_> {
    type Error = InverseError;

    fn at(&self, values: &[f64]) -> Result<Option<DVector<f64>>, InverseError> {
        simulated(self.machine, values, self.records, self.control)
            .map_err(|e| InverseError::Data(e.to_string()))
    }

    fn derivatives(&self, values: &[f64], here: &DVector<f64>) -> Result<Option<DMatrix<f64>>, InverseError> {
        let column = |&index: &usize| {
            let mut moved = values.to_vec();
            moved[index] = self.machine.parameters[index].stepped(values[index], STEP);
            Ok(self.at(&moved)?.map(|there| (there - here) / (moved[index] - values[index])))
        };
        let columns: Result<Vec<Option<DVector<f64>>>, InverseError> =
            self.free.par_iter().map(column).or_first_error();
        Ok(columns?.into_iter().collect::<Option<Vec<_>>>().map(|columns| DMatrix::from_columns(&columns)))
    }
}

/// Fits the free parameters by Gauss–Newton steps, shortened where they do not reduce the residual: recorded
/// less simulated force, record after record, counted in simulations of all records.
///
/// # Errors  as [`simulate_record`]; a loop that is unstable at the start values; parameters that these
///   records cannot distinguish.
pub fn output_error(
    machine: &Machine,
    start: &ParameterValues,
    free: &[usize],
    records: &[&MotionRecord],
    control: &Control,
) -> Result<ForceFit, InverseError> {
    let y = DVector::from_iterator(
        records.iter().map(|r| r.samples()).sum(),
        records.iter().flat_map(|r| r.load.samples().iter().copied()),
    );
    let simulated = Loop { machine, free, records, control };
    let found = STOP
        .fit(&simulated, &y, start, &coordinates(machine, free, &vec![false; free.len()]))
        .map_err(|e| unidentifiable(machine, free, e))?;
    // The derivatives are those before the last step: new ones would need one simulation per parameter.
    Ok(ForceFit { converged: found.converged && !control.stopped(), ..ForceFit::new(found, free) })
}

/// Simulates the force of the records, one after another; `None` if stopped.
fn simulated(
    machine: &Machine,
    values: &[f64],
    records: &[&MotionRecord],
    control: &Control,
) -> Result<Option<DVector<f64>>, MotionError> {
    let mut all = Vec::new();
    for record in records {
        let (trace, _) =
            simulate_record(machine, values, record, &SimulationSettings::default(), &|| !control.stopped())?;
        if let Some((time_s, error)) = trace.unstable {
            return Err(MotionError::Input(format!(
                "record {}: the simulated loop is unstable, {error:.3e} from its command at {time_s:.4} s; start from other parameters",
                record.name
            )));
        }
        if !trace.complete {
            return Ok(None);
        }
        let every = (record.step_s / machine.drive.as_ref().map_or(record.step_s, |d| d.velocity.period_s))
            .round() as usize;
        all.extend((0..record.samples()).map(|i| trace.samples.get(i * every).map_or(f64::NAN, |s| s.force)));
    }
    Ok(Some(DVector::from_vec(all)))
}

/// Returns the gap of each record at the given parameters; `None` for a simulation that did not run to its
/// end.
///
/// # Errors  as [`simulate_record`].
pub fn simulated_gaps(
    machine: &Machine,
    values: &[f64],
    records: &[&MotionRecord],
    control: &Control,
) -> Result<Vec<Option<RecordGap>>, MotionError> {
    let each = |record: &&MotionRecord| {
        Ok(simulate_record(machine, values, record, &SimulationSettings::default(), &|| !control.stopped())?
            .1)
    };
    records.par_iter().map(each).or_first_error()
}
