//! Peaks that a model predicts and the measurement lacks: how unlikely their absence is.

use super::mode_settings::ModeSettings;
use super::pairing::MISSING;
use dynamics::model::Peak;
use numeric::distribution::normal_upper_tail;

/// Share of the lowest and of the highest measured frequency by which the band in which peaks are expected is wider (1).
const MARGIN: f64 = 0.1;

/// Prominence and frequency at which a predicted peak should have been measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Visibility {
    least_prominence: f64,
    /// Standard deviation of ln(prominence) (1).
    prominence_sd: f64,
    /// Relative standard deviation of a frequency (1).
    frequency_sd: f64,
    /// Band in which peaks are expected (Hz).
    band_hz: (f64, f64),
    /// Largest χ² of a peak: that of a missing mode.
    most: f64,
}

impl Visibility {
    /// Returns the visibility of peaks in a set whose read peaks have a least prominence and lie in a band (Hz).
    ///
    /// Prominence is a ratio of two amplitudes, each with the standard deviation of an amplitude: √2 of it together.
    pub(super) fn new(settings: ModeSettings, least_prominence: f64, band_hz: (f64, f64)) -> Self {
        let frequency_sd = settings.frequency_sd(0.0, 1.0);
        Visibility {
            least_prominence,
            prominence_sd: std::f64::consts::SQRT_2 * settings.amplitude_sd.max(1e-6),
            frequency_sd,
            band_hz: ((1.0 - MARGIN) * band_hz.0, (1.0 + MARGIN) * band_hz.1),
            most: (MISSING / frequency_sd).powi(2),
        }
    }

    /// Whether the measurement should show a predicted peak: it is more likely than not prominent enough and in the band.
    pub(super) fn is_expected(&self, peak: &Peak) -> bool {
        peak.prominence >= self.least_prominence && (self.band_hz.0..=self.band_hz.1).contains(&peak.frequency_hz)
    }

    /// Computes the χ² of a predicted peak that was not measured: −2 ln of the probability that it is too flat or outside the band, at most that
    /// of a missing mode.
    ///
    /// It rises smoothly with the prominence, from 0 at a prominence of 1, where the peak vanishes, through 1.4 or less at the least prominence of
    /// a read peak to the square of the distance from it in standard deviations.
    ///
    /// # Source  likelihood of a censored observation; Tobin, Econometrica 26 (1958) 24–36.
    pub(super) fn absence(&self, peak: &Peak) -> f64 {
        let flat = |prominence: f64| normal_upper_tail((prominence / self.least_prominence).ln() / self.prominence_sd);
        let outside = |distance: f64| normal_upper_tail(distance / self.frequency_sd);
        // The probability of being too flat is that among existing peaks: 1 at a prominence of 1.
        let unseen = [
            flat(peak.prominence.max(1.0)) / flat(1.0),
            outside(peak.frequency_hz / self.band_hz.0 - 1.0),
            outside(1.0 - peak.frequency_hz / self.band_hz.1),
        ];
        let any = unseen.into_iter().fold(0.0, |any, one| any + one - any * one);
        (-2.0 * any.clamp(f64::MIN_POSITIVE, 1.0).ln()).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peak(frequency_hz: f64, prominence: f64) -> Peak {
        Peak { frequency_hz, amplitude: 1.0, prominence }
    }

    fn visibility() -> Visibility {
        Visibility::new(ModeSettings::default(), 2.0, (20.0, 700.0))
    }

    /// Far below the threshold and outside the band a peak costs nothing, far above as much as a missing mode or the square of its distance.
    #[test]
    fn limit_flat_and_prominent_peaks() {
        let absence = |f, p| visibility().absence(&peak(f, p));
        assert!(absence(300.0, 1.0) == 0.0 && absence(300.0, 1.2) < 0.01 && absence(15.0, 50.0) < 1e-6 && absence(900.0, 50.0) < 1e-6);
        assert!((absence(300.0, 2.0) - 2.0 * std::f64::consts::LN_2).abs() < 1e-3);
        let distance = 5.0;
        let prominence = 2.0 * (distance * 0.13 * std::f64::consts::SQRT_2).exp();
        assert!((distance * distance..1.3 * distance * distance).contains(&absence(300.0, prominence)), "{}", absence(300.0, prominence));
        assert!((absence(300.0, 1e9) - 900.0).abs() < 1e-9);
    }

    /// A step of a thousandth changes χ² by no more than its slope allows: at the threshold, at the edges of the band, and where it is cut.
    #[test]
    fn limit_no_cliff() {
        let of = visibility();
        let largest = |values: Vec<f64>| values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        for steps in [1000, 4000] {
            let along = |at: usize| at as f64 / steps as f64;
            let by_prominence = largest((0..=steps).map(|at| of.absence(&peak(300.0, (5.0 * along(at)).exp()))).collect());
            let by_frequency = largest((0..=steps).map(|at| of.absence(&peak(10.0 + 800.0 * along(at), 1e3))).collect());
            assert!(by_prominence < 3000.0 / steps as f64, "{by_prominence}");
            assert!(by_frequency < 3e5 / steps as f64, "{by_frequency}");
        }
    }
}
