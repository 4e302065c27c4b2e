//! Student's t for 95 % intervals.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use numeric::root::bracketed_root;

/// 97.5 % quantile of the standard normal distribution.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Above this many degrees of freedom the expansion is good to 1e-9.
const EXPAND_ABOVE: usize = 100;

/// The t with 95 % of Student's distribution between −t and t; the normal quantile for `None`, a variance that is known.
///
/// ```text
///              t = √ν·tan θ:   A(θ|ν) = 2/π·[ θ + sin θ·( cos θ + 2/3 cos³θ + … + 2·4…(ν−3)/(3·5…(ν−2)) cos^(ν−2)θ ) ]    ν odd
/// A(θ|ν) = 0.95                A(θ|ν) = sin θ·[ 1 + 1/2 cos²θ + … + 1·3…(ν−3)/(2·4…(ν−2)) cos^(ν−2)θ ]                     ν even
/// ```
///
/// # Limits     ν → ∞ gives 1.95996; ν = 1 gives tan(0.475·π)
/// # Source     Abramowitz and Stegun, 26.7.3–4, solved for t; above ν = 100 their expansion 26.7.5.
pub fn t_quantile_95(degrees_of_freedom: Option<usize>) -> f64 {
    match degrees_of_freedom {
        None => NORMAL,
        Some(0) => f64::INFINITY,
        Some(count) if count > EXPAND_ABOVE => expansion(count as f64),
        Some(count) => {
            let angle = bracketed_root(0.0, FRAC_PI_2, |angle| probability(angle, count) - 0.95).unwrap_or(FRAC_PI_2);
            (count as f64).sqrt() * angle.tan()
        }
    }
}

/// A(θ|ν).
fn probability(angle: f64, count: usize) -> f64 {
    let (sin, cos) = angle.sin_cos();
    let square = cos * cos;
    if count == 1 {
        return FRAC_2_PI * angle;
    }
    let odd = count % 2 == 1;
    let (mut term, mut sum) = if odd { (cos, cos) } else { (1.0, 1.0) };
    let mut numerator = if odd { 2 } else { 1 };
    while numerator + 2 < count {
        term *= square * numerator as f64 / (numerator + 1) as f64;
        sum += term;
        numerator += 2;
    }
    if odd { FRAC_2_PI * (angle + sin * sum) } else { sin * sum }
}

/// Abramowitz and Stegun, 26.7.5.
fn expansion(count: f64) -> f64 {
    let x = NORMAL;
    let power = |exponent: i32| x.powi(exponent);
    let terms = [
        (power(3) + x) / 4.0,
        (5.0 * power(5) + 16.0 * power(3) + 3.0 * x) / 96.0,
        (3.0 * power(7) + 19.0 * power(5) + 17.0 * power(3) - 15.0 * x) / 384.0,
        (79.0 * power(9) + 776.0 * power(7) + 1482.0 * power(5) - 1920.0 * power(3) - 945.0 * x) / 92_160.0,
    ];
    terms.into_iter().rev().fold(0.0, |sum, term| (sum + term) / count) + x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_table() {
        for (count, t) in [
            (1, 12.706_204_736),
            (2, 4.302_652_730),
            (3, 3.182_446_305),
            (4, 2.776_445_105),
            (5, 2.570_581_836),
            (10, 2.228_138_852),
            (29, 2.045_229_642),
            (30, 2.042_272_456),
            (60, 2.000_297_822),
            (100, 1.983_971_519),
            (120, 1.979_930_405),
            (1000, 1.962_339_081),
        ] {
            assert!((t_quantile_95(Some(count)) - t).abs() < 1e-8 * t, "{count}: {}", t_quantile_95(Some(count)));
        }
        assert_eq!(t_quantile_95(Some(0)), f64::INFINITY);
    }

    #[test]
    fn limit_closed_forms_and_the_two_branches_meet() {
        assert!((t_quantile_95(Some(1)) / (0.475 * std::f64::consts::PI).tan() - 1.0).abs() < 1e-13);
        assert!((t_quantile_95(Some(2)) / (0.95 * (2.0_f64 / (1.0 - 0.95 * 0.95)).sqrt()) - 1.0).abs() < 1e-13);
        let (sum, expanded) = (t_quantile_95(Some(EXPAND_ABOVE)), expansion(EXPAND_ABOVE as f64));
        assert!((sum - expanded).abs() < 1e-9);
        assert!((t_quantile_95(Some(100_000_000)) - t_quantile_95(None)).abs() < 1e-7);
        let all: Vec<f64> = (1..300).map(|count| t_quantile_95(Some(count))).collect();
        assert!(all.windows(2).all(|pair| pair[0] > pair[1]));
    }
}
