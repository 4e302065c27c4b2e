//! Roots of a complex polynomial by simultaneous iteration.

use num_complex::Complex64;

/// Returns value and derivative of Σ c_k z^k (Horner).
fn value_and_slope(coefficients: &[Complex64], z: Complex64) -> (Complex64, Complex64) {
    let mut value = Complex64::ZERO;
    let mut slope = Complex64::ZERO;
    for c in coefficients.iter().rev() {
        slope = slope * z + value;
        value = value * z + c;
    }
    (value, slope)
}

/// Returns the Newton step p/p' at z. Outside the unit circle it uses the reversed polynomial, which does not
/// overflow there.
fn newton(coefficients: &[Complex64], reversed: &[Complex64], z: Complex64) -> Complex64 {
    if z.norm_sqr() <= 1.0 {
        let (value, slope) = value_and_slope(coefficients, z);
        return value / slope;
    }
    let y = z.inv();
    let (value, slope) = value_and_slope(reversed, y);
    // p(z) = zⁿ q(1/z), so p'/p = n/z − q'/(q z²).
    let n = (coefficients.len() - 1) as f64;
    (y * n - slope / value * y * y).inv()
}

/// Returns the roots of Σ c_k z^k by simultaneous iteration, started on the circle of the roots' geometric
/// mean.
///
/// A root that has not converged after 80 sweeps is returned as it is: the caller keeps only poles that
/// repeat over orders.
///
/// # Source  Aberth, Mathematics of Computation 27 (1973), 339–344.
pub(super) fn roots(coefficients: &[Complex64]) -> Vec<Complex64> {
    let Some(top) = coefficients.iter().rposition(|c| c.norm_sqr() > 0.0) else { return Vec::new() };
    let coefficients = &coefficients[..=top];
    let reversed: Vec<Complex64> = coefficients.iter().rev().copied().collect();
    let radius = (coefficients[0].norm() / coefficients[top].norm()).powf(1.0 / top.max(1) as f64);
    let radius = if radius.is_finite() && radius > 0.0 { radius.clamp(0.2, 5.0) } else { 1.0 };
    let mut z: Vec<Complex64> = (0..top)
        .map(|k| Complex64::from_polar(radius, std::f64::consts::TAU * (k as f64 + 0.31) / top as f64))
        .collect();
    let mut converged = vec![false; top];
    for _ in 0..80 {
        for k in 0..top {
            if converged[k] {
                continue;
            }
            let step = newton(coefficients, &reversed, z[k]);
            let mut repulsion = Complex64::ZERO;
            for (other, at) in z.iter().enumerate() {
                if other != k {
                    repulsion += (z[k] - at).inv();
                }
            }
            let step = step / (1.0 - step * repulsion);
            if !step.is_finite() {
                // Two iterates coincide, or an iterate is an exact root: continue from a nearby point, or
                // stop.
                converged[k] = step.re.is_nan() && newton(coefficients, &reversed, z[k]).is_nan();
                z[k] *= Complex64::new(1.0 + 1e-9, 1e-9);
                continue;
            }
            z[k] -= step;
            converged[k] = step.norm_sqr() < 1e-24 * z[k].norm_sqr();
        }
        if converged.iter().all(|s| *s) {
            break;
        }
    }
    z.retain(|z| z.is_finite());
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recover_roots_of_a_product() {
        let planted: Vec<Complex64> = (0..24)
            .map(|k| Complex64::from_polar(0.9 + 0.01 * f64::from(k), 0.26 * f64::from(k) + 0.1))
            .collect();
        let mut coefficients = vec![Complex64::ONE];
        for root in &planted {
            let mut next = vec![Complex64::ZERO; coefficients.len() + 1];
            for (k, c) in coefficients.iter().enumerate() {
                next[k + 1] += c;
                next[k] -= c * root;
            }
            coefficients = next;
        }
        let found = roots(&coefficients);
        assert_eq!(found.len(), planted.len());
        for root in planted {
            let nearest = found.iter().map(|f| (f - root).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{root}: {nearest:e}");
        }
    }

    #[test]
    fn limit_no_roots_of_a_constant() {
        assert!(roots(&[Complex64::ONE]).is_empty());
        assert!(roots(&[Complex64::ZERO; 4]).is_empty());
    }
}
