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

use super::lanes::{Complexes, LANES, Reals};
use super::network::{Network, Point, Workspace, filled};
use crate::unit::{frequency_hz, omega_rad_s};

/// Cosine of the largest turn of the phase of det D between neighbouring nodes (2.2 rad).
const COS_TURN: f64 = -0.5885;
/// Relative error of the interpolant at the middle of an interval that is accepted.
const FORETOLD: f64 = 5e-4;
/// Half-width, as a share of the frequency, from which a hidden ripple is too slight to be looked for.
const SLIGHT: f64 = 1e-6;
/// Intervals narrower than this share of their frequency are not split further.
const NARROWEST: f64 = 1e-9;
/// Places at which an interpolant is looked at: six even ones, five about each of its three features, and the middle node.
const SAMPLES: usize = 22;
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

/// A frequency at which the receptance is known.
#[derive(Clone, Copy)]
struct Node {
    point: Point,
    /// Log-slope of the sought quantity.
    slope: f64,
    /// Undamped natural frequencies below it.
    below: usize,
    /// The node of the next higher frequency.
    next: usize,
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

    /// d ln|H|/dt at some t times the returned positive weights: quotients without the division.
    fn weighted_log_slopes(&self, t: Reals) -> (Reals, Reals) {
        let [a, b, c, d] = [self.a, self.b, self.c, self.d].map(Complexes::splat);
        let n = a + b * t;
        let q = Complexes::real(Reals::ONE) + c * t + d * (t * t);
        let q_slope = c + d * (t + t);
        let (n2, q2) = (n.norm_sqr(), q.norm_sqr());
        let re = |x: Complexes, y: Complexes| x.re * y.re + x.im * y.im;
        (re(b, n) * q2 - re(q_slope, q) * n2, n2 * q2)
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
    /// Room for frequencies asked for together, and for what is found there.
    omegas: Vec<f64>,
    points: Vec<Point>,
    below: Vec<usize>,
}

/// An interval between two neighbouring nodes that is not yet accepted, with what decides where it is split.
struct Interval {
    low: usize,
    high: usize,
    rational: Option<Rational>,
    /// Half its width (rad/s).
    half: f64,
    /// Where it is looked at, from −1 to 1.
    split: f64,
}

impl Interval {
    fn between(nodes: &[Node], low: usize, high: usize) -> Self {
        let (a, b) = (&nodes[low], &nodes[high]);
        let half = 0.5 * (b.point.omega_rad_s - a.point.omega_rad_s);
        let of = |node: &Node| (node.point.receptance, node.point.slope * half);
        let rational = Rational::through(of(a), of(b));
        let split = if b.below > a.below { rational.as_ref().and_then(Rational::pole).unwrap_or(0.0) } else { 0.0 };
        Interval { low, high, rational, half, split }
    }
}

impl Search<'_> {
    fn log_slope(&self, point: &Point) -> f64 {
        point.log_slope_s() + f64::from(self.settings.omega_power) / point.omega_rad_s
    }

    /// Evaluates all frequencies asked for.
    fn evaluate(&mut self) {
        self.evaluations += self.omegas.len();
        self.network.at_each(&self.omegas, self.work, &mut self.points);
    }

    /// All nodes between and at the cuts, in rising frequency: every interval is looked at in its middle, all of a round together.
    fn resolve(&mut self, mut nodes: Vec<Node>) -> Vec<Node> {
        let mut pending: Vec<Interval> = (1..nodes.len()).map(|high| Interval::between(&nodes, high - 1, high)).collect();
        // Of what is to be split: the interval and its middle.
        let mut split: Vec<(usize, usize)> = Vec::new();
        while !pending.is_empty() {
            self.omegas.clear();
            self.omegas.extend(pending.iter().map(|i| nodes[i.low].point.omega_rad_s + i.half * (1.0 + i.split)));
            self.evaluate();
            self.omegas.clear();
            split.clear();
            for (at, interval) in pending.iter().enumerate() {
                let point = self.points[at];
                let (low, high, here) = (nodes[interval.low], nodes[interval.high], nodes.len());
                let middle = Node { point, slope: self.log_slope(&point), below: low.below, next: interval.high };
                nodes.push(middle);
                nodes[interval.low].next = here;
                if !self.is_accepted(interval, (&low, &middle, &high)) {
                    // The count never falls: between equal counts it needs no evaluation.
                    if high.below != low.below {
                        self.omegas.push(point.omega_rad_s);
                    }
                    split.push((at, here));
                }
            }
            self.network.modes_below_each(&self.omegas, self.work, &mut self.below);
            let mut counts = self.below.iter();
            let mut next = Vec::with_capacity(2 * split.len());
            for &(at, middle) in &split {
                let Interval { low, high, .. } = pending[at];
                if nodes[high].below != nodes[low].below {
                    nodes[middle].below = counts.next().copied().unwrap_or(nodes[low].below);
                }
                next.push(Interval::between(&nodes, low, middle));
                next.push(Interval::between(&nodes, middle, high));
            }
            pending = next;
        }
        let mut at = 0;
        let mut rising = Vec::with_capacity(nodes.len());
        while let Some(node) = nodes.get(at) {
            rising.push(*node);
            at = node.next;
        }
        rising
    }

    /// Whether the interpolant of an interval can be trusted, now that its middle is known.
    fn is_accepted(&self, interval: &Interval, (low, middle, high): (&Node, &Node, &Node)) -> bool {
        let half = interval.half;
        let to = high.point.omega_rad_s;
        let turns_little = |a: &Point, b: &Point| {
            let turn = b.determinant * a.determinant.conj();
            turn.re >= COS_TURN * turn.norm_sqr().sqrt()
        };
        half < NARROWEST * to
            || (high.below <= low.below + 1
                && turns_little(&low.point, &middle.point)
                && turns_little(&middle.point, &high.point)
                && interval.rational.as_ref().is_some_and(|r| {
                    let middle = (interval.split, &middle.point, middle.slope);
                    self.is_foretold(r, half, middle) && (half < SLIGHT * to || self.hides_nothing(r, (low, high), half, middle))
                }))
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
    fn hides_nothing(&self, rational: &Rational, ends: (&Node, &Node), half: f64, middle: (f64, &Point, f64)) -> bool {
        let mut samples = [f64::INFINITY; SAMPLES];
        samples[..6].copy_from_slice(&[-0.75, -0.5, -0.25, 0.25, 0.5, 0.75]);
        for (at, feature) in rational.features().into_iter().enumerate() {
            for (side, sample) in [-2.0, -0.7, 0.0, 0.7, 2.0].iter().zip(&mut samples[6 + 5 * at..]) {
                *sample = feature.re + side * feature.im.abs();
            }
        }
        samples[21] = middle.0;
        // The slope of the sought quantity, times its weight, and the weight.
        let (power, from) = (Reals::splat(f64::from(self.settings.omega_power) * half), Reals::splat(ends.0.point.omega_rad_s));
        let (mut slopes, mut weights) = ([0.0; SAMPLES], [0.0; SAMPLES]);
        for (at, some) in samples.chunks(LANES).enumerate() {
            let t = filled(some);
            let (slope, weight) = rational.weighted_log_slopes(t);
            let slope = slope + weight * power / (from + Reals::splat(half) * (Reals::ONE + t));
            slopes[at * LANES..][..some.len()].copy_from_slice(&slope.to_array()[..some.len()]);
            weights[at * LANES..][..some.len()].copy_from_slice(&weight.to_array()[..some.len()]);
        }
        let doubt = 10.0 * (slopes[21] / weights[21] - middle.2 * half).abs();
        [(-1.0, middle.0, ends.0.slope, middle.2), (middle.0, 1.0, middle.2, ends.1.slope)].iter().all(|&(start, stop, left, right)| {
            let turns = left.is_sign_positive() != right.is_sign_positive();
            // Where the sign of the left end was last seen, and that of the right end first.
            let (mut last_left, mut first_right) = (start, stop);
            for ((&t, slope), weight) in samples[..21].iter().zip(slopes).zip(weights).filter(|((t, _), _)| **t > start && **t < stop) {
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

    /// The maxima between pairs of nodes whose log-slopes are positive and negative, all looked for in step.
    fn maxima(&mut self, mut open: Vec<Maximum>) -> Vec<Point> {
        for step in 0..80 {
            self.omegas.clear();
            for maximum in open.iter_mut().filter(|m| !m.done) {
                match maximum.next(step, self.settings.precision) {
                    Some(omega) => self.omegas.push(omega),
                    None => maximum.done = true,
                }
            }
            if self.omegas.is_empty() {
                break;
            }
            self.evaluate();
            let slopes = self.points.iter().map(|point| (*point, self.log_slope(point)));
            open.iter_mut().filter(|m| !m.done).zip(slopes).for_each(|(maximum, found)| maximum.take(found));
        }
        open.into_iter().map(|maximum| maximum.best.0).collect()
    }
}

/// A maximum on its way to be found between two points, each with its log-slope.
struct Maximum {
    low: (Point, f64),
    high: (Point, f64),
    best: (Point, f64),
    before: (Point, f64),
    done: bool,
}

impl Maximum {
    fn between(low: &Node, high: &Node) -> Self {
        let (low, high) = ((low.point, low.slope), (high.point, high.slope));
        let (best, before) = if low.0.receptance.norm_sqr() > high.0.receptance.norm_sqr() { (low, high) } else { (high, low) };
        Maximum { low, high, best, before, done: false }
    }

    /// Where to look next: first at the real part of the complex pole as seen from the better end, then where the secant through the two latest slopes
    /// leads; a step that leaves the bracket, or every fifth, halves it. `None` where the next step would be shorter than the precision.
    fn next(&self, step: usize, precision: f64) -> Option<f64> {
        let (a, b) = (self.low.0.omega_rad_s, self.high.0.omega_rad_s);
        let reach = precision * b;
        if b - a <= reach {
            return None;
        }
        let here = self.best.0.omega_rad_s;
        let newton = here + (self.best.0.receptance / self.best.0.slope).re;
        let secant = here - self.best.1 * (here - self.before.0.omega_rad_s) / (self.best.1 - self.before.1);
        let guess = if step == 0 { newton } else { secant };
        let inside = guess > a - reach && guess < b + reach;
        if step > 0 && inside && (guess - here).abs() <= reach {
            return None;
        }
        Some(if inside && step % 5 != 4 { guess.clamp(a + 0.2 * reach, b - 0.2 * reach) } else { 0.5 * (a + b) })
    }

    fn take(&mut self, found: (Point, f64)) {
        self.before = self.best;
        self.best = found;
        if found.1 > 0.0 {
            self.low = found;
        } else {
            self.high = found;
        }
    }
}

/// All peaks of |H|·ω^p inside a band, in rising frequency.
pub fn peaks(network: &Network, settings: PeakSearch, work: &mut Workspace) -> Vec<Peak> {
    peaks_counted(network, settings, work).0
}

/// As [`peaks`], with the number of receptances evaluated.
pub fn peaks_counted(network: &Network, settings: PeakSearch, work: &mut Workspace) -> (Vec<Peak>, usize) {
    let (omegas, points, below) = (Vec::new(), Vec::new(), Vec::new());
    let mut search = Search { network, work, settings, evaluations: 0, omegas, points, below };
    let (from, to) = (omega_rad_s(settings.from_hz), omega_rad_s(settings.to_hz));
    // Cuts even in the square root of frequency: finer where modes of heavy tables lie.
    let cut = |at: usize| (from.sqrt() + at as f64 / FIRST_CUTS as f64 * (to.sqrt() - from.sqrt())).powi(2);
    search.omegas.extend((0..=FIRST_CUTS).map(|at| {
        if at == 0 {
            from
        } else if at == FIRST_CUTS {
            to
        } else {
            cut(at)
        }
    }));
    search.evaluate();
    network.modes_below_each(&search.omegas, search.work, &mut search.below);
    // The last one has no next: none has so high a number.
    let next = |at: usize| if at == FIRST_CUTS { usize::MAX } else { at + 1 };
    let of = |(at, (point, below)): (usize, (&Point, &usize))| Node {
        point: *point,
        slope: search.log_slope(point),
        below: *below,
        next: next(at),
    };
    let cuts: Vec<Node> = search.points.iter().zip(&search.below).enumerate().map(of).collect();
    let nodes = search.resolve(cuts);
    let tops: Vec<usize> = (1..nodes.len()).filter(|at| nodes[at - 1].slope > 0.0 && nodes[*at].slope <= 0.0).collect();
    let found = search.maxima(tops.iter().map(|at| Maximum::between(&nodes[at - 1], &nodes[*at])).collect());
    let size = |p: &Point| p.receptance.norm_sqr().sqrt() * p.omega_rad_s.powi(settings.omega_power);
    let lowest = |range: &[Node]| range.iter().map(|n| size(&n.point)).fold(f64::INFINITY, f64::min);
    let peak = |(index, top): (usize, &Point)| {
        let at = tops[index];
        let before = if index == 0 { 0 } else { tops[index - 1] };
        let after = tops.get(index + 1).map_or(nodes.len(), |next| *next);
        let valley = lowest(&nodes[before..at]).max(lowest(&nodes[at..after]));
        let amplitude = size(top);
        Peak { frequency_hz: frequency_hz(top.omega_rad_s), amplitude, prominence: (amplitude / valley).max(1.0) }
    };
    (found.iter().enumerate().map(peak).collect(), search.evaluations)
}
