//! One block of two channels: samples from transforms on the contour, and spectra from samples.

use num_complex::Complex64;

use super::fft::Fft;
use super::setting::{PRETRIGGER_S, Setting};

/// Tables that the blocks of a test share.
#[derive(Clone, Debug)]
pub struct Analyser {
    /// Settings.
    pub setting: Setting,
    /// Contour of the inverse transform.
    pub contour: Vec<Complex64>,
    filter: Vec<Complex64>,
    exponential: Vec<f64>,
    window: Vec<f64>,
    fft: Fft,
}

impl Analyser {
    /// Computes the tables for a setting.
    pub fn new(setting: Setting) -> Self {
        let contour = setting.contour();
        let filter = contour.iter().map(|&s| setting.filter(s)).collect();
        let exponential = (0..setting.samples)
            .map(|n| (setting.shift_per_s() * n as f64 / setting.rate_hz).exp())
            .collect();
        let window =
            (0..setting.samples).map(|n| force_window(&setting, n as f64 / setting.rate_hz)).collect();
        Self { setting, contour, filter, exponential, window, fft: Fft::new(setting.samples) }
    }

    /// Computes the samples of two signals from their transforms on the contour, both through the anti-alias
    /// filter.
    ///
    /// The damped inversion x(t) = e^{σt} (1/T) Σ X(σ + iω_k) e^{iω_k t} gives the response of a structure at
    /// rest to one blow. The block truncates this response, as in an analyser. An inversion on the imaginary
    /// axis would make it periodic and free of leakage.
    pub fn samples(&self, transform: impl Fn(usize) -> (Complex64, Complex64)) -> Vec<Complex64> {
        let n = self.setting.samples;
        let mut values = vec![Complex64::ZERO; n];
        for k in 0..=n / 2 {
            let (mut a, mut b) = transform(k);
            a *= self.filter[k];
            b *= self.filter[k];
            if k == 0 || k == n / 2 {
                (a.im, b.im) = (0.0, 0.0);
            }
            values[k] = a + Complex64::I * b;
            values[(n - k) % n] = a.conj() + Complex64::I * b.conj();
        }
        self.fft.backward(&mut values);
        let scale = self.setting.rate_hz / n as f64;
        for (value, exponential) in values.iter_mut().zip(&self.exponential) {
            *value *= scale * exponential;
        }
        values
    }

    /// Computes the spectra of the two channels at some lines; the force window acts on the first channel.
    pub fn spectra(&self, mut samples: Vec<Complex64>, lines: &[usize]) -> Vec<(Complex64, Complex64)> {
        for (value, window) in samples.iter_mut().zip(&self.window) {
            value.re *= window;
        }
        self.fft.forward(&mut samples);
        let n = samples.len();
        let half = Complex64::new(0.5, 0.0);
        lines
            .iter()
            .map(|&k| {
                let (here, mirror) = (samples[k], samples[(n - k) % n].conj());
                ((here + mirror) * half, (here - mirror) * half * -Complex64::I)
            })
            .collect()
    }
}

/// Returns the force window: 1 during the pulse and the ringing of the filter, then a cosine down to 0.
fn force_window(setting: &Setting, time_s: f64) -> f64 {
    let end = PRETRIGGER_S + 3.0 * setting.width_s + 40.0 / setting.band_hz;
    let fall = 20.0 / setting.band_hz;
    if time_s <= end {
        1.0
    } else if time_s >= end + fall {
        0.0
    } else {
        0.5 + 0.5 * (std::f64::consts::PI * (time_s - end) / fall).cos()
    }
}
