//! What a record says of its own measuring chain: a delay between force and position and a factor of the force that the others do not have.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::gap::{MotionPart, part, square};
use super::noise_floor::not_systematic;
use super::residual_bootstrap::ResidualBootstrap;
use dynamics::inverse_dynamics::{LinearForce, MotionSignal, Rigid};
use identification::motion::{ForceFit, intervals};
use machine::Machine;
use numeric::filter::central_differences;
use numeric::linear_fit::LinearFit;

/// Delay and factor of one record, beside a model fitted to the records.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordShift {
    /// Record.
    pub name: String,
    /// By how much its position comes late against its force (s).
    pub delay_s: f64,
    /// Half of its 95 % interval (s), as far as the residual's colour tells.
    pub delay_half95_s: f64,
    /// ln of what its force is of the model's.
    pub gain: f64,
    /// Half of its 95 % interval.
    pub gain_half95: f64,
    /// Gap of the record with the model.
    pub gap: f64,
    /// The same with its own delay and factor.
    pub gap_own: f64,
    /// What delay and factor take of its square, and of what is left of it where what is open of the model has moved as far as it may: the lesser.
    pub taken: f64,
    /// Gap that noise leaves.
    pub floor: f64,
}

/// A record that contradicts the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// Record.
    pub name: String,
    /// In words.
    pub description: String,
}

/// A rigid drive, its machine and the values of the machine's parameters.
type Model<'m> = (&'m Rigid, &'m Machine, &'m [f64]);

/// How far the fitted records leave a model's parameters open.
pub(super) struct Covariance {
    /// Indices of parameters.
    parameters: Vec<usize>,
    /// Each column moves them by a standard deviation.
    root: DMatrix<f64>,
}

impl Covariance {
    /// Of a fit: (Jᵀ·J/s² + 1/range²)⁻¹, s² the variance of what it leaves, as a mean of that varies.
    pub fn new(fit: &ForceFit, machine: &Machine, motions: &[&MotionSignal]) -> Option<Self> {
        let records: Vec<(usize, Option<usize>)> = motions.iter().flat_map(|m| m.channels()).collect();
        let variance =
            fit.residual.norm_squared() / fit.residual.len() as f64 * ResidualBootstrap::new(&fit.residual, &records).inflation();
        let ranges = DMatrix::from_diagonal(&DVector::from_iterator(
            fit.free.len(),
            fit.free.iter().map(|i| machine.parameters[*i].upper - machine.parameters[*i].lower),
        ));
        let columns = &fit.derivatives * &ranges;
        let normal = columns.tr_mul(&columns) / variance + DMatrix::identity(columns.ncols(), columns.ncols());
        let root = normal.cholesky()?.l().transpose().try_inverse()?;
        Some(Covariance { parameters: fit.free.clone(), root: ranges * root })
    }

    /// What that leaves open of the force of a motion, column by column.
    fn moves(&self, (rigid, machine, values): Model<'_>, motion: &MotionSignal) -> DMatrix<f64> {
        let columns = LinearForce::new(rigid, machine, values, &self.parameters, &[motion]).derivatives;
        columns.rows(0, motion.load.len()) * &self.root
    }
}

/// Delay and factor of each record that suit a model best, and what they take beside what is open of it.
pub(super) fn shifts(model: Model<'_>, motions: &[&MotionSignal], open: Option<&Covariance>) -> Vec<RecordShift> {
    motions.iter().filter_map(|motion| shift(model, motion, open)).collect()
}

fn shift(model: Model<'_>, motion: &MotionSignal, open: Option<&Covariance>) -> Option<RecordShift> {
    let (rigid, machine, values) = model;
    let as_is: MotionPart = part(rigid, machine, values, motion);
    let force = rigid.force(machine, values, motion);
    let rising: Vec<f64> = central_differences(&force).into_iter().map(|d| d / motion.step_s).collect();
    let columns = DMatrix::from_columns(&[DVector::from_vec(motion.thinned(&rising)?), DVector::from_vec(motion.thinned(&force)?)]);
    let records = [(motion.load.len(), motion.period)];
    let left = DVector::from_vec(as_is.residual.clone());
    let fit = LinearFit::new(&columns, &left)?;
    let half = intervals(&columns, &fit.residual, &records)?;
    let given = open.and_then(|open| Given::new(open.moves(model, motion), &left));
    let mut taken = left.norm_squared() - fit.residual.norm_squared();
    if let Some(given) = given {
        let left = given.without(&DMatrix::from_columns(&[left])).column(0).into_owned();
        taken = taken.min(left.norm_squared() - LinearFit::new(&given.without(&columns), &left)?.residual.norm_squared());
    }
    let scale = as_is.recorded.iter().map(|x| x * x).sum::<f64>().sqrt();
    Some(RecordShift {
        name: motion.name.clone(),
        delay_s: fit.coefficients[0],
        delay_half95_s: half[0].half95,
        gain: (1.0 + fit.coefficients[1]).max(1e-6).ln(),
        gain_half95: half[1].half95,
        gap: as_is.own_gap(),
        floor: not_systematic(&as_is, motion).first().map_or(0.0, |n| square(n).sqrt() / scale),
        gap_own: fit.residual.norm() / scale,
        taken: taken / (scale * scale),
    })
}

/// Standard deviations, root mean square, by which what is open of a model may move.
const MOVES: f64 = 2.0;

/// Least squares of a few columns whose coefficients are bounded: (Bᵀ·B + λ·1), λ the least for which those of what is left of a record move no farther than
/// they may.
struct Given {
    moves: DMatrix<f64>,
    normal: Cholesky<f64, Dyn>,
}

impl Given {
    fn new(moves: DMatrix<f64>, left: &DVector<f64>) -> Option<Self> {
        let (normal, wanted) = (moves.tr_mul(&moves), moves.tr_mul(left));
        let mut ridge = 1e-9 * normal.trace();
        while ridge > 0.0 && ridge.is_finite() {
            let normal = (&normal + DMatrix::identity(moves.ncols(), moves.ncols()) * ridge).cholesky()?;
            if normal.solve(&wanted).norm_squared() <= MOVES * MOVES * moves.ncols() as f64 {
                return Some(Given { moves, normal });
            }
            ridge *= 2.0;
        }
        None
    }

    /// Columns without that.
    fn without(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        columns - &self.moves * self.normal.solve(&self.moves.tr_mul(columns))
    }
}

/// Share of a record's squared gap, and of what noise does not leave of it, that its own delay and factor must take away to be told, and by how much they
/// must differ: the delay in steps of the record beside the intervals of both.
const TAKES: (f64, f64) = (0.1, 0.5);
const STEPS: f64 = 0.1;
const GAIN: f64 = 0.03;
/// Share that they must take of what the machine as described leaves of a fitted record.
const TAKES_OF_ALL: f64 = 0.25;

/// Records whose delay or factor is not that of the fitted ones.
pub(super) fn contradictions(fit: &[RecordShift], others: &[RecordShift], step_s: f64) -> Vec<Contradiction> {
    let middle = |of: fn(&RecordShift) -> f64| numeric::statistics::median(fit.iter().map(of)).unwrap_or(0.0);
    let (delay_s, gain) = (middle(|r| r.delay_s), middle(|r| r.gain));
    let sure = |of: fn(&RecordShift) -> f64| fit.iter().map(of).fold(0.0, f64::max);
    others
        .iter()
        .filter_map(|record| {
            let square = record.gap.powi(2);
            let much = record.taken > (TAKES.0 * square).max(TAKES.1 * (square - record.floor.powi(2)));
            let late = record.delay_s - delay_s;
            let more = record.gain - gain;
            let delayed = late.abs() > STEPS * step_s + record.delay_half95_s.hypot(sure(|r| r.delay_half95_s));
            let scaled = more.abs() > GAIN + record.gain_half95.hypot(sure(|r| r.gain_half95));
            if !much || !(delayed || scaled) {
                return None;
            }
            let mut what = Vec::new();
            if delayed {
                what.push(format!("its position comes {:.2} ms after its force, theirs {:.2} ms", 1e3 * record.delay_s, 1e3 * delay_s));
            }
            if scaled {
                what.push(format!("its force is {:.3} times that of the records that were fitted", more.exp()));
            }
            let says = format!(
                "{} contradicts the fitted records: {}; with that set right its gap is {:.2} % for {:.2} %",
                record.name,
                what.join(", and "),
                100.0 * record.gap_own,
                100.0 * record.gap
            );
            Some(Contradiction { name: record.name.clone(), description: says })
        })
        .collect()
}

/// Fitted records that contradict the others: the one, or where there are but two, both. Of what the machine as described leaves of a record (`before`) its
/// delay and factor must take their share, too: what an imperfect form of a large effect leaves is no fault of a record.
pub(super) fn faulty(shifts: &[RecordShift], before: &[MotionPart], step_s: f64) -> Vec<Contradiction> {
    if shifts.len() < 2 {
        return Vec::new();
    }
    let against_others = |at: usize| {
        let others: Vec<RecordShift> = shifts.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, s)| s.clone()).collect();
        let taken = shifts[at].gap.powi(2) - shifts[at].gap_own.powi(2);
        let gap = before.iter().find(|part| part.name == shifts[at].name).map_or(0.0, MotionPart::own_gap);
        let much = taken > 0.5 * shifts[at].gap.powi(2) && taken > TAKES_OF_ALL * gap.powi(2);
        contradictions(&others, std::slice::from_ref(&shifts[at]), step_s).into_iter().filter(move |_| much)
    };
    (0..shifts.len()).flat_map(against_others).collect()
}
