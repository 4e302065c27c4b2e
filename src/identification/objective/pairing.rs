//! Pairing of predicted peaks with measured modes, either of which may lack a partner.

/// Relative frequency error assigned to a mode without a partner (1).
pub const MISSING: f64 = 0.3;
/// Least prominence (1) at which a predicted peak should be visible, for measurements that do not state it.
pub const VISIBLE: f64 = 2.0;

/// One row of an alignment: an order sought, a predicted peak, or both (by index).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModePair {
    /// Index of the order sought.
    pub measured: Option<usize>,
    /// Index of the predicted peak.
    pub predicted: Option<usize>,
}

/// Pairs two rising lists of modes with the least sum of squares, in order, so that no two pairs cross.
///
/// The terms are the relative frequency error of a pair, [`MISSING`] for a measured mode without a partner, and `alone[j]` for the predicted peak j
/// without a partner. `sought` holds the frequency (Hz) of each order, or `None` for an order about which this position states nothing: it takes a
/// peak for nothing, which may have been there or not. `least` is working memory.
pub(super) fn pair_into(sought: &[Option<f64>], predicted_hz: &[f64], alone: &[f64], least: &mut Vec<f64>, pairs: &mut Vec<ModePair>) {
    let with = |i: usize, j: usize| sought[i].map_or(0.0, |measured_hz| (predicted_hz[j] / measured_hz - 1.0).powi(2));
    let without = |i: usize| sought[i].map_or(0.0, |_| MISSING * MISSING);
    let (m, n) = (sought.len(), predicted_hz.len());
    // least[i][j]: least sum over the first i sought and the first j predicted.
    let width = n + 1;
    least.clear();
    least.resize((m + 1) * width, 0.0);
    for i in 0..=m {
        for j in 0..=n {
            if i == 0 && j == 0 {
                continue;
            }
            let mut best = f64::INFINITY;
            if i > 0 {
                best = best.min(least[(i - 1) * width + j] + without(i - 1));
            }
            if j > 0 {
                best = best.min(least[i * width + j - 1] + alone[j - 1] * alone[j - 1]);
            }
            if i > 0 && j > 0 {
                best = best.min(least[(i - 1) * width + j - 1] + with(i - 1, j - 1));
            }
            least[i * width + j] = best;
        }
    }
    let (mut i, mut j) = (m, n);
    pairs.clear();
    while i > 0 || j > 0 {
        let here = least[i * width + j];
        if i > 0 && j > 0 && least[(i - 1) * width + j - 1] + with(i - 1, j - 1) <= here {
            pairs.push(ModePair { measured: Some(i - 1), predicted: Some(j - 1) });
            i -= 1;
            j -= 1;
        } else if i > 0 && least[(i - 1) * width + j] + without(i - 1) <= here {
            pairs.push(ModePair { measured: Some(i - 1), predicted: None });
            i -= 1;
        } else {
            pairs.push(ModePair { measured: None, predicted: Some(j - 1) });
            j -= 1;
        }
    }
    pairs.reverse();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(measured_hz: &[f64], predicted_hz: &[f64], alone: &[f64]) -> Vec<ModePair> {
        let sought: Vec<Option<f64>> = measured_hz.iter().map(|f| (*f > 0.0).then_some(*f)).collect();
        let mut pairs = Vec::new();
        pair_into(&sought, predicted_hz, alone, &mut Vec::new(), &mut pairs);
        pairs
    }

    /// A peak without a partner costs nothing where an order without a statement (0) may be it, and as much as elsewhere where none may.
    #[test]
    fn an_order_without_a_statement_takes_one_peak() {
        let pairs = pair(&[0.0, 402.0], &[90.0, 400.0], &[MISSING; 2]);
        assert!(pairs.iter().all(|p| p.measured == p.predicted), "{pairs:?}");
        let pairs = pair(&[0.0, 402.0], &[90.0, 200.0, 400.0], &[MISSING; 3]);
        assert_eq!(pairs.iter().filter(|p| p.measured.is_none()).count(), 1, "{pairs:?}");
        let pairs = pair(&[0.0, 402.0], &[400.0], &[MISSING]);
        assert_eq!(pairs[1], ModePair { measured: Some(1), predicted: Some(0) });
    }

    #[test]
    fn a_missing_mode_does_not_shift_the_others() {
        let pairs = pair(&[24.0, 116.0, 717.0], &[23.7, 115.0, 596.0, 720.0], &[MISSING, MISSING, 0.0, MISSING]);
        let partners: Vec<_> = pairs.iter().filter_map(|p| Some((p.measured?, p.predicted?))).collect();
        assert_eq!(partners, [(0, 0), (1, 1), (2, 3)]);
    }

    #[test]
    fn an_extra_mode_does_not_shift_the_others() {
        let pairs = pair(&[109.0, 532.0], &[24.0, 110.0, 530.0], &[MISSING; 3]);
        let partners: Vec<_> = pairs.iter().filter_map(|p| Some((p.measured?, p.predicted?))).collect();
        assert_eq!(partners, [(0, 1), (1, 2)]);
    }

    #[test]
    fn distant_modes_are_not_paired() {
        let pairs = pair(&[24.0], &[109.0], &[MISSING]);
        assert!(pairs.iter().all(|p| p.measured.is_none() || p.predicted.is_none()), "{pairs:?}");
        assert_eq!(pairs.len(), 2);
    }

    #[test]
    fn empty_lists_have_no_pairs() {
        assert!(pair(&[], &[], &[]).is_empty());
    }
}
