//! Scan of neighbouring evaluations of a piece for the extrema between them.

use super::simd::{Complexes, Reals};

/// Cosine of the largest phase step of Δ between neighbouring evaluations (2.2 rad).
const COS_MAX_PHASE_STEP: f64 = -0.5885;
/// Dip that requests another evaluation: the minimum of the parabola through three evaluations of one sign,
/// as a share of the middle one.
const DIP: f64 = 0.5;

/// Evaluation at one position t of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evaluation {
    pub t: f64,
    /// G, which has the sign of the slope of |H|·ω^p.
    pub rise: f64,
    /// Δ.
    pub denominator: (f64, f64),
}

/// Neighbouring evaluations between which |H|·ω^p has an extremum.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExtremumBracket {
    pub low: (f64, f64),
    pub high: (f64, f64),
    pub is_maximum: bool,
}

/// State of a scan over all evaluations.
pub(super) struct Scan {
    /// Whether all phase steps so far are small enough.
    pub near: bool,
    /// Positions that need another evaluation.
    pub requested: Vec<f64>,
    pub brackets: Vec<ExtremumBracket>,
}

impl Scan {
    /// Moves from the last two evaluations to the next one and records a bracket where G changes its sign.
    pub fn step(&mut self, [before, last]: [Evaluation; 2], here: Evaluation) -> [Evaluation; 2] {
        if (last.rise > 0.0) != (here.rise > 0.0) {
            self.brackets.push(ExtremumBracket {
                low: (last.t, last.rise),
                high: (here.t, here.rise),
                is_maximum: last.rise > 0.0,
            });
        }
        let (a, b) = (last.denominator, here.denominator);
        let along = a.0 * b.0 + a.1 * b.1;
        self.near &= along >= 0.0
            || along * along
                <= COS_MAX_PHASE_STEP
                    * COS_MAX_PHASE_STEP
                    * (a.0 * a.0 + a.1 * a.1)
                    * (b.0 * b.0 + b.1 * b.1);
        self.requested.extend(dip(before, last, here));
        [last, here]
    }
}

/// Returns the minimum of the parabola through three evaluations of one sign if the middle one is the least
/// and the parabola comes near zero.
fn dip(before: Evaluation, last: Evaluation, here: Evaluation) -> Option<f64> {
    let [a, b, c] = [before, last, here].map(|evaluation| evaluation.rise * last.rise.signum());
    if !(b < a && b < c && b > 0.0) {
        return None;
    }
    let (falls, rises) = ((b - a) / (last.t - before.t), (c - b) / (here.t - last.t));
    let bend = (rises - falls) / (here.t - before.t);
    let slope = falls + bend * (last.t - before.t);
    (slope * slope > 4.0 * (1.0 - DIP) * b * bend).then_some(last.t - 0.5 * slope / bend)
}

/// Masks the lanes in which the phase step is too large, as in [`Scan::step`].
pub(super) fn phase_step_too_large(a: Complexes, b: Complexes) -> Reals {
    let along = a.dot(b);
    along.simd_lt(Reals::ZERO)
        & (along * along)
            .simd_gt(Reals::splat(COS_MAX_PHASE_STEP * COS_MAX_PHASE_STEP) * a.norm_sqr() * b.norm_sqr())
}
