//! Least squares of the force that a machine needs against the force that was recorded, and of its transmission error where it was.

use nalgebra::{DMatrix, DVector};

use super::error::InverseError;
use super::force::Rigid;
use super::further::{leave_crossings_out, weights};
use super::interval::{Interval, intervals};
use super::recipe::Motion;
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
pub fn prediction(rigid: &Rigid, machine: &Machine, values: &[f64], motions: &[&Motion]) -> DVector<f64> {
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
pub fn recorded(motions: &[&Motion]) -> DVector<f64> {
    let mut all = Vec::with_capacity(samples(motions));
    for m in motions {
        all.extend_from_slice(&m.load);
        m.further.iter().for_each(|f| all.extend(f.recorded()));
    }
    DVector::from_vec(all)
}

fn samples(motions: &[&Motion]) -> usize {
    motions.iter().flat_map(|m| m.channels()).map(|(length, _)| length).sum()
}

/// Free parameters on which records with further points do not depend at all.
pub fn unseen(rigid: &Rigid, machine: &Machine, free: &[usize], motions: &[&Motion]) -> Vec<usize> {
    if motions.iter().all(|m| m.further.is_empty()) {
        return Vec::new();
    }
    let columns = Columns::new(rigid, machine, &machine.start(), free, motions);
    free.iter().zip(columns.derivatives.column_iter()).filter(|(_, c)| c.norm() == 0.0).map(|(i, _)| *i).collect()
}

/// Step of differences, as a share of a parameter's range.
const STEP: f64 = 1e-3;

/// Prediction and its derivatives with parameters, at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// The prediction.
    pub prediction: DVector<f64>,
    /// Derivatives with the parameters asked for, in their order and units.
    pub derivatives: DMatrix<f64>,
}

impl Columns {
    /// By differences of a thousandth of each parameter's range, which are exact where the force is linear in a parameter.
    pub fn new(rigid: &Rigid, machine: &Machine, values: &[f64], free: &[usize], motions: &[&Motion]) -> Self {
        let here = prediction(rigid, machine, values, motions);
        let mut derivatives = DMatrix::zeros(here.len(), free.len());
        for (column, (&index, inverse)) in free.iter().zip(inverse(machine, free)).enumerate() {
            let parameter = &machine.parameters[index];
            let unit = parameter.to_unit(values[index]);
            let beside = parameter.from_unit(if unit + STEP <= 1.0 { unit + STEP } else { unit - STEP });
            let mut moved = values.to_vec();
            moved[index] = beside;
            let there = prediction(rigid, machine, &moved, motions);
            // Of a stiffness the inverse is linear: d/dp = −1/p²·d/d(1/p).
            let x = values[index];
            let step = if inverse { -x * x * (1.0 / beside - 1.0 / x) } else { beside - x };
            derivatives.set_column(column, &((there - &here) / step));
        }
        Columns { prediction: here, derivatives }
    }
}

/// Least squares of linear columns by QR with each column scaled to length one.
#[derive(Debug, Clone, PartialEq)]
pub struct Projected {
    /// Coefficients.
    pub coefficients: DVector<f64>,
    /// What is left.
    pub residual: DVector<f64>,
}

impl Projected {
    /// Solves; `None` where columns are not independent.
    pub fn new(columns: &DMatrix<f64>, y: &DVector<f64>) -> Option<Self> {
        let lengths: Vec<f64> = columns.column_iter().map(|c| c.norm()).collect();
        if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
            return None;
        }
        let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| columns[(i, j)] / lengths[j]);
        let qr = scaled.clone().qr();
        let r = qr.r();
        if (0..r.ncols()).any(|i| r[(i, i)].abs() < 1e-9) {
            return None;
        }
        let projected = qr.q().transpose() * y;
        let solved = r.solve_upper_triangular(&projected)?;
        let residual = y - &scaled * &solved;
        let coefficients = DVector::from_iterator(solved.len(), solved.iter().zip(&lengths).map(|(x, l)| x / l));
        Some(Projected { coefficients, residual })
    }
}

/// A fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Values of all parameters of the machine.
    pub values: Vec<f64>,
    /// Indices of those that were fitted.
    pub free: Vec<usize>,
    /// Recorded less predicted force, thinned, record after record.
    pub residual: DVector<f64>,
    /// Sum of its squares.
    pub squares: f64,
    /// Derivatives of the prediction with the free parameters there.
    pub derivatives: DMatrix<f64>,
    /// Evaluations of the prediction.
    pub evaluations: u64,
}

/// Most steps of a fit, and the relative gain at which it ends.
const STEPS: usize = 25;
const GAIN: f64 = 1e-9;

/// Fits parameters from a place: Gauss–Newton steps, kept within the ranges and shortened where they do not gain. A force that is linear in its
/// parameters is there in one step.
///
/// # Errors  two parameters do the same to the force of these records, or one does nothing.
pub fn estimate(rigid: &Rigid, machine: &Machine, start: &[f64], free: &[usize], motions: &[&Motion]) -> Result<Fit, InverseError> {
    let y = recorded(motions);
    let mut values = start.to_vec();
    let mut evaluations = 0;
    let inverse = inverse(machine, free);
    let mut columns = Columns::new(rigid, machine, &values, free, motions);
    let mut residual = &y - &columns.prediction;
    for round in 0..STEPS {
        evaluations += 1 + free.len() as u64;
        let squares = residual.norm_squared();
        // What does nothing at the start is untold; what does nothing where another came to its end (a speed over which no friction falls) stays.
        let live = live(&columns.derivatives);
        if round == 0 && live.len() < free.len() {
            return Err(dependent(machine, free, &columns.derivatives));
        }
        let places: Vec<(f64, f64, f64)> = free.iter().zip(&inverse).map(|(i, inverse)| place(machine, &values, *i, *inverse)).collect();
        // d/d(1/p) = −p²·d/dp.
        let mut derivatives = columns.derivatives.clone();
        for ((mut column, &index), _) in derivatives.column_iter_mut().zip(free).zip(&inverse).filter(|(_, inverse)| **inverse) {
            column *= -values[index] * values[index];
        }
        let moving: Vec<(f64, f64, f64)> = live.iter().map(|at| places[*at]).collect();
        let moved = step_within(&moving, &derivatives.select_columns(&live), &residual).ok_or_else(|| {
            let moving: Vec<usize> = live.iter().map(|at| free[*at]).collect();
            dependent(machine, &moving, &columns.derivatives.select_columns(&live))
        })?;
        let mut step = vec![0.0; free.len()];
        live.into_iter().zip(moved).for_each(|(at, moved)| step[at] = moved);
        let mut gained = None;
        let mut share = 1.0;
        for _ in 0..10 {
            let mut next = values.clone();
            for ((&index, delta), (&(at, lower, upper), inverse)) in free.iter().zip(step.iter()).zip(places.iter().zip(&inverse)) {
                let there = (at + share * delta).clamp(lower, upper);
                next[index] = if *inverse { 1.0 / there } else { there };
            }
            evaluations += 1;
            let left = &y - prediction(rigid, machine, &next, motions);
            if left.norm_squared() < squares {
                gained = Some((next, left));
                break;
            }
            share *= 0.5;
        }
        let Some((next, left)) = gained else { break };
        let gain = squares - left.norm_squared();
        (values, residual) = (next, left);
        columns = Columns::new(rigid, machine, &values, free, motions);
        if gain <= GAIN * squares {
            break;
        }
    }
    let squares = residual.norm_squared();
    Ok(Fit { values, free: free.to_vec(), squares, residual, derivatives: columns.derivatives, evaluations })
}

/// As [`estimate`], but what the motions do not tell beside the others stays where it starts, one parameter after another, if it `may`.
///
/// # Errors  as [`estimate`], of parameters that may not stay.
pub fn estimate_told(
    rigid: &Rigid,
    machine: &Machine,
    start: &[f64],
    free: &[usize],
    motions: &[&Motion],
    may: impl Fn(usize) -> bool,
) -> Result<Fit, InverseError> {
    let mut free = free.to_vec();
    loop {
        match estimate(rigid, machine, start, &free, motions) {
            Err(InverseError::Untold { parameter, .. }) if may(parameter) => free.retain(|i| *i != parameter),
            found => return found,
        }
    }
}

/// Rounds of fit and weights.
const ROUNDS: usize = 4;

/// As [`estimate`] from a machine's start on the `fitted` of some motions, all of whose further points are weighed anew by what is left, until
/// each channel counts in units of its own misfit. What is read while a play is crossed counts for nothing from the first fit on.
///
/// # Errors  as [`estimate`].
pub fn estimate_weighed(
    rigid: &Rigid,
    machine: &Machine,
    free: &[usize],
    motions: &mut [Motion],
    fitted: &[usize],
) -> Result<Fit, InverseError> {
    let mut values = machine.start();
    let mut evaluations = 0;
    for round in 0.. {
        let own: Vec<&Motion> = fitted.iter().map(|i| &motions[*i]).collect();
        let mut fit = estimate(rigid, machine, &values, free, &own)?;
        evaluations += fit.evaluations;
        if round == ROUNDS || own.iter().all(|m| m.further.is_empty()) {
            fit.evaluations = evaluations;
            return Ok(fit);
        }
        let weights = weights(fit.residual.as_slice(), &own);
        if round > 0 || !leave_crossings_out(motions, rigid, machine, &fit.values) {
            motions.iter_mut().for_each(|m| m.weigh(&weights));
        }
        values = fit.values;
    }
    unreachable!("the last round returns")
}

/// Whether a parameter's inverse is what a motion is linear in: that of a stiffness, whose wind-up it divides.
pub fn inverse(machine: &Machine, free: &[usize]) -> Vec<bool> {
    let mut stiff = vec![false; machine.parameters.len()];
    machine.joints.iter().flat_map(|j| j.stiffness.depends_on()).for_each(|i| stiff[i] = true);
    free.iter().map(|i| stiff[*i] && machine.parameters[*i].lower > 0.0).collect()
}

/// Where a parameter stands, and its ends; of its inverse.
fn place(machine: &Machine, values: &[f64], index: usize, inverse: bool) -> (f64, f64, f64) {
    let (p, x) = (&machine.parameters[index], values[index]);
    if inverse { (1.0 / x, 1.0 / p.upper, 1.0 / p.lower) } else { (x, p.lower, p.upper) }
}

/// A Gauss–Newton step; parameters that it would take out of their range go to its end and the others are solved again.
pub fn bounded_step(
    machine: &Machine,
    values: &[f64],
    free: &[usize],
    derivatives: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Option<Vec<f64>> {
    let places: Vec<(f64, f64, f64)> = free.iter().map(|i| place(machine, values, *i, false)).collect();
    step_within(&places, derivatives, residual)
}

/// The same of numbers with their ends. Where some would leave their ranges, the one that would be at its end first is held there, and the others are
/// looked at anew: of two that do nearly the same, the one in the narrow range stays.
fn step_within(places: &[(f64, f64, f64)], derivatives: &DMatrix<f64>, residual: &DVector<f64>) -> Option<Vec<f64>> {
    let mut step = vec![0.0; places.len()];
    let mut open: Vec<usize> = (0..places.len()).collect();
    let mut left = residual.clone();
    while !open.is_empty() {
        let solved = Projected::new(&derivatives.select_columns(&open), &left)?;
        let mut first: Option<(f64, usize)> = None;
        for (&at, &delta) in open.iter().zip(solved.coefficients.iter()) {
            let (value, lower, upper) = places[at];
            let wanted = value + delta;
            let kept = wanted.clamp(lower, upper);
            step[at] = kept - value;
            let share = step[at] / delta;
            if kept != wanted && first.is_none_or(|(least, _)| share < least) {
                first = Some((share, at));
            }
        }
        let Some((_, held)) = first else { break };
        left -= step[held] * derivatives.column(held);
        open.retain(|at| *at != held);
    }
    Some(step)
}

/// Columns that are not nothing.
pub fn live(derivatives: &DMatrix<f64>) -> Vec<usize> {
    (0..derivatives.ncols()).filter(|at| derivatives.column(*at).norm() > 0.0).collect()
}

/// Which parameter the others stand for.
pub fn dependent(machine: &Machine, free: &[usize], derivatives: &DMatrix<f64>) -> InverseError {
    let id = |at: usize| machine.parameters[free[at]].id.as_str();
    let untold = |at: usize, why: String| InverseError::Untold { parameter: free[at], why };
    for at in 0..free.len() {
        if !(derivatives.column(at).norm() > 0.0) {
            return untold(at, format!("these records do not depend on {}; freeze it, or record a motion that shows it", id(at)));
        }
        let before: Vec<usize> = (0..=at).collect();
        let own = derivatives.column(at).clone_owned();
        let all = derivatives.select_columns(&before);
        if at > 0 && Projected::new(&all, &own).is_none() {
            let others: Vec<&str> = (0..at).map(id).collect();
            let why = "freeze one, or record a motion that tells them apart";
            return untold(at, format!("these records cannot tell {} from {} together; {why}", id(at), others.join(", ")));
        }
    }
    InverseError::Data("these records do not determine the parameters".into())
}

/// A parameter with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// Index in the machine.
    pub parameter: usize,
    /// Value.
    pub value: f64,
    /// Interval, where one can be told.
    pub interval: Option<Interval>,
    /// Stands at an end of its range.
    pub at_bound: bool,
}

impl Fit {
    /// The free parameters with intervals that respect coloured and repeating residuals.
    pub fn estimates(&self, machine: &Machine, free: &[usize], motions: &[&Motion]) -> Vec<Estimated> {
        let records: Vec<(usize, Option<usize>)> = motions.iter().flat_map(|m| m.channels()).collect();
        self.estimates_of(machine, free, &records)
    }

    /// As [`Fit::estimates`], with the lengths and periods of the records that the residual runs over.
    pub fn estimates_of(&self, machine: &Machine, free: &[usize], records: &[(usize, Option<usize>)]) -> Vec<Estimated> {
        let mut inside = live(&self.derivatives);
        inside.retain(|at| machine.parameters[free[*at]].holds_inside(self.values[free[*at]]));
        let found = intervals(&self.derivatives.select_columns(&inside), &self.residual, records);
        free.iter()
            .enumerate()
            .map(|(at, &parameter)| {
                let place = inside.iter().position(|i| *i == at);
                let sd = place.and_then(|p| found.as_ref()?.get(p).copied());
                Estimated {
                    parameter,
                    value: self.values[parameter],
                    interval: sd,
                    at_bound: !machine.parameters[parameter].holds_inside(self.values[parameter]),
                }
            })
            .collect()
    }
}

/// Correlations of the coefficients of columns; nothing where they are not independent.
pub fn correlation(columns: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let Some(inverse) = (columns.transpose() * columns).cholesky().map(|c| c.inverse()) else { return Vec::new() };
    let sd = |i: usize| inverse[(i, i)].sqrt();
    (0..inverse.nrows()).map(|i| (0..inverse.ncols()).map(|j| inverse[(i, j)] / (sd(i) * sd(j))).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns that are nearly one: the number known within a narrow range ends at it, and the other takes what is left.
    #[test]
    fn limit_what_is_known_narrowly_is_held_first() {
        let wave = |n: f64, i: usize| (n * i as f64 / 50.0).sin();
        let columns = DMatrix::from_fn(400, 2, |i, column| wave(1.0, i) + 1e-3 * column as f64 * wave(3.0, i));
        let y = DVector::from_fn(400, |i, _| 0.2 * wave(1.0, i) - 0.05 * wave(3.0, i));
        let places = [(1.0, 0.97, 1.03), (0.0, -0.5, 0.5)];
        let step = step_within(&places, &columns, &y).unwrap();
        let left = |step: &[f64]| (&y - &columns * DVector::from_column_slice(step)).norm();
        let grid = (0..=60).flat_map(|a| (0..=1000).map(move |b| [-0.03 + 1e-3 * f64::from(a), -0.5 + 1e-3 * f64::from(b)]));
        let least = grid.map(|step| left(&step)).fold(f64::INFINITY, f64::min);
        assert!(left(&step) < least + 1e-3, "{step:?}: {} for {least}", left(&step));
    }
}
