//! Small statistics.

/// Computes the root mean square; `None` without values.
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(s, n), v| (s + v * v, n + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// Computes the root mean square of groups, each given by its root mean square and its number of values;
/// `None` without values.
pub fn root_mean_square_of_parts(parts: impl IntoIterator<Item = (f64, usize)>) -> Option<f64> {
    let (square, count) =
        parts.into_iter().fold((0.0, 0), |(s, n), (rms, lines)| (s + rms * rms * lines as f64, n + lines));
    (count > 0).then(|| (square / count as f64).sqrt())
}

/// Computes the root of the sum of squares; `None` without values.
pub fn root_sum_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(s, n), v| (s + v * v, n + 1));
    (count > 0).then_some(sum.sqrt())
}

/// Returns minimum and maximum; ∞ and −∞ without values.
pub fn extremes<'v>(values: impl IntoIterator<Item = &'v f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
}

/// Computes ln Σ eˣ without overflow.
pub fn log_sum_exp(values: &[f64]) -> f64 {
    let largest = extremes(values).1;
    largest + values.iter().map(|x| (x - largest).exp()).sum::<f64>().ln()
}

/// Computes the median; `None` without values. NaN counts as largest.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// Computes a quantile by linear interpolation between order statistics; `None` without values.
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let low = at.floor() as usize;
    let high = at.ceil() as usize;
    Some(sorted[low] + (at - low as f64) * (sorted[high] - sorted[low]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_sets_have_no_statistics() {
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
}
