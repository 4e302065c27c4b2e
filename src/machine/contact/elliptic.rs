//! Complete elliptic integrals by the arithmetic–geometric mean.

use std::f64::consts::{FRAC_PI_2, PI};

/// The complete elliptic integrals K and E and the associate integrals B and D of the parameter m = k²,
/// without cancellation for any m in [0, 1).
///
/// ```text
///      π/2                                         π                   π/2
/// K =  ∫  dφ / √(1 − m sin²φ)  =  ─────────────────           E =  ∫  √(1 − m sin²φ) dφ
///      0                               2·agm(1, √(1−m))                0
///
///      π/2                               π/2
/// B =  ∫  cos²φ/√(1 − m sin²φ) dφ   D =  ∫  sin²φ/√(1 − m sin²φ) dφ   K = B + D   E = B + (1 − m) D
///      0                                 0
/// ```
///
/// # Limits     K(0) = E(0) = π/2; K(1/2) = Γ(1/4)²/(4√π) (test `limit_circle_and_lemniscate`)
/// # Source     Abramowitz and Stegun, 17.3.1, 17.3.3 and 17.6.
#[derive(Debug, Clone, Copy)]
pub(super) struct Complete {
    /// K(m).
    pub first: f64,
    /// E(m).
    pub second: f64,
    /// B(m).
    pub cosine: f64,
    /// D(m).
    pub sine: f64,
}

impl Complete {
    /// Computes all four at m = 1 − m₁, for 0 < m₁ ≤ 1.
    ///
    /// E is K − m·D up to m = 1/2. Above, that difference cancels, and Legendre's relation with the integrals
    /// of m₁ replaces it.
    pub fn of_complement(complement: f64) -> Complete {
        let m = 1.0 - complement;
        let (first, sine) = first_and_sine(complement);
        let second = if m <= 0.5 {
            first - m * sine
        } else {
            let (other_first, other_sine) = first_and_sine(m);
            (FRAC_PI_2 + first * complement * other_sine) / other_first
        };
        Complete { first, second, cosine: second - complement * sine, sine }
    }
}

/// Computes K and D = (K − E)/m. The sum Σ 2^(n−1) c_n² of the mean is divided by m term by term, which
/// avoids a division by zero at m → 0.
fn first_and_sine(complement: f64) -> (f64, f64) {
    let root = complement.sqrt();
    let (mut a, mut g) = (0.5 * (1.0 + root), root.sqrt());
    let mut c = 0.5 * (1.0 - root);
    // c_n²/m and 2^(n−1)
    let (mut ratio, mut weight) = (0.25 * (1.0 - root) / (1.0 + root), 1.0);
    let mut sum = 0.5;
    while c > f64::EPSILON * a * 0.1 {
        sum += weight * ratio;
        let next = 0.5 * (a + g);
        g = (a * g).sqrt();
        a = next;
        ratio *= c * c / (16.0 * a * a);
        c = c * c / (4.0 * a);
        weight *= 2.0;
    }
    sum += weight * ratio;
    let first = PI / (a + g);
    (first, first * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// m, K, E to 25 digits, computed with mpmath 1.3; the first three agree with Abramowitz and Stegun,
    /// Table 17.1.
    #[allow(clippy::excessive_precision)]
    const TABLE: [(f64, f64, f64); 5] = [
        (0.1, 1.612441348720219398229916, 1.530757636897763202469069),
        (0.5, 1.85407467730137191843385, 1.350643881047675502520175),
        (0.9, 2.578092113348173188202571, 1.104774732704073326090399),
        (0.99, 3.695637362989874677809954, 1.015993545025223935639448),
        (0.999999, 8.294051463615439985316781, 1.000003897026172061152689),
    ];

    fn of(m: f64) -> Complete {
        Complete::of_complement(1.0 - m)
    }

    #[test]
    fn published_table() {
        for (m, first, second) in TABLE {
            // The conditioning of K near m = 1 amplifies the rounding of the decimal m: allow for it.
            let conditioning = f64::EPSILON / (1.0 - m) / first;
            assert!((of(m).first / first - 1.0).abs() < 1e-15 + conditioning, "K({m})");
            assert!((of(m).second / second - 1.0).abs() < 1e-15, "E({m})");
        }
    }

    #[test]
    fn limit_circle_and_lemniscate() {
        assert_eq!(of(0.0).first, FRAC_PI_2);
        assert_eq!(of(0.0).second, FRAC_PI_2);
        // Γ(1/4)
        let gamma = 3.625_609_908_221_908_f64;
        assert!((of(0.5).first / (gamma * gamma / (4.0 * PI.sqrt())) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn limit_legendre_relation() {
        for step in 1..1000 {
            let m = f64::from(step) / 1000.0;
            let (here, there) = (Complete::of_complement(1.0 - m), Complete::of_complement(m));
            // E = K − m·D on both sides, so that Legendre's relation is an independent check.
            let (e, other) = (here.first - m * here.sine, there.first - (1.0 - m) * there.sine);
            let left = e * there.first + other * here.first - here.first * there.first;
            assert!((left / FRAC_PI_2 - 1.0).abs() < 2e-14, "{m}: {left}");
            let left = here.second * there.first + there.second * here.first - here.first * there.first;
            assert!((left / FRAC_PI_2 - 1.0).abs() < 4e-15, "{m}: {left}");
        }
    }

    /// The trapezoidal rule converges geometrically for periodic functions: an independent value of all four
    /// integrals.
    #[test]
    fn limit_quadrature_of_the_definitions() {
        for m in [0.0, 1e-9, 0.03, 0.2, 0.499, 0.501, 0.7, 0.95] {
            let count = 400;
            let [mut k, mut e, mut b, mut d] = [0.0; 4];
            for index in 0..count {
                let (sin, cos) = (PI * f64::from(index) / f64::from(count)).sin_cos();
                let root = (1.0 - m * sin * sin).sqrt();
                k += 1.0 / root;
                e += root;
                b += cos * cos / root;
                d += sin * sin / root;
            }
            let scale = FRAC_PI_2 / f64::from(count);
            let got = Complete::of_complement(1.0 - m);
            for (value, sum) in [(got.first, k), (got.second, e), (got.cosine, b), (got.sine, d)] {
                assert!((value / (sum * scale) - 1.0).abs() < 4e-15, "{m}");
            }
        }
    }

    #[test]
    fn limit_logarithm_towards_one() {
        // K → ln(4/√m₁), B → 1, D → K − 1
        for complement in [1e-8, 1e-12, 1e-16] {
            let got = Complete::of_complement(complement);
            let log = (4.0 / f64::sqrt(complement)).ln();
            assert!((got.first / log - 1.0).abs() < complement * 2.0 + 1e-15);
            assert!((got.cosine - 1.0).abs() < complement * 30.0 + 4e-15);
            assert!((got.sine - (log - 1.0)).abs() < complement * 30.0 + 1e-14);
        }
    }
}
