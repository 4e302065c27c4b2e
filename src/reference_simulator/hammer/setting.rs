//! Analyser settings of a test.

use num_complex::Complex64;

/// Lower end of the kept band, Hz.
const LOWEST_HZ: f64 = 6.0;
/// Standard deviation of the logarithm of the blow heights.
pub const SPREAD: f64 = 0.15;
/// Resolution of the converter, bits.
pub const BITS: u32 = 20;
/// Time before the blow, s.
pub const PRETRIGGER_S: f64 = 0.02;

/// Settings of one test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Samples of a block; a power of two.
    pub samples: usize,
    /// Upper end of the kept band, Hz.
    pub band_hz: f64,
    /// Number of averaged blows.
    pub averages: usize,
    /// Width of the pulse, s.
    pub width_s: f64,
    /// Noise of the response over its spectrum, for one blow, at the line of median level.
    pub noise: f64,
    /// Corner frequency of the sensor's low-frequency noise, Hz.
    pub noise_corner_hz: f64,
}

impl Setting {
    /// Returns the length of a block, s.
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz
    }

    /// Returns the same setting with another block length.
    pub fn with_samples(&self, samples: usize) -> Self {
        Self { samples, ..*self }
    }

    /// Returns the frequencies of lines by their numbers, Hz.
    pub fn frequencies(&self, lines: &[usize]) -> Vec<f64> {
        lines.iter().map(|&line| line as f64 * self.rate_hz / self.samples as f64).collect()
    }

    /// Returns the lowest analyser rate that is at least four times the band: the filtered pulse then
    /// vanishes at half the rate.
    pub fn rate_for(band_hz: f64) -> f64 {
        [4096.0, 5120.0, 6400.0].into_iter().find(|rate| *rate >= 4.0 * band_hz).unwrap_or(8192.0)
    }

    /// Returns the shift of the inversion contour, 1/s: it reduces wrap-around in the block by e^{−7}.
    pub fn shift_per_s(&self) -> f64 {
        7.0 / self.duration_s()
    }

    /// Returns the points s = σ + 2πi k / T of the contour, k = 0 … N/2.
    pub fn contour(&self) -> Vec<Complex64> {
        let step = 2.0 * std::f64::consts::PI / self.duration_s();
        (0..=self.samples / 2).map(|k| Complex64::new(self.shift_per_s(), step * k as f64)).collect()
    }

    /// Returns the anti-alias filter at s: Butterworth of order 16 at 1.1 times the band, the same in both
    /// channels.
    pub fn filter(&self, s: Complex64) -> Complex64 {
        let along = s / (2.0 * std::f64::consts::PI * 1.1 * self.band_hz);
        (0..8).fold(Complex64::ONE, |value, pair| {
            let damping = ((2.0 * f64::from(pair) + 1.0) * std::f64::consts::PI / 32.0).sin();
            value / (along * along + along * (2.0 * damping) + 1.0)
        })
    }

    /// Returns the power of the response noise at a frequency over that of its white part.
    pub fn noise_shape(&self, frequency_hz: f64) -> f64 {
        1.0 + (self.noise_corner_hz / frequency_hz.max(1e-3)).powi(2)
    }

    /// Returns the numbers of the kept lines: all at low frequency, spaced in proportion to frequency above.
    pub fn kept_lines(&self, spacing: f64) -> Vec<usize> {
        let step_hz = 1.0 / self.duration_s();
        let mut out = Vec::new();
        let mut line = (LOWEST_HZ / step_hz).ceil() as usize;
        while line as f64 * step_hz <= self.band_hz {
            out.push(line);
            line += ((line as f64 * spacing).round() as usize).max((0.25 / step_hz).round() as usize).max(1);
        }
        out
    }
}
