//! What a record says of its own measuring chain: a delay between force and position and a factor of the force that the others do not have.

use nalgebra::{DMatrix, DVector};

use super::gap::{MotionPart, part};
use crate::inverse_dynamics::{Motion, Projected, Rigid, intervals};
use crate::machine::Machine;
use crate::numeric::filter::central_differences;

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
}

/// A record that contradicts the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// Record.
    pub name: String,
    /// In words.
    pub says: String,
}

/// Delay and factor of each record that suit a model best.
pub fn shifts(rigid: &Rigid, machine: &Machine, values: &[f64], motions: &[&Motion]) -> Vec<RecordShift> {
    motions.iter().filter_map(|motion| shift(rigid, machine, values, motion)).collect()
}

fn shift(rigid: &Rigid, machine: &Machine, values: &[f64], motion: &Motion) -> Option<RecordShift> {
    let as_is: MotionPart = part(rigid, machine, values, motion);
    let force = rigid.force(machine, values, motion);
    let rising: Vec<f64> = central_differences(&force).into_iter().map(|d| d / motion.step_s).collect();
    let columns = DMatrix::from_columns(&[DVector::from_vec(motion.thinned(&rising)?), DVector::from_vec(motion.thinned(&force)?)]);
    let fit = Projected::new(&columns, &DVector::from_vec(as_is.residual.clone()))?;
    let half = intervals(&columns, &fit.residual, &[(motion.load.len(), motion.period)])?;
    let scale = as_is.recorded.iter().map(|x| x * x).sum::<f64>().sqrt();
    Some(RecordShift {
        name: motion.name.clone(),
        delay_s: fit.coefficients[0],
        delay_half95_s: half[0].half95,
        gain: (1.0 + fit.coefficients[1]).max(1e-6).ln(),
        gain_half95: half[1].half95,
        gap: as_is.own_gap(),
        gap_own: fit.residual.norm() / scale,
    })
}

/// Share of a record's squared gap that its own delay and factor must take away to be told, and by how much they must differ: the delay in
/// steps of the record beside the intervals of both.
const TAKES: f64 = 0.1;
const STEPS: f64 = 0.1;
const GAIN: f64 = 0.03;
/// Share that they must take of what the machine as described leaves of a fitted record.
const TAKES_OF_ALL: f64 = 0.25;

/// Records whose delay or factor is not that of the fitted ones.
pub(super) fn contradictions(fit: &[RecordShift], others: &[RecordShift], step_s: f64) -> Vec<Contradiction> {
    let middle = |of: fn(&RecordShift) -> f64| crate::numeric::statistics::median(fit.iter().map(of)).unwrap_or(0.0);
    let (delay_s, gain) = (middle(|r| r.delay_s), middle(|r| r.gain));
    let sure = |of: fn(&RecordShift) -> f64| fit.iter().map(of).fold(0.0, f64::max);
    others
        .iter()
        .filter_map(|record| {
            let takes = 1.0 - (record.gap_own / record.gap).powi(2);
            let late = record.delay_s - delay_s;
            let more = record.gain - gain;
            let delayed = late.abs() > STEPS * step_s + record.delay_half95_s.hypot(sure(|r| r.delay_half95_s));
            let scaled = more.abs() > GAIN + record.gain_half95.hypot(sure(|r| r.gain_half95));
            if takes < TAKES || !(delayed || scaled) {
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
            Some(Contradiction { name: record.name.clone(), says })
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
