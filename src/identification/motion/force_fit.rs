//! Least-squares fit of the predicted to the recorded force, and of the transmission error where it is
//! recorded.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::interval::half_widths;
use super::marginal::{Channel, marginal};
use super::single_frequency::SingleFrequency;
use super::tolerances::Tolerances;
use crate::uncertainty::{Estimate, narrow_width};
use dynamics::inverse_dynamics::{
    InverseError, MotionSignal, Rigid, derivatives, is_linear_in_inverse, mask_backlash_crossings,
    prediction, recorded, weights,
};
use long_work::Control;
use machine::{Machine, ParameterValues};
use numeric::halton::halton_point;
use numeric::linear_fit::LinearFit;
use optimizer::{
    Coordinate, GaussNewton, GaussNewtonError, GaussNewtonFit, PredictionFunction, nonzero_columns,
};

/// Result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceFit {
    /// Values of all parameters of the machine.
    pub values: ParameterValues,
    /// Indices of the fitted parameters.
    pub free: Vec<usize>,
    /// Recorded less predicted force, thinned, record after record.
    pub residual: DVector<f64>,
    /// Sum of the squared residuals.
    pub squares: f64,
    /// Derivatives of the prediction with respect to the free parameters, at these values.
    pub derivatives: DMatrix<f64>,
    /// Number of evaluations of the prediction.
    pub evaluations: u64,
    /// Whether the fit converged and was not stopped.
    pub converged: bool,
    /// Inertias that the motions do not determine, since they have a single frequency.
    pub single_frequency: Option<SingleFrequency>,
}

/// Stopping rule of the force fit.
const STOP: GaussNewton = GaussNewton { steps: 25, lengths: 10, gain: 1e-9 };

/// The predicted force along motions, as a function to fit; beside tolerances the part of it that they leave.
struct Force<'a> {
    rigid: &'a Rigid,
    machine: &'a Machine,
    free: &'a [usize],
    motions: &'a [&'a MotionSignal],
    tolerances: Option<&'a Tolerances>,
}

impl PredictionFunction for Force<'_> {
    type Error = InverseError;

    fn at(&self, values: &[f64]) -> Result<Option<DVector<f64>>, InverseError> {
        let mut force = prediction(self.rigid, self.machine, values, self.motions);
        if let Some(tolerances) = self.tolerances {
            tolerances.apply(&mut force);
        }
        Ok(Some(force))
    }

    fn derivatives(&self, values: &[f64], here: &DVector<f64>) -> Result<Option<DMatrix<f64>>, InverseError> {
        Ok(Some(self.derivatives_at(values, here)))
    }
}

impl Force<'_> {
    /// Computes the derivatives at values that predict `here`.
    fn derivatives_at(&self, values: &[f64], here: &DVector<f64>) -> DMatrix<f64> {
        let Force { rigid, machine, free, motions, .. } = *self;
        let Some(tolerances) = self.tolerances else {
            return derivatives(rigid, machine, values, free, motions, here);
        };
        let here = prediction(rigid, machine, values, motions);
        let mut columns = derivatives(rigid, machine, values, free, motions, &here);
        tolerances.apply(&mut columns);
        columns
    }
}

/// Fits parameters by Gauss–Newton steps within their ranges, shortened where they do not reduce the
/// residual.
///
/// A force that is linear in its parameters needs one step. Without a free parameter the force is evaluated at
/// the start values.
///
/// # Errors  two parameters have the same effect on the force of these records, or one has none.
pub fn estimate(
    rigid: &Rigid,
    machine: &Machine,
    start: &ParameterValues,
    free: &[usize],
    motions: &[&MotionSignal],
) -> Result<ForceFit, InverseError> {
    estimate_beside(rigid, machine, start, free, motions, None)
}

/// As [`estimate`], beside tolerances: residual, its sum of squares and derivatives are those that they leave.
fn estimate_beside(
    rigid: &Rigid,
    machine: &Machine,
    start: &ParameterValues,
    free: &[usize],
    motions: &[&MotionSignal],
    tolerances: Option<&Tolerances>,
) -> Result<ForceFit, InverseError> {
    let mut recorded = recorded(motions);
    tolerances.iter().for_each(|tolerances| tolerances.apply(&mut recorded));
    let force = Force { rigid, machine, free, motions, tolerances };
    if free.is_empty() {
        let predicted = force.at(start)?.unwrap_or_else(|| DVector::zeros(recorded.len()));
        let residual = recorded - predicted;
        return Ok(ForceFit {
            values: start.clone(),
            free: Vec::new(),
            squares: residual.norm_squared(),
            derivatives: DMatrix::zeros(residual.len(), 0),
            residual,
            evaluations: 1,
            converged: true,
            single_frequency: None,
        });
    }
    let found = STOP
        .fit(&force, &recorded, start, &coordinates(machine, free, &is_linear_in_inverse(machine, free)))
        .map_err(|e| beside_limits(unidentifiable(machine, free, e), motions))?;
    if found.at_end {
        return Ok(ForceFit::new(found, free));
    }
    let last = force.derivatives_at(&found.values, &found.prediction);
    let evaluations = found.evaluations + free.len() as u64;
    Ok(ForceFit { derivatives: last, evaluations, ..ForceFit::new(found, free) })
}

/// Most starts all over the ranges of the parameters, and those of one batch.
const STARTS: usize = 32;
const BATCH: usize = 8;
/// Number of fits that have to end in the least sum of squares, and the relative difference of two sums
/// within which they are one minimum (1).
const WANTED: usize = 3;
const SAME_MINIMUM: f64 = 1e-3;
/// Share of its change by which a linear prediction may depart from a straight line (1).
const STRAIGHT: f64 = 1e-6;

/// Returns the best of a fit and of further ones from starts all over the ranges of its parameters, where the
/// force is not linear in these. The search ends once the least sum of squares was found several times, or
/// the work is stopped.
pub fn best_anywhere(
    rigid: &Rigid,
    machine: &Machine,
    near: ForceFit,
    motions: &[&MotionSignal],
    control: &Control,
) -> ForceFit {
    let (start, free) = (machine.start(), near.free.clone());
    let values_of = |at: usize| {
        let mut values = start.clone();
        for (&index, unit) in free.iter().zip(halton_point(at, free.len())) {
            values[index] = machine.parameters[index].from_unit(unit);
        }
        values
    };
    if is_linear(rigid, machine, &near, &values_of(1), motions) {
        return near;
    }
    let (mut found, mut evaluations) = (1, near.evaluations);
    let mut best = near;
    for first in (1..=STARTS).step_by(BATCH).take_while(|_| !control.stopped()) {
        let fit = |at: usize| estimate(rigid, machine, &values_of(at), &free, motions).ok();
        let ends: Vec<Option<ForceFit>> = (first..first + BATCH).into_par_iter().map(fit).collect();
        for end in ends.into_iter().flatten() {
            evaluations += end.evaluations;
            let ratio = end.squares / best.squares;
            if ratio < 1.0 - SAME_MINIMUM {
                (best, found) = (end, 1);
            } else {
                found += usize::from(ratio < 1.0 + SAME_MINIMUM);
            }
        }
        if found >= WANTED {
            break;
        }
    }
    ForceFit { evaluations, ..best }
}

/// Whether the prediction at values all of which differ from those of a fit follows from its derivatives.
fn is_linear(
    rigid: &Rigid,
    machine: &Machine,
    fit: &ForceFit,
    other: &ParameterValues,
    motions: &[&MotionSignal],
) -> bool {
    let inverse = is_linear_in_inverse(machine, &fit.free);
    // Derivatives are those by the parameters; d/d(1/p) = −p²·d/dp.
    let change = fit.free.iter().zip(&inverse).map(|(&index, &inverse)| {
        let (here, there) = (fit.values[index], other[index]);
        if inverse { -here * here * (1.0 / there - 1.0 / here) } else { there - here }
    });
    let straight = &fit.derivatives * DVector::from_iterator(fit.free.len(), change);
    let moved = prediction(rigid, machine, other, motions) - (recorded(motions) - &fit.residual);
    (&moved - straight).norm() <= STRAIGHT * moved.norm()
}

/// Converts free parameters to coordinates of a fit, some by their inverse.
pub(super) fn coordinates(machine: &Machine, free: &[usize], inverse: &[bool]) -> Vec<Coordinate> {
    let of = |(&index, &inverse): (&usize, &bool)| {
        let parameter = &machine.parameters[index];
        Coordinate { index, range: (parameter.lower, parameter.upper), inverse }
    };
    free.iter().zip(inverse).map(of).collect()
}

/// Adds to the failure of a fit what limits the motions.
fn beside_limits(error: InverseError, motions: &[&MotionSignal]) -> InverseError {
    let slides =
        motions.iter().map(|m| m.slides()).fold([false; 2], |all, own| [all[0] | own[0], all[1] | own[1]]);
    let sum = |of: fn(&MotionSignal) -> usize| motions.iter().map(|m| of(m)).sum::<usize>();
    let (used, moving) = (sum(MotionSignal::used), sum(MotionSignal::moving));
    let limit = match slides {
        _ if 2 * used < moving => {
            format!(
                "of {moving} samples in motion {used} are used, the others are too close to a rest: record longer moves"
            )
        }
        [true, false] | [false, true] => {
            "the axis slides in one direction only: record strokes in both".into()
        }
        _ => return error,
    };
    match error {
        InverseError::Unidentifiable { parameter, why } => {
            InverseError::Unidentifiable { parameter, why: format!("{why}; {limit}") }
        }
        error => error,
    }
}

/// Converts the failure of a fit to an error that names the parameter.
pub(super) fn unidentifiable(
    machine: &Machine,
    free: &[usize],
    error: GaussNewtonError<InverseError>,
) -> InverseError {
    match error {
        GaussNewtonError::Model(error) => error,
        GaussNewtonError::Stopped => InverseError::Stopped,
        GaussNewtonError::Dependent(moving, derivatives) => {
            let moving: Vec<usize> = moving.into_iter().map(|at| free[at]).collect();
            dependent(machine, &moving, &derivatives)
        }
    }
}

/// Fits as [`estimate`], but holds unidentifiable parameters at their start values, one after another, where
/// `may_stay` permits it. Beside tolerances, residual, its sum of squares and derivatives are those that they
/// leave.
///
/// # Errors  as [`estimate`], for parameters that must not stay.
pub fn estimate_identifiable(
    (rigid, machine): (&Rigid, &Machine),
    start: &ParameterValues,
    free: &[usize],
    motions: &[&MotionSignal],
    tolerances: Option<&Tolerances>,
    may_stay: impl Fn(usize) -> bool,
) -> Result<ForceFit, InverseError> {
    let mut free = free.to_vec();
    loop {
        match estimate_beside(rigid, machine, start, &free, motions, tolerances) {
            Err(InverseError::Unidentifiable { parameter, .. }) if may_stay(parameter) => {
                free.retain(|i| *i != parameter)
            }
            found => return found,
        }
    }
}

/// Number of updates of the channel weights.
const ROUNDS: usize = 4;

/// Fits to the `fitted` motions, first as [`best_anywhere`], and updates the channel weights of all motions.
///
/// After each fit the residuals of a channel set its weight, so that each channel counts in units of its own
/// misfit. Samples during backlash crossings are masked from the first fit on.
///
/// # Errors  as [`estimate`].
pub fn estimate_weighted(
    rigid: &Rigid,
    machine: &Machine,
    free: &[usize],
    motions: &mut [MotionSignal],
    fitted: &[usize],
    control: &Control,
) -> Result<ForceFit, InverseError> {
    let mut values = machine.start();
    let mut evaluations = 0;
    for round in 0.. {
        let own: Vec<&MotionSignal> = fitted.iter().map(|i| &motions[*i]).collect();
        let mut fit = estimate(rigid, machine, &values, free, &own)?;
        if round == 0 {
            fit = best_anywhere(rigid, machine, fit, &own, control);
        }
        evaluations += fit.evaluations;
        if round == ROUNDS || own.iter().all(|m| m.extra_channels.is_empty()) {
            fit.evaluations = evaluations;
            fit.single_frequency = {
                let place = (&fit.values, &fit.free[..], &fit.derivatives);
                SingleFrequency::of((rigid, machine), place, &own)
            };
            return Ok(fit);
        }
        let weights = weights(fit.residual.as_slice(), &own);
        if round > 0 || !mask_backlash_crossings(motions, rigid, machine, &fit.values) {
            motions.iter_mut().for_each(|m| m.set_weights(&weights));
        }
        values = fit.values;
    }
    unreachable!("the last round returns")
}

/// Finds the parameter that the records do not determine: it has no effect, or the others have the same
/// effect together.
fn dependent(machine: &Machine, free: &[usize], derivatives: &DMatrix<f64>) -> InverseError {
    let id = |at: usize| machine.parameters[free[at]].id.as_str();
    let error = |at: usize, why: String| InverseError::Unidentifiable { parameter: free[at], why };
    for at in 0..free.len() {
        if !(derivatives.column(at).norm() > 0.0) {
            return error(
                at,
                format!(
                    "these records do not depend on {}; freeze it, or record a motion that excites it",
                    id(at)
                ),
            );
        }
        let before: Vec<usize> = (0..=at).collect();
        let own = derivatives.column(at).clone_owned();
        let all = derivatives.select_columns(&before);
        if at > 0 && LinearFit::new(&all, &own).is_none() {
            let others: Vec<&str> = (0..at).map(id).collect();
            let remedy = "freeze one, or record a motion that distinguishes them";
            return error(
                at,
                format!(
                    "these records cannot distinguish {} from a combination of {}; {remedy}",
                    id(at),
                    others.join(", ")
                ),
            );
        }
    }
    InverseError::Data("these records do not determine the parameters".into())
}

impl ForceFit {
    /// Returns a fit of the free parameters with the derivatives of its last step.
    pub(super) fn new(found: GaussNewtonFit, free: &[usize]) -> Self {
        let GaussNewtonFit { values, residual, derivatives, evaluations, converged, .. } = found;
        let (values, squares) = (ParameterValues(values), residual.norm_squared());
        ForceFit {
            values,
            free: free.to_vec(),
            squares,
            residual,
            derivatives,
            evaluations,
            converged,
            single_frequency: None,
        }
    }

    /// Returns the free parameters with intervals that allow for noise with the correlation of the residual,
    /// and for a misfit that repeats.
    pub fn estimates(&self, machine: &Machine, free: &[usize], motions: &[&MotionSignal]) -> Vec<Estimate> {
        if free.is_empty() {
            return Vec::new();
        }
        let inside = self.inside(machine, free);
        let found =
            marginal(&self.derivatives.select_columns(&inside), &self.residual, &[], &channels(motions));
        self.estimates_with(machine, free, &inside, found.map(|m| m.half_widths).as_deref())
    }

    /// As [`ForceFit::estimates`] for residuals in closed loop, with lengths and periods of the records in
    /// the order of the residual.
    pub fn estimates_of(
        &self,
        machine: &Machine,
        free: &[usize],
        records: &[(usize, Option<usize>)],
    ) -> Vec<Estimate> {
        let inside = self.inside(machine, free);
        let found = half_widths(&self.derivatives.select_columns(&inside), &self.residual, records);
        self.estimates_with(machine, free, &inside, found.as_deref())
    }

    /// Returns the positions, among the free parameters, of those inside their ranges with an influence that no
    /// force along the travel can have.
    pub(super) fn inside(&self, machine: &Machine, free: &[usize]) -> Vec<usize> {
        let is_separate = |at: &usize| {
            self.single_frequency.as_ref().is_none_or(|single| !single.parameters.contains(&free[*at]))
        };
        let mut inside = nonzero_columns(&self.derivatives);
        inside.retain(|at| machine.parameters[free[*at]].holds_inside(self.values[free[*at]]));
        inside.retain(is_separate);
        inside
    }

    /// Returns the free parameters with the 95 % intervals of those at the positions `inside`, of given half
    /// widths.
    pub(super) fn estimates_with(
        &self,
        machine: &Machine,
        free: &[usize],
        inside: &[usize],
        half_widths: Option<&[f64]>,
    ) -> Vec<Estimate> {
        let of = |(at, &index): (usize, &usize)| {
            let (parameter, value) = (&machine.parameters[index], self.values[index]);
            let place = inside.iter().position(|i| *i == at);
            let interval95 =
                place.and_then(|place| half_widths?.get(place)).map(|half| (value - half, value + half));
            // An interval that reaches zero has no width on a logarithmic scale, and is not narrow.
            let width = interval95
                .map_or(f64::INFINITY, |(low, high)| parameter.to_unit(high) - parameter.to_unit(low));
            Estimate {
                interval95,
                identifiable: Some(width <= narrow_width(&machine.parameters, &self.values, index)),
                at_bound: !parameter.holds_inside(value),
                ..Estimate::without_interval(index, value, None)
            }
        };
        free.iter().enumerate().map(of).collect()
    }
}

/// Returns the channels of motions in the layout of the prediction.
pub(super) fn channels(motions: &[&MotionSignal]) -> Vec<Channel> {
    let of = |m: &&MotionSignal| {
        let masks = std::iter::once(&m.is_moving).chain(m.extra_channels.iter().map(|f| &f.is_used));
        let channel =
            |used: &Vec<bool>| Channel { length: m.load.len(), period: m.period, used: used.clone() };
        masks.map(channel).collect::<Vec<Channel>>()
    };
    motions.iter().flat_map(of).collect()
}

/// Returns the correlations of the coefficients of columns; empty if the columns are dependent.
pub fn correlation(columns: &DMatrix<f64>) -> Vec<Vec<f64>> {
    if columns.ncols() == 0 {
        return Vec::new();
    }
    let Some(inverse) = (columns.transpose() * columns).cholesky().map(|c| c.inverse()) else {
        return Vec::new();
    };
    let sd = |i: usize| inverse[(i, i)].sqrt();
    (0..inverse.nrows())
        .map(|i| (0..inverse.ncols()).map(|j| inverse[(i, j)] / (sd(i) * sd(j))).collect())
        .collect()
}
