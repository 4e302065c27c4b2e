//! Search for the extrema of |H| over a piece of a frequency band.

use std::sync::LazyLock;

use super::extremum_scan::{Evaluation, ExtremumBracket, Scan, phase_step_too_large};
use super::peak_search::PeakSearch;
use super::rational_interpolant::RationalInterpolant;
use super::simd::{Complexes, LANES, Reals, padded, padded_by};

/// Number of evaluations of a piece before its roots are known.
const GRID: usize = 24;
/// Largest error of the polynomials relative to their least magnitude on the piece; and relative to their
/// largest magnitude, where rounding dominates.
const RELATIVE_ERROR: f64 = 1e-5;
const ROUNDING: f64 = 1e-13;
/// Largest Newton step to a root that is kept, along the band and away from it, in units of the grid spacing.
const NEWTON_REACH: (f64, f64) = (0.75, 1.5);
/// Distance assumed for a root on the band itself, as a share of half a piece.
const MIN_DISTANCE: f64 = 1e-8;
/// Distance from the band at which Newton's method restarts if it does not converge from the band, as a share
/// of half a piece.
const RESTART_DISTANCE: f64 = 0.05;
/// Positions evaluated around a root, in units of its distance from the band.
const OFFSETS: [f64; 5] = [-2.0, -0.7, 0.0, 0.7, 2.0];
/// Largest number of rounds of evaluations requested by a scan.
const SCANS: usize = 3;
/// Relative precision of the frequencies of valleys; only the depth of a valley is used.
const VALLEY_PRECISION: f64 = 1e-6;
/// Largest relative change of |H| over the last Newton step to an extremum. The result includes the step's
/// change, ½·slope·step.
pub(super) const SMALL_CHANGE: f64 = 1e-5;

/// Positions at which a piece is evaluated before its roots are known.
#[derive(Debug)]
struct Grid {
    /// Positions from −1 to 1, dense at both ends and symmetric about 0.
    positions: [f64; GRID],
    /// The upper half of the positions in SIMD groups, with the spacing to their neighbours.
    upper: [(Reals, Reals); GRID / 2 / LANES],
}

static GRID_POINTS: LazyLock<Grid> = LazyLock::new(|| {
    let positions: [f64; GRID] =
        std::array::from_fn(|i| -(std::f64::consts::PI * i as f64 / (GRID - 1) as f64).cos());
    let upper = |group: usize| {
        let at = |lane: usize| GRID / 2 + group * LANES + lane;
        let spacing = |at: usize| 0.5 * (positions[(at + 1).min(GRID - 1)] - positions[at - 1]);
        let of = |what: &dyn Fn(usize) -> f64| {
            Reals::from(std::array::from_fn::<_, LANES, _>(|lane| what(at(lane))))
        };
        (of(&|at| positions[at]), of(&spacing))
    };
    Grid { positions, upper: std::array::from_fn(upper) }
});

/// A root of N or Δ near a piece.
#[derive(Debug, Clone, Copy)]
struct Root {
    re: f64,
    /// Distance from the band (signed imaginary part).
    distance: f64,
    pole: bool,
    /// Index of the grid cell that contains the root.
    cell: usize,
}

/// A maximum or minimum of |H|·ω^p.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extremum {
    /// Frequency (rad/s).
    pub omega_rad_s: f64,
    /// |H|·ω^p at the extremum.
    pub size: f64,
    /// d²ln(|H|·ω^p)/dω² (s²).
    pub curvature: f64,
    /// Bound on the relative error of the size and of the frequency.
    pub error: f64,
    /// Whether it is a maximum.
    pub is_maximum: bool,
}

/// State and buffers of the search over the current piece.
#[derive(Debug, Clone)]
pub(super) struct ExtremumSearch {
    grid: &'static Grid,
    /// G on the grid; real and imaginary part of Δ.
    rise: [f64; GRID],
    denominator: [[f64; GRID]; 2],
    roots: Vec<Root>,
    /// Positions to evaluate next, and the evaluations made around roots.
    requested: Vec<f64>,
    near_roots: Vec<Evaluation>,
    /// Intervals in which G changes its sign.
    brackets: Vec<ExtremumBracket>,
}

impl Default for ExtremumSearch {
    fn default() -> Self {
        ExtremumSearch {
            grid: &GRID_POINTS,
            rise: [0.0; GRID],
            denominator: [[0.0; GRID]; 2],
            roots: Vec::new(),
            requested: Vec::new(),
            near_roots: Vec::new(),
            brackets: Vec::new(),
        }
    }
}

/// Returns |z|² and its first and second derivative.
fn square([z, slope, half_bend]: [Complexes; 3]) -> [Reals; 3] {
    let two = Reals::splat(2.0);
    [z.norm_sqr(), two * z.dot(slope), two * (slope.norm_sqr() + two * z.dot(half_bend))]
}

impl ExtremumSearch {
    /// Returns the evaluation at a grid position.
    fn evaluation(&self, at: usize) -> Evaluation {
        Evaluation {
            t: self.grid.positions[at],
            rise: self.rise[at],
            denominator: (self.denominator[0][at], self.denominator[1][at]),
        }
    }

    /// Frequencies of the grid over a piece, without its upper end (rad/s).
    pub fn grid_rad_s(&self, of: &RationalInterpolant) -> impl Iterator<Item = f64> {
        self.grid.positions[..GRID - 1].iter().map(|t| of.omega_rad_s(*t))
    }

    /// Whether |H|·ω^p rises at the upper end of the piece.
    pub fn rises_at_end(&self) -> bool {
        self.rise[GRID - 1] > 0.0
    }

    /// Number of poles found near the piece.
    pub fn pole_count(&self) -> usize {
        self.roots.iter().filter(|r| r.pole).count()
    }

    /// Number of poles found in one cell of the grid.
    pub fn poles_in_cell(&self, at: usize) -> usize {
        self.roots.iter().filter(|r| r.pole && r.cell == at).count()
    }

    /// Evaluates the grid of a piece and collects the near roots to which one Newton step leads. Returns
    /// whether the polynomials are accurate enough.
    pub fn evaluate_grid(&mut self, of: &RationalInterpolant, settings: &PeakSearch) -> bool {
        self.roots.clear();
        let (mut least, mut most) = ([Reals::splat(f64::MAX); 2], [Reals::ZERO; 2]);
        for (group, (t, spacing)) in self.grid.upper.iter().enumerate() {
            for (found, (t, upper)) in of.slopes_on_both_sides(*t).iter().zip([(*t, true), (-*t, false)]) {
                for ([value, slope], (least, (most, pole))) in [found.0, found.1]
                    .into_iter()
                    .zip(least.iter_mut().zip(most.iter_mut().zip([false, true])))
                {
                    let (size, steep) = (value.norm_sqr(), slope.norm_sqr());
                    *least = least.fast_min((steep * *spacing).mul_add(*spacing, size));
                    *most = most.fast_max(size);
                    let step = value * slope.inverse();
                    let near = step.re.abs().simd_le(*spacing * Reals::splat(NEWTON_REACH.0))
                        & step.im.abs().simd_le(*spacing * Reals::splat(NEWTON_REACH.1));
                    let bits = near.to_bitmask();
                    if bits != 0 {
                        let (re, im) = ((t - step.re).to_array(), step.im.to_array());
                        let start = |lane: usize| Root { re: re[lane], distance: -im[lane], pole, cell: 0 };
                        self.roots.extend((0..LANES).filter(|lane| bits >> lane & 1 == 1).map(start));
                    }
                }
                let rise = rise_of(of, settings, t, found);
                let ExtremumSearch { rise: rises, denominator: [re, im], .. } = self;
                for (all, some) in [(rises, rise), (re, found.1[0].re), (im, found.1[0].im)] {
                    let mut some = some.to_array();
                    let from = GRID / 2 + group * LANES;
                    if upper {
                        all[from..from + LANES].copy_from_slice(&some);
                    } else {
                        some.reverse();
                        all[GRID - from - LANES..GRID - from].copy_from_slice(&some);
                    }
                }
            }
        }
        (0..2).all(|part| {
            let (least, most) = (
                least[part].to_array().into_iter().fold(f64::MAX, f64::min),
                most[part].to_array().into_iter().fold(0.0, f64::max),
            );
            of.error[part] <= RELATIVE_ERROR * least.sqrt() || of.error[part] <= ROUNDING * most.sqrt()
        })
    }

    /// Evaluates around the roots near the piece and brackets the sign changes of G. `rising` is the sign of
    /// the slope below the piece. Returns whether the phase steps between neighbouring evaluations are small
    /// enough.
    pub fn bracket_extrema(
        &mut self,
        of: &RationalInterpolant,
        settings: &PeakSearch,
        rising: Option<bool>,
    ) -> bool {
        self.refine_roots(of);
        self.near_roots.clear();
        self.request_near_roots();
        for _ in 0..SCANS {
            self.evaluate_requested(of, settings);
            if !self.scan(rising) {
                return false;
            }
            if self.requested.is_empty() {
                break;
            }
        }
        true
    }

    /// Refines the roots by Newton's method. Keeps each root on the piece once, in rising order.
    fn refine_roots(&mut self, of: &RationalInterpolant) {
        let positions = &self.grid.positions;
        let roots = &mut self.roots;
        for some in roots.chunks_mut(LANES) {
            let each = |what: fn(&Root) -> f64| padded_by(some, what);
            let poles = each(|root| f64::from(u8::from(root.pole))).simd_gt(Reals::ZERO);
            let mut z = Complexes::new(each(|root| root.re), each(|root| root.distance));
            let start = z;
            for round in 0..12 {
                let step = of.steps(poles, z);
                z += step;
                let small = (z.im.abs() * Reals::splat(0.03)).fast_max(Reals::splat(1e-11));
                let settled = step.norm_sqr().simd_le(small * small);
                if settled.all() {
                    break;
                }
                if round == 4 {
                    // Between two roots on either side of the band Newton's iteration never leaves the band.
                    z = Complexes::new(
                        settled.select(z.re, start.re),
                        settled.select(z.im, Reals::splat(RESTART_DISTANCE)),
                    );
                }
            }
            let (re, im) = (z.re.to_array(), z.im.to_array());
            for (at, root) in some.iter_mut().enumerate() {
                (root.re, root.distance) = (re[at], im[at]);
            }
        }
        roots.retain(|root| root.re >= -1.0 && root.re <= 1.0);
        roots.sort_unstable_by(|a, b| a.re.total_cmp(&b.re));
        let mut kept = 0;
        for at in 0..roots.len() {
            let root = roots[at];
            let same = |other: &Root| {
                let square = (root.re - other.re).powi(2) + (root.distance - other.distance).powi(2);
                root.pole == other.pole && square <= (0.3 * root.distance).powi(2).max(1e-18)
            };
            if !roots[..kept].iter().rev().take(3).any(same) {
                let cell = positions.partition_point(|t| *t <= root.re).clamp(1, GRID - 1) - 1;
                roots[kept] = Root { cell, ..root };
                kept += 1;
            }
        }
        roots.truncate(kept);
    }

    /// Requests evaluations around all roots.
    fn request_near_roots(&mut self) {
        let ExtremumSearch { roots, requested, .. } = self;
        requested.clear();
        for root in roots.iter() {
            let reach = root.distance.abs().max(MIN_DISTANCE);
            requested.extend(OFFSETS.iter().map(|side| root.re + side * reach).filter(|t| t.abs() < 1.0));
        }
    }

    /// Evaluates the requested positions.
    fn evaluate_requested(&mut self, of: &RationalInterpolant, settings: &PeakSearch) {
        let ExtremumSearch { requested, near_roots, .. } = self;
        for some in requested.chunks(LANES) {
            let t = padded(some);
            let found = of.slopes(t);
            let (rise, re, im) = (
                rise_of(of, settings, t, &found).to_array(),
                found.1[0].re.to_array(),
                found.1[0].im.to_array(),
            );
            near_roots.extend(some.iter().enumerate().map(|(lane, t)| Evaluation {
                t: *t,
                rise: rise[lane],
                denominator: (re[lane], im[lane]),
            }));
        }
        near_roots.sort_unstable_by(|a, b| a.t.total_cmp(&b.t));
    }

    /// Scans all evaluations in rising order, collects brackets and requests missing evaluations. Returns
    /// whether the phase steps between neighbours are small enough.
    fn scan(&mut self, rising: Option<bool>) -> bool {
        let flagged = self.flagged();
        let mut scan = Scan {
            near: true,
            requested: std::mem::take(&mut self.requested),
            brackets: std::mem::take(&mut self.brackets),
        };
        scan.requested.clear();
        scan.brackets.clear();
        let first = self.evaluation(0);
        if rising.is_some_and(|rising| rising != (first.rise > 0.0)) {
            let at = (first.t, first.rise);
            scan.brackets.push(ExtremumBracket { low: at, high: at, is_maximum: first.rise <= 0.0 });
        }
        let mut near_roots = self.near_roots.iter().peekable();
        let (mut last, mut crowded, mut skipped) = ([first; 2], false, false);
        for at in 1..GRID {
            let t = self.grid.positions[at];
            let extra_here = near_roots.peek().is_some_and(|here| here.t < t);
            // Without roots nearby, the comparison of all grid neighbours in `flagged` suffices.
            if !extra_here && !crowded && flagged >> (at - 1) & 1 == 0 {
                skipped = true;
                continue;
            }
            if skipped {
                last = [self.evaluation(at.saturating_sub(2)), self.evaluation(at - 1)];
            }
            while let Some(here) = near_roots.next_if(|here| here.t < t) {
                last = scan.step(last, *here);
            }
            last = scan.step(last, self.evaluation(at));
            (crowded, skipped) = (extra_here, false);
        }
        (self.requested, self.brackets) = (scan.requested, scan.brackets);
        scan.near
    }

    /// Returns, as bits, the grid cells that need a closer scan. There G changes its sign, the phase step of
    /// Δ is too large, or |G| has a local minimum.
    fn flagged(&self) -> u32 {
        let ExtremumSearch { rise, denominator: [re, im], .. } = self;
        let four = |of: &[f64; GRID], from: usize| {
            Reals::from(std::array::from_fn::<_, LANES, _>(|lane| of[from + lane]))
        };
        let after = |from: usize| {
            let [a, b] =
                [from, from + 1].map(|at| (four(rise, at), Complexes::new(four(re, at), four(im, at))));
            let signs = a.0.simd_gt(Reals::ZERO) ^ b.0.simd_gt(Reals::ZERO);
            let before =
                Reals::from(std::array::from_fn::<_, LANES, _>(|lane| rise[(from + lane).saturating_sub(1)]));
            let low = a.0.abs().simd_lt(b.0.abs()) & a.0.abs().simd_lt(before.abs());
            (signs | low | phase_step_too_large(a.1, b.1)).to_bitmask()
        };
        (0..GRID - 1)
            .step_by(LANES)
            .map(|from| from.min(GRID - 1 - LANES))
            .fold(0, |bits, from| bits | after(from) << from)
    }

    /// Refines the extrema in all brackets of a piece.
    pub fn extrema(&self, of: &RationalInterpolant, settings: &PeakSearch, extrema: &mut Vec<Extremum>) {
        let power = f64::from(settings.omega_power);
        let (half, middle) = (Reals::splat(of.half), Reals::splat(of.middle));
        let steady = Reals::splat(2.0 * power * of.half);
        for at in (0..self.brackets.len()).step_by(LANES) {
            let some = &self.brackets[at..self.brackets.len().min(at + LANES)];
            let each = |what: &dyn Fn(&ExtremumBracket) -> f64| padded_by(some, what);
            let (mut low, mut high) = (each(&|b| b.low.0), each(&|b| b.high.0));
            let precision = each(&|b| if b.is_maximum { settings.precision } else { VALLEY_PRECISION });
            let up = each(&|b| b.low.1).simd_gt(Reals::ZERO);
            let width = high - low;
            let mut t = each(&|b| {
                if b.high.0 > b.low.0 {
                    (b.low.0 * b.high.1 - b.high.0 * b.low.1) / (b.high.1 - b.low.1)
                } else {
                    b.low.0
                }
            });
            let (mut n2, mut d2);
            let (position, bend, mut change, mut omega);
            let mut rounds = 0;
            loop {
                let (n, d) = of.jets(t);
                (n2, d2) = (square(n), square(d));
                omega = t.mul_add(half, middle);
                let twist = n2[1] * d2[0] - n2[0] * d2[1];
                let rise = twist.mul_add(omega, steady * n2[0] * d2[0]);
                let rise_slope = (n2[2] * d2[0] - n2[0] * d2[2])
                    .mul_add(omega, twist * half + steady * (n2[1] * d2[0] + n2[0] * d2[1]));
                let above = rise.simd_gt(Reals::ZERO) ^ up;
                high = above.select(t, high);
                low = above.select(low, t);
                let next = t - rise / rise_slope;
                let inside = next.simd_ge(low) & next.simd_le(high);
                let next = inside.select(next, (low + high) * Reals::splat(0.5));
                let step = next - t;
                let (reach, wanted) = (step.abs() * half, precision * omega);
                // Newton's method converges quadratically: the remaining error is the square of the step,
                // relative to the bracket.
                let settled = reach.simd_le(wanted) | (step * step * half).simd_le(wanted * width);
                let per_2 = Reals::ONE / (n2[0] * d2[0] * omega * Reals::splat(2.0));
                change = rise * per_2 * step * Reals::splat(0.5);
                let unchanged = change.abs().simd_le(Reals::splat(SMALL_CHANGE))
                    | reach.simd_le(Reals::splat(1e-14) * omega);
                rounds += 1;
                if (settled & unchanged).all() || rounds == 60 {
                    bend = rise_slope * per_2;
                    position = next;
                    break;
                }
                t = next;
            }
            let curvature = (bend / (half * half)).to_array();
            let (t, change) = (position.to_array(), change.to_array());
            let (n2, d2, omega) = (n2[0].to_array(), d2[0].to_array(), omega.to_array());
            for (lane, is_maximum) in some.iter().map(|b| b.is_maximum).enumerate() {
                let omega_rad_s = of.omega_rad_s(t[lane]);
                let size = (n2[lane] / d2[lane]).sqrt()
                    * (1.0 + change[lane])
                    * omega[lane].powi(settings.omega_power);
                let error = of.error[0] / n2[lane].sqrt() + of.error[1] / d2[lane].sqrt();
                let error = error / (curvature[lane].abs() * omega_rad_s * of.half).min(1.0);
                extrema.push(Extremum { omega_rad_s, size, curvature: curvature[lane], error, is_maximum });
            }
        }
    }
}

/// Computes G over a piece.
#[inline(always)]
fn rise_of(
    of: &RationalInterpolant,
    settings: &PeakSearch,
    t: Reals,
    (n, d): &([Complexes; 2], [Complexes; 2]),
) -> Reals {
    let (n2, d2) = (n[0].norm_sqr(), d[0].norm_sqr());
    let omega = t.mul_add(Reals::splat(of.half), Reals::splat(of.middle));
    let steady = Reals::splat(of.half * f64::from(settings.omega_power)) * n2 * d2;
    (n[0].dot(n[1]) * d2 - n2 * d[0].dot(d[1])).mul_add(omega, steady)
}
