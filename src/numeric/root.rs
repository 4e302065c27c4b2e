//! Roots of a function inside a bracket.

/// A bracket [`lower`, `upper`] whose function values have opposite signs.
#[derive(Debug, Clone, Copy)]
pub struct Bracket {
    /// Left end and the function there.
    pub lower: (f64, f64),
    /// Right end and the function there.
    pub upper: (f64, f64),
}

/// Shrinks a bracket until its width is at most `relative_width` of its upper end, and returns the midpoint.
///
/// Regula falsi with the Illinois rule, and bisection whenever a step fails to halve the bracket. The worst
/// case therefore takes twice the steps of bisection. Infinite values are allowed.
///
/// # Source  Dowell and Jarratt, "A modified regula falsi method", BIT 11 (1971) 168–174.
pub fn refine(bracket: Bracket, relative_width: f64, mut function: impl FnMut(f64) -> f64) -> f64 {
    let (mut a, mut fa) = bracket.lower;
    let (mut b, mut fb) = bracket.upper;
    let mut kept_lower = 0_i8;
    let mut last_width = b - a;
    let mut bisect = false;
    for _ in 0..400 {
        let width = b - a;
        if width <= relative_width * b.abs() {
            break;
        }
        let secant = b - fb * (b - a) / (fb - fa);
        let x = if bisect || !(secant > a && secant < b) {
            0.5 * (a + b)
        } else {
            // A small step beyond the estimate moves the other end, too, once the estimate is exact.
            let margin = 0.25 * relative_width * b.abs();
            secant.clamp(a + margin, b - margin)
        };
        if x <= a || x >= b {
            break;
        }
        let fx = function(x);
        if fx == 0.0 {
            return x;
        }
        if fx.is_sign_positive() == fa.is_sign_positive() {
            a = x;
            fa = fx;
            if kept_lower == 1 {
                fb *= 0.5;
            }
            kept_lower = 1;
        } else {
            b = x;
            fb = fx;
            if kept_lower == -1 {
                fa *= 0.5;
            }
            kept_lower = -1;
        }
        bisect = (b - a) > 0.5 * last_width;
        last_width = b - a;
    }
    0.5 * (a + b)
}

/// Returns the root of a continuous function whose values at the two ends differ in sign, to machine
/// precision; `None` if they do not differ. Infinite values at the ends are allowed.
pub fn bracketed_root(lower: f64, upper: f64, mut function: impl FnMut(f64) -> f64) -> Option<f64> {
    let (at_lower, at_upper) = (function(lower), function(upper));
    if at_lower == 0.0 {
        return Some(lower);
    }
    if at_upper == 0.0 {
        return Some(upper);
    }
    let differ = !at_lower.is_nan() && !at_upper.is_nan() && (at_lower > 0.0) != (at_upper > 0.0);
    differ.then(|| {
        refine(Bracket { lower: (lower, at_lower), upper: (upper, at_upper) }, f64::EPSILON, function)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bracket(f: fn(f64) -> f64, a: f64, b: f64) -> Bracket {
        Bracket { lower: (a, f(a)), upper: (b, f(b)) }
    }

    #[test]
    fn limit_root_of_a_cubic() {
        let f = |x: f64| x * x * x - 2.0;
        let root = refine(bracket(f, 0.0, 2.0), 1e-13, f);
        assert!((root - 2.0_f64.cbrt()).abs() < 1e-12, "{root}");
    }

    #[test]
    fn steep_functions_stay_inside_and_are_cheap() {
        let f = |x: f64| (x - 0.3).signum() * (x - 0.3).abs().powf(0.1);
        let mut calls = 0;
        let root = refine(bracket(f, 0.0, 1.0), 1e-12, |x| {
            calls += 1;
            f(x)
        });
        assert!((root - 0.3).abs() < 1e-11, "{root}");
        assert!(calls < 100, "{calls}");
    }

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
        // Twice a bisection would be 2·53.
        assert!(calls < 60, "{calls}");
    }
}
