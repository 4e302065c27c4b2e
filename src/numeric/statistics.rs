//! Small statistics.

/// Root of the mean of the squares; `None` for nothing.
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(s, n), v| (s + v * v, n + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// Root mean square of parts, each with the number of values it stands for; `None` for nothing.
pub fn root_mean_square_of_parts(parts: impl IntoIterator<Item = (f64, usize)>) -> Option<f64> {
    let (square, count) = parts.into_iter().fold((0.0, 0), |(s, n), (rms, lines)| (s + rms * rms * lines as f64, n + lines));
    (count > 0).then(|| (square / count as f64).sqrt())
}

/// Root of the summed squares; `None` for nothing.
pub fn root_sum_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(s, n), v| (s + v * v, n + 1));
    (count > 0).then_some(sum.sqrt())
}

/// Least and largest; ∞ and −∞ for nothing.
pub fn extremes<'v>(values: impl IntoIterator<Item = &'v f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
}

/// Median; `None` for nothing. NaN counts as largest.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// Quantile by linear interpolation between order statistics; `None` for nothing.
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let low = at.floor() as usize;
    let high = at.ceil() as usize;
    Some(sorted[low] + (at - low as f64) * (sorted[high] - sorted[low]))
}

/// Exact interval of a proportion after Clopper and Pearson: `of` trials, `count` of them counted; `None` for no trials.
///
/// Each end leaves half of what `confidence` spares in one tail of the binomial law.
pub fn clopper_pearson(count: usize, of: usize, confidence: f64) -> Option<[f64; 2]> {
    if of == 0 || count > of {
        return None;
    }
    let spared = 0.5 * (1.0 - confidence);
    // P(X ≥ count) rises with the share, P(X ≤ count) falls.
    let lower = if count == 0 { 0.0 } else { crossing(|share| binomial_tail(count, of, share) < spared) };
    let upper = if count == of { 1.0 } else { crossing(|share| 1.0 - binomial_tail(count + 1, of, share) > spared) };
    Some([lower, upper])
}

/// P(X ≥ count) of a binomial law.
fn binomial_tail(count: usize, of: usize, share: f64) -> f64 {
    let (yes, no) = (share.ln(), (-share).ln_1p());
    let mut ways = 0.0;
    let mut sum = 0.0;
    for k in 0..=of {
        if k > 0 {
            ways += ((of - k + 1) as f64 / k as f64).ln();
        }
        if k >= count {
            sum += (ways + k as f64 * yes + (of - k) as f64 * no).exp();
        }
    }
    sum.min(1.0)
}

/// Where a condition that holds near 0 ceases to hold, within (0, 1).
fn crossing(below: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_statistics() {
        assert_eq!(root_mean_square([]), None);
        assert_eq!(root_sum_square([]), None);
        assert_eq!(median([]), None);
    }

    #[test]
    fn limit_small_sets() {
        assert_eq!(root_mean_square([3.0, 4.0]), Some(12.5_f64.sqrt()));
        assert_eq!(root_sum_square([3.0, 4.0]), Some(5.0));
        assert_eq!(median([3.0, 1.0, 2.0, 10.0]), Some(2.5));
        assert_eq!(quantile([0.0, 10.0], 0.25), Some(2.5));
    }

    /// Closed forms of the ends, and two entries of the usual tables (10 of 20, 3 of 300).
    #[test]
    fn limit_exact_interval_of_a_proportion() {
        assert_eq!(clopper_pearson(0, 0, 0.95), None);
        let near = |found: Option<[f64; 2]>, low: f64, high: f64| {
            let [a, b] = found.unwrap();
            assert!((a - low).abs() < 5e-5 && (b - high).abs() < 5e-5, "{a} … {b}");
        };
        near(clopper_pearson(0, 30, 0.95), 0.0, 1.0 - 0.025_f64.powf(1.0 / 30.0));
        near(clopper_pearson(30, 30, 0.95), 0.025_f64.powf(1.0 / 30.0), 1.0);
        near(clopper_pearson(10, 20, 0.95), 0.2720, 0.7280);
        near(clopper_pearson(3, 300, 0.95), 0.0021, 0.0289);
        let [low, high] = clopper_pearson(600, 1300, 0.95).unwrap();
        assert!((low - 0.4341).abs() < 5e-4 && (high - 0.4891).abs() < 5e-4, "{low} … {high}");
    }
}
