//! Modes whose order does not fit their course over the positions.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use numeric::statistics::log_sum_exp;

use super::{MeasurementSet, ModeObservation, ModeTable};

/// A mode that fits another order than its own, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MisplacedMode {
    /// Index of the position.
    pub position: usize,
    /// Order under which it is entered.
    pub order: u32,
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Order whose course over the other positions it continues; `None` for a mode that continues none.
    pub fits: Option<u32>,
}

/// Standard deviations of ln(frequency) of a mode along the stroke (1), equally probable: from a mode that
/// the nut position hardly changes to one of the screw, which it changes by half.
const VARIATION: [f64; 5] = [0.01, 0.03, 0.1, 0.2, 0.4];
/// Correlation length of a mode's frequency along the stroke, as a share of the stroke (1): one arch or half
/// a wave.
const LENGTH: f64 = 0.5;
/// Standard deviation of ln(frequency) by reading and by curves with a kink, where two modes come close (1).
const READING: f64 = 0.01;
/// Standard deviation of ln(frequency) of an order that no other position shows (1): a factor of ten.
const UNKNOWN: f64 = 2.3;
/// ln of the probability that a mode in a table is none, a harmonic or a local one.
const SPURIOUS: f64 = -4.6;
/// ln of the odds at which a position is named. A table has a wrong order at one of a hundred positions, and
/// one of ten that are named may be sound.
const LEAST_ODDS: f64 = 7.0;

/// Finds modes under a wrong order: those that continue the course of another order over the nut positions
/// better than that of their own.
///
/// The course of an order is a smooth random function of the nut position. Each position in turn gets the
/// orders at which its modes are most probable, given those of the others, with frequencies rising with the
/// order. The position with the best reason to be renumbered is, and the search goes on with its new orders,
/// until no position has odds above 1000 : 1. A wrong order therefore does not accuse the sound positions.
///
/// # Source  Gaussian process with a squared exponential covariance: Rasmussen and Williams (2006), chapter
///   2; the variation along the stroke is
/// averaged by its marginal likelihood. Alignment by dynamic programming.
pub fn misplaced_modes(set: &MeasurementSet) -> Vec<MisplacedMode> {
    let Some(table) = &set.modes else { return Vec::new() };
    let located: Vec<(usize, f64)> =
        set.positions.iter().enumerate().filter_map(|(at, p)| Some((at, p.nut_m?))).collect();
    let stroke = |end: fn(f64, f64) -> f64| located.iter().map(|(_, x)| *x).reduce(end).unwrap_or(0.0);
    let length_m = (LENGTH * (stroke(f64::max) - stroke(f64::min))).max(f64::MIN_POSITIVE);
    let mut positions: Vec<Labelled> =
        located.iter().map(|(at, nut_m)| Labelled::new(*at, *nut_m, table)).collect();
    for _ in 0..positions.len() {
        let proposal = |at: usize| {
            let (best, odds) = positions[at].renumbered(&positions, length_m);
            (at, best, odds)
        };
        let Some((at, best, odds)) = (0..positions.len()).map(proposal).max_by(|a, b| a.2.total_cmp(&b.2))
        else {
            break;
        };
        if !(odds > LEAST_ODDS) {
            break;
        }
        positions[at].orders = best;
    }
    let misplaced = |p: &Labelled| {
        let stated = table.positions[p.position].iter().filter(|m| m.frequency_hz.is_some()).map(|m| m.order);
        let moved = stated.zip(&p.orders).zip(&p.logs).filter(|((stated, fits), _)| Some(*stated) != **fits);
        let of = |((order, fits), log): ((u32, &Option<u32>), &f64)| MisplacedMode {
            position: p.position,
            order,
            frequency_hz: log.exp(),
            fits: *fits,
        };
        moved.map(of).collect::<Vec<MisplacedMode>>()
    };
    positions.iter().flat_map(misplaced).collect()
}

/// Returns the set with misplaced modes under the orders they fit, and without those that fit none. An order
/// that a mode leaves is not stated.
#[must_use]
pub fn with_fitting_orders(set: &MeasurementSet, misplaced: &[MisplacedMode]) -> MeasurementSet {
    let mut set = set.clone();
    for (position, modes) in set.modes.iter_mut().flat_map(|table| &mut table.positions).enumerate() {
        let of = |order: u32| misplaced.iter().find(|m| m.position == position && m.order == order);
        let moved: Vec<ModeObservation> = modes
            .iter()
            .filter_map(|mode| match of(mode.order).filter(|_| mode.frequency_hz.is_some()) {
                Some(wrong) => wrong.fits.map(|order| ModeObservation { order, ..*mode }),
                None => Some(*mode),
            })
            .collect();
        let taken = |order: u32| moved.iter().any(|m| m.order == order && m.frequency_hz.is_some());
        *modes = moved.iter().filter(|m| m.frequency_hz.is_some() || !taken(m.order)).copied().collect();
        modes.sort_by_key(|m| m.order);
    }
    set
}

/// The observed modes of a position with their present orders.
struct Labelled {
    position: usize,
    nut_m: f64,
    /// ln(frequency), rising.
    logs: Vec<f64>,
    /// Variance of each by reading and rounding.
    variances: Vec<f64>,
    /// Order of each; `None` for a mode that is taken for none.
    orders: Vec<Option<u32>>,
}

impl Labelled {
    fn new(position: usize, nut_m: f64, table: &ModeTable) -> Self {
        let seen = || table.positions[position].iter().filter_map(|m| Some((m, m.frequency_hz?)));
        Labelled {
            position,
            nut_m,
            logs: seen().map(|(_, frequency_hz)| frequency_hz.ln()).collect(),
            variances: seen()
                .map(|(mode, _)| READING.powi(2) + mode.frequency_scatter(table.resolution_hz).powi(2))
                .collect(),
            orders: seen().map(|(mode, _)| Some(mode.order)).collect(),
        }
    }

    /// Returns a mode as a point of a course.
    fn point(&self, at: usize) -> CoursePoint {
        CoursePoint { nut_m: self.nut_m, log: self.logs[at], variance: self.variances[at] }
    }

    /// Returns the most probable orders of its modes given those of the other positions, and ln of their odds
    /// against the present ones.
    fn renumbered(&self, all: &[Labelled], length_m: f64) -> (Vec<Option<u32>>, f64) {
        let others = || all.iter().filter(|p| p.position != self.position);
        let known = |p: &Labelled| p.orders.iter().flatten().copied().collect::<Vec<u32>>();
        let mut orders: Vec<u32> = all.iter().flat_map(known).collect();
        orders.sort_unstable();
        orders.dedup();
        // A mode above all known ones may be a new order.
        orders.extend(orders.last().and_then(|last| last.checked_add(1)));
        let course = |order: &u32| -> Vec<CoursePoint> {
            let point = |p: &Labelled| Some(p.point(p.orders.iter().position(|o| *o == Some(*order))?));
            others().filter_map(point).collect()
        };
        let courses: Vec<Vec<CoursePoint>> = orders.iter().map(course).collect();
        let density = |at: usize, order: usize| log_density(self.point(at), &courses[order], length_m);
        let densities: Vec<Vec<f64>> = (0..self.logs.len())
            .map(|at| (0..orders.len()).map(|order| density(at, order)).collect())
            .collect();
        let none = SPURIOUS - (2.0 * UNKNOWN).ln();
        let of_present = |(at, order): (usize, &Option<u32>)| match order {
            Some(order) => orders.binary_search(order).map_or(none, |order| densities[at][order]),
            None => none,
        };
        let present: f64 = self.orders.iter().enumerate().map(of_present).sum();
        // best[i][j]: largest sum over the first i modes and the first j orders.
        let width = orders.len() + 1;
        let mut best = vec![0.0; (self.logs.len() + 1) * width];
        for i in 1..=self.logs.len() {
            for j in 0..width {
                let mut here = best[(i - 1) * width + j] + none;
                if j > 0 {
                    here = here
                        .max(best[i * width + j - 1])
                        .max(best[(i - 1) * width + j - 1] + densities[i - 1][j - 1]);
                }
                best[i * width + j] = here;
            }
        }
        let (mut i, mut j) = (self.logs.len(), orders.len());
        let mut labels = vec![None; self.logs.len()];
        while i > 0 {
            if j > 0 && best[i * width + j] <= best[i * width + j - 1] {
                j -= 1;
            } else if j > 0 && best[i * width + j] <= best[(i - 1) * width + j - 1] + densities[i - 1][j - 1]
            {
                labels[i - 1] = Some(orders[j - 1]);
                (i, j) = (i - 1, j - 1);
            } else {
                i -= 1;
            }
        }
        (labels, best[best.len() - 1] - present)
    }
}

/// A point of the course of an order.
#[derive(Debug, Clone, Copy)]
struct CoursePoint {
    nut_m: f64,
    /// ln(frequency).
    log: f64,
    /// Its variance by reading and rounding.
    variance: f64,
}

/// Computes ln of the density of ln(frequency) at a nut position, given its course at others.
fn log_density(here: CoursePoint, course: &[CoursePoint], length_m: f64) -> f64 {
    let normal =
        |deviation: f64, variance: f64| -0.5 * (deviation * deviation / variance + (TAU * variance).ln());
    if course.is_empty() {
        // The middle of the range is unknown, too: only its width counts.
        return normal(0.0, UNKNOWN * UNKNOWN);
    }
    let mean = course.iter().map(|p| p.log).sum::<f64>() / course.len() as f64;
    let parts = VARIATION.map(|variation| {
        // The level of the course is as good as unknown.
        let along = |a: f64, b: f64| (variation * variation) * (-0.5 * ((a - b) / length_m).powi(2)).exp();
        let covariance = |a: &CoursePoint, b: &CoursePoint| UNKNOWN * UNKNOWN + along(a.nut_m, b.nut_m);
        let own = |i: usize, j: usize| if i == j { course[i].variance } else { 0.0 };
        let known = DMatrix::from_fn(course.len(), course.len(), |i, j| {
            covariance(&course[i], &course[j]) + own(i, j)
        });
        let values = DVector::from_iterator(course.len(), course.iter().map(|p| p.log - mean));
        let cross = DVector::from_iterator(course.len(), course.iter().map(|p| covariance(p, &here)));
        let Some(factor) = known.cholesky() else { return (f64::NEG_INFINITY, f64::NEG_INFINITY) };
        let solved = factor.solve(&values);
        let evidence = -0.5 * values.dot(&solved) - factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let variance = covariance(&here, &here) + here.variance - cross.dot(&factor.solve(&cross));
        (evidence, normal(here.log - mean - cross.dot(&solved), variance.max(here.variance)))
    });
    log_sum_exp(&parts.map(|(evidence, density)| evidence + density))
        - log_sum_exp(&parts.map(|(evidence, _)| evidence))
}

#[cfg(test)]
mod tests;
