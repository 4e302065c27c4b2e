//! What is seen of |H| over a piece of a band: where it turns.

use std::sync::LazyLock;

use super::peak_search::PeakSearch;
use super::rational_interpolant::RationalInterpolant;
use super::simd::{Complexes, LANES, Reals, filled};

/// Cosine of the largest turn of the phase of Δ between neighbouring looks (2.2 rad).
const COS_TURN: f64 = -0.5885;
/// Looks at a piece before its roots are known.
const GRID: usize = 24;
/// How much polynomials may err beside their least size on the piece, and beside their largest, where rounding is all there is.
const ERR: f64 = 1e-5;
const ROUNDING: f64 = 1e-13;
/// How far along and off the band Newton's rule may lead to a root that is looked at, in distances between neighbours on the grid.
const NEAR: (f64, f64) = (0.75, 1.5);
/// Reach of a root on the band itself, as a share of half a piece.
const LEAST_REACH: f64 = 1e-8;
/// Distance from the band at which a root is looked for once more that is not found from a place on it, as a share of half a piece.
const ASIDE: f64 = 0.05;
/// Where roots are looked at, in units of their distance from the band.
const SIDES: [f64; 5] = [-2.0, -0.7, 0.0, 0.7, 2.0];
/// How deep a parabola through three looks of one sign must dip for another look there, as a share of the middle one, and how often that is asked.
const DIP: (f64, usize) = (0.5, 3);
/// Relative precision of the frequencies of valleys, of which only the depth is asked.
const OF_VALLEYS: f64 = 1e-6;
/// Relative change of |H| over the last step to a turn, of which half is accounted for.
pub(super) const LITTLE: f64 = 1e-5;

/// Where a piece is looked at before its roots are known.
#[derive(Debug)]
struct Grid {
    /// −1 … 1, dense at both ends and alike on both sides of 0.
    places: [f64; GRID],
    /// The upper half of them in groups, and how far each is from its neighbours.
    upper: [(Reals, Reals); GRID / 2 / LANES],
}

static PLACES: LazyLock<Grid> = LazyLock::new(|| {
    let places: [f64; GRID] = std::array::from_fn(|i| -(std::f64::consts::PI * i as f64 / (GRID - 1) as f64).cos());
    let upper = |group: usize| {
        let at = |lane: usize| GRID / 2 + group * LANES + lane;
        let apart = |at: usize| 0.5 * (places[(at + 1).min(GRID - 1)] - places[at - 1]);
        let of = |what: &dyn Fn(usize) -> f64| Reals::from(std::array::from_fn::<_, LANES, _>(|lane| what(at(lane))));
        (of(&|at| places[at]), of(&apart))
    };
    Grid { places, upper: std::array::from_fn(upper) }
});

/// What is seen at a place of a piece.
#[derive(Debug, Clone, Copy)]
struct Evaluation {
    t: f64,
    /// G.
    rise: f64,
    /// Δ.
    denominator: (f64, f64),
}

/// A root of N or Δ near a piece.
#[derive(Debug, Clone, Copy)]
struct Root {
    re: f64,
    /// Its distance from the band.
    reach: f64,
    pole: bool,
    /// The number of the look on the grid below it.
    after: usize,
}

/// Neighbouring looks between which the sought quantity turns.
#[derive(Debug, Clone, Copy)]
struct ExtremumBracket {
    low: (f64, f64),
    high: (f64, f64),
    top: bool,
}

/// A maximum or minimum of |H|·ω^p.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extremum {
    /// Where (rad/s).
    pub omega_rad_s: f64,
    /// |H|·ω^p there.
    pub size: f64,
    /// d²ln(|H|·ω^p)/dω² (s²).
    pub curvature: f64,
    /// How much its size may err, relative to it, and its frequency with it.
    pub doubt: f64,
    /// A maximum.
    pub top: bool,
}

/// What is seen of the piece at hand; room for it.
#[derive(Debug, Clone)]
pub(super) struct ExtremumSearch {
    grid: &'static Grid,
    /// G on the grid, real and imaginary part of Δ.
    rise: [f64; GRID],
    denominator: [[f64; GRID]; 2],
    roots: Vec<Root>,
    /// Where roots are looked at, and what is seen there.
    asked: Vec<f64>,
    about: Vec<Evaluation>,
    /// Where G changes its sign.
    brackets: Vec<ExtremumBracket>,
}

impl Default for ExtremumSearch {
    fn default() -> Self {
        let (roots, asked, about, brackets) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        ExtremumSearch { grid: &PLACES, rise: [0.0; GRID], denominator: [[0.0; GRID]; 2], roots, asked, about, brackets }
    }
}

/// |z|² and its first and second derivative.
fn square([z, slope, half_bend]: [Complexes; 3]) -> [Reals; 3] {
    let two = Reals::splat(2.0);
    [z.norm_sqr(), two * z.dot(slope), two * (slope.norm_sqr() + two * z.dot(half_bend))]
}

impl ExtremumSearch {
    /// What is seen at a place of the grid.
    fn look(&self, at: usize) -> Evaluation {
        Evaluation { t: self.grid.places[at], rise: self.rise[at], denominator: (self.denominator[0][at], self.denominator[1][at]) }
    }

    /// Frequencies of the grid over a piece but for its upper end (rad/s).
    pub fn grid_rad_s(&self, of: &RationalInterpolant) -> impl Iterator<Item = f64> {
        self.grid.places[..GRID - 1].iter().map(|t| of.omega_rad_s(*t))
    }

    /// Whether the sought quantity rises at the upper end.
    pub fn rises(&self) -> bool {
        self.rise[GRID - 1] > 0.0
    }

    /// Number of poles seen.
    pub fn poles(&self) -> usize {
        self.roots.iter().filter(|r| r.pole).count()
    }

    /// Number of poles seen between a place of the grid and the next.
    pub fn poles_after(&self, at: usize) -> usize {
        self.roots.iter().filter(|r| r.pole && r.after == at).count()
    }

    /// Looks at the grid of a piece, and where from there Newton's rule leads to near roots; whether the polynomials err little.
    pub fn survey(&mut self, of: &RationalInterpolant, settings: &PeakSearch) -> bool {
        self.roots.clear();
        let (mut least, mut most) = ([Reals::splat(f64::MAX); 2], [Reals::ZERO; 2]);
        for (group, (t, apart)) in self.grid.upper.iter().enumerate() {
            for (found, (t, upper)) in of.slopes_on_both_sides(*t).iter().zip([(*t, true), (-*t, false)]) {
                for ([value, slope], (least, (most, pole))) in
                    [found.0, found.1].into_iter().zip(least.iter_mut().zip(most.iter_mut().zip([false, true])))
                {
                    let (size, steep) = (value.norm_sqr(), slope.norm_sqr());
                    *least = least.fast_min((steep * *apart).mul_add(*apart, size));
                    *most = most.fast_max(size);
                    let step = value * slope.inverse();
                    let near = step.re.abs().simd_le(*apart * Reals::splat(NEAR.0)) & step.im.abs().simd_le(*apart * Reals::splat(NEAR.1));
                    let bits = near.to_bitmask();
                    if bits != 0 {
                        let (re, im) = ((t - step.re).to_array(), step.im.to_array());
                        let start = |lane: usize| Root { re: re[lane], reach: -im[lane], pole, after: 0 };
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
            let (least, most) =
                (least[part].to_array().into_iter().fold(f64::MAX, f64::min), most[part].to_array().into_iter().fold(0.0, f64::max));
            of.doubt[part] <= ERR * least.sqrt() || of.doubt[part] <= ROUNDING * most.sqrt()
        })
    }

    /// Looks about the roots near the piece, and where G changes its sign, `rising` below the piece; whether neighbouring looks are near enough.
    pub fn look_closer(&mut self, of: &RationalInterpolant, settings: &PeakSearch, rising: Option<bool>) -> bool {
        self.root(of);
        self.about.clear();
        self.look_about_roots();
        for _ in 0..DIP.1 {
            self.look_there(of, settings);
            if !self.walk(rising) {
                return false;
            }
            if self.asked.is_empty() {
                break;
            }
        }
        true
    }

    /// Refines roots from where they are foretold; keeps each once, in rising order, and those on the piece alone.
    fn root(&mut self, of: &RationalInterpolant) {
        let places = &self.grid.places;
        let roots = &mut self.roots;
        for some in roots.chunks_mut(LANES) {
            let each =
                |what: fn(&Root) -> f64| Reals::from(std::array::from_fn::<_, LANES, _>(|lane| what(&some[lane.min(some.len() - 1)])));
            let poles = each(|root| f64::from(u8::from(root.pole))).simd_gt(Reals::ZERO);
            let mut z = Complexes::new(each(|root| root.re), each(|root| root.reach));
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
                    // Between two roots on either side of the band Newton's rule never leaves it.
                    z = Complexes::new(settled.select(z.re, start.re), settled.select(z.im, Reals::splat(ASIDE)));
                }
            }
            let (re, im) = (z.re.to_array(), z.im.to_array());
            for (at, root) in some.iter_mut().enumerate() {
                (root.re, root.reach) = (re[at], im[at]);
            }
        }
        roots.retain(|root| root.re >= -1.0 && root.re <= 1.0);
        roots.sort_unstable_by(|a, b| a.re.total_cmp(&b.re));
        let mut kept = 0;
        for at in 0..roots.len() {
            let root = roots[at];
            let same = |other: &Root| {
                let square = (root.re - other.re).powi(2) + (root.reach - other.reach).powi(2);
                root.pole == other.pole && square <= (0.3 * root.reach).powi(2).max(1e-18)
            };
            if !roots[..kept].iter().rev().take(3).any(same) {
                let after = places.partition_point(|t| *t <= root.re).clamp(1, GRID - 1) - 1;
                roots[kept] = Root { after, ..root };
                kept += 1;
            }
        }
        roots.truncate(kept);
    }

    /// Asks for looks about all roots.
    fn look_about_roots(&mut self) {
        let ExtremumSearch { roots, asked, .. } = self;
        asked.clear();
        for root in roots.iter() {
            let reach = root.reach.abs().max(LEAST_REACH);
            asked.extend(SIDES.iter().map(|side| root.re + side * reach).filter(|t| t.abs() < 1.0));
        }
    }

    /// Looks where that is asked for.
    fn look_there(&mut self, of: &RationalInterpolant, settings: &PeakSearch) {
        let ExtremumSearch { asked, about, .. } = self;
        for some in asked.chunks(LANES) {
            let t = filled(some);
            let found = of.slopes(t);
            let (rise, re, im) = (rise_of(of, settings, t, &found).to_array(), found.1[0].re.to_array(), found.1[0].im.to_array());
            about.extend(some.iter().enumerate().map(|(lane, t)| Evaluation {
                t: *t,
                rise: rise[lane],
                denominator: (re[lane], im[lane]),
            }));
        }
        about.sort_unstable_by(|a, b| a.t.total_cmp(&b.t));
    }

    /// Walks over all looks in rising order, and asks for those that are missing; whether neighbours are near enough.
    fn walk(&mut self, rising: Option<bool>) -> bool {
        let changes = self.changes();
        let mut way = Scan { near: true, asked: std::mem::take(&mut self.asked), brackets: std::mem::take(&mut self.brackets) };
        way.asked.clear();
        way.brackets.clear();
        let first = self.look(0);
        if rising.is_some_and(|rising| rising != (first.rise > 0.0)) {
            let at = (first.t, first.rise);
            way.brackets.push(ExtremumBracket { low: at, high: at, top: first.rise <= 0.0 });
        }
        let mut about = self.about.iter().peekable();
        let (mut last, mut crowded, mut left_out) = ([first; 2], false, false);
        for at in 1..GRID {
            let t = self.grid.places[at];
            let here_too = about.peek().is_some_and(|here| here.t < t);
            // Where no root is near, neighbours on the grid have been compared all at once.
            if !here_too && !crowded && changes >> (at - 1) & 1 == 0 {
                left_out = true;
                continue;
            }
            if left_out {
                last = [self.look(at.saturating_sub(2)), self.look(at - 1)];
            }
            while let Some(here) = about.next_if(|here| here.t < t) {
                last = way.step(last, *here);
            }
            last = way.step(last, self.look(at));
            (crowded, left_out) = (here_too, false);
        }
        (self.asked, self.brackets) = (way.asked, way.brackets);
        way.near
    }

    /// Places of the grid, as bits, after which there is something to be done: up to the next G changes its sign or the phase of Δ turns far, or |G| is
    /// less there than on both sides.
    fn changes(&self) -> u32 {
        let ExtremumSearch { rise, denominator: [re, im], .. } = self;
        let four = |of: &[f64; GRID], from: usize| Reals::from(std::array::from_fn::<_, LANES, _>(|lane| of[from + lane]));
        let after = |from: usize| {
            let [a, b] = [from, from + 1].map(|at| (four(rise, at), Complexes::new(four(re, at), four(im, at))));
            let signs = a.0.simd_gt(Reals::ZERO) ^ b.0.simd_gt(Reals::ZERO);
            let before = Reals::from(std::array::from_fn::<_, LANES, _>(|lane| rise[(from + lane).saturating_sub(1)]));
            let low = a.0.abs().simd_lt(b.0.abs()) & a.0.abs().simd_lt(before.abs());
            (signs | low | far(a.1, b.1)).to_bitmask()
        };
        (0..GRID - 1).step_by(LANES).map(|from| from.min(GRID - 1 - LANES)).fold(0, |bits, from| bits | after(from) << from)
    }

    /// Finds where the sought quantity turns in all brackets of a piece.
    pub fn turns(&self, of: &RationalInterpolant, settings: &PeakSearch, turns: &mut Vec<Extremum>) {
        let power = f64::from(settings.omega_power);
        let (half, middle) = (Reals::splat(of.half), Reals::splat(of.middle));
        let steady = Reals::splat(2.0 * power * of.half);
        for at in (0..self.brackets.len()).step_by(LANES) {
            let some = &self.brackets[at..self.brackets.len().min(at + LANES)];
            let each = |what: &dyn Fn(&ExtremumBracket) -> f64| {
                Reals::from(std::array::from_fn::<_, LANES, _>(|lane| what(&some[lane.min(some.len() - 1)])))
            };
            let (mut low, mut high) = (each(&|b| b.low.0), each(&|b| b.high.0));
            let precision = each(&|b| if b.top { settings.precision } else { OF_VALLEYS });
            let up = each(&|b| b.low.1).simd_gt(Reals::ZERO);
            let width = high - low;
            let mut t =
                each(&|b| if b.high.0 > b.low.0 { (b.low.0 * b.high.1 - b.high.0 * b.low.1) / (b.high.1 - b.low.1) } else { b.low.0 });
            let (mut n2, mut d2);
            let (place, bend, mut growth, mut omega);
            let mut rounds = 0;
            loop {
                let (n, d) = of.jets(t);
                (n2, d2) = (square(n), square(d));
                omega = t.mul_add(half, middle);
                let twist = n2[1] * d2[0] - n2[0] * d2[1];
                let rise = twist.mul_add(omega, steady * n2[0] * d2[0]);
                let rise_slope = (n2[2] * d2[0] - n2[0] * d2[2]).mul_add(omega, twist * half + steady * (n2[1] * d2[0] + n2[0] * d2[1]));
                let above = rise.simd_gt(Reals::ZERO) ^ up;
                high = above.select(t, high);
                low = above.select(low, t);
                let next = t - rise / rise_slope;
                let inside = next.simd_ge(low) & next.simd_le(high);
                let next = inside.select(next, (low + high) * Reals::splat(0.5));
                let step = next - t;
                let (reach, wanted) = (step.abs() * half, precision * omega);
                // What is left after a step is its square, in units of where it was looked for.
                let settled = reach.simd_le(wanted) | (step * step * half).simd_le(wanted * width);
                let per_2 = Reals::ONE / (n2[0] * d2[0] * omega * Reals::splat(2.0));
                growth = rise * per_2 * step * Reals::splat(0.5);
                let kept = growth.abs().simd_le(Reals::splat(LITTLE)) | reach.simd_le(Reals::splat(1e-14) * omega);
                rounds += 1;
                if (settled & kept).all() || rounds == 60 {
                    bend = rise_slope * per_2;
                    place = next;
                    break;
                }
                t = next;
            }
            let curvature = (bend / (half * half)).to_array();
            let (t, growth) = (place.to_array(), growth.to_array());
            let (n2, d2, omega) = (n2[0].to_array(), d2[0].to_array(), omega.to_array());
            for (lane, top) in some.iter().map(|b| b.top).enumerate() {
                let omega_rad_s = of.omega_rad_s(t[lane]);
                let size = (n2[lane] / d2[lane]).sqrt() * (1.0 + growth[lane]) * omega[lane].powi(settings.omega_power);
                let doubt = of.doubt[0] / n2[lane].sqrt() + of.doubt[1] / d2[lane].sqrt();
                let doubt = doubt / (curvature[lane].abs() * omega_rad_s * of.half).min(1.0);
                turns.push(Extremum { omega_rad_s, size, curvature: curvature[lane], doubt, top });
            }
        }
    }
}

/// G over a piece.
#[inline(always)]
fn rise_of(of: &RationalInterpolant, settings: &PeakSearch, t: Reals, (n, d): &([Complexes; 2], [Complexes; 2])) -> Reals {
    let (n2, d2) = (n[0].norm_sqr(), d[0].norm_sqr());
    let omega = t.mul_add(Reals::splat(of.half), Reals::splat(of.middle));
    let steady = Reals::splat(of.half * f64::from(settings.omega_power)) * n2 * d2;
    (n[0].dot(n[1]) * d2 - n2 * d[0].dot(d[1])).mul_add(omega, steady)
}

/// What is found on the way over all looks.
struct Scan {
    /// Whether neighbours are near enough.
    near: bool,
    /// Where another look is worth it.
    asked: Vec<f64>,
    brackets: Vec<ExtremumBracket>,
}

impl Scan {
    /// From the last two looks to the next: what turns there is noted.
    fn step(&mut self, [before, last]: [Evaluation; 2], here: Evaluation) -> [Evaluation; 2] {
        if (last.rise > 0.0) != (here.rise > 0.0) {
            self.brackets.push(ExtremumBracket { low: (last.t, last.rise), high: (here.t, here.rise), top: last.rise > 0.0 });
        }
        let (a, b) = (last.denominator, here.denominator);
        let along = a.0 * b.0 + a.1 * b.1;
        self.near &= along >= 0.0 || along * along <= COS_TURN * COS_TURN * (a.0 * a.0 + a.1 * a.1) * (b.0 * b.0 + b.1 * b.1);
        self.asked.extend(dip(before, last, here));
        [last, here]
    }
}

/// Where the parabola through three looks of one sign, of which the middle one is the least, comes near the other sign.
fn dip(before: Evaluation, last: Evaluation, here: Evaluation) -> Option<f64> {
    let [a, b, c] = [before, last, here].map(|look| look.rise * last.rise.signum());
    if !(b < a && b < c && b > 0.0) {
        return None;
    }
    let (falls, rises) = ((b - a) / (last.t - before.t), (c - b) / (here.t - last.t));
    let bend = (rises - falls) / (here.t - before.t);
    let slope = falls + bend * (last.t - before.t);
    (slope * slope > 4.0 * (1.0 - DIP.0) * b * bend).then_some(last.t - 0.5 * slope / bend)
}

/// Where the phase turns far, as in [`Way::step`].
fn far(a: Complexes, b: Complexes) -> Reals {
    let along = a.dot(b);
    along.simd_lt(Reals::ZERO) & (along * along).simd_gt(Reals::splat(COS_TURN * COS_TURN) * a.norm_sqr() * b.norm_sqr())
}
