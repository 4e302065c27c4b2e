//! Predicted force and extra-point readings along motions as one vector, and its derivatives.

use nalgebra::{DMatrix, DVector};

use super::error::InverseError;
use super::friction::FrictionMemory;
use super::preprocessing::MotionSignal;
use super::rigid::Rigid;
use machine::{FitRule, Machine};

/// Returns the indices of the fitted parameters: all that may be fitted, except the frozen ones.
///
/// # Errors  the machine has no parameter of a frozen name.
pub fn free_parameters(machine: &Machine, frozen: &[String]) -> Result<Vec<usize>, InverseError> {
    if let Some(id) = frozen.iter().find(|id| machine.parameter(id).is_none()) {
        let known: Vec<&str> = machine.parameters.iter().map(|p| p.id.as_str()).collect();
        let fault = format!("the machine has no such parameter; it has {}", known.join(", "));
        return Err(InverseError::Setting { key: "freeze", given: id.clone(), fault });
    }
    let free = |i: &usize| {
        machine.parameters[*i].fit != FitRule::Never && !frozen.contains(&machine.parameters[*i].id)
    };
    Ok((0..machine.parameters.len()).filter(free).collect())
}

/// Predicts the decimated force of a machine along motions, one record after another. The force of each
/// record is followed by the weighted transmission error of its extra points. For a reconstructed encoder
/// this error includes the effect of the force on the loops.
pub fn prediction(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    motions: &[&MotionSignal],
) -> DVector<f64> {
    let mut all = Vec::with_capacity(samples(motions));
    for m in motions {
        let columns = at_full_rate(rigid, machine, values, m, &mut FrictionMemory::default());
        for (of, column) in columns.into_iter().enumerate() {
            all.extend(thinned(m, of, &[column]).concat());
        }
    }
    DVector::from_vec(all)
}

/// Predicts the force along a motion, then the transmission error of each extra point, sample by sample.
fn at_full_rate(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    m: &MotionSignal,
    memory: &mut FrictionMemory,
) -> Vec<Vec<f64>> {
    let force = rigid.force_remembering(machine, values, m, memory);
    let mut errors = rigid.transmission_remembering(machine, values, m, memory);
    for (channel, error) in m.extra_channels.iter().zip(&mut errors) {
        if let Some(estimate) = &channel.encoder_estimate {
            error
                .iter_mut()
                .zip(estimate.reading_change(&force, m))
                .for_each(|(error, behind)| *error += behind);
        }
    }
    std::iter::once(force).chain(errors).collect()
}

/// Decimates predicted columns: forces (0), or errors of an extra point (from 1).
fn thinned(m: &MotionSignal, of: usize, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let channel = of.checked_sub(1).and_then(|at| m.extra_channels.get(at));
    channel
        .map_or_else(|| m.thinned_all(columns), |channel| channel.thinned_all(m, columns))
        .unwrap_or_default()
}

/// Returns the recorded force and the recorded transmission error of extra points, in the layout of
/// [`prediction`].
pub fn recorded(motions: &[&MotionSignal]) -> DVector<f64> {
    let mut all = Vec::with_capacity(samples(motions));
    for m in motions {
        all.extend_from_slice(&m.load);
        m.extra_channels.iter().for_each(|f| all.extend(f.recorded()));
    }
    DVector::from_vec(all)
}

fn samples(motions: &[&MotionSignal]) -> usize {
    motions.iter().flat_map(|m| m.channels()).map(|(length, _)| length).sum()
}

/// Returns the free parameters on which records with extra points do not depend.
pub fn parameters_without_influence(
    rigid: &Rigid,
    machine: &Machine,
    free: &[usize],
    motions: &[&MotionSignal],
) -> Vec<usize> {
    if motions.iter().all(|m| m.extra_channels.is_empty()) {
        return Vec::new();
    }
    let columns = LinearForce::new(rigid, machine, &machine.start(), free, motions);
    free.iter()
        .zip(columns.derivatives.column_iter())
        .filter(|(_, c)| c.norm() == 0.0)
        .map(|(i, _)| *i)
        .collect()
}

/// Step of finite differences, as a share of a parameter's range.
const STEP: f64 = 1e-3;

/// A prediction and its derivatives with parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearForce {
    /// The prediction.
    pub prediction: DVector<f64>,
    /// Derivatives with the requested parameters, in their order and units.
    pub derivatives: DMatrix<f64>,
}

impl LinearForce {
    /// Computes both; see [`derivatives`].
    pub fn new(
        rigid: &Rigid,
        machine: &Machine,
        values: &[f64],
        free: &[usize],
        motions: &[&MotionSignal],
    ) -> Self {
        let here = prediction(rigid, machine, values, motions);
        LinearForce {
            derivatives: derivatives(rigid, machine, values, free, motions, &here),
            prediction: here,
        }
    }
}

/// Computes the derivatives of the prediction with some parameters, in their order and units, at values that
/// predict `here`. Finite differences of a thousandth of each parameter's range are exact where the force is
/// linear in the parameter.
pub fn derivatives(
    rigid: &Rigid,
    machine: &Machine,
    values: &[f64],
    free: &[usize],
    motions: &[&MotionSignal],
    here: &DVector<f64>,
) -> DMatrix<f64> {
    let stepped: Vec<(f64, Vec<f64>)> = free
        .iter()
        .zip(is_linear_in_inverse(machine, free))
        .map(|(&index, inverse)| {
            let (x, stepped) = (values[index], machine.parameters[index].stepped(values[index], STEP));
            let mut moved = values.to_vec();
            moved[index] = stepped;
            // The prediction is linear in the inverse of a stiffness: d/dp = −1/p²·d/d(1/p).
            (if inverse { -x * x * (1.0 / stepped - 1.0 / x) } else { stepped - x }, moved)
        })
        .collect();
    let mut derivatives = DMatrix::zeros(here.len(), free.len());
    let mut first = 0;
    for m in motions {
        let mut memory = FrictionMemory::default();
        let mut by_kind: Vec<Vec<Vec<f64>>> =
            vec![Vec::with_capacity(free.len()); 1 + m.extra_channels.len()];
        for (_, moved) in &stepped {
            at_full_rate(rigid, machine, moved, m, &mut memory)
                .into_iter()
                .zip(&mut by_kind)
                .for_each(|(column, of)| of.push(column));
        }
        for (of, columns) in by_kind.iter().enumerate() {
            let there = thinned(m, of, columns);
            let count = there.first().map_or(0, Vec::len);
            for (column, (there, (step, _))) in there.iter().zip(&stepped).enumerate() {
                let rows = derivatives.view_mut((first, column), (count, 1));
                rows.into_iter()
                    .zip(there)
                    .zip(here.rows(first, count).iter())
                    .for_each(|((d, there), here)| *d = (there - here) / step);
            }
            first += count;
        }
    }
    derivatives
}

/// Whether the prediction is linear in the inverse of each parameter: that of a stiffness, by which the
/// wind-up is divided.
pub fn is_linear_in_inverse(machine: &Machine, free: &[usize]) -> Vec<bool> {
    let mut stiff = vec![false; machine.parameters.len()];
    machine.joints.iter().flat_map(|j| j.stiffness.depends_on()).for_each(|i| stiff[i] = true);
    free.iter().map(|i| stiff[*i] && machine.parameters[*i].lower > 0.0).collect()
}
