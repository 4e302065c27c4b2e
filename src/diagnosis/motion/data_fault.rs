//! Faults of records: a delay between force and position, or a factor of the force, that the other records do
//! not have.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::gap::{MotionPart, part, square};
use super::noise_floor::non_systematic;
use super::residual_bootstrap::ResidualBootstrap;
use crate::measuring_chain::ChainFault;
use crate::policy::HELD_OUT_OUTLIER;
use dynamics::inverse_dynamics::{LinearForce, MotionSignal, Rigid, shifted_earlier};
use identification::motion::{ForceFit, half_widths};
use machine::Machine;
use numeric::filter::central_differences;
use numeric::linear_fit::LinearFit;

/// Delay and factor of one record relative to a model fitted to the records.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordShift {
    /// Name of the record.
    pub name: String,
    /// Delay of the position against the force (s).
    pub delay_s: f64,
    /// Half of its 95 % interval (s), with the autocorrelation of the residual.
    pub delay_half95_s: f64,
    /// ln of the ratio of its force to that of the model.
    pub gain: f64,
    /// Half of its 95 % interval.
    pub gain_half95: f64,
    /// Gap of the record with the model.
    pub gap: f64,
    /// Gap with its own delay and factor.
    pub gap_own: f64,
    /// Reduction of the squared gap by delay and factor. The least of three: of the residual by a small
    /// delay, by the delay as it is, and of the residual after the model moved within its covariance.
    pub gap_reduction: f64,
    /// Gap due to noise.
    pub floor: f64,
}

/// A record that contradicts the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// Name of the record.
    pub name: String,
    /// Ids of what is wrong, with the record.
    pub faults: Vec<String>,
    /// Description in words.
    pub description: String,
}

/// A rigid drive, its machine and the values of the machine's parameters.
type Model<'m> = (&'m Rigid, &'m Machine, &'m [f64]);

/// Covariance of a model's parameters after a fit.
pub(super) struct Covariance {
    /// Indices of the parameters.
    parameters: Vec<usize>,
    /// Root of the covariance: each column is a change by one standard deviation.
    root: DMatrix<f64>,
}

impl Covariance {
    /// Computes (Jᵀ·J/s² + 1/range²)⁻¹ of a fit. s² is the variance of the residual, corrected for its
    /// autocorrelation.
    pub fn new(fit: &ForceFit, machine: &Machine, motions: &[&MotionSignal]) -> Option<Self> {
        let records: Vec<(usize, Option<usize>)> = motions.iter().flat_map(|m| m.channels()).collect();
        let variance = fit.residual.norm_squared() / fit.residual.len() as f64
            * ResidualBootstrap::new(&fit.residual, &records).inflation();
        let ranges = DMatrix::from_diagonal(&DVector::from_iterator(
            fit.free.len(),
            fit.free.iter().map(|i| machine.parameters[*i].upper - machine.parameters[*i].lower),
        ));
        let columns = &fit.derivatives * &ranges;
        let normal =
            columns.tr_mul(&columns) / variance + DMatrix::identity(columns.ncols(), columns.ncols());
        let root = normal.cholesky()?.l().transpose().try_inverse()?;
        Some(Covariance { parameters: fit.free.clone(), root: ranges * root })
    }

    /// Returns the changes of a motion's force by one standard deviation, column by column.
    fn moves(&self, (rigid, machine, values): Model<'_>, motion: &MotionSignal) -> DMatrix<f64> {
        let columns = LinearForce::new(rigid, machine, values, &self.parameters, &[motion]).derivatives;
        columns.rows(0, motion.load.len()) * &self.root
    }
}

/// Estimates delay and factor of each record relative to a model, and the reduction of the gap by them beyond
/// the model's uncertainty.
pub(super) fn shifts(
    model: Model<'_>,
    motions: &[&MotionSignal],
    covariance: Option<&Covariance>,
) -> Vec<RecordShift> {
    motions.iter().filter_map(|motion| shift(model, motion, covariance)).collect()
}

fn shift(model: Model<'_>, motion: &MotionSignal, covariance: Option<&Covariance>) -> Option<RecordShift> {
    let (rigid, machine, values) = model;
    let predicted: MotionPart = part(rigid, machine, values, motion);
    let force = rigid.force(machine, values, motion);
    let slope: Vec<f64> = central_differences(&force).into_iter().map(|d| d / motion.step_s).collect();
    let columns = DMatrix::from_columns(&[
        DVector::from_vec(motion.thinned(&slope)?),
        DVector::from_vec(motion.thinned(&force)?),
    ]);
    let records = [(motion.load.len(), motion.period)];
    let left = DVector::from_vec(predicted.residual.clone());
    let fit = LinearFit::new(&columns, &left)?;
    let half = half_widths(&columns, &fit.residual, &records)?;
    let projection =
        covariance.and_then(|covariance| UncertaintyProjection::new(covariance.moves(model, motion), &left));
    let mut taken = left.norm_squared() - fit.residual.norm_squared();
    if let Some(projection) = projection {
        let left =
            projection.without(&DMatrix::from_columns(std::slice::from_ref(&left))).column(0).into_owned();
        taken = taken.min(
            left.norm_squared()
                - LinearFit::new(&projection.without(&columns), &left)?.residual.norm_squared(),
        );
    }
    // g·F(t − τ) ≈ g·F − g·τ·Ḟ. A delay that the record really has removes the residual when it is applied,
    // whatever the slope of the force promises.
    let factor = 1.0 + fit.coefficients[1];
    let delay_s = fit.coefficients[0] / factor;
    let shifted = shifted_earlier(&force, delay_s / motion.step_s);
    let change: Vec<f64> = shifted.iter().zip(&force).map(|(there, here)| factor * there - here).collect();
    let applied = &left - DVector::from_vec(motion.thinned(&change)?);
    taken = taken.min(left.norm_squared() - applied.norm_squared());
    let scale = square(&predicted.recorded).sqrt();
    Some(RecordShift {
        name: motion.name.clone(),
        delay_s,
        delay_half95_s: (half[0] / factor).abs(),
        gain: factor.max(1e-6).ln(),
        gain_half95: (half[1] / factor).abs(),
        gap: predicted.own_gap(),
        floor: non_systematic(&predicted, motion).first().map_or(0.0, |n| square(n).sqrt() / scale),
        gap_own: applied.norm() / scale,
        gap_reduction: taken / (scale * scale),
    })
}

/// Root mean square of standard deviations by which uncertain parameters of the model may move.
const MAX_MOVE: f64 = 2.0;

/// Projection of columns within a model's uncertainty: (Bᵀ·B + λ·1) with the least λ that keeps the
/// coefficients of a residual within [`MAX_MOVE`].
struct UncertaintyProjection {
    moves: DMatrix<f64>,
    normal: Cholesky<f64, Dyn>,
}

impl UncertaintyProjection {
    fn new(moves: DMatrix<f64>, left: &DVector<f64>) -> Option<Self> {
        let (normal, wanted) = (moves.tr_mul(&moves), moves.tr_mul(left));
        let mut ridge = 1e-9 * normal.trace();
        while ridge > 0.0 && ridge.is_finite() {
            let normal = (&normal + DMatrix::identity(moves.ncols(), moves.ncols()) * ridge).cholesky()?;
            if normal.solve(&wanted).norm_squared() <= MAX_MOVE * MAX_MOVE * moves.ncols() as f64 {
                return Some(UncertaintyProjection { moves, normal });
            }
            ridge *= 2.0;
        }
        None
    }

    /// Removes that part from columns.
    fn without(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        columns - &self.moves * self.normal.solve(&self.moves.tr_mul(columns))
    }
}

/// Least reductions by a record's own delay and factor: as a share of its squared gap, and of that beyond
/// noise. Then the least differences beyond the intervals of both: of the delay in steps of the record, and
/// of the factor.
const LEAST_REDUCTION: (f64, f64) = (0.1, 0.5);
const DELAY_STEPS: f64 = 0.1;
const FACTOR: f64 = 0.03;
/// Least reduction as a share of the squared gap of the machine as described, for a fitted record.
const LEAST_REDUCTION_NOMINAL: f64 = 0.25;

/// Returns the records whose delay or factor differs from that of the fitted ones.
pub(super) fn contradictions(fit: &[RecordShift], others: &[RecordShift], step_s: f64) -> Vec<Contradiction> {
    let middle = |of: fn(&RecordShift) -> f64| numeric::statistics::median(fit.iter().map(of)).unwrap_or(0.0);
    let (delay_s, gain) = (middle(|r| r.delay_s), middle(|r| r.gain));
    let largest_half95 = |of: fn(&RecordShift) -> f64| fit.iter().map(of).fold(0.0, f64::max);
    others
        .iter()
        .filter_map(|record| {
            let square = record.gap.powi(2);
            let much = record.gap_reduction > (LEAST_REDUCTION.0 * square).max(LEAST_REDUCTION.1 * (square - record.floor.powi(2)));
            let delay_difference = record.delay_s - delay_s;
            let more = record.gain - gain;
            let delayed = delay_difference.abs() > DELAY_STEPS * step_s + record.delay_half95_s.hypot(largest_half95(|r| r.delay_half95_s));
            let scaled = more.abs() > FACTOR + record.gain_half95.hypot(largest_half95(|r| r.gain_half95));
            if !much || !(delayed || scaled) {
                return None;
            }
            let (mut what, mut faults) = (Vec::new(), Vec::new());
            let mut id = |fault: ChainFault| faults.push(format!("{}@{}", fault.id(), record.name));
            if delayed {
                id(ChainFault::Delay(record.delay_s));
                what.push(format!(
                    "its position lags its force by {:.2} ms, that of the others by {:.2} ms",
                    1e3 * record.delay_s,
                    1e3 * delay_s
                ));
            }
            if scaled {
                id(ChainFault::Scale(more.exp()));
                what.push(format!("its force is {:.3} times that of the fitted records", more.exp()));
            }
            let description = format!(
                "{} contradicts the fitted records: {}; corrected for this, its gap is {:.2} % instead of {:.2} %",
                record.name,
                what.join(", and "),
                100.0 * record.gap_own,
                100.0 * record.gap
            );
            Some(Contradiction { name: record.name.clone(), faults, description })
        })
        .collect()
}

/// Returns those contradictions that explain a share of the gap of the machine as described (`before`), too:
/// the residual of an imperfectly modelled large effect is not a fault of a record.
pub(super) fn beyond_effects(
    found: &[Contradiction],
    shifts: &[RecordShift],
    before: &[MotionPart],
) -> Vec<Contradiction> {
    let explains = |contradiction: &&Contradiction| {
        shifts
            .iter()
            .find(|shift| shift.name == contradiction.name)
            .is_some_and(|shift| exceeds_effects(shift, before))
    };
    found.iter().filter(explains).cloned().collect()
}

/// Returns the held-out record of which far more is left than of any other, of the shifts of fitted and held-out ones.
pub(super) fn outlying([fitted, held_out]: &[Vec<RecordShift>; 2]) -> Option<Contradiction> {
    let worst = held_out.iter().max_by(|a, b| a.gap_own.total_cmp(&b.gap_own))?;
    let others = fitted.iter().chain(held_out).filter(|record| record.name != worst.name);
    let second = others.map(|record| record.gap).fold(0.0, f64::max);
    let is_far =
        second > 0.0 && worst.gap_own > HELD_OUT_OUTLIER.0 && worst.gap_own > HELD_OUT_OUTLIER.1 * second;
    is_far.then(|| Contradiction {
        name: worst.name.clone(),
        faults: Vec::new(),
        description: format!(
            "{} contradicts the fitted records: {:.2} % of its force is left, of theirs at most {:.2} %; something acts there that does not in the others",
            worst.name,
            100.0 * worst.gap,
            100.0 * second
        ),
    })
}

/// Whether a record's delay and factor explain a share of the gap of the machine as described.
fn exceeds_effects(shift: &RecordShift, before: &[MotionPart]) -> bool {
    let gap = before.iter().find(|part| part.name == shift.name).map_or(0.0, MotionPart::own_gap);
    shift.gap.powi(2) - shift.gap_own.powi(2) > LEAST_REDUCTION_NOMINAL * gap.powi(2)
}

/// Returns the fitted records that contradict the others; of two, both. Delay and factor must also explain a
/// share of the gap of the machine as described (`before`). The residual of an imperfectly modelled large
/// effect is not a fault of a record.
pub(super) fn faulty(shifts: &[RecordShift], before: &[MotionPart], step_s: f64) -> Vec<Contradiction> {
    if shifts.len() < 2 {
        return Vec::new();
    }
    let taken = |at: usize| shifts[at].gap.powi(2) - shifts[at].gap_own.powi(2);
    let against_others = |at: usize| {
        let others: Vec<RecordShift> =
            shifts.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, s)| s.clone()).collect();
        let much = taken(at) > 0.5 * shifts[at].gap.powi(2) && exceeds_effects(&shifts[at], before);
        let found = contradictions(&others, std::slice::from_ref(&shifts[at]), step_s).into_iter();
        found.filter(move |_| much).map(move |found| (taken(at), found))
    };
    let found: Vec<(f64, Contradiction)> = (0..shifts.len()).flat_map(against_others).collect();
    // A record that contradicts the others moves their middle: they then contradict it, each by less.
    let most = found.iter().map(|(taken, _)| *taken).fold(0.0, f64::max);
    found.into_iter().filter(|(taken, _)| *taken > 0.5 * most).map(|(_, found)| found).collect()
}
