//! Comparison of a named effect with generic impedances: where one of them explains as much with fewer
//! parameters, no effect is named.

use super::fit::Fitted;
use super::hypothesis::Hypothesis;
use super::null_distribution::NullDistribution;
use super::screening::Candidate;
use super::thresholds::Thresholds;

/// Largest number of parameters of a generic impedance. Second, the share of the reduction of χ² by which an
/// effect with more parameters must be better.
pub(super) const GENERIC_PARAMETERS: usize = 3;
const LEAST_IMPROVEMENT: f64 = 0.01;
/// Largest excess over null simulations with which a generic impedance explains the whole residual.
const EXPLAINED: f64 = 1.05;

/// The fit to be named.
pub(super) struct NamedFit<'n> {
    pub hypothesis: &'n Hypothesis,
    pub fitted: &'n Fitted,
    /// Number of effects.
    pub effects: usize,
    /// Excess over null simulations without and with the effects.
    pub before: f64,
    pub after: f64,
    /// Reduction of χ².
    pub gain: f64,
    /// Difference of χ² within which fits are indistinguishable.
    pub margin: f64,
}

/// Returns the best generic impedance that matches or beats the fit to be named, and the words of the
/// comparison.
///
/// - Effects with more parameters than any generic impedance must fit better than each of them. None is named
///   where a generic impedance explains the whole residual.
/// - A single effect that explains the whole residual must fit as well as generic impedances with no more
///   parameters.
pub(super) fn more_parsimonious<'c>(
    named: &NamedFit<'_>,
    generic: &'c [Candidate],
    null: &NullDistribution,
    count: f64,
    limits: Thresholds,
) -> Option<(&'c Candidate, &'static str)> {
    let NamedFit { hypothesis, fitted, effects, before, after, gain, margin } = *named;
    let parameters = hypothesis.added.len();
    let flexible = parameters > GENERIC_PARAMETERS && (limits.calibrated || effects == 1);
    let reach =
        fitted.chi_square + margin + limits.margin(LEAST_IMPROVEMENT * gain, fitted.chi_square, after);
    let explains_all = |c: &Candidate| {
        limits.calibrated && before > limits.large_excess && null.excess(c.chi_square() / count) <= EXPLAINED
    };
    let single = limits.calibrated && effects == 1 && after <= limits.large_excess;
    let comparison = |c: &Candidate| {
        let generic_parameters = c.fitted.as_ref()?.0.added.len();
        let better =
            single && generic_parameters <= parameters && c.chi_square() + margin < fitted.chi_square;
        match (better, flexible && (c.chi_square() <= reach || explains_all(c))) {
            (true, _) => Some("fits better than"),
            (false, true) => Some("fits, with fewer parameters, as well as"),
            (false, false) => None,
        }
    };
    let matching = generic.iter().filter_map(|c| Some((c, comparison(c)?)));
    matching.min_by(|(a, _), (b, _)| a.chi_square().total_cmp(&b.chi_square()))
}

/// Whether a generic impedance accounts for what a further effect explains beside the first: with no more
/// parameters than that effect adds it fits better, or it fits as well where each parameter that it saves
/// counts as much as a difference that the data can tell (`margin`). What is missing beside the first effect
/// then has a place, but no name.
pub(super) fn is_located_only(added: usize, chi_square: f64, generic: &[Candidate], margin: f64) -> bool {
    let explains = |c: &Candidate| {
        let parameters = c.fitted.as_ref().map_or(usize::MAX, |(hypothesis, _)| hypothesis.added.len());
        parameters <= added && c.chi_square() + margin < chi_square + margin * (added - parameters) as f64
    };
    generic.iter().any(explains)
}
