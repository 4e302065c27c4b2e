//! Faults of the measuring chain of one record, or of all records of one channel, from the ratio of measured
//! to predicted FRF. A model of the other records predicts.

use std::convert::Infallible;
use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use super::evidence::{Domain, PartialGap, gap_over};
use super::fit::{Fitted, Fitter, coordinates_of, values_of};
use super::hypothesis::Hypothesis;
use super::measuring_chain::{ChainFault, FREQUENCY_SCALES, MOUNT_RATIOS};
use super::policy::OUTLIER;
use identification::Tail;
use identification::objective::{FrfObjective, ObjectiveError};
use long_work::Control;
use measurement::{HoldOutSet, MeasurementSet};
use numeric::minimum::golden_section;
use numeric::statistics::median;

/// Records that share a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Records {
    /// This FRF.
    One(usize),
    /// All FRFs of the channel of this one.
    Channel(usize),
}

impl Records {
    /// Whether an FRF is one of them.
    pub fn contain(self, set: &MeasurementSet, frf: usize) -> bool {
        match self {
            Records::One(own) => frf == own,
            Records::Channel(own) => channel(set, own) == channel(set, frf),
        }
    }

    /// Returns their name: the position or record of one, the response of a channel.
    pub fn name(self, set: &MeasurementSet) -> String {
        match self {
            Records::One(own) => {
                let frf = &set.frfs[own];
                let position = frf.position.map(|p| &set.positions[p].name);
                position.or(frf.record.as_ref()).unwrap_or(&frf.source).clone()
            }
            Records::Channel(own) => channel_name(set, own),
        }
    }

    /// Returns them as a part of a sentence.
    pub fn text(self, set: &MeasurementSet) -> String {
        match self {
            Records::One(own) => set.frfs[own].source.clone(),
            Records::Channel(_) => format!("all records of channel «{}»", self.name(set)),
        }
    }
}

/// Returns the response and excitation of an FRF, which identify its channel.
pub(super) fn channel(set: &MeasurementSet, frf: usize) -> (&str, &str) {
    (&set.frfs[frf].response, &set.frfs[frf].excitation)
}

/// Returns the response of a channel, with its excitation where another channel has the same response.
fn channel_name(set: &MeasurementSet, frf: usize) -> String {
    let (response, excitation) = channel(set, frf);
    let is_unique = (0..set.frfs.len())
        .map(|at| channel(set, at))
        .all(|(other, by)| other != response || by == excitation);
    if is_unique { response.to_owned() } else { format!("{response}/{excitation}") }
}

/// Largest gaps with which corrected records are ordinary, and no outliers any more.
#[derive(Debug, Clone, Copy)]
pub(super) struct GapLimits {
    pub ordinary: f64,
    pub outlier: f64,
}

impl GapLimits {
    /// Returns the limits that the gaps of other records give.
    pub fn of(others: &[PartialGap]) -> Self {
        let middle = median(others.iter().map(|part| part.gap)).unwrap_or(0.0);
        GapLimits { ordinary: OUTLIER.1 * middle, outlier: OUTLIER.0 * middle }
    }
}

/// Returns the fault with which the gap of some records to a model fitted to others is no outlier; `None`
/// where none of the chain does that. Of faults that make the records ordinary it is the one with the fewest
/// parameters.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn fault_of_some(
    fitter: &Fitter<'_>,
    predicted: &HoldOutSet<'_>,
    (nominal, fitted): (&Hypothesis, &Fitted),
    records: Records,
    limits: GapLimits,
) -> Result<Option<ChainFault>, ObjectiveError> {
    let set = predicted.set();
    let own = predicted.with_frfs(|frf| records.contain(set, frf));
    let ratio = ratio_to(fitter, &own, (nominal, fitted))?;
    let gap = |fault: &ChainFault| -> Option<(ChainFault, f64)> {
        let corrected = fault.corrected_in(set, |frf| records.contain(set, frf));
        // Corrected data that cannot be compared, out of the band for example, are no explanation.
        let gaps = fitter.gaps(nominal, fitted, &own.in_version(&corrected)).ok()?;
        Some((*fault, gap_over(&gaps)?))
    };
    let tried: Vec<(ChainFault, f64)> =
        distinct_faults(fitter, nominal, ratio).iter().filter_map(gap).collect();
    let by_gap = |a: &&(ChainFault, f64), b: &&(ChainFault, f64)| a.1.total_cmp(&b.1);
    let is_ordinary = |tried: &&(ChainFault, f64)| tried.1 < limits.ordinary;
    let simplest = tried.iter().filter(is_ordinary).map(|(fault, _)| fault.parameters()).min();
    let best = match simplest {
        Some(fewest) => {
            tried.iter().filter(is_ordinary).filter(|(fault, _)| fault.parameters() == fewest).min_by(by_gap)
        }
        None => tried.iter().filter(|(_, gap)| *gap < limits.outlier).min_by(by_gap),
    };
    Ok(best.map(|(fault, _)| *fault))
}

/// Fits of all records with some of them corrected, and steps of each: every fit gives the fault its
/// parameters anew.
const ROUNDS: usize = 3;
const STEPS_OF_ALL: u64 = 25;

/// Returns the fault with which some records agree with all others in one fit, where a model of the others
/// alone does not predict them well enough: by a misfit per compared number that `agrees`. Of several such
/// faults it is the one with the fewest parameters.
///
/// # Errors  as [`Fitter::objective`].
pub(super) fn fault_of_some_with_others(
    fitter: &Fitter<'_>,
    (nominal, others): (&Hypothesis, &Fitted),
    records: Records,
    agrees: impl Fn(f64) -> bool + Sync,
    control: &Control,
) -> Result<Option<ChainFault>, ObjectiveError> {
    let set = fitter.fit.set();
    let own = fitter.fit.to_predict().with_frfs(|frf| records.contain(set, frf));
    let fitted_along = |first: &ChainFault| -> Option<(ChainFault, f64)> {
        // Channels of the fit differ from those of all records.
        let (mut fault, mut fitted, mut found) =
            (*first, Fitted { tail: Tail::default(), ..others.clone() }, None);
        for _ in 0..ROUNDS {
            let corrected = fault.corrected_in(set, |frf| records.contain(set, frf));
            let all = fitter.on(fitter.fit.in_version(&corrected));
            let objective = all.objective(nominal).ok()?;
            fitted = all.descend(&objective, &fitted, STEPS_OF_ALL, control);
            if control.stopped() {
                return None;
            }
            let misfit = fitted.chi_square / objective.observations() as f64;
            let (own_gaps, other_gaps): (Vec<PartialGap>, Vec<PartialGap>) = all
                .gaps(nominal, &fitted, &all.fit.to_predict())
                .ok()?
                .into_iter()
                .partition(|part| part.frf.is_some_and(|frf| records.contain(set, frf)));
            if agrees(misfit) && gap_over(&own_gaps)? < GapLimits::of(&other_gaps).outlier {
                found = Some((fault, misfit));
            }
            fault = refined(fault, &thinned(ratio_to(&all, &own, (nominal, &fitted)).ok()?))?;
        }
        found
    };
    let ratio = ratio_to(fitter, &own, (nominal, others))?;
    let found: Vec<(ChainFault, f64)> =
        distinct_faults(fitter, nominal, ratio).par_iter().filter_map(fitted_along).collect();
    let simpler = |a: &&(ChainFault, f64), b: &&(ChainFault, f64)| {
        a.0.parameters().cmp(&b.0.parameters()).then_with(|| a.1.total_cmp(&b.1))
    };
    Ok(found.iter().min_by(simpler).map(|(fault, _)| *fault))
}

/// Returns ln of measured over predicted FRF at each frequency (Hz) of some records, with the parameters and
/// the gain of a fit.
fn ratio_to(
    fitter: &Fitter<'_>,
    records: &HoldOutSet<'_>,
    (nominal, fitted): (&Hypothesis, &Fitted),
) -> Result<Vec<(f64, Complex64)>, ObjectiveError> {
    let Domain::Frf(settings) = fitter.domain else { return Ok(Vec::new()) };
    let own = fitter.objective(nominal)?;
    let gain = own.gain(&coordinates_of(&own, fitted));
    let objective = FrfObjective::held_out(&nominal.machine, records, settings)?;
    let residuals = objective.residuals(&values_of(nominal, fitted), gain).concat();
    Ok(objective.records().iter().flat_map(|record| record.frequencies_hz()).zip(residuals).collect())
}

/// Least and largest corner of a filter or natural frequency of a mount, as a share of the lowest and a
/// multiple of the highest frequency of a record; trial values per decade, and steps of the search between
/// two of them.
const CORNERS: (f64, f64, f64) = (0.1, 100.0, 40.0);
const STEPS: usize = 20;
/// Steps of the search between two trial damping ratios of a mount.
const RATIO_STEPS: usize = 8;

/// Largest number of lines to which a fault is fitted.
const MOST_LINES: usize = 600;
/// Trial delays per period of the highest frequency, and their largest number of periods.
const DELAYS: (f64, f64) = (8.0, 20.0);

/// Returns every n-th line of a ratio.
fn thinned(ratio: Vec<(f64, Complex64)>) -> Vec<(f64, Complex64)> {
    let step = ratio.len().div_ceil(MOST_LINES).max(1);
    ratio.into_iter().step_by(step).collect()
}

/// Returns the faults that a machine can show, with the parameters that fit a ratio best on few of its lines.
fn distinct_faults(
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    ratio: Vec<(f64, Complex64)>,
) -> Vec<ChainFault> {
    let mut all = faults(&thinned(ratio));
    all.retain(|fault| fault.is_distinct(fitter, nominal));
    all
}

/// Returns every kind of fault with the parameters that fit a ratio of measured over predicted FRF, ln of it
/// at each frequency (Hz), best.
fn faults(ratio: &[(f64, Complex64)]) -> Vec<ChainFault> {
    let mut all = vec![ChainFault::Polarity, ChainFault::Conjugate];
    all.extend([-2, -1, 1, 2].map(ChainFault::Quantity));
    all.extend(FREQUENCY_SCALES.map(ChainFault::FrequencyScale));
    let sized = [
        ChainFault::Scale(1.0),
        ChainFault::Delay(0.0),
        ChainFault::LowPass(1.0),
        ChainFault::HighPass(1.0),
        ChainFault::MountResonance(1.0, MOUNT_RATIOS[0]),
    ];
    all.extend(sized.into_iter().filter_map(|fault| refined(fault, ratio)));
    all
}

/// Returns a fault with the parameters that fit a ratio best; one without a size as it is.
fn refined(fault: ChainFault, ratio: &[(f64, Complex64)]) -> Option<ChainFault> {
    match fault {
        ChainFault::Scale(_) => Some(ChainFault::Scale(median(ratio.iter().map(|(_, log)| log.re))?.exp())),
        ChainFault::Delay(_) => best_delay(ratio),
        ChainFault::LowPass(_) => Some(best_corner(ratio, ChainFault::LowPass)?.0),
        ChainFault::HighPass(_) => Some(best_corner(ratio, ChainFault::HighPass)?.0),
        ChainFault::MountResonance(..) => Some(best_mount(ratio)?.0),
        _ => Some(fault),
    }
}

/// Returns the delay that fits the phases of a ratio best; these are known but for whole turns.
fn best_delay(ratio: &[(f64, Complex64)]) -> Option<ChainFault> {
    let highest = ratio.iter().map(|(hz, _)| *hz).fold(0.0, f64::max);
    if !(highest > 0.0) {
        return None;
    }
    let remains = |delay_s: f64| -> f64 {
        let turns = |(hz, log): &(f64, Complex64)| log.im / TAU + hz * delay_s;
        ratio.iter().map(|line| (turns(line) - turns(line).round()).powi(2)).sum()
    };
    let step = 1.0 / (DELAYS.0 * highest);
    let count = (DELAYS.0 * DELAYS.1) as i32;
    let trials = (-count..=count).map(|at| f64::from(at) * step).map(|delay_s| (delay_s, remains(delay_s)));
    let best = trials.min_by(|a, b| a.1.total_cmp(&b.1))?.0;
    let Ok((delay_s, _)) =
        golden_section((best - step, best + step), STEPS, |delay_s| Ok::<f64, Infallible>(remains(delay_s)));
    Some(ChainFault::Delay(delay_s))
}

/// Returns the resonance of a mount that fits a ratio best, and the sum of squares that remains.
fn best_mount(ratio: &[(f64, Complex64)]) -> Option<(ChainFault, f64)> {
    let of = |damping: f64| best_corner(ratio, |hz| ChainFault::MountResonance(hz, damping));
    let trials: Option<Vec<(ChainFault, f64)>> = MOUNT_RATIOS.iter().map(|damping| of(*damping)).collect();
    let trials = trials?;
    let best = (0..trials.len()).min_by(|a, b| trials[*a].1.total_cmp(&trials[*b].1))?;
    let neighbours =
        (MOUNT_RATIOS[best.saturating_sub(1)].ln(), MOUNT_RATIOS[(best + 1).min(trials.len() - 1)].ln());
    let remains = |log: f64| Ok::<f64, Infallible>(of(log.exp()).map_or(f64::INFINITY, |(_, rest)| rest));
    let Ok((log, rest)) = golden_section(neighbours, RATIO_STEPS, remains);
    if rest < trials[best].1 { of(log.exp()) } else { Some(trials[best]) }
}

/// Returns the corner of a fault that fits a ratio best, and the sum of squares that remains.
fn best_corner(ratio: &[(f64, Complex64)], made: impl Fn(f64) -> ChainFault) -> Option<(ChainFault, f64)> {
    let (low, high) =
        ratio.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), (hz, _)| (low.min(*hz), high.max(*hz)));
    if !(low > 0.0 && low.is_finite()) {
        return None;
    }
    let remains = |log_hz: f64| -> f64 {
        let fault = made(log_hz.exp());
        let rest = |(hz, log): &(f64, Complex64)| (log.exp() / fault.factor(*hz)).ln().norm_sqr();
        ratio.iter().map(rest).sum()
    };
    let (first, last) = ((CORNERS.0 * low).ln(), (CORNERS.1 * high).ln());
    let count = ((last - first) / std::f64::consts::LN_10 * CORNERS.2).ceil();
    let step = (last - first) / count;
    let trials = (0..=count as usize).map(|at| first + step * at as f64);
    let best = trials.map(|log| (log, remains(log))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let Ok(refined) =
        golden_section((best.0 - step, best.0 + step), STEPS, |log| Ok::<f64, Infallible>(remains(log)));
    Some((made(refined.0.exp()), refined.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of an exact ratio every fault has its own parameters.
    #[test]
    fn limit_parameters_of_exact_faults() {
        let exact = [
            ChainFault::LowPass(1500.0),
            ChainFault::HighPass(4.0),
            ChainFault::Delay(3e-5),
            ChainFault::Delay(-1.3e-3),
            ChainFault::Scale(9.80665),
            ChainFault::MountResonance(640.0, 0.08),
        ];
        for fault in exact {
            let ratio: Vec<(f64, Complex64)> =
                (10..800).map(|hz| (f64::from(hz), fault.factor(f64::from(hz)).ln())).collect();
            let near = |found: &ChainFault| match (fault, *found) {
                (ChainFault::LowPass(a), ChainFault::LowPass(b))
                | (ChainFault::HighPass(a), ChainFault::HighPass(b))
                | (ChainFault::Delay(a), ChainFault::Delay(b))
                | (ChainFault::Scale(a), ChainFault::Scale(b)) => (b / a - 1.0).abs() < 1e-4,
                (ChainFault::MountResonance(a, x), ChainFault::MountResonance(b, y)) => {
                    (b / a - 1.0).abs() < 1e-3 && (y / x - 1.0).abs() < 0.05
                }
                _ => false,
            };
            assert!(faults(&ratio).iter().any(near), "{fault:?}: {:?}", faults(&ratio));
        }
    }
}
