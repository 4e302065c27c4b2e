//! Peaks of the damped |H|, found on their own: damping moves and removes them.
//!
//! Between two frequencies H is replaced by the rational function of type \[1/2\] that matches H and dH/dω at both
//! ends: it holds one pole and one zero exactly. An interval is split until this interpolant foretells value and
//! slope at its middle, and shows no maximum that the slopes at the nodes do not show. Two counts guard against what an interpolant cannot see: no interval may keep more
//! than one undamped natural frequency (Wittrick–Williams), and between neighbouring nodes the phase of det D, which
//! turns by π at every lightly damped mode whether the response sees it or not, may not turn by more than
//! 2.2 rad. Every maximum then lies between two nodes whose slopes have opposite signs.
//!
//! What may be missed is a ripple: on 8,000 random benches no maximum that stands out by 1 % was, and eight that stand out by 0.1 % or less.

use num_complex::Complex64;

use super::network::{Network, Point, Workspace};
use crate::unit::{frequency_hz, omega_rad_s};

/// Cosine of the largest turn of the phase of det D between neighbouring nodes (2.2 rad).
const COS_TURN: f64 = -0.5885;
/// Relative error of the interpolant at the middle of an interval that is accepted.
const FORETOLD: f64 = 5e-4;
/// Half-width, as a share of the frequency, from which a hidden ripple is too slight to be looked for.
const SLIGHT: f64 = 1e-6;
/// Intervals narrower than this share of their frequency are not split further.
const NARROWEST: f64 = 1e-9;
/// Intervals the band is first cut into.
const FIRST_CUTS: usize = 7;

/// A maximum of |H| over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// |H| there.
    pub amplitude: f64,
    /// |H| at the peak over the larger of the two neighbouring minima (or ends of the band): how far it stands out.
    pub prominence: f64,
}

/// Band and precision of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakSearch {
    /// Lower end of the band (Hz), above 0.
    pub from_hz: f64,
    /// Upper end of the band (Hz).
    pub to_hz: f64,
    /// Relative precision of the frequencies.
    pub precision: f64,
    /// Factor on |H|: ω to this power (0 receptance, 1 mobility, 2 accelerance), whose peaks are sought.
    pub omega_power: i32,
}

/// Nodes in rising frequency, each with the log-slope of the sought quantity.
struct Nodes {
    points: Vec<(Point, f64)>,
}

/// The rational interpolant of type \[1/2\] on t ∈ \[−1, 1\].
struct Rational {
    a: Complex64,
    b: Complex64,
    c: Complex64,
    d: Complex64,
}

impl Rational {
    /// Through values and slopes (per t) at t = −1 and t = 1; `None` where it does not exist.
    fn through(low: (Complex64, Complex64), high: (Complex64, Complex64)) -> Option<Rational> {
        let (h0, s0) = low;
        let (h1, s1) = high;
        let half = (h1 - h0) * 0.5;
        // (a + b t) = H (1 + c t + d t²) and its slope at both ends, a and b eliminated.
        let (m11, m12, r1) = (-half - s1, half - s1 - h1 * 2.0, s1 - half);
        let (m21, m22, r2) = (half + s0, half - s0 + h0 * 2.0, s0 - half);
        let determinant = m11 * m22 - m12 * m21;
        let scale = (m11.norm_sqr() + m12.norm_sqr()) * (m21.norm_sqr() + m22.norm_sqr());
        if !(determinant.norm_sqr() > 1e-28 * scale) {
            return None;
        }
        let c = (r1 * m22 - r2 * m12) / determinant;
        let d = (m11 * r2 - m21 * r1) / determinant;
        let n1 = h1 * (1.0 + c + d);
        let n0 = h0 * (1.0 - c + d);
        Some(Rational { a: (n1 + n0) * 0.5, b: (n1 - n0) * 0.5, c, d })
    }

    /// Value and slope at t.
    fn at(&self, t: f64) -> (Complex64, Complex64) {
        let q = (1.0 + self.c * t + self.d * (t * t)).inv();
        let value = (self.a + self.b * t) * q;
        (value, (self.b - value * (self.c + self.d * (2.0 * t))) * q)
    }

    /// d ln|H|/dt at t times the returned positive weight: a quotient without the division.
    fn weighted_log_slope(&self, t: f64) -> (f64, f64) {
        let n = self.a + self.b * t;
        let q = 1.0 + self.c * t + self.d * (t * t);
        let q_slope = self.c + self.d * (2.0 * t);
        let (n2, q2) = (n.norm_sqr(), q.norm_sqr());
        let re = |x: Complex64, y: Complex64| x.re * y.re + x.im * y.im;
        (re(self.b, n) * q2 - re(q_slope, q) * n2, n2 * q2)
    }

    /// Its two poles and its zero.
    fn features(&self) -> [Complex64; 3] {
        let root = square_root(self.c * self.c - self.d * 4.0);
        let pole = |r: Complex64| (r - self.c) / (self.d * 2.0);
        [pole(root), pole(-root), -self.a / self.b]
    }

    /// Real part of a pole well inside (−1, 1) and close to the real axis.
    fn pole(&self) -> Option<f64> {
        self.features()[..2].iter().find(|t| t.re.abs() < 0.9 && t.im.abs() < 0.5).map(|t| t.re)
    }
}

/// A square root of a complex number, without angles.
fn square_root(z: Complex64) -> Complex64 {
    let size = z.norm_sqr().sqrt();
    let re = (0.5 * (size + z.re.abs())).sqrt();
    if re == 0.0 {
        return z;
    }
    let im = 0.5 * z.im / re;
    if z.re >= 0.0 { Complex64::new(re, im) } else { Complex64::new(im.abs(), re.copysign(z.im)) }
}

struct Search<'a> {
    network: &'a Network,
    work: &'a mut Workspace,
    settings: PeakSearch,
    evaluations: usize,
}

impl Search<'_> {
    fn at(&mut self, omega: f64) -> (Point, f64) {
        self.evaluations += 1;
        let point = self.network.at(omega, self.work);
        (point, point.log_slope_s() + f64::from(self.settings.omega_power) / omega)
    }

    fn below(&mut self, omega: f64) -> usize {
        self.network.modes_below(omega, self.work)
    }

    /// Adds nodes after `low` up to and with `high`.
    fn resolve(&mut self, nodes: &mut Nodes, low: (Point, f64, usize), high: (Point, f64, usize)) {
        let mut pending = vec![(low, high)];
        while let Some((low, high)) = pending.pop() {
            let (from, to) = (low.0.omega_rad_s, high.0.omega_rad_s);
            let half = 0.5 * (to - from);
            let narrow = half < NARROWEST * to;
            let rational = Rational::through((low.0.receptance, low.0.slope * half), (high.0.receptance, high.0.slope * half));
            let split = if high.2 > low.2 { rational.as_ref().and_then(Rational::pole).unwrap_or(0.0) } else { 0.0 };
            let middle_omega = from + half * (1.0 + split);
            let (middle, middle_slope) = self.at(middle_omega);
            let turns_little = |a: &Point, b: &Point| {
                let turn = b.determinant * a.determinant.conj();
                turn.re >= COS_TURN * turn.norm_sqr().sqrt()
            };
            let accepted = narrow
                || (high.2 <= low.2 + 1
                    && turns_little(&low.0, &middle)
                    && turns_little(&middle, &high.0)
                    && rational.as_ref().is_some_and(|r| {
                        let middle = (split, &middle, middle_slope);
                        self.is_foretold(r, half, middle) && (half < SLIGHT * to || self.hides_nothing(r, (&low, &high), half, middle))
                    }));
            if accepted {
                nodes.points.push((middle, middle_slope));
                nodes.points.push((high.0, high.1));
            } else {
                // The count never falls: between equal counts it needs no evaluation.
                let below = if high.2 == low.2 { low.2 } else { self.below(middle_omega) };
                let middle = (middle, middle_slope, below);
                pending.push((middle, high));
                pending.push((low, middle));
            }
        }
    }

    /// Whether the interpolant matches value and slope at the middle node (t, point, log-slope).
    fn is_foretold(&self, rational: &Rational, half: f64, middle: (f64, &Point, f64)) -> bool {
        let (value, slope) = rational.at(middle.0);
        let (h, s) = (middle.1.receptance, middle.1.slope * half);
        let tolerance = FORETOLD * FORETOLD;
        (value - h).norm_sqr() <= tolerance * h.norm_sqr() && (slope - s).norm_sqr() <= 100.0 * tolerance * (h.norm_sqr() + s.norm_sqr())
    }

    /// Whether the log-slope changes its sign between nodes only as often as it must, as far as the interpolant can tell: it is
    /// sampled evenly and around its poles and its zero, and must be further from zero than it errs at the middle.
    fn hides_nothing(
        &self,
        rational: &Rational,
        ends: (&(Point, f64, usize), &(Point, f64, usize)),
        half: f64,
        middle: (f64, &Point, f64),
    ) -> bool {
        let power = f64::from(self.settings.omega_power);
        let from = ends.0.0.omega_rad_s;
        // The slope of the sought quantity, times its weight, and the weight.
        let slope_at = |t: f64| {
            let (slope, weight) = rational.weighted_log_slope(t);
            (slope + weight * power * half / (from + half * (1.0 + t)), weight)
        };
        let (slope, weight) = slope_at(middle.0);
        let doubt = 10.0 * (slope / weight - middle.2 * half).abs();
        let mut samples = [f64::INFINITY; 21];
        samples[..6].copy_from_slice(&[-0.75, -0.5, -0.25, 0.25, 0.5, 0.75]);
        for (at, feature) in rational.features().into_iter().enumerate() {
            for (side, sample) in [-2.0, -0.7, 0.0, 0.7, 2.0].iter().zip(&mut samples[6 + 5 * at..]) {
                *sample = feature.re + side * feature.im.abs();
            }
        }
        [(-1.0, middle.0, ends.0.1, middle.2), (middle.0, 1.0, middle.2, ends.1.1)].iter().all(|&(start, stop, left, right)| {
            let turns = left.is_sign_positive() != right.is_sign_positive();
            // Where the sign of the left end was last seen, and that of the right end first.
            let (mut last_left, mut first_right) = (start, stop);
            for t in samples.iter().copied().filter(|t| *t > start && *t < stop) {
                let (slope, weight) = slope_at(t);
                if !turns {
                    if slope * left.signum() <= doubt * weight {
                        return false;
                    }
                } else if slope.is_sign_positive() == left.is_sign_positive() {
                    last_left = last_left.max(t);
                } else {
                    first_right = first_right.min(t);
                }
            }
            last_left <= first_right
        })
    }

    /// The maximum between two nodes whose log-slopes are positive and negative.
    ///
    /// First the real part of the complex pole as seen from the better end, then the secant through the two latest slopes; a
    /// step that leaves the bracket, or every fifth, halves it. Ends where the next step would be shorter than the precision.
    fn maximum(&mut self, mut low: (Point, f64), mut high: (Point, f64)) -> Point {
        let (mut best, mut before) = if low.0.receptance.norm_sqr() > high.0.receptance.norm_sqr() { (low, high) } else { (high, low) };
        for step in 0..80 {
            let (a, b) = (low.0.omega_rad_s, high.0.omega_rad_s);
            let reach = self.settings.precision * b;
            if b - a <= reach {
                break;
            }
            let here = best.0.omega_rad_s;
            let newton = here + (best.0.receptance / best.0.slope).re;
            let secant = here - best.1 * (here - before.0.omega_rad_s) / (best.1 - before.1);
            let guess = if step == 0 { newton } else { secant };
            let inside = guess > a - reach && guess < b + reach;
            if step > 0 && inside && (guess - here).abs() <= reach {
                break;
            }
            let x = if inside && step % 5 != 4 { guess.clamp(a + 0.2 * reach, b - 0.2 * reach) } else { 0.5 * (a + b) };
            before = best;
            best = self.at(x);
            if best.1 > 0.0 {
                low = best;
            } else {
                high = best;
            }
        }
        best.0
    }
}

/// All peaks of |H|·ω^p inside a band, in rising frequency.
pub fn peaks(network: &Network, settings: PeakSearch, work: &mut Workspace) -> Vec<Peak> {
    peaks_counted(network, settings, work).0
}

/// As [`peaks`], with the number of receptances evaluated.
pub fn peaks_counted(network: &Network, settings: PeakSearch, work: &mut Workspace) -> (Vec<Peak>, usize) {
    let mut search = Search { network, work, settings, evaluations: 0 };
    let (from, to) = (omega_rad_s(settings.from_hz), omega_rad_s(settings.to_hz));
    let first = search.at(from);
    let mut nodes = Nodes { points: vec![first] };
    let mut low = (first.0, first.1, search.below(from));
    for cut in 1..=FIRST_CUTS {
        // Cuts even in the square root of frequency: finer where modes of heavy tables lie.
        let share = cut as f64 / FIRST_CUTS as f64;
        let omega = if cut == FIRST_CUTS { to } else { (from.sqrt() + share * (to.sqrt() - from.sqrt())).powi(2) };
        let node = search.at(omega);
        let high = (node.0, node.1, search.below(omega));
        search.resolve(&mut nodes, low, high);
        low = high;
    }
    let points = nodes.points;
    let size = |p: &Point| p.receptance.norm_sqr().sqrt() * p.omega_rad_s.powi(settings.omega_power);
    let mut peaks: Vec<(Peak, usize)> = Vec::new();
    for (at, pair) in points.windows(2).enumerate() {
        if pair[0].1 > 0.0 && pair[1].1 <= 0.0 {
            let top = search.maximum(pair[0], pair[1]);
            peaks.push((Peak { frequency_hz: frequency_hz(top.omega_rad_s), amplitude: size(&top), prominence: 1.0 }, at));
        }
    }
    let ends: Vec<usize> = peaks.iter().map(|(_, at)| *at).collect();
    for (index, (peak, at)) in peaks.iter_mut().enumerate() {
        let before = if index == 0 { 0 } else { ends[index - 1] + 1 };
        let after = ends.get(index + 1).map_or(points.len() - 1, |next| *next);
        let lowest = |range: &[(Point, f64)]| range.iter().map(|(p, _)| size(p)).fold(f64::INFINITY, f64::min);
        let valley = lowest(&points[before..=*at]).max(lowest(&points[*at + 1..=after]));
        peak.prominence = (peak.amplitude / valley).max(1.0);
    }
    (peaks.into_iter().map(|(peak, _)| peak).collect(), search.evaluations)
}
