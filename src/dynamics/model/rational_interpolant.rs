//! The receptance over a piece of a band as a quotient of two polynomials.
//!
//! H = N/Δ with Δ = det D·Π sin φ over the rods. Neither N nor Δ has a pole, since the poles of a rod cancel
//! against its sine. Polynomials through some frequencies therefore predict both in between, to rounding once
//! the frequencies are dense enough. The quotient has the poles and zeros of H.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::simd::{Complexes, LANES, Reals};

/// Number of frequencies per piece.
pub(super) const NODES: usize = 16;
/// SIMD groups per piece.
pub(super) const GROUPS: usize = NODES / LANES;

/// The Chebyshev–Lobatto nodes −1 … 1, and the matrices from values at the nodes to coefficients.
struct Basis {
    nodes: [f64; NODES],
    /// Coefficients of t^k from the values, row by row.
    powers: [[f64; NODES]; NODES],
    /// The coefficients of the two highest Chebyshev polynomials from the values.
    last: [[f64; NODES]; 2],
}

static BASIS: LazyLock<Basis> = LazyLock::new(|| {
    let end = NODES - 1;
    let angle = |j: usize| PI * j as f64 / end as f64;
    let share = |k: usize, j: usize| {
        let halved = |at: usize| if at == 0 || at == end { 0.5 } else { 1.0 };
        // Nodes rise from −1: T_k(−cos x) = (−1)^k·cos kx.
        let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        2.0 / end as f64 * halved(k) * halved(j) * sign * (k as f64 * angle(j)).cos()
    };
    let mut powers = [[0.0; NODES]; NODES];
    let (mut previous, mut chebyshev) = ([0.0; NODES], [0.0; NODES]);
    chebyshev[0] = 1.0;
    for k in 0..NODES {
        for (row, c) in powers.iter_mut().zip(chebyshev) {
            for (j, sum) in row.iter_mut().enumerate() {
                *sum += c * share(k, j);
            }
        }
        // T_1 = t, T_k+1 = 2·t·T_k − T_k−1.
        let factor = if k == 0 { 1.0 } else { 2.0 };
        let next: [f64; NODES] =
            std::array::from_fn(|at| if at == 0 { 0.0 } else { factor * chebyshev[at - 1] } - previous[at]);
        (previous, chebyshev) = (chebyshev, next);
    }
    Basis {
        nodes: std::array::from_fn(|j| -angle(j).cos()),
        powers,
        last: [end - 1, end].map(|k| std::array::from_fn(|j| share(k, j))),
    }
});

/// Returns the frequencies (rad/s) at which N and Δ of a piece are computed.
pub(super) fn nodes((from, to): (f64, f64)) -> [f64; NODES] {
    BASIS.nodes.map(|t| 0.5 * (from + to) + 0.5 * (to - from) * t)
}

/// N and Δ over a piece of a band, t = −1 … 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct RationalInterpolant {
    /// ω at t = 0 (rad/s).
    pub middle: f64,
    /// Change of ω over a unit of t (rad/s).
    pub half: f64,
    /// Coefficients, constant term first: real and imaginary part of N, then of Δ.
    coefficients: [[f64; 4]; NODES],
    /// Magnitude of the last Chebyshev coefficients of N and of Δ: an estimate of the interpolation error.
    pub error: [f64; 2],
}

/// A polynomial with its first derivative and half of its second derivative over t.
pub(super) type Jet = [Complexes; 3];

impl RationalInterpolant {
    /// Interpolates N and Δ given at [`nodes`].
    pub fn through((from, to): (f64, f64), found: &[(Complexes, Complexes)]) -> Self {
        let basis = &*BASIS;
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut values = [Reals::ZERO; NODES];
        for (values, (n, d)) in values.chunks_exact_mut(LANES).zip(found) {
            let parts = [n.re, n.im, d.re, d.im].map(|x| x.to_array());
            for (lane, value) in values.iter_mut().enumerate() {
                *value = Reals::from([parts[0][lane], parts[1][lane], parts[2][lane], parts[3][lane]]);
            }
        }
        // The nodes are symmetric about 0: even coefficients follow from sums of opposite values, odd ones
        // from differences.
        let mut halves = [[Reals::ZERO; NODES / 2]; 2];
        for j in 0..NODES / 2 {
            (halves[0][j], halves[1][j]) =
                (values[j] + values[NODES - 1 - j], values[j] - values[NODES - 1 - j]);
        }
        let combine = |k: usize, row: &[f64; NODES]| {
            let values = &halves[k % 2];
            row[..NODES / 2]
                .iter()
                .zip(values)
                .fold(Reals::ZERO, |sum, (c, v)| v.mul_add(Reals::splat(*c), sum))
        };
        let last =
            (combine(NODES - 2, &basis.last[0]).abs() + combine(NODES - 1, &basis.last[1]).abs()).to_array();
        RationalInterpolant {
            middle,
            half,
            coefficients: std::array::from_fn(|k| combine(k, &basis.powers[k]).to_array()),
            error: [last[0] + last[1], last[2] + last[3]],
        }
    }

    /// Returns ω at t.
    pub fn omega_rad_s(&self, t: f64) -> f64 {
        self.middle + self.half * t
    }

    /// Evaluates N and Δ with their first derivatives at real t.
    #[inline(always)]
    pub fn slopes(&self, t: Reals) -> ([Complexes; 2], [Complexes; 2]) {
        let mut sums = [[Reals::ZERO; 4]; 2];
        for c in self.coefficients.iter().rev() {
            for part in 0..4 {
                sums[1][part] = sums[1][part].mul_add(t, sums[0][part]);
                sums[0][part] = sums[0][part].mul_add(t, Reals::splat(c[part]));
            }
        }
        let of = |first: usize| sums.map(|s| Complexes::new(s[first], s[first + 1]));
        (of(0), of(2))
    }

    /// Evaluates as [`RationalInterpolant::slopes`] at t and at −t, from the even and the odd part, at half
    /// the cost.
    #[inline(always)]
    pub fn slopes_on_both_sides(&self, t: Reals) -> [([Complexes; 2], [Complexes; 2]); 2] {
        let square = t * t;
        let mut sums = [[[Reals::ZERO; 4]; 2]; 2];
        for pair in self.coefficients.as_chunks::<2>().0.iter().rev() {
            for ([value, slope], c) in sums.iter_mut().zip(pair) {
                for part in 0..4 {
                    slope[part] = slope[part].mul_add(square, value[part]);
                    value[part] = value[part].mul_add(square, Reals::splat(c[part]));
                }
            }
        }
        let [[even, even_slope], [odd, odd_slope]] = sums;
        [t, -t].map(|t| {
            let value: [Reals; 4] = std::array::from_fn(|part| odd[part].mul_add(t, even[part]));
            let slope: [Reals; 4] = std::array::from_fn(|part| {
                even_slope[part].mul_add(t + t, odd_slope[part].mul_add(square + square, odd[part]))
            });
            let of = |first: usize| [value, slope].map(|s| Complexes::new(s[first], s[first + 1]));
            (of(0), of(2))
        })
    }

    /// Evaluates N and Δ with their first and second derivatives at real t.
    #[inline(always)]
    pub fn jets(&self, t: Reals) -> (Jet, Jet) {
        let mut sums = [[Reals::ZERO; 4]; 3];
        for c in self.coefficients.iter().rev() {
            for part in 0..4 {
                sums[2][part] = sums[2][part].mul_add(t, sums[1][part]);
                sums[1][part] = sums[1][part].mul_add(t, sums[0][part]);
                sums[0][part] = sums[0][part].mul_add(t, Reals::splat(c[part]));
            }
        }
        let of = |first: usize| sums.map(|s| Complexes::new(s[first], s[first + 1]));
        (of(0), of(2))
    }

    /// Computes Newton steps from complex t towards roots of Δ where `poles` is set, otherwise of N.
    #[inline(always)]
    pub fn steps(&self, poles: Reals, t: Complexes) -> Complexes {
        let (mut value, mut slope) = (Complexes::ZERO, Complexes::ZERO);
        for [n_re, n_im, d_re, d_im] in self.coefficients.iter().rev().map(|c| c.map(Reals::splat)) {
            slope = slope.mul_add(t, value);
            value = value.mul_add(t, Complexes::new(poles.select(d_re, n_re), poles.select(d_im, n_im)));
        }
        -(value * slope.inverse())
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    /// Polynomials of lower degree are reproduced with both derivatives on either side of the middle, and
    /// Newton's method converges to their roots.
    #[test]
    fn limit_interpolant_reproduces_polynomials() {
        let c = Complex64::new;
        let (zeros, poles) =
            ([c(300.0, 5.0), c(410.0, -2.0)], [c(250.0, 1.0), c(370.0, 30.0), c(900.0, 0.0)]);
        let product = |roots: &[Complex64], omega: f64| {
            roots.iter().map(|root| (omega - root) / 100.0).product::<Complex64>()
        };
        let ends = (200.0, 500.0);
        let at: Vec<(Complexes, Complexes)> = nodes(ends)
            .chunks_exact(LANES)
            .map(|omegas| {
                (
                    Complexes::each(|lane| product(&zeros, omegas[lane])),
                    Complexes::each(|lane| product(&poles, omegas[lane])),
                )
            })
            .collect();
        let of = RationalInterpolant::through(ends, &at);
        assert!(of.error.iter().all(|error| *error < 1e-12), "{:?}", of.error);
        // Derivatives of a product by its logarithm; a jet holds half of the second derivative.
        let jet = |roots: &[Complex64], omega: f64| {
            let (value, half) = (product(roots, omega), of.half);
            let one: Complex64 = roots.iter().map(|root| half / (omega - root)).sum();
            let two: Complex64 = roots.iter().map(|root| (half / (omega - root)).powi(2)).sum();
            [value, value * one, 0.5 * value * (one * one - two)]
        };
        let assert_near = |a: Complexes, b: Complex64| {
            assert!((a.lanes()[2] - b).norm() <= 1e-9 * (1.0 + b.norm()), "{:?} {b}", a.lanes()[2])
        };
        for t in [0.01, 0.4, 0.97] {
            let both = of.slopes_on_both_sides(Reals::splat(t));
            for (t, both) in [t, -t].into_iter().zip(both) {
                let (slopes, jets) = (of.slopes(Reals::splat(t)), of.jets(Reals::splat(t)));
                for (roots, (both, (slopes, jets))) in
                    [(&zeros[..], (both.0, (slopes.0, jets.0))), (&poles[..], (both.1, (slopes.1, jets.1)))]
                {
                    let exact = jet(roots, of.omega_rad_s(t));
                    (0..2).for_each(|k| assert_near(both[k], exact[k]));
                    (0..2).for_each(|k| assert_near(slopes[k], exact[k]));
                    (0..3).for_each(|k| assert_near(jets[k], exact[k]));
                }
            }
        }
        for (roots, pole) in [(&zeros[..], false), (&poles[..2], true)] {
            for root in roots {
                let towards = (root - of.middle) / of.half;
                let mut z = Complexes::splat(towards + c(0.05, -0.03));
                let which = Reals::splat(if pole { 1.0 } else { 0.0 }).simd_gt(Reals::ZERO);
                (0..8).for_each(|_| z += of.steps(which, z));
                assert_near(z, towards);
            }
        }
    }
}
