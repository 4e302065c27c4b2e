//! Faults of records: a channel that contradicts the others, or records assigned to each other's positions.

use rayon::prelude::*;

use super::chain_of_records::{GapLimits, Records, channel, fault_of_some, fault_of_some_with_others};
use super::evidence::{Domain, PartialGap};
use super::facts::FaultFacts;
use super::fit::{Fitted, Fitter, at_start};
use super::hypothesis::Hypothesis;
use super::measuring_chain::{ChainCandidate, ChainFault};
use super::policy::{HELD_OUT_OUTLIER, OUTLIER, Policy};
use identification::objective::ObjectiveError;
use long_work::Control;
use measurement::{HoldOutSet, MeasurementSet};
use numeric::parallel::OrFirstError;
use numeric::statistics::quantile;

/// A fault of the records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Fault {
    /// No FRF holds a signal.
    NoSignal,
    /// This FRF holds no signal.
    Noise(usize),
    /// The second FRF is a copy of the first.
    Copied(usize, usize),
    /// No FRF shows a resonance.
    NoResonance,
    /// All FRFs agree within their noise but for a factor, as if measured at this position.
    OnePosition(usize),
    /// The measuring chain of all FRFs has a fault.
    OfAll(ChainCandidate),
    /// The measuring chain of these FRFs has a fault.
    OfSome(ChainFault, Records),
    /// These FRFs contradict the others.
    Contradicts(Records),
    /// These two FRFs are assigned to each other's positions.
    Exchanged(usize, usize),
}

/// Steps of a fit without one record, or with two records exchanged.
const STEPS: u64 = 25;
/// Number of most likely pairs of records that are fitted from many starts.
const MOST_LIKELY: usize = 3;
impl Fault {
    /// Returns it as a verdict states it.
    pub fn facts(self, set: &MeasurementSet) -> FaultFacts {
        let (reason, next_measurement) = self.fault_text(set);
        let is_insufficient = self == Fault::NoResonance;
        FaultFacts { ids: self.ids(set), reason, next_measurement, is_insufficient }
    }

    /// Returns the ids of what is wrong, each with its record where it is one; none for a contradiction
    /// without a known cause.
    fn ids(self, set: &MeasurementSet) -> Vec<String> {
        let name = |frf: usize| Records::One(frf).name(set);
        match self {
            Fault::NoSignal => vec!["noise".into()],
            Fault::Noise(frf) => vec![format!("noise@{}", name(frf))],
            Fault::Copied(_, copy) => vec![format!("copied-record@{}", name(copy))],
            Fault::NoResonance => Vec::new(),
            Fault::OnePosition(_) => vec!["copied-record".into()],
            Fault::OfAll(found) => vec![found.fault.id().into()],
            Fault::OfSome(fault, records) => vec![format!("{}@{}", fault.id(), records.name(set))],
            Fault::Contradicts(_) => Vec::new(),
            Fault::Exchanged(a, b) => [a, b].map(|frf| format!("swapped-records@{}", name(frf))).into(),
        }
    }

    /// Returns the reason and the proposed measurement.
    fn fault_text(self, set: &MeasurementSet) -> (String, String) {
        let source = |frf: usize| &set.frfs[frf].source;
        let position = |frf: usize| set.frfs[frf].position.map_or("?", |p| &set.positions[p].name);
        match self {
            Fault::NoSignal => (
                "the records hold no signal: the phases of their neighbouring lines are unrelated".into(),
                "check hammer, sensors and cables, and measure again".into(),
            ),
            Fault::Noise(frf) => (
                format!("{} holds no signal: the phases of its neighbouring lines are unrelated", source(frf)),
                format!("measure {} again; check sensor and cable of that channel", source(frf)),
            ),
            Fault::Copied(first, copy) => (
                format!("{} is a copy of {}, though at another position: all their values are equal", source(copy), source(first)),
                "check which of both was measured where, and measure the other".into(),
            ),
            Fault::NoResonance => (
                "no record shows a resonance: but for noise each follows a power of the frequency, as a mass, spring or damper does; such records hardly \
                 tell joints apart"
                    .into(),
                "measure up to frequencies of several modes; check which quantity was measured".into(),
            ),
            Fault::OnePosition(at) => (
                format!(
                    "the records of all positions differ by noise and a factor alone, as if all were measured at {0}: taken as measured there, and \
                     scaled alike, they agree with the model",
                    set.positions[at].name
                ),
                "check at which position each record was measured, and measure at the others".into(),
            ),
            Fault::OfAll(fault) => (
                format!("{}; corrected for it, the records agree with the model", fault.text()),
                "correct the files, or measure one record again with a known chain".into(),
            ),
            Fault::OfSome(fault, Records::One(frf)) => (
                format!("{}; corrected for it, the record agrees with the model and the others", fault.text(source(frf))),
                format!("correct {}, or measure it again; check sensor, mounting and cable of that channel", source(frf)),
            ),
            Fault::OfSome(fault, records) => (
                format!("{}; corrected for it, they agree with the model and the others", fault.text(&records.text(set))),
                format!("correct {}, or measure again; check sensor, mounting and cable of that channel", records.text(set)),
            ),
            Fault::Contradicts(Records::One(frf)) => (
                format!("{} contradicts the other records, which agree with the model once it is left out", source(frf)),
                format!("measure {} again; check sensor, mounting and cable of that channel", source(frf)),
            ),
            Fault::Contradicts(records) => (
                format!("{} contradict the others, which agree with the model once they are left out", records.text(set)),
                "check sensor, mounting and cable of that channel, and measure again".into(),
            ),
            Fault::Exchanged(a, b) => (
                format!(
                    "{} and {} are exchanged: assigned to {} and {}, they agree with the model and the other records",
                    source(a),
                    source(b),
                    position(b),
                    position(a)
                ),
                format!("check at which position each of {} and {} was measured, or measure one of them again", source(a), source(b)),
            ),
        }
    }
}

/// A fit without some records, which contradict it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Contradiction {
    pub records: Records,
    fitted: Fitted,
    /// Misfit of the others per compared number.
    pub rest: f64,
    /// Misfit of these records per compared number.
    own: f64,
}

/// Returns the record, or the channel, without which the others agree with the model best by far, though it
/// does not; whether they agree is not asked.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn contradiction(
    fitter: &Fitter<'_>,
    nominal: (&Hypothesis, &Fitted),
    control: &Control,
) -> Result<Option<Contradiction>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(None) };
    let policy = Policy::of(fitter.domain.kind());
    let (set, frfs) = (fitter.fit.set(), fitter.fit.frfs());
    let single: Vec<Records> =
        if frfs.len() < 3 { Vec::new() } else { frfs.iter().map(|frf| Records::One(*frf)).collect() };
    let first = |at: &usize| frfs[..*at].iter().all(|other| channel(set, *other) != channel(set, frfs[*at]));
    let channels = (0..frfs.len()).filter(first).map(|at| Records::Channel(frfs[at]));
    // A channel of one record is that record. One record alone agrees with any model.
    let several = |channel: &Records| {
        let own = frfs.iter().filter(|frf| channel.contain(set, **frf)).count();
        own > 1 && frfs.len() > own + 1
    };
    for candidates in [single, channels.filter(several).collect()] {
        let fits: Result<Vec<Contradiction>, ObjectiveError> =
            candidates.par_iter().map(|left| without(fitter, nominal, *left, control)).or_first_error();
        let mut fits = fits?;
        fits.sort_by(|a, b| b.rest.total_cmp(&a.rest));
        let (Some(worst), Some(second)) = (fits.pop(), fits.pop()) else { continue };
        if control.stopped() {
            return Ok(None);
        }
        if worst.own > policy.contradicting * worst.rest
            && second.rest > policy.contradicting_alone * worst.rest
        {
            return Ok(Some(worst));
        }
    }
    Ok(None)
}

/// Fits the nominal machine without some records.
fn without(
    fitter: &Fitter<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    left: Records,
    control: &Control,
) -> Result<Contradiction, ObjectiveError> {
    let set = fitter.fit.set();
    let kept = fitter.on(fitter.fit.with_frfs(|frf| !left.contain(set, frf)));
    let objective = kept.objective(nominal)?;
    // The records may have led the joints far astray.
    let described = at_start(nominal);
    let mut ends = [base, &described].map(|start| kept.descend(&objective, start, STEPS, control)).to_vec();
    ends.push(kept.multistart(nominal, &described, 0, control)?);
    ends.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    let fitted = ends.swap_remove(0);
    let own = fitter.on(fitter.fit.with_frfs(|frf| left.contain(set, frf)));
    let count = own.objective(nominal)?.observations() as f64;
    let (rest, own) =
        (fitted.chi_square / objective.observations() as f64, own.loss(nominal, &fitted)? / count);
    Ok(Contradiction { records: left, fitted, rest, own })
}

impl Contradiction {
    /// Whether a fault of the measuring chain that no effect imitates makes the records agree with a model of
    /// the others.
    pub fn is_corrected_wholly(&self, fitter: &Fitter<'_>, nominal: &Hypothesis) -> bool {
        self.cause(fitter, nominal).is_ok_and(|cause| cause.is_some_and(|cause| !cause.is_gradual()))
    }

    /// Returns the fault of the measuring chain with which the records agree with a model of the others.
    ///
    /// # Errors  as [`Fitter::objective`].
    fn cause(&self, fitter: &Fitter<'_>, nominal: &Hypothesis) -> Result<Option<ChainFault>, ObjectiveError> {
        let (Contradiction { records, fitted, .. }, set) = (self, fitter.fit.set());
        let kept = fitter.on(fitter.fit.with_frfs(|frf| !records.contain(set, frf)));
        let limits = GapLimits::of(&kept.gaps(nominal, fitted, &kept.fit.to_predict())?);
        fault_of_some(&kept, &fitter.fit.to_predict(), (nominal, fitted), *records, limits)
    }

    /// Returns the fault, with its cause where one of the measuring chain is found: with it corrected, all
    /// records agree with the model.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn fault(
        &self,
        fitter: &Fitter<'_>,
        nominal: &Hypothesis,
        agrees: impl Fn(f64) -> bool + Sync,
        control: &Control,
    ) -> Result<Fault, ObjectiveError> {
        let Contradiction { records, fitted, .. } = self;
        let cause = match self.cause(fitter, nominal)? {
            None => fault_of_some_with_others(fitter, (nominal, fitted), *records, agrees, control)?,
            cause => cause,
        };
        Ok(cause.map_or(Fault::Contradicts(*records), |fault| Fault::OfSome(fault, *records)))
    }
}

/// Returns the set with two records at each other's positions.
fn with_exchanged(set: &MeasurementSet, (a, b): (usize, usize)) -> MeasurementSet {
    let mut other = set.clone();
    (other.frfs[a].position, other.frfs[b].position) = (set.frfs[b].position, set.frfs[a].position);
    other
}

/// Returns pairs of records of one channel at two positions.
pub(super) fn pairs<'p>(
    set: &'p MeasurementSet,
    frfs: &'p [usize],
    others: &'p [usize],
) -> impl Iterator<Item = (usize, usize)> + 'p {
    let alike = move |a: usize, b: usize| {
        let (a, b) = (&set.frfs[a], &set.frfs[b]);
        (&a.response, &a.excitation, a.quantity) == (&b.response, &b.excitation, b.quantity)
            && a.position.is_some()
            && b.position.is_some()
            && a.position != b.position
    };
    let twice = move |a: usize, b: usize| frfs.contains(&b) && b < a;
    frfs.iter()
        .flat_map(move |&a| others.iter().map(move |&b| (a, b)))
        .filter(move |&(a, b)| alike(a, b) && !twice(a, b))
}

/// Returns the pairs of two fitted records, or of a fitted and a held-out one, whose exchange reduces χ²
/// most, each with the least χ².
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn exchanged(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    control: &Control,
) -> Result<Vec<(Fault, f64)>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(Vec::new()) };
    let set = fitter.fit.set();
    let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
    let candidates: Vec<(usize, usize)> = pairs(set, fitter.fit.frfs(), &all).collect();
    let near = |pair: (usize, usize)| {
        let other = with_exchanged(set, pair);
        let right = fitter.on(fitter.fit.in_version(&other));
        let fitted = right.descend(&right.objective(nominal)?, base, STEPS, control);
        Ok::<_, ObjectiveError>((pair, fitted.chi_square))
    };
    let mut fits: Vec<((usize, usize), f64)> = candidates.into_par_iter().map(near).or_first_error()?;
    fits.sort_by(|a, b| a.1.total_cmp(&b.1));
    fits.truncate(MOST_LIKELY);
    // Records at wrong positions lead the joint parameters far astray: fit the most likely pairs from many
    // starts.
    let far = |(pair, chi_square): ((usize, usize), f64)| {
        let other = with_exchanged(set, pair);
        let right = fitter.on(fitter.fit.in_version(&other));
        let again = right.multistart(nominal, base, 0, control)?.chi_square;
        Ok((Fault::Exchanged(pair.0, pair.1), again.min(chi_square)))
    };
    fits.into_iter().map(far).collect()
}

/// Returns the fault of a held-out record that is far off while all others are not: exchanged with another,
/// or contradicting.
///
/// # Errors  as [`Fitter::gaps`].
pub(super) fn held_out_fault(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    gaps: &[PartialGap],
) -> Result<Option<Fault>, ObjectiveError> {
    if gaps.is_empty() {
        return Ok(None);
    }
    let set = fitter.fit.set();
    // Of three held-out records two may be exchanged: fitted ones tell what is ordinary, too.
    let fitted = fitter.gaps(nominal, base, &fitter.fit.to_predict())?;
    let all = gaps.iter().chain(&fitted).map(|p| p.gap);
    let Some(middle) = quantile(all, 0.5) else { return Ok(None) };
    let outlying: Vec<usize> =
        gaps.iter().filter(|p| p.gap > OUTLIER.0 * middle).filter_map(|p| p.frf).collect();
    for pair in pairs(set, &outlying, &outlying) {
        let other = with_exchanged(set, pair);
        let two = held_out.in_version(&other).with_frfs(|frf| frf == pair.0 || frf == pair.1);
        if fitter.gaps(nominal, base, &two)?.iter().all(|p| p.gap < OUTLIER.1 * middle) {
            return Ok(Some(Fault::Exchanged(pair.0, pair.1)));
        }
    }
    let Some(frf) = contradicting(gaps) else { return Ok(None) };
    let one = Records::One(frf);
    let others: Vec<PartialGap> = gaps.iter().filter(|part| part.frf != Some(frf)).cloned().collect();
    let cause = fault_of_some(fitter, held_out, (nominal, base), one, GapLimits::of(&others))?;
    Ok(Some(cause.map_or(Fault::Contradicts(one), |fault| Fault::OfSome(fault, one))))
}

/// Returns a held-out record with a large gap where all others have small ones.
fn contradicting(held_out: &[PartialGap]) -> Option<usize> {
    let mut gaps: Vec<(f64, Option<usize>)> = held_out.iter().map(|p| (p.gap, p.frf)).collect();
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(worst, frf), (second, _), ..] = gaps[..] else { return None };
    frf.filter(|_| worst > HELD_OUT_OUTLIER.0 && worst > HELD_OUT_OUTLIER.1 * second)
}
