//! Probability distributions for intervals and p-values.

use statrs::distribution::{Beta, ContinuousCDF, StudentsT};

/// 97.5 % quantile of the standard normal distribution.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Number of degrees of freedom above which the expansion is used. There it is accurate to 1e-13, while the
/// quantile search of `statrs` is inaccurate or fails.
const EXPAND_ABOVE: usize = 1000;

/// Computes the share of the standard normal distribution above a value.
pub fn normal_upper_tail(value: f64) -> f64 {
    0.5 * libm::erfc(value / std::f64::consts::SQRT_2)
}

/// Computes the t with 95 % of Student's distribution between −t and t; `None` stands for a known variance
/// and gives the normal quantile.
///
/// # Limits     ν → ∞ gives 1.95996; ν = 1 gives tan(0.475·π)
/// # Source     above ν = 1000 the expansion of Abramowitz and Stegun, 26.7.5.
pub fn t_quantile_95(degrees_of_freedom: Option<usize>) -> f64 {
    match degrees_of_freedom {
        None => NORMAL,
        Some(count) if count > EXPAND_ABOVE => expansion(count as f64),
        Some(count) => t_quantile(0.975, count),
    }
}

/// Computes the quantile of Student's distribution for a probability above ½, for up to 1000 degrees of
/// freedom.
///
/// # Limits     ∞ for 0 degrees of freedom, where the distribution does not exist
pub fn t_quantile(probability: f64, degrees_of_freedom: usize) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom as f64)
        .map_or(f64::INFINITY, |student| student.inverse_cdf(probability))
}

/// Computes the p-value of a Monte Carlo test, (1 + b)/(1 + m): b of m draws from the null distribution are
/// at least as extreme as the data.
///
/// # Source  Davison and Hinkley, Bootstrap Methods and their Application (1997), equation 4.11.
pub fn monte_carlo_p_value(at_least_as_extreme: usize, draws: usize) -> f64 {
    (1 + at_least_as_extreme) as f64 / (1 + draws) as f64
}

/// Computes the expansion of Abramowitz and Stegun, 26.7.5.
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

/// Computes the exact interval of a proportion after Clopper and Pearson, for `count` successes in `of`
/// trials; `None` without trials.
///
/// Each end leaves half of 1 − `confidence` in one tail of the binomial distribution; the ends are quantiles
/// of Beta distributions.
pub fn clopper_pearson(count: usize, of: usize, confidence: f64) -> Option<[f64; 2]> {
    if of == 0 || count > of {
        return None;
    }
    let tail = 0.5 * (1.0 - confidence);
    let (successes, failures) = (count as f64, (of - count) as f64);
    let lower = if count == 0 { 0.0 } else { Beta::new(successes, failures + 1.0).ok()?.inverse_cdf(tail) };
    let upper =
        if count == of { 1.0 } else { Beta::new(successes + 1.0, failures).ok()?.inverse_cdf(1.0 - tail) };
    Some([lower, upper])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_table_of_student() {
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
            assert!(
                (t_quantile_95(Some(count)) - t).abs() < 1e-8 * t,
                "{count}: {}",
                t_quantile_95(Some(count))
            );
        }
        assert_eq!(t_quantile_95(Some(0)), f64::INFINITY);
        for (count, t) in [
            (1, 3.077_683_537),
            (2, 1.885_618_083),
            (4, 1.533_206_274),
            (11, 1.363_430_318),
            (30, 1.310_415_025),
        ] {
            assert!((t_quantile(0.9, count) - t).abs() < 1e-8 * t, "{count}: {}", t_quantile(0.9, count));
        }
    }

    /// No statistic is rarer than one in all draws and itself.
    #[test]
    fn limit_a_p_value_counts_the_data_among_the_draws() {
        assert_eq!(
            (monte_carlo_p_value(0, 999), monte_carlo_p_value(999, 999), monte_carlo_p_value(0, 0)),
            (0.001, 1.0, 1.0)
        );
    }

    #[test]
    fn limit_closed_forms_and_the_two_branches_meet() {
        assert!((t_quantile_95(Some(1)) / (0.475 * std::f64::consts::PI).tan() - 1.0).abs() < 1e-10);
        assert!(
            (t_quantile_95(Some(2)) / (0.95 * (2.0_f64 / (1.0 - 0.95 * 0.95)).sqrt()) - 1.0).abs() < 1e-10
        );
        let (student, expanded) = (t_quantile_95(Some(EXPAND_ABOVE)), expansion(EXPAND_ABOVE as f64));
        assert!((student - expanded).abs() < 1e-9, "{student} {expanded}");
        assert!((t_quantile_95(Some(100_000_000)) - t_quantile_95(None)).abs() < 1e-7);
        let all: Vec<f64> = (1..1200).map(|count| t_quantile_95(Some(count))).collect();
        assert!(all.windows(2).all(|pair| pair[0] > pair[1]));
    }

    /// Values of standard tables, far into the tail.
    #[test]
    fn published_tail_of_the_normal_distribution() {
        for (value, share) in [
            (0.0, 0.5),
            (1.959_963_984_540_054, 0.025),
            (-1.0, 0.841_344_746_068_543),
            (6.0, 9.865_876_450_377e-10),
        ] {
            assert!(
                (normal_upper_tail(value) / share - 1.0).abs() < 1e-11,
                "{value}: {}",
                normal_upper_tail(value)
            );
        }
    }

    /// Closed forms of the ends, and entries of standard tables (10 of 20, 3 of 300).
    #[test]
    fn limit_exact_interval_of_a_proportion() {
        assert_eq!(clopper_pearson(0, 0, 0.95), None);
        let near = |found: Option<[f64; 2]>, low: f64, high: f64, tolerance: f64| {
            let [a, b] = found.unwrap();
            assert!((a - low).abs() < tolerance && (b - high).abs() < tolerance, "{a} … {b}");
        };
        near(clopper_pearson(0, 30, 0.95), 0.0, 1.0 - 0.025_f64.powf(1.0 / 30.0), 1e-12);
        near(clopper_pearson(30, 30, 0.95), 0.025_f64.powf(1.0 / 30.0), 1.0, 1e-12);
        near(clopper_pearson(10, 20, 0.95), 0.2720, 0.7280, 5e-5);
        near(clopper_pearson(3, 300, 0.95), 0.0021, 0.0289, 5e-5);
        near(clopper_pearson(600, 1300, 0.95), 0.4341, 0.4891, 5e-4);
    }
}
