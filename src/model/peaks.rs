//! Peaks of the damped |H|, found on their own: damping moves and removes them.
//!
//! Between two frequencies H is replaced by the rational function of type \[1/2\] that matches H and dH/dω at both
//! ends: it holds one pole and one zero exactly. An interval is split until this interpolant foretells value and
//! slope at its middle. Two counts guard against what an interpolant cannot see: no interval may keep more
//! than one undamped natural frequency (Wittrick–Williams), and between neighbouring nodes the phase of det D, which
//! turns by π at every lightly damped mode whether the response sees it or not, may not turn by more than
//! [`TURN`]. Every maximum then lies between two nodes whose slopes have opposite signs.

use num_complex::Complex64;

use super::network::{Network, Point, Workspace};
use crate::unit::{frequency_hz, omega_rad_s};

/// Largest turn of the phase of det D between neighbouring nodes (rad).
const TURN: f64 = 2.2;
/// Relative error of the interpolant at the middle of an interval that is accepted.
const FORETOLD: f64 = 2e-3;
/// Intervals narrower than this share of their frequency are not split further.
const NARROWEST: f64 = 1e-9;
/// Intervals the band is first cut into.
const FIRST_CUTS: usize = 12;

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
        let scale = (m11.norm() + m12.norm()) * (m21.norm() + m22.norm());
        if !(determinant.norm() > 1e-14 * scale) {
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

    /// Real part of a pole well inside (−1, 1) and close to the real axis.
    fn pole(&self) -> Option<f64> {
        let root = (self.c * self.c - self.d * 4.0).sqrt();
        [root, -root].into_iter().map(|r| (r - self.c) / (self.d * 2.0)).find(|t| t.re.abs() < 0.9 && t.im.abs() < 0.5).map(|t| t.re)
    }
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
            let foretold = rational.as_ref().is_some_and(|r| {
                let (value, slope) = r.at(split);
                let size = middle.receptance.norm();
                (value - middle.receptance).norm() <= FORETOLD * size
                    && (slope - middle.slope * half).norm() <= 10.0 * FORETOLD * (size + (middle.slope * half).norm())
            });
            let turns = [(&low.0, &middle), (&middle, &high.0)].map(|(a, b)| (b.determinant * a.determinant.conj()).arg().abs());
            let accepted = narrow || (high.2 <= low.2 + 1 && foretold && turns[0] <= TURN && turns[1] <= TURN);
            if !accepted {
                let below = self.below(middle_omega);
                let middle = (middle, middle_slope, below);
                pending.push((middle, high));
                pending.push((low, middle));
                continue;
            }
            if let Some(rational) = rational.filter(|_| !narrow) {
                self.inner_maxima(nodes, &rational, (&low, &high), half, (split, &middle, middle_slope));
            } else {
                nodes.points.push((middle, middle_slope));
            }
            nodes.points.push((high.0, high.1));
        }
    }

    /// Adds the middle node, and a node wherever the interpolant has a maximum that the slopes at the nodes do not show.
    fn inner_maxima(
        &mut self,
        nodes: &mut Nodes,
        rational: &Rational,
        ends: (&(Point, f64, usize), &(Point, f64, usize)),
        half: f64,
        middle: (f64, &Point, f64),
    ) {
        let from = ends.0.0.omega_rad_s;
        let power = f64::from(self.settings.omega_power);
        let slope_at = |t: f64| {
            let (value, slope) = rational.at(t);
            (slope * value.conj()).re / value.norm_sqr() + power * half / (from + half * (1.0 + t))
        };
        for (start, stop, left, right) in [(-1.0, middle.0, ends.0.1, middle.2), (middle.0, 1.0, middle.2, ends.1.1)] {
            const STEPS: usize = 5;
            if !(left > 0.0 && right < 0.0) {
                let mut last = left;
                for step in 1..=STEPS {
                    let t = start + (stop - start) * step as f64 / STEPS as f64;
                    let here = if step == STEPS { right } else { slope_at(t) };
                    if last > 0.0 && here < 0.0 {
                        // Nodes on both sides of the maximum the interpolant sees.
                        let before = start + (stop - start) * (step - 1) as f64 / STEPS as f64;
                        for t in [before, t] {
                            if t > start && t < stop {
                                let node = self.at(from + half * (1.0 + t));
                                nodes.points.push(node);
                            }
                        }
                    }
                    last = here;
                }
            }
            if stop < 1.0 {
                nodes.points.push((*middle.1, middle.2));
            }
        }
    }

    /// The maximum between two nodes whose log-slopes are positive and negative.
    fn maximum(&mut self, mut low: (Point, f64), mut high: (Point, f64)) -> Point {
        let mut best = if low.0.receptance.norm_sqr() > high.0.receptance.norm_sqr() { low } else { high };
        for step in 0..80 {
            let (a, b) = (low.0.omega_rad_s, high.0.omega_rad_s);
            let width = b - a;
            if width <= self.settings.precision * b {
                break;
            }
            // First the complex pole seen from the better end, then the straight line through both slopes.
            let newton = best.0.omega_rad_s + (best.0.receptance / best.0.slope).re;
            let secant = a + width * low.1 / (low.1 - high.1);
            let guess = match step {
                0 | 1 => newton,
                _ if step % 6 == 5 => 0.5 * (a + b),
                _ => secant,
            };
            let hair = 0.2 * self.settings.precision * b;
            let x = if guess > a && guess < b { guess.clamp(a + hair, b - hair) } else { 0.5 * (a + b) };
            let here = self.at(x);
            let converged = (x - best.0.omega_rad_s).abs() <= self.settings.precision * b;
            best = here;
            if converged && step > 1 {
                break;
            }
            if here.1 > 0.0 {
                low = here;
            } else {
                high = here;
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
    let size = |p: &Point| p.receptance.norm() * p.omega_rad_s.powi(settings.omega_power);
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
