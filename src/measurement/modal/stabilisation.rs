//! Stabilisation diagram: poles that repeat from order to order.
//!
//! Poles are estimated at all orders over the whole band, then over narrower bands. Narrow bands resolve
//! modes far below the top frequency with few orders. A pole is stable at an order if the previous order has
//! one within the tolerances of frequency and damping. Stable poles close to each other form one candidate.
//! Its stability is the share of orders at which it was stable, in the band with the largest share.
//!
//! # Source
//!
//! Guillaume et al., IMAC XXI (2003), section on stabilisation; tolerances 1 % and 5 to 10 % as used there.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;

use super::curve::{CurveLines, CurveOptions, FrfCurve};
use super::error::ModalError;
use super::lscf::diagram;
use super::noise;

/// Lowest order of a diagram.
const FIRST_ORDER: usize = 4;
/// Highest order of a narrow band.
const NARROW_ORDER: usize = 24;
/// Smallest ratio of upper to lower end of a narrow band (1).
const NARROW_RATIO: f64 = 2.5;
/// Smallest number of lines of a narrow band.
const NARROW_LINES: usize = 80;
/// Largest relative change of frequency from order to order of a stable pole (1). 1 % is common practice in
/// stabilisation diagrams.
const FREQUENCY_TOLERANCE: f64 = 0.01;
/// Largest relative change of damping from order to order of a stable pole (1). 5 to 10 % is common practice.
const DAMPING_TOLERANCE: f64 = 0.10;

/// Number of orders at which a pole was stable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stability {
    /// Orders at which it was stable, in the band with the largest share.
    pub stable: usize,
    /// Number of orders of that band.
    pub orders: usize,
}

impl Stability {
    /// Returns the share of orders at which the pole was stable (1).
    pub fn share(&self) -> f64 {
        self.stable as f64 / self.orders.max(1) as f64
    }
}

/// A group of stable poles.
#[derive(Debug, Clone, Copy)]
pub(super) struct StablePole {
    /// Median pole (rad/s).
    pub pole: Complex64,
    /// Stability of the group.
    pub stability: Stability,
}

/// A pole that was stable at an order of a band.
#[derive(Clone, Copy)]
struct Stable {
    pole: Complex64,
    band: usize,
    order: usize,
}

/// A pole of a stabilisation diagram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiagramPole {
    /// Polynomial order.
    pub order: usize,
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio (1).
    pub damping_ratio: f64,
    /// Whether the previous order has the same pole, within the tolerances of frequency and damping.
    pub stable: bool,
}

/// Computes the stabilisation diagram of a curve over its whole band: the poles of every order.
///
/// # Errors  as [`fit_curve`](super::fit_curve).
pub fn stabilisation_diagram(
    curve: &FrfCurve,
    options: &CurveOptions,
) -> Result<Vec<DiagramPole>, ModalError> {
    let lines = CurveLines::of(curve, options)?;
    let sd = lines.sd.clone().unwrap_or_else(|| noise::from_curve(&lines));
    let weight: Vec<f64> = sd.iter().map(|s| 1.0 / s).collect();
    let orders = polynomial_orders(lines.len(), options.max_order);
    let rows = diagram(&lines, 0..lines.len(), &weight, &orders);
    let mut found = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        found.extend(row.iter().map(|pole| DiagramPole {
            order: orders[at],
            frequency_hz: pole.norm() / TAU,
            damping_ratio: -pole.re / pole.norm(),
            stable: at > 0 && is_repeated(*pole, &rows[at - 1]),
        }));
    }
    Ok(found)
}

/// Returns the orders of a diagram over a number of lines.
fn polynomial_orders(lines: usize, highest: usize) -> Vec<usize> {
    // A line gives two real equations; an order has two unknowns, four where they are complex.
    (FIRST_ORDER..=highest.min(lines / 3).max(FIRST_ORDER)).step_by(2).collect()
}

/// Whether the previous order of a diagram has the same pole.
fn is_repeated(pole: Complex64, previous: &[Complex64]) -> bool {
    let size = pole.norm();
    let damping = -pole.re / size;
    previous.iter().any(|other| {
        (other.norm() - size).abs() <= FREQUENCY_TOLERANCE * size
            && (-other.re / other.norm() - damping).abs() <= DAMPING_TOLERANCE * damping
    })
}

/// Returns the candidates of the lines, the most stable first.
pub(super) fn candidates(lines: &CurveLines, weight: &[f64], options: &CurveOptions) -> Vec<StablePole> {
    let mut stable = Vec::new();
    let mut orders_of = Vec::new();
    for (band, range) in bands(lines).into_iter().enumerate() {
        let highest = if band == 0 { options.max_order } else { NARROW_ORDER.min(options.max_order) };
        let orders = polynomial_orders(range.len(), highest);
        let rows = diagram(lines, range, weight, &orders);
        collect(&mut stable, &rows, band);
        orders_of.push(rows.len().saturating_sub(1).max(1));
    }
    group(&stable, &orders_of)
}

/// Returns the whole band, then narrow bands that overlap by half.
fn bands(lines: &CurveLines) -> Vec<Range<usize>> {
    let mut bands = Vec::new();
    bands.push(0..lines.len());
    let mut start = 0;
    loop {
        let low = lines.omega[start];
        let stop = lines.omega.partition_point(|w| *w <= NARROW_RATIO * low).max(start + NARROW_LINES);
        if stop >= lines.len() {
            if start > 0 {
                let first = lines.omega.partition_point(|w| *w * NARROW_RATIO < lines.omega[lines.len() - 1]);
                bands.push(first.min(lines.len().saturating_sub(NARROW_LINES))..lines.len());
            }
            return bands;
        }
        bands.push(start..stop);
        let middle = (low * lines.omega[stop - 1]).sqrt();
        start = lines.omega.partition_point(|w| *w < middle).clamp(start + 1, start + (stop - start) / 2 + 1);
    }
}

/// Adds the poles of a diagram that the previous order has, too.
fn collect(stable: &mut Vec<Stable>, rows: &[Vec<Complex64>], band: usize) {
    for (order, pair) in rows.windows(2).enumerate() {
        for pole in &pair[1] {
            if is_repeated(*pole, &pair[0]) {
                stable.push(Stable { pole: *pole, band, order });
            }
        }
    }
}

/// Whether two poles coincide: closer than 0.4 times the smaller half-width plus 0.3 % of the frequency.
pub(super) fn coincide(a: Complex64, b: Complex64) -> bool {
    (a - b).norm() <= 0.4 * (-a.re).min(-b.re) + 0.003 * a.norm()
}

/// Groups coinciding poles, the most stable group first.
fn group(stable: &[Stable], orders_of: &[usize]) -> Vec<StablePole> {
    let neighbours = |centre: &Stable| stable.iter().filter(|s| coincide(s.pole, centre.pole)).count();
    let counts: Vec<usize> = stable.iter().map(neighbours).collect();
    let mut order: Vec<usize> = (0..stable.len()).collect();
    order.sort_by(|a, b| counts[*b].cmp(&counts[*a]).then(a.cmp(b)));
    let mut taken = vec![false; stable.len()];
    let mut found = Vec::new();
    for at in order {
        if taken[at] {
            continue;
        }
        let mut group = Vec::new();
        for (member, s) in stable.iter().enumerate() {
            if !taken[member] && coincide(s.pole, stable[at].pole) {
                taken[member] = true;
                group.push(*s);
            }
        }
        found.push(StablePole { pole: median(&group), stability: count(&group, orders_of) });
    }
    found.sort_by(|a, b| {
        b.stability.share().total_cmp(&a.stability.share()).then(a.pole.im.total_cmp(&b.pole.im))
    });
    found
}

/// Returns the median of both components.
fn median(group: &[Stable]) -> Complex64 {
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Complex64::new(
        middle(group.iter().map(|s| s.pole.re).collect()),
        middle(group.iter().map(|s| s.pole.im).collect()),
    )
}

/// Counts the orders at which a group was stable, in the band with the largest share.
fn count(group: &[Stable], orders_of: &[usize]) -> Stability {
    let mut best = Stability { stable: 0, orders: 1 };
    for (band, orders) in orders_of.iter().enumerate() {
        let mut seen: Vec<usize> = group.iter().filter(|s| s.band == band).map(|s| s.order).collect();
        seen.sort_unstable();
        seen.dedup();
        let here = Stability { stable: seen.len(), orders: *orders };
        if here.share() > best.share() {
            best = here;
        }
    }
    best
}
