//! Least-squares complex-frequency estimator: poles of one band at every polynomial order.
//!
//! The band is mapped onto the unit circle, z = e^{iθ}, and H ≈ B(z)/A(z) with polynomials in z is solved by
//! least squares. The normal matrices are Toeplitz: an order needs three sums per lag. Fixing the lowest
//! coefficient of A at 1 moves poles that fit noise outside the unit circle, where they are unstable.
//! Repeated weighting with 1/|A| turns the equation error into the error of H.
//!
//! # Source
//!
//! Guillaume, Verboven, Vanlanduit, Van der Auweraer, Peeters, IMAC XXI (2003), on the poly-reference
//! estimator (one input, one output here); Cauberghe, thesis, Vrije Universiteit Brussel (2004), on the
//! constraint; Sanathanan and Koerner, IEEE Trans. Automatic Control 8 (1963), 56–58, on the weighting.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::{ComplexField, DMatrix};
use num_complex::Complex64;

use super::curve::CurveLines;
use super::polynomial::roots;

/// Number of weighted solutions per order.
const REWEIGHTINGS: usize = 3;
/// Angle of the top line (rad) where the band extends towards 0 Hz and the lines are mirrored.
const MIRRORED_TOP: f64 = 0.85 * PI;
/// Angles of the first and last line (rad) where the lines are not mirrored.
const ARC: (f64, f64) = (0.2 * PI, 1.8 * PI);
/// Ratio of lower to upper band end (1) below which the lines are mirrored at 0 Hz: there poles and their
/// conjugates are neighbours.
const MIRROR_BELOW: f64 = 0.3;
/// Largest distance of a kept pole outside the band, as a share of the band width (1).
const MARGIN: f64 = 0.15;

/// Mapping of ω onto the unit circle: θ = offset + slope·ω.
struct UnitCircle {
    offset: f64,
    slope: f64,
    mirrored: bool,
    band: (f64, f64),
}

impl UnitCircle {
    fn of(low: f64, high: f64) -> Self {
        if low < MIRROR_BELOW * high {
            Self { offset: 0.0, slope: MIRRORED_TOP / high, mirrored: true, band: (low, high) }
        } else {
            let slope = (ARC.1 - ARC.0) / (high - low);
            Self { offset: ARC.0 - slope * low, slope, mirrored: false, band: (low, high) }
        }
    }

    /// Returns the pole in s of a root in z; `None` where it is unstable, heavily damped or far outside the
    /// band.
    fn pole(&self, z: Complex64) -> Option<Complex64> {
        let mut angle = z.arg();
        if !self.mirrored && angle < 0.0 {
            angle += TAU;
        }
        let pole = Complex64::new(z.norm().ln(), angle - self.offset) / self.slope;
        let margin = MARGIN * (self.band.1 - self.band.0);
        let inside =
            pole.im > (self.band.0 - margin).max(1e-3 * self.band.0) && pole.im < self.band.1 + margin;
        (pole.re < 0.0 && inside && -pole.re < 0.75 * pole.im).then_some(pole)
    }
}

/// Returns the poles (rad/s) of the lines in `range` for each order, with Re < 0 < Im, inside the band or
/// close to it; `weight` is the inverse relative standard deviation of each line.
pub(super) fn diagram(
    lines: &CurveLines,
    range: Range<usize>,
    weight: &[f64],
    orders: &[usize],
) -> Vec<Vec<Complex64>> {
    let omega = &lines.omega[range.clone()];
    let h = &lines.h[range.clone()];
    let weight = &weight[range];
    let (Some(low), Some(high)) = (omega.first(), omega.last()) else { return Vec::new() };
    let circle = UnitCircle::of(*low, *high);
    let z: Vec<Complex64> = omega.iter().map(|w| Complex64::cis(circle.offset + circle.slope * w)).collect();
    let scale = h.iter().map(|h| h.norm().ln()).sum::<f64>() / h.len() as f64;
    let h: Vec<Complex64> = h.iter().map(|h| h * (-scale).exp()).collect();
    let first: Vec<f64> = h.iter().zip(weight).map(|(h, w)| w * w / h.norm_sqr()).collect();
    orders
        .iter()
        .map(|order| {
            let mut squared = first.clone();
            let mut found = None;
            for _ in 0..REWEIGHTINGS {
                let sums = Sums::of(&z, &h, &squared, *order);
                let solution = if circle.mirrored {
                    denominator(&sums, |c| 2.0 * c.re).map(|a| a.iter().map(|a| a.into()).collect())
                } else {
                    denominator(&sums, |c| c)
                };
                let Some(a) = solution else { break };
                reweight(&mut squared, &first, &z, &a);
                found = Some(a);
            }
            let mut poles: Vec<Complex64> = found
                .map(|a| roots(&a))
                .unwrap_or_default()
                .into_iter()
                .filter_map(|z| circle.pole(z))
                .collect();
            poles.sort_by(|a, b| a.im.total_cmp(&b.im));
            poles
        })
        .collect()
}

/// Computes the squared weights of the next solution: the first ones over |A|².
fn reweight(squared: &mut [f64], first: &[f64], z: &[Complex64], a: &[Complex64]) {
    let size: Vec<f64> =
        z.iter().map(|z| a.iter().rev().fold(Complex64::ZERO, |sum, c| sum * z + c).norm_sqr()).collect();
    let largest = size.iter().copied().fold(0.0, f64::max);
    for ((out, first), size) in squared.iter_mut().zip(first).zip(size) {
        *out = first / size.max(1e-14 * largest);
    }
}

/// Toeplitz sums Σ w² g z^lag for lags −n..n with g = 1, H and |H|².
struct Sums {
    order: usize,
    one: Vec<Complex64>,
    cross: Vec<Complex64>,
    square: Vec<Complex64>,
}

impl Sums {
    fn of(z: &[Complex64], h: &[Complex64], squared: &[f64], order: usize) -> Self {
        let mut one = vec![Complex64::ZERO; order + 1];
        let mut square = one.clone();
        let mut cross = vec![Complex64::ZERO; 2 * order + 1];
        for ((z, h), w) in z.iter().zip(h).zip(squared) {
            let (weighted, energy) = (h * w, h.norm_sqr() * w);
            let mut power = Complex64::ONE;
            one[0] += w;
            square[0] += energy;
            cross[order] += weighted;
            for lag in 1..=order {
                power *= z;
                one[lag] += power * w;
                square[lag] += power * energy;
                cross[order + lag] += weighted * power;
                cross[order - lag] += weighted * power.conj();
            }
        }
        Self { order, one, cross, square }
    }

    /// Returns the sum of a Hermitian sequence at lag column − row.
    fn hermitian(sequence: &[Complex64], row: usize, column: usize) -> Complex64 {
        if column >= row { sequence[column - row] } else { sequence[row - column].conj() }
    }
}

/// Solves for the coefficients of A (lowest 1) by the reduced normal equations T − Sᴴ R⁻¹ S; `part` takes
/// 2·Re for mirrored lines.
fn denominator<T: ComplexField<RealField = f64>>(
    sums: &Sums,
    part: impl Fn(Complex64) -> T,
) -> Option<Vec<T>> {
    let n = sums.order + 1;
    let r = DMatrix::from_fn(n, n, |i, j| part(Sums::hermitian(&sums.one, i, j)));
    let s = DMatrix::from_fn(n, n, |i, j| part(sums.cross[sums.order + j - i]));
    let mut reduced = DMatrix::from_fn(n, n, |i, j| part(Sums::hermitian(&sums.square, i, j)));
    let half = r.cholesky()?.l().solve_lower_triangular(&s)?;
    reduced -= half.ad_mul(&half);
    let right = -reduced.view((1, 0), (n - 1, 1)).clone_owned();
    let solution = reduced.view((1, 1), (n - 1, n - 1)).clone_owned().lu().solve(&right)?;
    let mut a = vec![T::one()];
    a.extend(solution.iter().cloned());
    a.iter().all(|a| a.clone().modulus().is_finite()).then_some(a)
}
