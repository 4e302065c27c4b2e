//! Pairing of predicted peaks with measured modes, either of which may lack a partner.

use dynamics::model::Peak;
use measurement::ModeObservation;

/// Relative frequency error assigned to a mode without a partner (1).
pub const MISSING: f64 = 0.3;
/// Least prominence (1) at which a predicted peak should be visible, for measurements that do not state it.
pub const VISIBLE: f64 = 2.0;

/// Where the band of the measured frequencies ends for a peak that should be visible, relative to its lowest
/// and highest.
const BAND_ENDS: (f64, f64) = (0.9, 1.1);
/// Half width of the ramp of visibility at the ends of the band (1).
const END_RAMP: f64 = 0.05;
/// Excess of prominence over 1, in factors of two of that of the least prominent peak read, at which a
/// predicted peak is half a partner of a measured mode.
const HALF_PRESENT: f64 = -3.0;

/// A predicted peak to pair with measured modes.
///
/// Both shares are ramps: a cliff would let costs jump where a peak grows or goes, and fits hide just below
/// it. A jump remains where a ripple is born on the flank of a peak, whose prominence then counts from the
/// new valley.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictedPeak {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// How far (0 to 1) it should be seen: ½ at the least prominence of a peak that was read, 0 where it
    /// stands out half as much, 1 at twice as much.
    pub visibility: f64,
    /// How far (0 to 1) it can be a mode that was read: 0 where it stands out a sixteenth as much, 1 at a
    /// quarter.
    pub presence: f64,
}

impl PredictedPeak {
    /// Returns the derivatives of visibility and of presence with ln(prominence) and ln(frequency).
    pub fn slopes(
        prominence: f64,
        frequency_hz: f64,
        least_prominence: f64,
        band_hz: (f64, f64),
    ) -> [[f64; 2]; 2] {
        let octaves = ((prominence - 1.0) / (least_prominence - 1.0)).log2();
        let by_prominence = prominence / ((prominence - 1.0) * std::f64::consts::LN_2);
        let [low, high] = [frequency_hz / (BAND_ENDS.0 * band_hz.0), BAND_ENDS.1 * band_hz.1 / frequency_hz];
        let [at_low, at_high] = [low, high].map(|ratio| (ratio - 1.0) / END_RAMP);
        let ends = smooth_step(at_low) * smooth_step(at_high);
        let by_ends = (step_slope(at_low) * low * smooth_step(at_high)
            - smooth_step(at_low) * step_slope(at_high) * high)
            / END_RAMP;
        [
            [step_slope(octaves) * by_prominence * ends, smooth_step(octaves) * by_ends],
            [step_slope(octaves - HALF_PRESENT) * by_prominence, 0.0],
        ]
    }

    /// Judges a peak by its prominence (1) and frequency (Hz); `least_prominence` and `band_hz` are those of
    /// the measurement.
    pub fn new(prominence: f64, frequency_hz: f64, least_prominence: f64, band_hz: (f64, f64)) -> Self {
        let excess = (prominence - 1.0) / (least_prominence - 1.0);
        let octaves = if excess > 0.0 { excess.log2() } else { f64::NEG_INFINITY };
        let inside = |ratio: f64| smooth_step((ratio - 1.0) / END_RAMP);
        let ends =
            inside(frequency_hz / (BAND_ENDS.0 * band_hz.0)) * inside(BAND_ENDS.1 * band_hz.1 / frequency_hz);
        PredictedPeak {
            frequency_hz,
            visibility: smooth_step(octaves) * ends,
            presence: smooth_step(octaves - HALF_PRESENT),
        }
    }
}

/// Deviation of one mode order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The observation; `None` for a predicted peak without a partner.
    pub observed: Option<ModeObservation>,
    /// The predicted peak, with its amplitude in the measured quantity, without gain.
    pub predicted: Option<Peak>,
    /// How far (0 to 1) the predicted peak should be seen; of a pair, how far it can be the mode that was. 0
    /// without a predicted peak.
    pub visibility: f64,
}

impl Deviation {
    /// Returns the observation and the peak that is it: one that is present by half at least.
    pub fn pair(&self) -> Option<(ModeObservation, Peak)> {
        self.observed.zip(self.predicted).filter(|_| self.visibility >= 0.5)
    }

    /// Whether this is a peak without a partner that should have been seen.
    pub fn is_unexpected(&self) -> bool {
        self.observed.is_none() && self.visibility >= 0.5
    }

    /// How far (0 to 1) one side lacks the mode of the other.
    pub fn lacking(&self) -> f64 {
        if self.observed.is_some() { 1.0 - self.visibility } else { self.visibility }
    }
}

/// Rises smoothly from 0 at −1 over ½ at 0 to 1 at 1.
fn smooth_step(x: f64) -> f64 {
    let t = (0.5 * (x + 1.0)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the derivative of [`smooth_step`].
fn step_slope(x: f64) -> f64 {
    let t = (0.5 * (x + 1.0)).clamp(0.0, 1.0);
    3.0 * t * (1.0 - t)
}

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
/// The terms are the relative frequency error of a pair, as far as the peak is present, and [`MISSING`] as
/// far as it is not; [`MISSING`] for a measured mode without a partner; and the same for a predicted peak
/// without one, as far as it is visible. `sought` holds the frequency (Hz) of each order, or `None` for an
/// order about which this position states nothing: it takes a peak for nothing, which may have been there or
/// not. `least` is working memory.
pub(super) fn pair_into(
    sought: &[Option<f64>],
    predicted: &[PredictedPeak],
    least: &mut Vec<f64>,
    pairs: &mut Vec<ModePair>,
) {
    let missing = MISSING * MISSING;
    let with = |i: usize, j: usize| {
        let PredictedPeak { frequency_hz, presence, .. } = predicted[j];
        let error = |measured_hz: f64| (frequency_hz / measured_hz - 1.0).powi(2);
        sought[i].map_or(0.0, |measured_hz| match presence {
            // What is not there is no partner at any distance, though it would cost no more than none.
            0.0 => f64::INFINITY,
            _ => presence * error(measured_hz) + (1.0 - presence) * missing,
        })
    };
    let without = |i: usize| sought[i].map_or(0.0, |_| missing);
    let (m, n) = (sought.len(), predicted.len());
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
                best = best.min(least[i * width + j - 1] + missing * predicted[j - 1].visibility);
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

    /// Pairs with fully present peaks of given visibility.
    fn pair(measured_hz: &[f64], predicted_hz: &[f64], visibility: &[f64]) -> Vec<ModePair> {
        let sought: Vec<Option<f64>> = measured_hz.iter().map(|f| (*f > 0.0).then_some(*f)).collect();
        let peaks = predicted_hz.iter().zip(visibility);
        let peaks: Vec<_> = peaks
            .map(|(&frequency_hz, &visibility)| PredictedPeak { frequency_hz, visibility, presence: 1.0 })
            .collect();
        let mut pairs = Vec::new();
        pair_into(&sought, &peaks, &mut Vec::new(), &mut pairs);
        pairs
    }

    /// Neither ramp has a cliff: a small step changes it little. Visibility is ½ at the stated limit and at
    /// the ends of the band.
    #[test]
    fn visibility_and_presence_are_ramps() {
        let band_hz = (20.0, 500.0);
        for least in [1.25, 2.0, 4.0] {
            let at = |excess: f64| PredictedPeak::new(1.0 + excess * (least - 1.0), 100.0, least, band_hz);
            assert!((at(1.0).visibility - 0.5).abs() < 1e-12);
            assert_eq!([0.0, 0.499, 2.001].map(|excess| at(excess).visibility), [0.0, 0.0, 1.0]);
            assert_eq!([0.0, 0.0624, 0.2501].map(|excess| at(excess).presence), [0.0, 0.0, 1.0]);
            let steps: Vec<_> = (0..4000).map(|k| at(2.5 * f64::from(k) / 4000.0)).collect();
            assert!(
                steps
                    .windows(2)
                    .all(|w| w[1].visibility >= w[0].visibility && w[1].visibility - w[0].visibility < 0.01),
                "{least}"
            );
            assert!(
                steps
                    .windows(2)
                    .all(|w| w[1].presence >= w[0].presence && w[1].presence - w[0].presence < 0.01),
                "{least}"
            );
        }
        let at = |frequency_hz: f64| PredictedPeak::new(1e3, frequency_hz, 2.0, band_hz).visibility;
        assert_eq!([at(17.0), at(20.0), at(500.0), at(580.0)], [0.0, 1.0, 1.0, 0.0]);
        assert!((at(18.0) - 0.5).abs() < 1e-9 && (at(550.0) - 0.5).abs() < 1e-9);
    }

    /// A peak without a partner costs nothing where an order without a statement (0) may be it, and as much
    /// as elsewhere where none may.
    #[test]
    fn an_order_without_a_statement_takes_one_peak() {
        let pairs = pair(&[0.0, 402.0], &[90.0, 400.0], &[1.0; 2]);
        assert!(pairs.iter().all(|p| p.measured == p.predicted), "{pairs:?}");
        let pairs = pair(&[0.0, 402.0], &[90.0, 200.0, 400.0], &[1.0; 3]);
        assert_eq!(pairs.iter().filter(|p| p.measured.is_none()).count(), 1, "{pairs:?}");
        let pairs = pair(&[0.0, 402.0], &[400.0], &[1.0]);
        assert_eq!(pairs[1], ModePair { measured: Some(1), predicted: Some(0) });
    }

    #[test]
    fn a_missing_mode_does_not_shift_the_others() {
        let pairs = pair(&[24.0, 116.0, 717.0], &[23.7, 115.0, 596.0, 720.0], &[1.0, 1.0, 0.0, 1.0]);
        let partners: Vec<_> = pairs.iter().filter_map(|p| Some((p.measured?, p.predicted?))).collect();
        assert_eq!(partners, [(0, 0), (1, 1), (2, 3)]);
    }

    #[test]
    fn an_extra_mode_does_not_shift_the_others() {
        let pairs = pair(&[109.0, 532.0], &[24.0, 110.0, 530.0], &[1.0; 3]);
        let partners: Vec<_> = pairs.iter().filter_map(|p| Some((p.measured?, p.predicted?))).collect();
        assert_eq!(partners, [(0, 1), (1, 2)]);
    }

    #[test]
    fn distant_modes_are_not_paired() {
        let pairs = pair(&[24.0], &[109.0], &[1.0]);
        assert!(pairs.iter().all(|p| p.measured.is_none() || p.predicted.is_none()), "{pairs:?}");
        assert_eq!(pairs.len(), 2);
    }

    /// A peak that is not there is no partner, however near.
    #[test]
    fn an_absent_peak_is_not_paired() {
        for frequency_hz in [24.0, 600.0] {
            let absent = PredictedPeak { frequency_hz, visibility: 0.0, presence: 0.0 };
            let mut pairs = Vec::new();
            pair_into(&[Some(24.0)], &[absent], &mut Vec::new(), &mut pairs);
            assert!(pairs.iter().all(|p| p.measured.is_none() || p.predicted.is_none()), "{pairs:?}");
        }
    }

    #[test]
    fn empty_lists_have_no_pairs() {
        assert!(pair(&[], &[], &[]).is_empty());
    }
}
