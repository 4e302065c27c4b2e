//! Peaks of the damped |H|, found on their own: damping moves and removes them.
//!
//! Over a piece of the band H is a quotient of polynomials N/Δ; a piece is halved until these err little beside what they are anywhere on it. The
//! log-slope of |H|·ω^p then has the sign of a polynomial without sharp turns,
//!
//! ```text
//! G = (|N|²)′·|Δ|² − |N|²·(|Δ|²)′ + 2p/ω·|N|²·|Δ|²
//! ```
//!
//! which is looked at on a grid and about every root of N and of Δ near the band, where a ripple may hide that is as narrow as the root is near, and where the
//! parabola through three looks of one sign comes near the other. Every maximum lies where G changes its sign; Newton's rule finds it. Two counts guard the
//! roots: on a piece as many poles must be seen as there are undamped natural frequencies (Wittrick–Williams), or at most one of these between neighbours on
//! the grid; and the phase of Δ, which turns by π at every lightly damped mode whether the response sees it or not, may not turn by more than 2.2 rad from one
//! look to the next. A maximum that the polynomials do not give as exactly as asked is looked at in the receptance itself, until it stays.
//!
//! What may be missed is a ripple, mostly in the bottom of a valley. On 16,000 random benches (8,000 of them with a thousandth of the damping; receptance,
//! mobility and accelerance of table and rotor over table; 5–1,000 Hz) a search that halved intervals until a rational function foretold H found 400,598 maxima
//! that stand out by 0.05 %. 87 of them are not found: 78 stand out by less than 1 %, two by 1 to 2 %, and seven lie more than six decades below the highest.

use super::assembled_model::AssembledModel;
use super::extremum_search::LITTLE;
use super::frequency_grid::FrequencyGrid;
use super::peak_search::{PIECES, PeakSearch};
use super::rational_interpolant::{GROUPS, RationalInterpolant, nodes};
use super::simd::{ABREAST, LANES, Reals, filled};
use super::workspace::{Piece, Room, Workspace};
use numeric::unit::frequency_hz;

/// How often a piece is halved at most.
const DEEPEST: u32 = 12;
/// How far from a peak, relative to its frequency, it may be foretold.
const BESIDE: f64 = 1e-4;
/// What stands out by less is rounding.
const FAINT: f64 = 1e-6;

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

struct Search<'a> {
    network: &'a AssembledModel,
    work: &'a mut Workspace,
    settings: PeakSearch,
    lines: &'a FrequencyGrid,
    room: &'a mut Room,
    /// Whether the sought quantity rises at the end of what is done.
    rising: Option<bool>,
}

impl Search<'_> {
    /// |H|·ω^p at an end of a piece.
    fn size(&self, of: &RationalInterpolant, t: f64) -> f64 {
        let (n, d) = of.slopes(Reals::splat(t));
        (n[0].norm_sqr() / d[0].norm_sqr()).to_array()[0].sqrt() * of.omega_rad_s(t).powi(self.settings.omega_power)
    }

    /// Whether so many poles are seen as undamped natural frequencies lie on the piece, or these are apart.
    fn accounted(&mut self, piece: &Piece, of: &RationalInterpolant) -> bool {
        let Room { omegas, below, sight, .. } = &mut *self.room;
        if sight.poles() + piece.below.0 >= piece.below.1 || piece.below.1 <= piece.below.0 + 1 {
            return true;
        }
        omegas.clear();
        omegas.extend(sight.grid_rad_s(of));
        self.network.modes_below_each(omegas, self.work, below);
        let ends = below[1..].iter().chain([&piece.below.1]);
        below.iter().zip(ends).enumerate().all(|(at, (low, high))| *high <= low + 1 || low + sight.poles_after(at) >= *high)
    }

    /// Looks at a piece; whether it is done, and otherwise has to be halved.
    fn see(&mut self, piece: &Piece, of: &RationalInterpolant) -> bool {
        // What is no number does not become one by halving.
        let last = piece.halved == DEEPEST || of.doubt.iter().any(|doubt| doubt.is_nan());
        if !self.room.sight.survey(of, &self.settings) && !last {
            return false;
        }
        let near = self.room.sight.look_closer(of, &self.settings, self.rising);
        let done = near && self.accounted(piece, of);
        if !done && !last {
            return false;
        }
        self.room.sight.turns(of, &self.settings, &mut self.room.turns);
        self.rising = Some(self.room.sight.rises());
        true
    }

    /// The pieces of the band, and what is known of them.
    fn cut(&mut self) {
        let cuts = self.settings.cuts();
        let Room { below, pieces, first, .. } = &mut *self.room;
        self.network.modes_below_each(&cuts[1..], self.work, below);
        pieces.clear();
        pieces.extend((0..PIECES).rev().map(|at| Piece {
            from: cuts[at],
            to: cuts[at + 1],
            // Below the band there may be some, too; that they are none is the least.
            below: (if at == 0 { 0 } else { below[at - 1] }, below[at]),
            halved: 0,
            first: at,
        }));
        first.clear();
        let groups = PIECES * GROUPS;
        for from in (0..groups).step_by(ABREAST) {
            let some = from..groups.min(from + ABREAST);
            let omegas = &self.lines.omega_rad_s()[some.clone()];
            let found = self.network.fractions(omegas, |at, rod| self.lines.known(at, rod, some.clone()), self.work);
            for found in found[..some.len()].chunks_exact(GROUPS) {
                let at = first.len();
                first.push(RationalInterpolant::through((cuts[at], cuts[at + 1]), found));
            }
        }
    }

    /// The receptance over a piece that was halved.
    fn halved(&mut self, ends: (f64, f64)) -> RationalInterpolant {
        let nodes = nodes(ends);
        let omegas: [Reals; GROUPS] = std::array::from_fn(|w| filled(&nodes[w * LANES..][..LANES]));
        RationalInterpolant::through(ends, &self.network.fractions(&omegas, |_, _| None, self.work)[..GROUPS])
    }

    /// Maxima are looked at in the receptance itself, until they stay.
    fn settle(&mut self) {
        let power = self.settings.omega_power;
        let Room { omegas, points, turns, open, .. } = &mut *self.room;
        open.clear();
        let precision = self.settings.precision;
        open.extend(turns.iter().enumerate().filter(|(_, turn)| turn.top && !(turn.doubt <= precision)).map(|(at, _)| at));
        for _ in 0..8 {
            if open.is_empty() {
                break;
            }
            omegas.clear();
            omegas.extend(open.iter().map(|at| turns[*at].omega_rad_s));
            self.network.at_each(omegas, self.work, points);
            let mut points = points.iter();
            open.retain(|at| {
                let (turn, Some(point)) = (&mut turns[*at], points.next()) else { return false };
                let change = point.slope / point.receptance + f64::from(power) / point.omega_rad_s;
                // Beside a peak that is sharper than foretold frequencies are sure its pole alone counts: |d ln H/dω| is one over the distance from it.
                let beside = change.im.abs() < change.re.abs() && change.norm_sqr().sqrt() * BESIDE * point.omega_rad_s > 1.0;
                let step = change.re / if beside { change.norm_sqr() } else { turn.curvature.abs() };
                turn.omega_rad_s = point.omega_rad_s + step;
                turn.size = point.receptance.norm_sqr().sqrt() * point.omega_rad_s.powi(power) * (0.5 * change.re * step).exp();
                step.abs() > precision * point.omega_rad_s || (change.re * step).abs() > LITTLE
            });
        }
    }

    /// All peaks, in rising frequency.
    fn peaks(&mut self, found: &mut Vec<Peak>) {
        found.clear();
        self.room.turns.clear();
        self.cut();
        let first = std::mem::take(&mut self.room.first);
        while let Some(piece) = self.room.pieces.pop() {
            let half;
            let of = match piece.halved {
                0 => &first[piece.first],
                _ => {
                    half = self.halved((piece.from, piece.to));
                    &half
                }
            };
            if !self.see(&piece, of) {
                let middle = 0.5 * (piece.from + piece.to);
                let below = if piece.below.0 == piece.below.1 { piece.below.0 } else { self.network.modes_below(middle, self.work) };
                let halved = piece.halved + 1;
                self.room.pieces.push(Piece { from: middle, below: (below, piece.below.1), halved, ..piece });
                self.room.pieces.push(Piece { to: middle, below: (piece.below.0, below), halved, ..piece });
            }
        }
        let [low, high] = [(&first[0], -1.0), (&first[PIECES - 1], 1.0)].map(|(of, end)| self.size(of, end));
        self.room.first = first;
        self.settle();
        let mut valley = low;
        for turn in &self.room.turns {
            if turn.top {
                let peak = Peak { frequency_hz: frequency_hz(turn.omega_rad_s), amplitude: turn.size, prominence: turn.size / valley };
                found.push(peak);
                valley = f64::INFINITY;
            } else {
                valley = valley.min(turn.size);
                beside(found, valley);
            }
        }
        beside(found, valley.min(high));
        found.retain(|peak| peak.prominence > 1.0 + FAINT);
    }
}

/// The last peak stands out of a valley above it, too.
fn beside(found: &mut [Peak], valley: f64) {
    if let Some(peak) = found.last_mut() {
        peak.prominence = peak.prominence.min(peak.amplitude / valley);
    }
}

/// All peaks of |H|·ω^p inside a band, in rising frequency.
pub fn peaks(network: &AssembledModel, settings: PeakSearch, work: &mut Workspace) -> Vec<Peak> {
    let mut found = Vec::new();
    peaks_into(network, (settings, &settings.lines()), work, &mut found);
    found
}

/// As [`peaks`], into a list, with [`PeakSearch::lines`], which may know rods; once workspace and list have room, nothing is allocated.
pub fn peaks_into(network: &AssembledModel, (settings, lines): (PeakSearch, &FrequencyGrid), work: &mut Workspace, found: &mut Vec<Peak>) {
    let mut room = work.peaks.take().unwrap_or_default();
    let mut search = Search { network, work, settings, lines, room: &mut room, rising: None };
    search.peaks(found);
    work.peaks = Some(room);
}
