//! The force that a machine needs along motions, with what is read at its further points, as one vector; and its derivatives.

use nalgebra::{DMatrix, DVector};

use super::error::InverseError;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{FitRule, Machine};

/// Indices of the parameters that are fitted: those that may be, without the frozen ones.
///
/// # Errors  a frozen one is none of the machine's.
pub fn free_parameters(machine: &Machine, frozen: &[String]) -> Result<Vec<usize>, InverseError> {
    if let Some(id) = frozen.iter().find(|id| machine.parameter(id).is_none()) {
        let known: Vec<&str> = machine.parameters.iter().map(|p| p.id.as_str()).collect();
        return Err(InverseError::Data(format!("--freeze {id}: the machine has no such parameter; it has {}", known.join(", "))));
    }
    let free = |i: &usize| machine.parameters[*i].fit != FitRule::Never && !frozen.contains(&machine.parameters[*i].id);
    Ok((0..machine.parameters.len()).filter(free).collect())
}

/// The force of a machine along motions, thinned, one record after another; after that of each record the transmission error at its further
/// points, weighed; of one told by the loops with what the force does to it.
pub fn prediction(rigid: &Rigid, machine: &Machine, values: &[f64], motions: &[&MotionSignal]) -> DVector<f64> {
    let mut all = Vec::with_capacity(samples(motions));
    for m in motions {
        let force = rigid.force(machine, values, m);
        all.extend(m.thinned(&force).unwrap_or_default());
        for (further, mut error) in m.further.iter().zip(rigid.transmission(machine, values, m)) {
            if let Some(told) = &further.told {
                error.iter_mut().zip(told.behind(&force, m)).for_each(|(error, behind)| *error += behind);
            }
            all.extend(further.thinned(m, &error).unwrap_or_default());
        }
    }
    DVector::from_vec(all)
}

/// The recorded force, and the transmission error of further points, as in [`prediction`].
pub fn recorded(motions: &[&MotionSignal]) -> DVector<f64> {
    let mut all = Vec::with_capacity(samples(motions));
    for m in motions {
        all.extend_from_slice(&m.load);
        m.further.iter().for_each(|f| all.extend(f.recorded()));
    }
    DVector::from_vec(all)
}

fn samples(motions: &[&MotionSignal]) -> usize {
    motions.iter().flat_map(|m| m.channels()).map(|(length, _)| length).sum()
}

/// Free parameters on which records with further points do not depend at all.
pub fn unseen(rigid: &Rigid, machine: &Machine, free: &[usize], motions: &[&MotionSignal]) -> Vec<usize> {
    if motions.iter().all(|m| m.further.is_empty()) {
        return Vec::new();
    }
    let columns = LinearForce::new(rigid, machine, &machine.start(), free, motions);
    free.iter().zip(columns.derivatives.column_iter()).filter(|(_, c)| c.norm() == 0.0).map(|(i, _)| *i).collect()
}

/// Step of differences, as a share of a parameter's range.
const STEP: f64 = 1e-3;

/// Prediction and its derivatives with parameters, at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearForce {
    /// The prediction.
    pub prediction: DVector<f64>,
    /// Derivatives with the parameters asked for, in their order and units.
    pub derivatives: DMatrix<f64>,
}

impl LinearForce {
    /// See [`derivatives`].
    pub fn new(rigid: &Rigid, machine: &Machine, values: &[f64], free: &[usize], motions: &[&MotionSignal]) -> Self {
        let here = prediction(rigid, machine, values, motions);
        LinearForce { derivatives: derivatives(rigid, machine, values, free, motions, &here), prediction: here }
    }
}

/// Derivatives of the prediction with some parameters, in their order and units, at values that predict `here`: by differences of a thousandth of each
/// parameter's range, which are exact where the force is linear in a parameter.
pub fn derivatives(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    free: &[usize],
    motions: &[&MotionSignal],
    here: &DVector<f64>,
) -> DMatrix<f64> {
    let mut derivatives = DMatrix::zeros(here.len(), free.len());
    for (column, (&index, inverse)) in free.iter().zip(inverse(machine, free)).enumerate() {
        let beside = machine.parameters[index].stepped(values[index], STEP);
        let mut moved = values.to_vec();
        moved[index] = beside;
        let there = prediction(rigid, machine, &moved, motions);
        // Of a stiffness the inverse is linear: d/dp = −1/p²·d/d(1/p).
        let x = values[index];
        let step = if inverse { -x * x * (1.0 / beside - 1.0 / x) } else { beside - x };
        derivatives.set_column(column, &((there - here) / step));
    }
    derivatives
}

/// Whether a parameter's inverse is what a motion is linear in: that of a stiffness, whose wind-up it divides.
pub fn inverse(machine: &Machine, free: &[usize]) -> Vec<bool> {
    let mut stiff = vec![false; machine.parameters.len()];
    machine.joints.iter().flat_map(|j| j.stiffness.depends_on()).for_each(|i| stiff[i] = true);
    free.iter().map(|i| stiff[*i] && machine.parameters[*i].lower > 0.0).collect()
}
