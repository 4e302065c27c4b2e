//! Pairing of predicted peaks with measured modes, either of which may lack a partner.

/// Relative frequency error assigned to a mode without a partner (1).
pub const MISSING: f64 = 0.3;
/// Least prominence (1) at which a predicted peak should be visible, for measurements that do not state it.
pub const VISIBLE: f64 = 2.0;

/// One row of an alignment: a measured mode, a predicted peak, or both (by index).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModePair {
    /// Index of the measured mode.
    pub measured: Option<usize>,
    /// Index of the predicted peak.
    pub predicted: Option<usize>,
}

/// Pairs two rising lists of frequencies with the least sum of squares, in order, so that no two pairs cross.
///
/// The terms are the relative frequency error of a pair, [`MISSING`] for a measured mode without a partner, and `alone[j]` for the
/// predicted peak j without a partner. `least` is working memory.
pub(super) fn pair_into(measured_hz: &[f64], predicted_hz: &[f64], alone: &[f64], least: &mut Vec<f64>, pairs: &mut Vec<ModePair>) {
    let (m, n) = (measured_hz.len(), predicted_hz.len());
    // least[i][j]: least sum over the first i measured and the first j predicted.
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
                best = best.min(least[(i - 1) * width + j] + MISSING * MISSING);
            }
            if j > 0 {
                best = best.min(least[i * width + j - 1] + alone[j - 1] * alone[j - 1]);
            }
            if i > 0 && j > 0 {
                let error = predicted_hz[j - 1] / measured_hz[i - 1] - 1.0;
                best = best.min(least[(i - 1) * width + j - 1] + error * error);
            }
            least[i * width + j] = best;
        }
    }
    let (mut i, mut j) = (m, n);
    pairs.clear();
    while i > 0 || j > 0 {
        let here = least[i * width + j];
        if i > 0 && j > 0 {
            let error = predicted_hz[j - 1] / measured_hz[i - 1] - 1.0;
            if least[(i - 1) * width + j - 1] + error * error <= here {
                pairs.push(ModePair { measured: Some(i - 1), predicted: Some(j - 1) });
                i -= 1;
                j -= 1;
                continue;
            }
        }
        if i > 0 && least[(i - 1) * width + j] + MISSING * MISSING <= here {
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
        let mut pairs = Vec::new();
        pair_into(measured_hz, predicted_hz, alone, &mut Vec::new(), &mut pairs);
        pairs
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
