//! Peaks of the damped |H|. They are searched directly, since damping moves and removes peaks.
//!
//! Over a piece of the band H is a quotient of polynomials N/Δ. A piece is halved until the errors of both
//! are small relative to their magnitude anywhere on it. The log-slope of |H|·ω^p then has the sign of a
//! smooth polynomial,
//!
//! ```text
//! G = (|N|²)′·|Δ|² − |N|²·(|Δ|²)′ + 2p/ω·|N|²·|Δ|²
//! ```
//!
//! G is evaluated on a grid, and around every root of N and Δ near the band: a root close to the band causes
//! a narrow ripple. It is also evaluated where the parabola through three values of one sign comes near zero.
//! Every maximum lies at a sign change of G, which Newton's method refines.
//!
//! Two checks guard against missed roots. The number of poles on a piece must reach the number of undamped
//! natural frequencies (Wittrick–Williams), unless each grid cell holds at most one of these. And the phase
//! of Δ may advance by at most 2.2 rad between evaluations: it advances by π at every lightly damped mode,
//! even if the response does not show the mode. A maximum that the polynomials do not give to the requested
//! precision is iterated on the receptance itself until it converges.
//!
//! The search can miss a ripple, mostly at the bottom of a valley. The reference is a search on 16,000 random
//! benches that halves intervals until a rational function predicts H. Of these benches 8,000 have a
//! thousandth of the damping; the responses are receptance, mobility and accelerance of table and of rotor
//! over table, 5–1,000 Hz. The reference finds 400,598 maxima with a prominence of at least 0.05 %. This
//! search misses 87 of them: 78 with a prominence below 1 %, two of 1 to 2 %, and seven more than six decades
//! below the highest maximum.

use super::assembled_model::AssembledModel;
use super::extremum_search::SMALL_CHANGE;
use super::frequency_grid::FrequencyGrid;
use super::peak_search::{PIECES, PeakSearch};
use super::rational_interpolant::{GROUPS, RationalInterpolant, nodes};
use super::simd::{ABREAST, LANES, Reals, padded};
use super::workspace::{PeakWorkspace, Piece, Workspace};
use numeric::unit::frequency_hz;

/// Largest number of halvings of a piece.
const MAX_HALVINGS: u32 = 12;
/// Largest error of the predicted peak frequency, relative to it.
const PREDICTION_ERROR: f64 = 1e-4;
/// Smallest prominence above 1; less is rounding.
const MIN_EXCESS: f64 = 1e-6;

/// A maximum of |H| over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// |H| at the peak.
    pub amplitude: f64,
    /// |H| at the peak over the larger of the two neighbouring minima (or ends of the band).
    pub prominence: f64,
    /// Frequency (Hz) of that minimum or end of the band.
    pub valley_hz: f64,
}

struct Search<'a> {
    model: &'a AssembledModel,
    work: &'a mut Workspace,
    settings: PeakSearch,
    lines: &'a FrequencyGrid,
    space: &'a mut PeakWorkspace,
    /// Whether |H|·ω^p rises at the upper end of the processed part of the band.
    rising: Option<bool>,
}

impl Search<'_> {
    /// Computes |H|·ω^p at an end of a piece.
    fn size(&self, of: &RationalInterpolant, t: f64) -> f64 {
        let (n, d) = of.slopes(Reals::splat(t));
        (n[0].norm_sqr() / d[0].norm_sqr()).to_array()[0].sqrt()
            * of.omega_rad_s(t).powi(self.settings.omega_power)
    }

    /// Whether the piece shows as many poles as undamped natural frequencies, or each grid cell with too few
    /// poles holds at most one natural frequency.
    fn has_all_poles(&mut self, piece: &Piece, of: &RationalInterpolant) -> bool {
        let PeakWorkspace { omegas, below, search, .. } = &mut *self.space;
        if search.pole_count() + piece.below.0 >= piece.below.1 || piece.below.1 <= piece.below.0 + 1 {
            return true;
        }
        omegas.clear();
        omegas.extend(search.grid_rad_s(of));
        self.model.modes_below_each(omegas, self.work, below);
        let ends = below[1..].iter().chain([&piece.below.1]);
        below
            .iter()
            .zip(ends)
            .enumerate()
            .all(|(at, (low, high))| *high <= low + 1 || low + search.poles_in_cell(at) >= *high)
    }

    /// Searches a piece. Returns whether it is done; otherwise it must be halved.
    fn search_piece(&mut self, piece: &Piece, of: &RationalInterpolant) -> bool {
        // Halving does not remove NaN.
        let last = piece.halved == MAX_HALVINGS || of.error.iter().any(|error| error.is_nan());
        if !self.space.search.evaluate_grid(of, &self.settings) && !last {
            return false;
        }
        let fine = self.space.search.bracket_extrema(of, &self.settings, self.rising);
        let done = fine && self.has_all_poles(piece, of);
        if !done && !last {
            return false;
        }
        self.space.search.extrema(of, &self.settings, &mut self.space.extrema);
        self.rising = Some(self.space.search.rises_at_end());
        true
    }

    /// Divides the band into pieces and computes the mode counts and interpolants.
    fn set_up_pieces(&mut self) {
        let cuts = self.settings.cuts();
        let PeakWorkspace { below, pieces, first, .. } = &mut *self.space;
        self.model.modes_below_each(&cuts[1..], self.work, below);
        pieces.clear();
        pieces.extend((0..PIECES).rev().map(|at| Piece {
            from: cuts[at],
            to: cuts[at + 1],
            // There may be modes below the band; 0 is a lower bound of their number.
            below: (if at == 0 { 0 } else { below[at - 1] }, below[at]),
            halved: 0,
            first: at,
        }));
        first.clear();
        let groups = PIECES * GROUPS;
        for from in (0..groups).step_by(ABREAST) {
            let some = from..groups.min(from + ABREAST);
            let omegas = &self.lines.omega_rad_s()[some.clone()];
            let found = self.model.numerators_and_denominators(
                omegas,
                |at, rod| self.lines.known(at, rod, some.clone()),
                self.work,
            );
            for found in found[..some.len()].chunks_exact(GROUPS) {
                let at = first.len();
                first.push(RationalInterpolant::through((cuts[at], cuts[at + 1]), found));
            }
        }
    }

    /// Computes the interpolant over a halved piece.
    fn interpolant_over(&mut self, ends: (f64, f64)) -> RationalInterpolant {
        let nodes = nodes(ends);
        let omegas: [Reals; GROUPS] = std::array::from_fn(|w| padded(&nodes[w * LANES..][..LANES]));
        RationalInterpolant::through(
            ends,
            &self.model.numerators_and_denominators(&omegas, |_, _| None, self.work)[..GROUPS],
        )
    }

    /// Iterates maxima on the receptance itself until they converge.
    fn refine_maxima(&mut self) {
        let power = self.settings.omega_power;
        let PeakWorkspace { omegas, points, extrema, unsettled, .. } = &mut *self.space;
        unsettled.clear();
        let precision = self.settings.precision;
        unsettled.extend(
            extrema
                .iter()
                .enumerate()
                .filter(|(_, extremum)| extremum.is_maximum && !(extremum.error <= precision))
                .map(|(at, _)| at),
        );
        for _ in 0..8 {
            if unsettled.is_empty() {
                break;
            }
            omegas.clear();
            omegas.extend(unsettled.iter().map(|at| extrema[*at].omega_rad_s));
            self.model.at_each(omegas, self.work, points);
            let mut points = points.iter();
            unsettled.retain(|at| {
                let (extremum, Some(point)) = (&mut extrema[*at], points.next()) else { return false };
                let change = point.slope / point.receptance + f64::from(power) / point.omega_rad_s;
                // Next to a peak narrower than the error of the predicted frequency only its pole matters: |d
                // ln H/dω| is the reciprocal distance to the pole.
                let near_pole = change.im.abs() < change.re.abs()
                    && change.norm_sqr().sqrt() * PREDICTION_ERROR * point.omega_rad_s > 1.0;
                let step = change.re / if near_pole { change.norm_sqr() } else { extremum.curvature.abs() };
                // On the pole of an undamped mode there is no closer place.
                if !step.is_finite() {
                    return false;
                }
                extremum.omega_rad_s = point.omega_rad_s + step;
                extremum.size = point.receptance.norm_sqr().sqrt()
                    * point.omega_rad_s.powi(power)
                    * (0.5 * change.re * step).exp();
                step.abs() > precision * point.omega_rad_s || (change.re * step).abs() > SMALL_CHANGE
            });
        }
    }

    /// Finds all peaks, in rising frequency.
    fn peaks(&mut self, found: &mut Vec<Peak>) {
        found.clear();
        self.space.extrema.clear();
        self.set_up_pieces();
        let first = std::mem::take(&mut self.space.first);
        while let Some(piece) = self.space.pieces.pop() {
            let half;
            let of = match piece.halved {
                0 => &first[piece.first],
                _ => {
                    half = self.interpolant_over((piece.from, piece.to));
                    &half
                }
            };
            if !self.search_piece(&piece, of) {
                let middle = 0.5 * (piece.from + piece.to);
                let below = if piece.below.0 == piece.below.1 {
                    piece.below.0
                } else {
                    self.model.modes_below(middle, self.work)
                };
                let halved = piece.halved + 1;
                self.space.pieces.push(Piece {
                    from: middle,
                    below: (below, piece.below.1),
                    halved,
                    ..piece
                });
                self.space.pieces.push(Piece { to: middle, below: (piece.below.0, below), halved, ..piece });
            }
        }
        let [low, high] = [(&first[0], -1.0), (&first[PIECES - 1], 1.0)].map(|(of, end)| Valley {
            size: self.size(of, end),
            frequency_hz: frequency_hz(of.omega_rad_s(end)),
        });
        self.space.first = first;
        self.refine_maxima();
        let mut valley = low;
        for extremum in &self.space.extrema {
            if extremum.is_maximum {
                found.push(Peak {
                    frequency_hz: frequency_hz(extremum.omega_rad_s),
                    amplitude: extremum.size,
                    prominence: extremum.size / valley.size,
                    valley_hz: valley.frequency_hz,
                });
                valley = Valley::NONE;
            } else {
                valley = valley
                    .lower(Valley { size: extremum.size, frequency_hz: frequency_hz(extremum.omega_rad_s) });
                limit_prominence(found, valley);
            }
        }
        limit_prominence(found, valley.lower(high));
        found.retain(|peak| peak.prominence > 1.0 + MIN_EXCESS);
    }
}

/// A minimum of |H|·ω^p, or an end of the band.
#[derive(Debug, Clone, Copy)]
struct Valley {
    size: f64,
    frequency_hz: f64,
}

impl Valley {
    const NONE: Self = Valley { size: f64::INFINITY, frequency_hz: f64::NAN };

    /// Returns the lower of two.
    fn lower(self, other: Self) -> Self {
        if other.size < self.size { other } else { self }
    }
}

/// Limits the prominence of the last peak by the valley above it.
fn limit_prominence(found: &mut [Peak], valley: Valley) {
    if let Some(peak) = found.last_mut()
        && peak.amplitude / valley.size < peak.prominence
    {
        (peak.prominence, peak.valley_hz) = (peak.amplitude / valley.size, valley.frequency_hz);
    }
}

/// Finds all peaks of |H|·ω^p inside a band, in rising frequency.
pub fn peaks(model: &AssembledModel, settings: PeakSearch, work: &mut Workspace) -> Vec<Peak> {
    let mut found = Vec::new();
    peaks_into(model, (settings, &settings.start_grid()), work, &mut found);
    found
}

/// Finds peaks as [`peaks`] does, into a list, on the grid of [`PeakSearch::start_grid`], which may have
/// cached rods. Allocates nothing once workspace and list have their capacity.
pub fn peaks_into(
    model: &AssembledModel,
    (settings, lines): (PeakSearch, &FrequencyGrid),
    work: &mut Workspace,
    found: &mut Vec<Peak>,
) {
    let mut space = work.peaks.take().unwrap_or_default();
    let mut search = Search { model, work, settings, lines, space: &mut space, rising: None };
    search.peaks(found);
    work.peaks = Some(space);
}
