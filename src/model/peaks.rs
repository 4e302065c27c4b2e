//! Peaks of the damped |H|, found on their own: damping moves and removes them.
//!
//! Between two frequencies H is replaced by the rational function of type \[1/2\] that matches H and dH/dω at both
//! ends: it holds one pole and one zero exactly. An interval is split until this interpolant foretells value and
//! slope at its middle, and shows no maximum that the slopes at the nodes do not show. Two counts guard against what an interpolant cannot see: no interval may keep more
//! than one undamped natural frequency (Wittrick–Williams), and between neighbouring nodes the phase of det D, which
//! turns by π at every lightly damped mode whether the response sees it or not, may not turn by more than
//! 2.2 rad. Every maximum then lies between two nodes whose slopes have opposite signs.
//!
//! What may be missed is a ripple: on 16,000 random benches (receptance, mobility and accelerance; table over table, rotor over table; 5–1,000 Hz) no maximum
//! that stands out by 1 % was, and one that stands out by 0.1 to 1 %.
//!
//! Peaks and the valleys between them are then where the interpolant between the nodes beside them turns; peaks are looked at there again, until they
//! stay.

use super::interpolant::{Rationals, Slopes};
use super::lanes::{Complexes, LANES, Reals};
use super::network::{Network, Point, Workspace};
use crate::unit::{frequency_hz, omega_rad_s};

/// Cosine of the largest turn of the phase of det D between neighbouring nodes (2.2 rad).
const COS_TURN: f64 = -0.5885;
/// Half-width, as a share of the frequency, from which a hidden ripple is too slight to be looked for.
const SLIGHT: f64 = 1e-6;
/// Intervals narrower than this share of their frequency are not split further.
const NARROWEST: f64 = 1e-9;
/// Relative precision of the frequencies of valleys, of which only the depth is asked.
const OF_VALLEYS: f64 = 1e-6;
/// Intervals the band is first cut into.
const FIRST_CUTS: usize = 15;

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

impl PeakSearch {
    /// d ln(|H|·ω^p)/dω (s): zero where the sought quantity turns.
    fn log_slope_s(&self, point: &Point) -> f64 {
        point.log_slope_s() + f64::from(self.omega_power) / point.omega_rad_s
    }
}

/// Room for a search; kept, a later one takes none.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    /// Frequencies asked for together, and what is found there.
    omegas: Vec<f64>,
    points: Vec<Point>,
    below: Vec<usize>,
    /// What is known, as it came, and in rising frequency.
    known: Vec<Node>,
    nodes: Vec<Node>,
    pairs: Vec<(usize, usize)>,
    groups: Vec<Group>,
    /// Maxima or valleys on their way, where they are foretold, and between which nodes they lie.
    open: Vec<Turn>,
    places: Vec<f64>,
    tops: Vec<usize>,
    dips: Vec<usize>,
    found: Vec<Point>,
    sizes: Vec<f64>,
}

/// A frequency at which the receptance is known.
#[derive(Debug, Clone, Copy)]
struct Node {
    point: Point,
    /// Log-slope of the sought quantity.
    slope: f64,
    /// Undamped natural frequencies below it.
    below: usize,
    /// The node of the next higher frequency.
    next: usize,
}

struct Search<'a> {
    network: &'a Network,
    work: &'a mut Workspace,
    settings: PeakSearch,
    evaluations: usize,
    room: Room,
}

/// An interval between two neighbouring nodes that is not yet accepted.
#[derive(Debug, Clone, Copy)]
struct Interval {
    low: usize,
    high: usize,
    /// Half its width (rad/s).
    half: f64,
    /// Where it is looked at, from −1 to 1.
    split: f64,
}

/// Interpolants between pairs of points, ω at their lower ends and half the width of each.
fn interpolants<'p>(pair: impl Fn(usize) -> (&'p Point, &'p Point)) -> (Rationals, (Reals, Reals)) {
    let pairs: [_; LANES] = std::array::from_fn(pair);
    let from = Reals::from(pairs.map(|(low, _)| low.omega_rad_s));
    let half = (Reals::from(pairs.map(|(_, high)| high.omega_rad_s)) - from) * Reals::splat(0.5);
    let end =
        |points: [&Point; LANES]| (Complexes::each(|lane| points[lane].receptance), Complexes::each(|lane| points[lane].slope) * half);
    (Rationals::through(end(pairs.map(|(low, _)| low)), end(pairs.map(|(_, high)| high))), (from, half))
}

/// Up to four intervals, the last one repeated where there are fewer, with what decides where they are split.
#[derive(Debug, Clone, Copy)]
struct Group {
    intervals: [Interval; LANES],
    count: usize,
    rationals: Rationals,
}

impl Group {
    /// Of intervals between pairs of nodes.
    fn new(nodes: &[Node], pairs: &[(usize, usize)]) -> Self {
        let pair = |lane: usize| pairs[lane.min(pairs.len() - 1)];
        let (rationals, (_, half)) = interpolants(|lane| (&nodes[pair(lane).0].point, &nodes[pair(lane).1].point));
        let half = half.to_array();
        let mut intervals: [Interval; LANES] =
            std::array::from_fn(|lane| Interval { low: pair(lane).0, high: pair(lane).1, half: half[lane], split: 0.0 });
        if intervals.iter().any(|i| nodes[i.high].below > nodes[i.low].below) {
            for (interval, pole) in intervals.iter_mut().zip(rationals.poles().to_array()) {
                interval.split = if nodes[interval.high].below > nodes[interval.low].below { pole } else { 0.0 };
            }
        }
        Group { intervals, count: pairs.len(), rationals }
    }

    /// Frequencies its intervals are looked at.
    fn places<'g>(&'g self, nodes: &'g [Node]) -> impl Iterator<Item = f64> + 'g {
        self.intervals[..self.count].iter().map(|i| nodes[i.low].point.omega_rad_s + i.half * (1.0 + i.split))
    }

    /// Of which intervals the interpolant can be trusted, now that their middles are known.
    fn accepted(&self, nodes: &[Node], middles: &[Node], power: f64) -> [bool; LANES] {
        let middle = |lane: usize| &middles[lane.min(self.count - 1)];
        let each = |of: &dyn Fn(usize) -> f64| Reals::from(std::array::from_fn::<_, LANES, _>(of));
        let (low, high) = (|lane: usize| &nodes[self.intervals[lane].low], |lane: usize| &nodes[self.intervals[lane].high]);
        let half = each(&|lane| self.intervals[lane].half);
        let split = each(&|lane| self.intervals[lane].split);
        let to = each(&|lane| high(lane).point.omega_rad_s);
        let [d0, d1, d2] = [
            Complexes::each(|lane| low(lane).point.determinant),
            Complexes::each(|lane| middle(lane).point.determinant),
            Complexes::each(|lane| high(lane).point.determinant),
        ];
        let turns_little = |a: Complexes, b: Complexes| {
            let turn = b * a.conj();
            turn.re.simd_ge(turn.norm_sqr().sqrt() * Reals::splat(COS_TURN))
        };
        let (h, s) = (Complexes::each(|lane| middle(lane).point.receptance), Complexes::each(|lane| middle(lane).point.slope));
        let apart = each(&|lane| f64::from(u8::from(high(lane).below <= low(lane).below + 1))).simd_gt(Reals::ZERO);
        let trusted = apart & turns_little(d0, d1) & turns_little(d1, d2) & self.rationals.foretell(split, (h, s * half));
        let slight = half.simd_lt(to * Reals::splat(SLIGHT));
        let plain = if (trusted & !slight).any() {
            let slopes = Slopes {
                low: each(&|lane| low(lane).slope) * half,
                middle: each(&|lane| middle(lane).slope) * half,
                high: each(&|lane| high(lane).slope) * half,
            };
            self.rationals.hide_nothing(power, (each(&|lane| low(lane).point.omega_rad_s), half), split, &slopes)
        } else {
            slight
        };
        let accepted = half.simd_lt(to * Reals::splat(NARROWEST)) | (trusted & (slight | plain));
        let bits = accepted.to_bitmask();
        std::array::from_fn(|lane| bits >> lane & 1 == 1)
    }
}

impl Search<'_> {
    /// Evaluates all frequencies asked for.
    fn evaluate(&mut self) {
        self.evaluations += self.room.omegas.len();
        self.network.at_each(&self.room.omegas, self.work, &mut self.room.points);
    }

    /// Counts the undamped modes below all frequencies asked for.
    fn count(&mut self) {
        self.network.modes_below_each(&self.room.omegas, self.work, &mut self.room.below);
    }

    /// The cuts of the band, even in the square root of frequency: finer where modes of heavy tables lie.
    fn cut(&mut self) {
        let (from, to) = (omega_rad_s(self.settings.from_hz), omega_rad_s(self.settings.to_hz));
        let between = |at: usize| (from.sqrt() + at as f64 / FIRST_CUTS as f64 * (to.sqrt() - from.sqrt())).powi(2);
        self.room.omegas.clear();
        self.room.omegas.push(from);
        self.room.omegas.extend((1..FIRST_CUTS).map(between));
        self.room.omegas.push(to);
        self.evaluate();
        self.count();
        self.room.known.clear();
        for at in 0..=FIRST_CUTS {
            let point = self.room.points[at];
            // The last one has no next: none has so high a number.
            let next = if at == FIRST_CUTS { usize::MAX } else { at + 1 };
            self.room.known.push(Node { point, slope: self.settings.log_slope_s(&point), below: self.room.below[at], next });
        }
    }

    /// All nodes between and at the cuts, in rising frequency: every interval is looked at in its middle, all of a round together.
    fn resolve(&mut self) {
        self.room.pairs.clear();
        self.room.pairs.extend((1..self.room.known.len()).map(|high| (high - 1, high)));
        let settings = self.settings;
        while !self.room.pairs.is_empty() {
            let Room { omegas, known, pairs, groups, .. } = &mut self.room;
            groups.clear();
            groups.extend(pairs.chunks(LANES).map(|pairs| Group::new(known, pairs)));
            omegas.clear();
            omegas.extend(groups.iter().flat_map(|group| group.places(known)));
            self.evaluate();
            let Room { omegas, points, known, pairs, groups, .. } = &mut self.room;
            omegas.clear();
            pairs.clear();
            let mut points = points.iter();
            for group in groups.iter() {
                let first = known.len();
                for (interval, point) in group.intervals[..group.count].iter().zip(&mut points) {
                    let here = known.len();
                    known.push(Node {
                        point: *point,
                        slope: settings.log_slope_s(point),
                        below: known[interval.low].below,
                        next: interval.high,
                    });
                    known[interval.low].next = here;
                }
                let accepted = group.accepted(known, &known[first..], f64::from(settings.omega_power));
                for (lane, interval) in group.intervals[..group.count].iter().enumerate().filter(|(lane, _)| !accepted[*lane]) {
                    // The count never falls: between equal counts it needs no evaluation.
                    if known[interval.high].below != known[interval.low].below {
                        omegas.push(known[first + lane].point.omega_rad_s);
                    }
                    pairs.extend([(interval.low, first + lane), (first + lane, interval.high)]);
                }
            }
            self.count();
            let Room { below, known, pairs, .. } = &mut self.room;
            let mut counts = below.iter();
            for halves in pairs.chunks_exact(2) {
                let ((low, middle), (_, high)) = (halves[0], halves[1]);
                if known[high].below != known[low].below {
                    known[middle].below = counts.next().copied().unwrap_or(known[low].below);
                }
            }
        }
        let Room { known, nodes, .. } = &mut self.room;
        nodes.clear();
        let mut at = 0;
        while let Some(node) = known.get(at) {
            nodes.push(*node);
            at = node.next;
        }
    }

    /// Finds where the sought quantity turns in all that is open, whose ends have log-slopes of different signs, in step.
    fn turn(&mut self, precision: f64) {
        for step in 0..80 {
            let Room { omegas, open, places, .. } = &mut self.room;
            places.clear();
            for some in open.chunks(LANES) {
                places.extend(&Turn::foretold(some, self.settings.omega_power)[..some.len()]);
            }
            omegas.clear();
            for (turn, foretold) in open.iter_mut().zip(places).filter(|(t, _)| !t.done) {
                match turn.next(step, *foretold, precision) {
                    Some(omega) => omegas.push(omega),
                    None => turn.done = true,
                }
            }
            if omegas.is_empty() {
                break;
            }
            self.evaluate();
            let settings = self.settings;
            let Room { points, open, .. } = &mut self.room;
            let found = points.iter().map(|point| (*point, settings.log_slope_s(point)));
            open.iter_mut().filter(|t| !t.done).zip(found).for_each(|(turn, found)| turn.take(found));
        }
    }

    /// All peaks, in rising frequency.
    fn peaks(&mut self, found: &mut Vec<Peak>) {
        self.cut();
        self.resolve();
        let omega_power = self.settings.omega_power;
        let Room { nodes, open, tops, .. } = &mut self.room;
        tops.clear();
        tops.extend((1..nodes.len()).filter(|at| nodes[at - 1].slope > 0.0 && nodes[*at].slope <= 0.0));
        open.clear();
        open.extend(tops.iter().map(|at| Turn::between(&nodes[at - 1], &nodes[*at])));
        self.turn(self.settings.precision);
        let Room { nodes, open, dips, found: maxima, .. } = &mut self.room;
        maxima.clear();
        maxima.extend(open.iter().map(|turn| turn.best.0));
        // The least |H|·ω^p between each node and the next, where it falls and rises again.
        dips.clear();
        dips.extend((1..nodes.len()).filter(|at| nodes[at - 1].slope < 0.0 && nodes[*at].slope > 0.0).map(|at| at - 1));
        open.clear();
        open.extend(dips.iter().map(|at| Turn::between(&nodes[*at], &nodes[at + 1])));
        self.turn(OF_VALLEYS);
        let Room { nodes, open, dips, tops, found: maxima, sizes, .. } = &mut self.room;
        let size = |p: &Point| p.receptance.norm_sqr().sqrt() * p.omega_rad_s.powi(omega_power);
        sizes.clear();
        sizes.extend(nodes.iter().map(|n| size(&n.point)));
        for (at, valley) in dips.iter().zip(open) {
            sizes[*at] = sizes[*at].min(size(&valley.best.0));
        }
        let lowest = |range: std::ops::Range<usize>| sizes[range].iter().copied().fold(f64::INFINITY, f64::min);
        let peak = |(index, top): (usize, &Point)| {
            let at = tops[index];
            let before = if index == 0 { 0 } else { tops[index - 1] };
            let after = tops.get(index + 1).map_or(nodes.len(), |next| *next);
            let valley = lowest(before..at).max(lowest(at..after));
            let amplitude = size(top);
            Peak { frequency_hz: frequency_hz(top.omega_rad_s), amplitude, prominence: (amplitude / valley).max(1.0) }
        };
        found.clear();
        found.extend(maxima.iter().enumerate().map(peak));
    }
}

/// A point with its log-slope.
type Sloped = (Point, f64);

/// A maximum or a minimum on its way to be found between two points.
#[derive(Debug, Clone, Copy)]
struct Turn {
    low: Sloped,
    high: Sloped,
    best: Sloped,
    done: bool,
}

impl Turn {
    fn between(low: &Node, high: &Node) -> Self {
        let (low, high) = ((low.point, low.slope), (high.point, high.slope));
        let low_is_larger = low.0.receptance.norm_sqr() > high.0.receptance.norm_sqr();
        Turn { low, high, best: if low_is_larger == (low.1 > 0.0) { low } else { high }, done: false }
    }

    /// Where the interpolants between the ends of up to four of them turn (rad/s).
    fn foretold(some: &[Turn], omega_power: i32) -> [f64; LANES] {
        let of = |lane: usize| &some[lane.min(some.len() - 1)];
        let each = |what: fn(&Turn) -> f64| Reals::from(std::array::from_fn::<_, LANES, _>(|lane| what(of(lane))));
        let (rationals, (from, half)) = interpolants(|lane| (&of(lane).low.0, &of(lane).high.0));
        let slopes = (each(|t| t.low.1) * half, each(|t| t.high.1) * half);
        let t = rationals.turn(f64::from(omega_power), (from, half), slopes);
        (from + half * (Reals::ONE + t)).to_array()
    }

    /// Where to look next: where it is foretold; where that is nowhere between the ends, and every fifth time, half-way. `None` where the next step would
    /// be shorter than the precision.
    fn next(&self, step: usize, foretold: f64, precision: f64) -> Option<f64> {
        let (a, b) = (self.low.0.omega_rad_s, self.high.0.omega_rad_s);
        let reach = precision * b;
        let inside = foretold >= a && foretold <= b;
        if b - a <= reach || (step > 0 && inside && (foretold - self.best.0.omega_rad_s).abs() <= reach) {
            return None;
        }
        Some(if inside && step % 5 != 4 { foretold.clamp(a + 0.2 * reach, b - 0.2 * reach) } else { 0.5 * (a + b) })
    }

    fn take(&mut self, found: Sloped) {
        self.best = found;
        if (found.1 > 0.0) == (self.low.1 > 0.0) {
            self.low = found;
        } else {
            self.high = found;
        }
    }
}

/// All peaks of |H|·ω^p inside a band, in rising frequency.
pub fn peaks(network: &Network, settings: PeakSearch, work: &mut Workspace) -> Vec<Peak> {
    let mut found = Vec::new();
    peaks_into(network, settings, work, &mut found);
    found
}

/// As [`peaks`], into a list, with the number of receptances evaluated; once workspace and list have room, nothing is allocated.
pub fn peaks_into(network: &Network, settings: PeakSearch, work: &mut Workspace, found: &mut Vec<Peak>) -> usize {
    let room = std::mem::take(&mut work.peaks);
    let mut search = Search { network, work, settings, evaluations: 0, room };
    search.peaks(found);
    let Search { work, evaluations, room, .. } = search;
    work.peaks = room;
    evaluations
}
