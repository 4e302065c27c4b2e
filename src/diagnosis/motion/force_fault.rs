//! Sign and unit of the recorded force of one record, or of all: sought in every record before any effect.

use super::gap::{MotionPart, part, square};
use crate::measuring_chain::{ChainFault, SAME_SCALE, times};
use crate::policy::LEAST_UNIT;
use crate::{Verdict, VerdictKind};
use dynamics::inverse_dynamics::{InverseError, MotionSignal, Rigid};
use identification::motion::{ForceFit, estimate_identifiable};
use machine::Machine;

/// Factors between units of force or torque, what is recorded and what was meant.
const UNITS: [(f64, &str, &str); 3] = [(1e3, "N", "kN"), (9.80665, "N", "kgf"), (4.448_222, "N", "lbf")];
/// Share of the squared force that the machine as described leaves at least where its sign or unit is wrong
/// in all records (1).
const UNEXPLAINED: f64 = 0.5;
/// Largest share of the squared force of other records that the machine leaves where it judges a record, and
/// largest share of a squared deviation that remains once its sign or unit is corrected (1): nine tenths are
/// explained.
const REMAINS: f64 = 0.1;
/// Largest ratio of what two factors leave of the squared force at which they explain it equally well (1).
const SAME: f64 = 2.0;

/// A wrong sign or unit of the force.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ForceFault {
    /// Name of the record; `None` for all.
    record: Option<String>,
    /// Recorded force over that of the motion (1).
    factor: f64,
}

impl ForceFault {
    /// Returns the ids of what is wrong: a sign, a factor or both.
    pub fn ids(&self) -> impl Iterator<Item = String> {
        let at = self.record.as_ref().map_or(String::new(), |record| format!("@{record}"));
        let sign = (self.factor < 0.0).then_some(ChainFault::Polarity);
        let scale = is_scale(self.factor).then_some(ChainFault::Scale(self.factor));
        sign.into_iter().chain(scale).map(move |fault| format!("{}{at}", fault.id()))
    }

    /// Describes the fault in words.
    pub fn text(&self) -> String {
        let of = self.record.as_ref().map_or("all records".into(), |record| format!("record {record}"));
        let size = self.factor.abs();
        let cause = |factor: f64| {
            let [of, by] = [factor, 1.0 / factor]
                .map(|factor| UNITS.iter().find(|(unit, ..)| (factor / unit - 1.0).abs() < SAME_SCALE));
            let words = of
                .map(|(_, recorded, meant)| (recorded, meant))
                .or(by.map(|(_, recorded, meant)| (meant, recorded)));
            words.map_or(String::new(), |(recorded, meant)| format!(", as of {recorded} for {meant}"))
        };
        let times = match size {
            _ if !is_scale(size) => None,
            x => Some(format!("{}{}", times(x), cause(x))),
        };
        match (self.factor < 0.0, times) {
            (true, None) => format!("the sign of the force of {of} is reversed"),
            (true, Some(times)) => format!("the force of {of} has the wrong sign and is {times}"),
            (false, times) => format!("the force of {of} is {}", times.unwrap_or_default()),
        }
    }

    /// Corrects the records that it concerns.
    fn correct(&self, motions: &mut [MotionSignal]) {
        let concerned =
            |motion: &&mut MotionSignal| self.record.as_ref().is_none_or(|record| *record == motion.name);
        motions.iter_mut().filter(concerned).for_each(|motion| {
            multiply(motion, 1.0 / self.factor);
            // A reading that was reconstructed from the force is wrong with it.
            motion.extra_channels.retain(|channel| channel.encoder_estimate.is_none());
        });
    }
}

/// Returns faults in words.
pub(super) fn texts(found: &[ForceFault]) -> Vec<String> {
    found.iter().map(ForceFault::text).collect()
}

fn is_scale(factor: f64) -> bool {
    !(1.0 / LEAST_UNIT..=LEAST_UNIT).contains(&factor.abs())
}

fn multiply(motion: &mut MotionSignal, by: f64) {
    motion.load.iter_mut().for_each(|force| *force *= by);
}

/// Adds wrong signs and units of the force to the verdict on the corrected records. They are the verdict
/// where it names no effect.
pub(super) fn with_force_faults(verdict: Verdict, found: &[ForceFault]) -> Verdict {
    if found.is_empty() {
        return verdict;
    }
    let what = texts(found).join("; ");
    let faults = found.iter().flat_map(ForceFault::ids).chain(verdict.faults).collect();
    let reason = format!("{what}; corrected for this, {}", verdict.reason);
    if verdict.kind.explains() || verdict.kind == VerdictKind::Insufficient {
        return Verdict { faults, reason, ..verdict };
    }
    let next = "correct the files, or check sign and range of the force channel and record again".to_string();
    Verdict {
        kind: VerdictKind::Measurement,
        faults,
        reason,
        next_measurement: Some(next),
        confirmed: None,
        ..verdict
    }
}

/// A rigid drive, its machine, the free parameters and those of them that may keep their start values.
pub(super) struct Nominal<'n, S> {
    pub rigid: &'n Rigid,
    pub machine: &'n Machine,
    pub free: &'n [usize],
    pub may_stay: S,
}

impl<S: Fn(usize) -> bool> Nominal<'_, S> {
    fn fit(&self, motions: &[&MotionSignal]) -> Result<ForceFit, InverseError> {
        let start = self.machine.start();
        estimate_identifiable((self.rigid, self.machine), &start, self.free, motions, None, &self.may_stay)
    }

    /// Returns the share of the squared force of records that a fit to them leaves (1); infinite where they
    /// determine no fit.
    fn left(&self, motions: &[MotionSignal]) -> f64 {
        let recorded: f64 = motions.iter().map(|motion| square(&motion.load)).sum();
        self.fit(&motions.iter().collect::<Vec<_>>()).map_or(f64::INFINITY, |fit| fit.squares / recorded)
    }
}

/// Finds wrong signs and units of the force and corrects the records for them. The first `fitted` motions are
/// the fitted ones.
pub(super) fn correct(
    nominal: &Nominal<'_, impl Fn(usize) -> bool>,
    motions: &mut [MotionSignal],
    fitted: usize,
) -> Vec<ForceFault> {
    // The force alone is compared.
    let mut forces = motions.to_vec();
    forces.iter_mut().for_each(|motion| motion.extra_channels.clear());
    let mut found: Vec<ForceFault> = of_all(nominal, &forces).into_iter().collect();
    found.iter().for_each(|fault| fault.correct(&mut forces));
    for _ in 1..forces.len() {
        let Some(fault) = of_one(nominal, &forces, fitted) else { break };
        fault.correct(&mut forces);
        found.push(fault);
    }
    found.iter().for_each(|fault| fault.correct(motions));
    found
}

/// Returns the sign or unit of all records with which the machine explains them, where it does not as they
/// are.
fn of_all(nominal: &Nominal<'_, impl Fn(usize) -> bool>, motions: &[MotionSignal]) -> Option<ForceFault> {
    let as_recorded = nominal.left(motions);
    if !(as_recorded > UNEXPLAINED) || !as_recorded.is_finite() {
        return None;
    }
    let units = UNITS.iter().flat_map(|(unit, ..)| [*unit, 1.0 / unit]);
    let factors = std::iter::once(1.0)
        .chain(units)
        .flat_map(|factor| [-factor, factor])
        .filter(|factor| *factor != 1.0);
    let left = |factor: f64| {
        let mut corrected = motions.to_vec();
        corrected.iter_mut().for_each(|motion| multiply(motion, 1.0 / factor));
        (factor, nominal.left(&corrected))
    };
    let tried: Vec<(f64, f64)> = factors.map(left).collect();
    let least = tried.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
    // Wide ranges of the parameters allow several units: the smallest change is stated.
    let as_good = tried.into_iter().filter(|(_, left)| *left <= (SAME * least).min(REMAINS * as_recorded));
    let factor =
        as_good.map(|(factor, _)| factor).min_by(|a, b| a.abs().ln().abs().total_cmp(&b.abs().ln().abs()))?;
    Some(ForceFault { record: None, factor })
}

/// Returns the record whose force differs by sign or unit from that of a machine fitted to the others. Two
/// records may contradict each other: it is the held-out one then, and none where both are fitted.
fn of_one(
    nominal: &Nominal<'_, impl Fn(usize) -> bool>,
    motions: &[MotionSignal],
    fitted: usize,
) -> Option<ForceFault> {
    let against_others = |at: usize| {
        let others: Vec<&MotionSignal> =
            motions.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, motion)| motion).collect();
        let fit = nominal.fit(&others).ok()?;
        let others_left = fit.squares / others.iter().map(|motion| square(&motion.load)).sum::<f64>();
        let record: MotionPart = part(nominal.rigid, nominal.machine, &fit.values, &motions[at]);
        let (factor, deviation, left) = factor_of(&record)?;
        let factor = sign_and_unit(factor);
        let is_wrong = factor != 1.0 && others_left < REMAINS && left < REMAINS * deviation;
        let unexplained = left / square(&record.recorded) + others_left;
        is_wrong.then(|| (at, unexplained, ForceFault { record: Some(motions[at].name.clone()), factor }))
    };
    let claims: Vec<(usize, f64, ForceFault)> = (0..motions.len()).filter_map(against_others).collect();
    let is_mutual = motions.len() == 2 && claims.len() == 2;
    let eligible = claims.into_iter().filter(|(at, _, _)| !is_mutual || *at >= fitted);
    eligible.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(_, _, fault)| fault)
}

/// Returns the factor of a record's force that fits best, its squared deviation from the predicted force, and
/// what that factor leaves of it.
fn factor_of(record: &MotionPart) -> Option<(f64, f64, f64)> {
    let predicted: Vec<f64> = record
        .recorded
        .iter()
        .zip(&record.residual)
        .map(|(recorded, residual)| recorded - residual)
        .collect();
    let product: f64 =
        record.recorded.iter().zip(&predicted).map(|(recorded, predicted)| recorded * predicted).sum();
    let (own, deviation) = (square(&predicted), square(&record.residual));
    let factor = product / own;
    (own > 0.0 && factor != 0.0).then(|| (factor, deviation, square(&record.recorded) - product * factor))
}

/// Returns the sign of a factor, with the unit that it is near: other factors may be those of a missing
/// effect in a record at one speed.
fn sign_and_unit(factor: f64) -> f64 {
    let units = UNITS.iter().flat_map(|(unit, ..)| [*unit, 1.0 / unit]);
    let near = units.into_iter().find(|unit| (factor.abs() / unit - 1.0).abs() < SAME_SCALE);
    near.unwrap_or(1.0).copysign(factor)
}
