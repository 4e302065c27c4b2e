//! Rational functions of type \[1/2\] on t ∈ \[−1, 1\], for four intervals side by side: each holds one pole pair and one zero exactly.

use super::lanes::{Complexes, Reals};

/// Relative error at the middle of an interval that is accepted.
const FORETOLD: f64 = 2e-3;

/// (a + b·t)/(1 + c·t + d·t²) of some intervals.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rationals {
    a: Complexes,
    b: Complexes,
    c: Complexes,
    d: Complexes,
    /// A mask: where there is such a function.
    exist: Reals,
}

/// What is known at the ends and at the place looked at of some intervals: log-slopes per t of the sought quantity.
pub(super) struct Slopes {
    pub low: Reals,
    pub middle: Reals,
    pub high: Reals,
}

impl Rationals {
    /// Through values and slopes (per t) at t = −1 and t = 1.
    pub fn through(low: (Complexes, Complexes), high: (Complexes, Complexes)) -> Self {
        let ((h0, s0), (h1, s1)) = (low, high);
        let half = (h1 - h0) * 0.5;
        // (a + b t) = H (1 + c t + d t²) and its slope at both ends, a and b eliminated.
        let (m11, m12, r1) = (-half - s1, half - s1 - h1 * 2.0, s1 - half);
        let (m21, m22, r2) = (half + s0, half - s0 + h0 * 2.0, s0 - half);
        let determinant = m11 * m22 - m12 * m21;
        let scale = (m11.norm_sqr() + m12.norm_sqr()) * (m21.norm_sqr() + m22.norm_sqr());
        let inverse = determinant.inverse();
        let c = (r1 * m22 - r2 * m12) * inverse;
        let d = (m11 * r2 - m21 * r1) * inverse;
        let one = Complexes::real(Reals::ONE);
        let (n1, n0) = (h1 * (one + d + c), h0 * (one + d - c));
        let exist = determinant.norm_sqr().simd_gt(scale * Reals::splat(1e-28));
        Rationals { a: (n1 + n0) * 0.5, b: (n1 - n0) * 0.5, c, d, exist }
    }

    /// Value and slope at t.
    fn at(&self, t: Reals) -> (Complexes, Complexes) {
        let q = (Complexes::real(Reals::ONE) + self.c * t + self.d * (t * t)).inverse();
        let value = (self.a + self.b * t) * q;
        (value, (self.b - value * (self.c + self.d * (t + t))) * q)
    }

    /// d ln|H·ω^power|/dt as a quotient of real polynomials. With |n|² = n and |q|² = q of numerator and denominator, d ln|H|/dt = ½·(n′·q − n·q′)/(n·q).
    fn log_slope(&self, power: f64, (from, half): (Reals, Reals)) -> LogSlope {
        let re = |x: Complexes, y: Complexes| x.re.mul_add(y.re, x.im * y.im);
        let two = Reals::splat(2.0);
        let n = [self.a.norm_sqr(), re(self.a, self.b) * two, self.b.norm_sqr()];
        let q = [Reals::ONE, self.c.re * two, self.d.re.mul_add(two, self.c.norm_sqr()), re(self.c, self.d) * two, self.d.norm_sqr()];
        let mut slope = [Reals::ZERO; 7];
        let mut weight = [Reals::ZERO; 7];
        for (i, n) in n.into_iter().enumerate() {
            for (j, q) in q.into_iter().enumerate() {
                let product = n * q;
                weight[i + j] += product;
                if i != j {
                    slope[i + j - 1] = product.mul_add(Reals::splat(0.5 * (i as f64 - j as f64)), slope[i + j - 1]);
                }
            }
        }
        if power == 0.0 {
            return LogSlope { slope, weight, omega: None };
        }
        // Both times ω, which grows evenly.
        let (middle, power) = (from + half, half * Reals::splat(power));
        for at in (0..7).rev() {
            let below = if at == 0 { Reals::ZERO } else { slope[at - 1] };
            slope[at] = slope[at] * middle + below * half + weight[at] * power;
        }
        LogSlope { slope, weight, omega: Some((middle, half)) }
    }

    /// Their two poles and their zero.
    fn features(&self) -> [Complexes; 3] {
        let root = (self.c * self.c - self.d * 4.0).sqrt();
        let per_d = (self.d + self.d).inverse();
        [(root - self.c) * per_d, -(root + self.c) * per_d, -self.a * self.b.inverse()]
    }

    /// Real part of a pole well inside (−1, 1) and close to the real axis; 0 where there is none.
    pub fn poles(&self) -> Reals {
        let [one, other, _] = self.features();
        let near = |t: Complexes| t.re.abs().simd_lt(Reals::splat(0.9)) & t.im.abs().simd_lt(Reals::splat(0.5)) & self.exist;
        near(one).select(one.re, near(other).select(other.re, Reals::ZERO))
    }

    /// A mask: where value and slope at t are as foretold.
    pub fn foretell(&self, t: Reals, (h, s): (Complexes, Complexes)) -> Reals {
        let (value, slope) = self.at(t);
        let tolerance = Reals::splat(FORETOLD * FORETOLD);
        let of_value = (value - h).norm_sqr().simd_le(tolerance * h.norm_sqr());
        let of_slope = (slope - s).norm_sqr().simd_le(tolerance * (h.norm_sqr() + s.norm_sqr()) * Reals::splat(100.0));
        self.exist & of_value & of_slope
    }

    /// Where the log-slope of ω^power·H, of different signs at −1 and 1, passes through zero: by Newton's rule from where a straight line would, halved
    /// where that leads out. `span` as in [`Rationals::hide_nothing`].
    pub fn turn(&self, power: f64, span: (Reals, Reals), (low, high): (Reals, Reals)) -> Reals {
        let log_slope = self.log_slope(power, span);
        let (mut a, mut b) = (Reals::splat(-1.0), Reals::ONE);
        let mut t = (low + high) / (low - high);
        for _ in 0..30 {
            let (slope, change) = log_slope.with_change(t);
            let beyond = slope.is_sign_negative() ^ low.is_sign_negative();
            a = beyond.select(a, t);
            b = beyond.select(t, b);
            let next = t - slope / change;
            let inside = next.simd_ge(a) & next.simd_le(b);
            let next = inside.select(next, (a + b) * Reals::splat(0.5));
            let settled = (next - t).abs().simd_le(Reals::splat(1e-11)) | !self.exist;
            t = next;
            if settled.all() {
                break;
            }
        }
        self.exist.select(t, Reals::splat(f64::NAN))
    }

    /// A mask: where the log-slope of ω^power·H changes its sign between t = −1, `middle` and 1 only as often as it must, as far as can be told: it is
    /// sampled evenly and around the poles and the zero, and must be further from zero than it errs at the middle. `from` is ω at −1, `half` its change
    /// over a unit of t.
    pub fn hide_nothing(&self, power: f64, (from, half): (Reals, Reals), middle: Reals, slopes: &Slopes) -> Reals {
        let log_slope = self.log_slope(power, (from, half));
        let (slope, weight) = log_slope.at(middle);
        let doubt = (slope / weight - slopes.middle).abs() * Reals::splat(30.0);
        let mut parts = [
            Part::new((Reals::splat(-1.0), middle), (slopes.low, slopes.middle)),
            Part::new((middle, Reals::ONE), (slopes.middle, slopes.high)),
        ];
        let mut look = |t: Reals| {
            let (slope, weight) = log_slope.at(t);
            parts.iter_mut().for_each(|part| part.see(t, slope, doubt * weight));
        };
        [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75].into_iter().for_each(|t| look(Reals::splat(t)));
        for feature in self.features() {
            let reach = feature.im.abs();
            [-2.0, -0.7, 0.0, 0.7, 2.0].into_iter().for_each(|side| look(reach.mul_add(Reals::splat(side), feature.re)));
        }
        parts[0].plain() & parts[1].plain()
    }
}

/// The log-slope of some rational functions as a polynomial over a positive one, coefficients from the constant on.
struct LogSlope {
    slope: [Reals; 7],
    /// The positive one, without its factor ω.
    weight: [Reals; 7],
    /// ω at t = 0 and its change over a unit of t, where the positive one has it as a factor.
    omega: Option<(Reals, Reals)>,
}

impl LogSlope {
    /// The log-slope times the weight, and the weight, at t.
    #[inline]
    fn at(&self, t: Reals) -> (Reals, Reals) {
        let horner = |of: &[Reals; 7]| of.iter().rev().fold(Reals::ZERO, |sum, c| sum.mul_add(t, *c));
        let (slope, weight) = (horner(&self.slope), horner(&self.weight));
        (slope, self.omega.map_or(weight, |(middle, half)| weight * t.mul_add(half, middle)))
    }

    /// The log-slope times the weight, and its change over t.
    #[inline]
    fn with_change(&self, t: Reals) -> (Reals, Reals) {
        let step = |(value, change): (Reals, Reals), c: &Reals| (value.mul_add(t, *c), change.mul_add(t, value));
        self.slope.iter().rev().fold((Reals::ZERO, Reals::ZERO), step)
    }
}

/// What is seen of the log-slope between two nodes.
struct Part {
    ends: (Reals, Reals),
    /// Masks: where it is negative at the lower end, and of another sign at the upper.
    negative: Reals,
    turns: Reals,
    /// A mask: where it keeps its sign as long as it is not to turn.
    keeps: Reals,
    /// Where the sign of the lower end was last seen, and that of the upper one first.
    last_lower: Reals,
    first_upper: Reals,
}

impl Part {
    fn new(ends: (Reals, Reals), slopes: (Reals, Reals)) -> Self {
        let negative = slopes.0.is_sign_negative();
        let turns = negative ^ slopes.1.is_sign_negative();
        Part { ends, negative, turns, keeps: Reals::ZERO.simd_eq(Reals::ZERO), last_lower: ends.0, first_upper: ends.1 }
    }

    #[inline]
    fn see(&mut self, t: Reals, slope: Reals, doubt: Reals) {
        let inside = t.simd_gt(self.ends.0) & t.simd_lt(self.ends.1);
        let differs = slope.is_sign_negative() ^ self.negative;
        self.keeps &= !inside | (!differs & slope.abs().simd_gt(doubt));
        self.last_lower = (inside & !differs).select(self.last_lower.fast_max(t), self.last_lower);
        self.first_upper = (inside & differs).select(self.first_upper.fast_min(t), self.first_upper);
    }

    fn plain(&self) -> Reals {
        self.turns.select(self.last_lower.simd_le(self.first_upper), self.keeps)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    /// A function of this very type is told from its ends: its value, its pole, and that its slope turns where it does.
    #[test]
    fn limit_a_rational_function_is_its_own_interpolant() {
        let c = Complex64::new;
        let pole = c(0.3, 0.05);
        let of = |t: f64| {
            let (n, q) = (c(2.0, 0.1) + 0.4 * t, (t - pole) * (t - c(-3.0, 1.0)));
            let q_slope = (t - pole) + (t - c(-3.0, 1.0));
            (n / q, (0.4 - n * q_slope / q) / q)
        };
        let at = |t: f64| {
            let (h, s) = of(t);
            (Complexes::splat(h), Complexes::splat(s))
        };
        let rational = Rationals::through(at(-1.0), at(1.0));
        let all = |mask: Reals| mask.all();
        for t in [-0.9, -0.2, 0.3, 0.8] {
            assert!(all(rational.foretell(Reals::splat(t), at(t))));
            assert!(!all(rational.foretell(Reals::splat(t), at(t + 0.01))));
        }
        assert!((rational.poles().to_array()[0] - 0.3).abs() < 1e-9);
        let log_slope = |t: f64| Reals::splat((of(t).1 / of(t).0).re);
        let slopes = |middle: f64| Slopes { low: log_slope(-1.0), middle: log_slope(middle), high: log_slope(1.0) };
        let span = (Reals::splat(100.0), Reals::splat(1.0));
        // The one maximum lies between −1 and 0.5, or between 0 and 1.
        assert!(all(rational.hide_nothing(0.0, span, Reals::splat(0.5), &slopes(0.5))));
        assert!(all(rational.hide_nothing(0.0, span, Reals::splat(0.0), &slopes(0.0))));
        // Were the slope the same at both ends and the middle, a maximum would hide.
        let one = Slopes { low: log_slope(-1.0), middle: log_slope(0.0), high: log_slope(0.0) };
        assert!(!rational.hide_nothing(0.0, span, Reals::splat(0.0), &one).any());
    }
}
