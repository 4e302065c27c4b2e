//! Settings of a test, as someone at the analyser chooses them.

use num_complex::Complex64;

/// Settings of one test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Samples per second.
    pub rate_hz: f64,
    /// Samples of a block, a power of two.
    pub samples: usize,
    /// Upper end of the band that is kept.
    pub band_hz: f64,
    /// Lower end of it.
    pub lowest_hz: f64,
    /// Blows averaged.
    pub averages: usize,
    /// Width of the pulse.
    pub width_s: f64,
    /// Spread of the logarithm of the blows' heights.
    pub spread: f64,
    /// Noise of the response over its spectrum, for one blow, at the middle line.
    pub noise: f64,
    /// Corner of the sensor's low-frequency noise.
    pub noise_corner_hz: f64,
    /// Bits of the converter.
    pub bits: u32,
}

impl Setting {
    /// Length of a block.
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz
    }

    /// The same test with blocks of another length.
    pub fn with_samples(&self, samples: usize) -> Self {
        Self { samples, ..*self }
    }

    /// Frequencies of lines given by number.
    pub fn frequencies(&self, lines: &[usize]) -> Vec<f64> {
        lines.iter().map(|&line| line as f64 * self.rate_hz / self.samples as f64).collect()
    }

    /// Slowest of the analyser's rates at which nothing to speak of is left of a filtered pulse at half the rate.
    pub fn rate_for(band_hz: f64) -> f64 {
        [4096.0, 5120.0, 6400.0].into_iter().find(|rate| *rate >= 4.0 * band_hz).unwrap_or(8192.0)
    }

    /// Time before the blow.
    pub fn pretrigger_s(&self) -> f64 {
        0.02
    }

    /// Shift of the contour on which transforms are inverted: what wraps around the block is reduced by e^{−7}.
    pub fn shift_per_s(&self) -> f64 {
        7.0 / self.duration_s()
    }

    /// Points s = σ + 2πi k / T of the contour, k = 0 … N/2.
    pub fn contour(&self) -> Vec<Complex64> {
        let step = 2.0 * std::f64::consts::PI / self.duration_s();
        (0..=self.samples / 2).map(|k| Complex64::new(self.shift_per_s(), step * k as f64)).collect()
    }

    /// Anti-alias filter, Butterworth of order 16 a little above the band, the same in both channels.
    pub fn filter(&self, s: Complex64) -> Complex64 {
        let along = s / (2.0 * std::f64::consts::PI * 1.1 * self.band_hz);
        (0..8).fold(Complex64::ONE, |value, pair| {
            let damping = ((2.0 * f64::from(pair) + 1.0) * std::f64::consts::PI / 32.0).sin();
            value / (along * along + along * (2.0 * damping) + 1.0)
        })
    }

    /// Spectral power of the response's noise at a frequency over that of its white part.
    pub fn noise_shape(&self, frequency_hz: f64) -> f64 {
        1.0 + (self.noise_corner_hz / frequency_hz.max(1e-3)).powi(2)
    }

    /// Numbers of the block's lines that are kept: all of them low in the band, thinned in proportion to frequency above.
    pub fn kept_lines(&self, spacing: f64) -> Vec<usize> {
        let step_hz = 1.0 / self.duration_s();
        let mut out = Vec::new();
        let mut line = (self.lowest_hz / step_hz).ceil() as usize;
        while line as f64 * step_hz <= self.band_hz {
            out.push(line);
            line += ((line as f64 * spacing).round() as usize).max((0.25 / step_hz).round() as usize).max(1);
        }
        out
    }
}
