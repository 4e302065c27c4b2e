//! A bracketed root to the last bit.

/// The root of a continuous function whose values at the two ends differ in sign; `None` if they do not.
///
/// Inverse quadratic interpolation where three points promise it, bisection elsewhere; ends when the bracket is as narrow
/// as the numbers allow. Infinite values at the ends are allowed.
///
/// # Source  Chandrupatla, «A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function without
/// using derivatives», Advances in Engineering Software 28 (1997) 145–149.
pub(super) fn bracketed_root(lower: f64, upper: f64, mut function: impl FnMut(f64) -> f64) -> Option<f64> {
    // b is the newest point, a the other end of the bracket, c the point a or b replaced.
    let (mut b, mut a) = (lower, upper);
    let (mut fb, mut fa) = (function(b), function(a));
    if fb == 0.0 {
        return Some(b);
    }
    if fa == 0.0 {
        return Some(a);
    }
    if fa.is_nan() || fb.is_nan() || (fa > 0.0) == (fb > 0.0) {
        return None;
    }
    let mut fraction = 0.5;
    for _ in 0..200 {
        let x = b + fraction * (a - b);
        let fx = function(x);
        if fx.is_nan() {
            return None;
        }
        let (c, fc);
        if (fx > 0.0) == (fb > 0.0) {
            (c, fc) = (b, fb);
        } else {
            (c, fc) = (a, fa);
            (a, fa) = (b, fb);
        }
        (b, fb) = (x, fx);
        let best = if fb.abs() < fa.abs() { b } else { a };
        let width = (a - b).abs();
        let tolerance = 0.5 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE;
        if fx == 0.0 || width <= 2.0 * tolerance {
            return Some(best);
        }
        let least = tolerance / width;
        // Where is b between a and c, and where is its value? Quadratic only if the inverse function is monotone there.
        let (xi, phi) = ((b - a) / (c - a), (fb - fa) / (fc - fa));
        fraction = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fb / (fa - fb) * fc / (fa - fc) + (c - b) / (a - b) * fb / (fc - fb) * fa / (fc - fa)
        } else {
            0.5
        };
        fraction = if fraction.is_finite() { fraction.clamp(least, 1.0 - least) } else { 0.5 };
    }
    Some(if fb.abs() < fa.abs() { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_known_roots_to_the_last_bits() {
        let cubic = bracketed_root(0.0, 2.0, |x| x * x * x - 2.0).unwrap();
        assert!((cubic / 2.0_f64.cbrt() - 1.0).abs() < 4.0 * f64::EPSILON);
        let steep = bracketed_root(-1e3, 700.0, |x: f64| x.exp() - 3.0).unwrap();
        assert!((steep / 3.0_f64.ln() - 1.0).abs() < 4.0 * f64::EPSILON);
        let flat = bracketed_root(0.0, 1.0, |x: f64| (x - 0.3).powi(9)).unwrap();
        assert!((flat - 0.3).abs() < 1e-12);
    }

    #[test]
    fn limit_ends_and_no_sign_change() {
        assert_eq!(bracketed_root(0.0, 1.0, |x| x), Some(0.0));
        assert_eq!(bracketed_root(0.0, 1.0, |x| x - 1.0), Some(1.0));
        assert_eq!(bracketed_root(0.0, 1.0, |x| x + 1.0), None);
        assert_eq!(bracketed_root(0.0, 1.0, |_| f64::NAN), None);
        let pole = bracketed_root(0.0, 1.0, |x: f64| x.ln() + 1.0).unwrap();
        assert!((pole - (-1.0_f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn regress_effort_stays_small() {
        let mut calls = 0;
        bracketed_root(0.0, 50.0, |x: f64| {
            calls += 1;
            x.exp() - 20.0
        });
        assert!(calls < 25, "{calls}");
    }
}
