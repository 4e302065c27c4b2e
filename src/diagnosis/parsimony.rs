//! When a free shape explains as much as an effect that is about to be named: then something of that kind sits there, and no effect is named.

use super::fit::Fitted;
use super::hypothesis::Hypothesis;
use super::null_distribution::NullDistribution;
use super::screening::Candidate;
use super::thresholds::Thresholds;

/// Most numbers a free shape has, and the share of its gain by which an effect with more must do better.
const SHAPE_NUMBERS: usize = 3;
const PLAINER: f64 = 0.01;
/// Excess over nulls up to which a free shape explains all there is.
const ALL: f64 = 1.05;

/// What is about to be named.
pub(super) struct NamedFit<'n> {
    pub hypothesis: &'n Hypothesis,
    pub fitted: &'n Fitted,
    /// How many effects it is.
    pub effects: usize,
    /// Excess over nulls without and with it.
    pub before: f64,
    pub after: f64,
    /// χ² that it takes away.
    pub gain: f64,
    /// What the data can tell apart, in χ².
    pub apart: f64,
}

/// The free shape that fits best of those that do as well, and how.
///
/// - Effects with more numbers than any free shape must do what none of them does, and where a shape leaves no more than nulls show there is nothing to do.
/// - One effect that explains all must fit as well as shapes elsewhere with no more numbers.
pub(super) fn more_parsimonious<'c>(
    named: &NamedFit<'_>,
    shapes: &'c [Candidate],
    null: &NullDistribution,
    count: f64,
    limits: Thresholds,
) -> Option<(&'c Candidate, &'static str)> {
    let NamedFit { hypothesis, fitted, effects, before, after, gain, apart } = *named;
    let numbers = hypothesis.added.len();
    let flexible = numbers > SHAPE_NUMBERS && (limits.known || effects == 1);
    let reach = fitted.chi_square + apart + limits.apart(PLAINER * gain, fitted.chi_square, after);
    let all = |c: &Candidate| limits.known && before > limits.little_from && null.excess(c.chi_square() / count) <= ALL;
    let single = limits.known && effects == 1 && after <= limits.little_from;
    let how = |c: &Candidate| {
        let shape_numbers = c.fitted.as_ref()?.0.added.len();
        let better = single && shape_numbers <= numbers && c.chi_square() + apart < fitted.chi_square;
        match (better, flexible && (c.chi_square() <= reach || all(c))) {
            (true, _) => Some("more than"),
            (false, true) => Some("with fewer numbers what"),
            (false, false) => None,
        }
    };
    let as_well = shapes.iter().filter_map(|c| Some((c, how(c)?)));
    as_well.min_by(|(a, _), (b, _)| a.chi_square().total_cmp(&b.chi_square()))
}
