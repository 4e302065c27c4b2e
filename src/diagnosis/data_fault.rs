//! Faults of records: a channel that contradicts the others, or records assigned to each other's positions.

use rayon::prelude::*;

use super::chain_of_records::{
    GapLimits, OUTLIER, Records, channel, fault_of_some, fault_of_some_with_others,
};
use super::evidence::{Domain, PartialGap};
use super::fit::{Fitted, Fitter, at_start};
use super::hypothesis::Hypothesis;
use super::measuring_chain::{ChainCandidate, ChainFault};
use super::null_distribution::NullDistribution;
use super::ranking::EQUIVALENT;
use super::verdict::VerdictKind;
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
    /// The machine as described agrees with the records, and a fault of the measuring chain of all FRFs
    /// accounts for the little that an effect reduces.
    Possible(ChainCandidate),
    /// The measuring chain of these FRFs has a fault.
    OfSome(ChainFault, Records),
    /// These FRFs contradict the others.
    Contradicts(Records),
    /// These two FRFs are assigned to each other's positions.
    Exchanged(usize, usize),
}

/// Largest excess of the misfit with which the other records agree with the model.
pub(super) const AGREES: f64 = 1.6;
/// Steps of a fit without one record, or with two records exchanged.
const STEPS: u64 = 25;
/// Number of most likely pairs of records that are fitted from many starts.
const MOST_LIKELY: usize = 3;
/// Largest share of χ² that remains once exchanged records are corrected. Second, the allowance on the excess
/// as a share of that before: the null distribution was simulated about the wrong fit.
pub(super) const RESTORED: (f64, f64) = (0.2, 0.01);

impl Fault {
    /// Whether it is stated, and not only as likely as an effect.
    pub fn is_certain(self) -> bool {
        !matches!(self, Fault::Possible(_))
    }

    /// Returns the kind of the verdict that states it.
    pub fn verdict_kind(self) -> VerdictKind {
        if self == Fault::NoResonance { VerdictKind::Insufficient } else { VerdictKind::Measurement }
    }

    /// Returns id, reason and proposed measurement of a fault that is only as likely as an effect.
    pub fn possible(self, set: &MeasurementSet) -> Option<(String, (String, String))> {
        let Fault::Possible(found) = self else { return None };
        Some((found.fault.id().into(), self.fault_text(set)))
    }

    /// Returns the ids of what is wrong, each with its record where it is one; none for a contradiction
    /// without a known cause.
    pub fn ids(self, set: &MeasurementSet) -> Vec<String> {
        let name = |frf: usize| Records::One(frf).name(set);
        match self {
            Fault::NoSignal => vec!["noise".into()],
            Fault::Noise(frf) => vec![format!("noise@{}", name(frf))],
            Fault::Copied(_, copy) => vec![format!("copied-record@{}", name(copy))],
            Fault::NoResonance => Vec::new(),
            Fault::OnePosition(_) => vec!["copied-record".into()],
            Fault::OfAll(found) => vec![found.fault.id().into()],
            Fault::Possible(_) => Vec::new(),
            Fault::OfSome(fault, records) => vec![format!("{}@{}", fault.id(), records.name(set))],
            Fault::Contradicts(_) => Vec::new(),
            Fault::Exchanged(a, b) => [a, b].map(|frf| format!("swapped-records@{}", name(frf))).into(),
        }
    }

    /// Returns the reason and the proposed measurement.
    pub fn fault_text(self, set: &MeasurementSet) -> (String, String) {
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
            Fault::OfAll(fault) | Fault::Possible(fault) => (
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

/// Returns the fault that best explains why no model fits; `None` where the records do not contradict each
/// other. Where a contradiction was sought already, it is not sought again.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn fault(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    nominal: (&Hypothesis, &Fitted),
    sought: Option<Option<Contradiction>>,
    null: &NullDistribution,
    control: &Control,
) -> Result<Option<Fault>, ObjectiveError> {
    let Domain::Frf(_) = fitter.domain else { return Ok(None) };
    if let Some((a, b)) = exchanged(fitter, held_out, nominal, null, control)? {
        return Ok(Some(Fault::Exchanged(a, b)));
    }
    let found = match sought {
        None => contradiction(fitter, nominal, control)?,
        Some(found) => found,
    };
    found
        .filter(|found| null.excess(found.rest) <= AGREES)
        .map(|found| found.fault(fitter, nominal.0, null, control))
        .transpose()
}

/// Returns the fault of the measuring chain of all records that explains the misfit of the nominal machine:
/// the corrected data agree with it, and no effect explains the data as they are with as few parameters.
/// Where the records agree nearly as they are, a fault is certain only if no effect explains as much: every
/// chain has some corner far from its band, and small effects resemble it. `rival`: χ² and number of
/// parameters of the best significant effect.
pub(super) fn chain_fault(
    best: ChainCandidate,
    base: f64,
    rival: Option<(f64, usize)>,
    count: f64,
    null: &NullDistribution,
) -> Option<Fault> {
    let reach = AGREES + RESTORED.1 * null.excess(base / count);
    if null.excess(best.chi_square / count) > reach {
        return None;
    }
    let (explains, is_certain) = match rival {
        None => (best.chi_square <= RESTORED.0 * base, true),
        // Of two explanations that the data cannot tell apart, the simpler one is named.
        Some((chi_square, added)) => {
            let margin = EQUIVALENT * null.excess(chi_square / count);
            let is_better = best.chi_square <= chi_square - margin;
            let is_simpler = best.fault.parameters() < added && best.chi_square <= chi_square + margin;
            (is_better || is_simpler, is_better || null.excess(base / count) > AGREES)
        }
    };
    let fault = if is_certain { Fault::OfAll } else { Fault::Possible };
    explains.then(|| fault(best))
}

/// A fit without some records, which contradict it.
pub(super) struct Contradiction {
    records: Records,
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
        if worst.own > 10.0 * worst.rest && second.rest > 2.5 * worst.rest {
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

    /// Returns the fault, with its cause where one of the measuring chain is found.
    fn fault(
        &self,
        fitter: &Fitter<'_>,
        nominal: &Hypothesis,
        null: &NullDistribution,
        control: &Control,
    ) -> Result<Fault, ObjectiveError> {
        let Contradiction { records, fitted, .. } = self;
        let cause = match self.cause(fitter, nominal)? {
            None => fault_of_some_with_others(
                fitter,
                (nominal, fitted),
                *records,
                |misfit| null.excess(misfit) <= AGREES,
                control,
            )?,
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

/// Returns two fitted records, or a fitted and a held-out one, whose exchange makes the model fit.
fn exchanged(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    (nominal, base): (&Hypothesis, &Fitted),
    null: &NullDistribution,
    control: &Control,
) -> Result<Option<(usize, usize)>, ObjectiveError> {
    let set = fitter.fit.set();
    let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
    let candidates: Vec<(usize, usize)> = pairs(set, fitter.fit.frfs(), &all).collect();
    let fits: Result<Vec<_>, ObjectiveError> = candidates
        .into_par_iter()
        .map(|pair| {
            let other = with_exchanged(set, pair);
            let right = fitter.on(fitter.fit.in_version(&other));
            let fitted = right.descend(&right.objective(nominal)?, base, STEPS, control);
            Ok((pair, fitted.chi_square))
        })
        .or_first_error();
    let mut fits = fits?;
    fits.sort_by(|a, b| a.1.total_cmp(&b.1));
    let count = fitter.objective(nominal)?.observations() as f64;
    let reach = AGREES + RESTORED.1 * null.excess(base.chi_square / count);
    // Records at wrong positions lead the joint parameters far astray: fit the most likely pairs from many
    // starts.
    for (pair, chi_square) in fits.into_iter().take(MOST_LIKELY) {
        let other = with_exchanged(set, pair);
        let right = fitter.on(fitter.fit.in_version(&other));
        let again = right.multistart(nominal, base, 0, control)?.chi_square;
        let least = again.min(chi_square);
        if least <= RESTORED.0 * base.chi_square && null.excess(least / count) <= reach {
            return Ok(Some(pair));
        }
    }
    Ok(None)
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
    let set = fitter.fit.set();
    let Some(middle) = quantile(gaps.iter().map(|p| p.gap), 0.5) else { return Ok(None) };
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
    frf.filter(|_| worst > 0.2 && worst > 8.0 * second)
}
