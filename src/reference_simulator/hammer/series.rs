//! A series of blows: averages, H1, coherence, and the expected noise.

use num_complex::Complex64;

use super::block::Analyser;
use super::pulse::Pulse;
use super::setting::{BITS, PRETRIGGER_S, Setting};
use crate::draw::Draw;

/// One line of a measured frequency response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Response over force.
    pub response: Complex64,
    /// Coherence.
    pub coherence: f64,
}

/// Fault of a measurement channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The sensor stands on a soft mount of this frequency and damping ratio.
    LooseSensor {
        /// Natural frequency of the mount, Hz.
        mount_hz: f64,
        /// Damping ratio of the mount.
        ratio: f64,
    },
    /// The response is clipped at a share of its largest value.
    Clipped {
        /// Share.
        share: f64,
    },
    /// The cable is interrupted for part of each block.
    Dropouts {
        /// Lost share of the block.
        share: f64,
    },
}

/// The structure's accelerance on the analyser's contour, and its derivative with the logarithm of the force
/// level.
#[derive(Clone, Debug)]
pub struct StructureResponse {
    /// Acceleration over force on the contour.
    pub accelerance: Vec<Complex64>,
    /// Derivative with ln(level), if the structure depends on the level.
    pub slope: Option<Vec<Complex64>>,
}

/// Simulates a series of blows and returns accelerance lines by H1 with their coherence.
///
/// `noise` is the standard deviation of one sample of the response's white noise. `None` gives one nominal
/// blow without noise and converter.
pub fn strike(
    analyser: &Analyser,
    structure: &StructureResponse,
    lines: &[usize],
    noise: Option<f64>,
    fault: Option<Fault>,
    draw: &mut Draw,
) -> Vec<Line> {
    let setting = &analyser.setting;
    let mut force_power = vec![0.0; lines.len()];
    let mut cross_power = vec![Complex64::ZERO; lines.len()];
    let mut response_power = vec![0.0; lines.len()];
    let mut range: Option<(f64, f64)> = None;
    let blows = if noise.is_some() { setting.averages } else { 1 };
    for _ in 0..blows {
        let pulse = if noise.is_some() { Pulse::random(setting, draw) } else { Pulse::nominal(setting) };
        let level = pulse.height.ln();
        let mut samples = analyser.samples(|k| {
            let s = analyser.contour[k];
            let force = pulse.transform(s);
            let mut ratio = structure.accelerance[k];
            if let Some(slope) = &structure.slope {
                ratio += slope[k] * level;
            }
            if let Some(Fault::LooseSensor { mount_hz, ratio: damping }) = fault {
                let along = s / (2.0 * std::f64::consts::PI * mount_hz);
                ratio *= (1.0 + along * (2.0 * damping)) / (along * along + along * (2.0 * damping) + 1.0);
            }
            (force, force * ratio)
        });
        if let Some(noise) = noise {
            disturb(&mut samples, setting, noise, fault, draw);
            let (force_range, response_range) = *range.get_or_insert_with(|| {
                let largest = |part: fn(&Complex64) -> f64| {
                    samples.iter().map(part).fold(0.0, |a: f64, b| a.max(b.abs()))
                };
                (2.2 * largest(|value| value.re), 2.2 * largest(|value| value.im))
            });
            for value in &mut samples {
                *value =
                    Complex64::new(converted(value.re, force_range), converted(value.im, response_range));
            }
        }
        for (index, (force, response)) in analyser.spectra(samples, lines).into_iter().enumerate() {
            force_power[index] += force.norm_sqr();
            cross_power[index] += force.conj() * response;
            response_power[index] += response.norm_sqr();
        }
    }
    let estimated = |(index, frequency_hz): (usize, f64)| Line {
        frequency_hz,
        response: cross_power[index] / force_power[index],
        coherence: (cross_power[index].norm_sqr() / (force_power[index] * response_power[index])).min(1.0),
    };
    setting.frequencies(lines).into_iter().enumerate().map(estimated).collect()
}

/// Adds noise to both channels and applies a fault of cable or amplifier. The force noise is 90 dB below the
/// force peak.
fn disturb(samples: &mut [Complex64], setting: &Setting, noise: f64, fault: Option<Fault>, draw: &mut Draw) {
    let decay = (-2.0 * std::f64::consts::PI / setting.rate_hz).exp();
    let drift_gain = 2.0 * std::f64::consts::PI * setting.noise_corner_hz / setting.rate_hz;
    let force_noise = 3e-5 * samples.iter().map(|value| value.re.abs()).fold(0.0, f64::max);
    let largest = samples.iter().map(|value| value.im.abs()).fold(0.0, f64::max);
    let mut drift = draw.normal() / (1.0 - decay * decay).sqrt();
    let lost = match fault {
        Some(Fault::Dropouts { share }) => {
            let length = (share * samples.len() as f64) as usize;
            let start = draw.index((samples.len() / 8).max(1)) + (PRETRIGGER_S * setting.rate_hz) as usize;
            start..start + length
        }
        _ => 0..0,
    };
    for (index, value) in samples.iter_mut().enumerate() {
        drift = decay * drift + draw.normal();
        if lost.contains(&index) {
            value.im *= 0.05;
        }
        if let Some(Fault::Clipped { share }) = fault {
            value.im = value.im.clamp(-share * largest, share * largest);
        }
        *value += Complex64::new(force_noise * draw.normal(), noise * (draw.normal() + drift_gain * drift));
    }
}

fn converted(value: f64, range: f64) -> f64 {
    let step = range / f64::from(1u32 << (BITS - 1));
    (value.clamp(-range, range) / step).round() * step
}

/// Returns the standard deviation of one sample of white response noise that gives the setting's noise ratio
/// at the line of median level.
pub fn noise_level(setting: &Setting, lines_hz: &[f64], accelerance: &[Complex64]) -> f64 {
    let mut spectrum: Vec<f64> = response_spectrum(setting, lines_hz, accelerance);
    spectrum.sort_by(f64::total_cmp);
    let middle = spectrum.get(spectrum.len() / 2).copied().unwrap_or(0.0);
    setting.noise * middle * setting.rate_hz / (setting.samples as f64).sqrt()
}

/// Returns the expected coherence of each line for a white noise with the standard deviation `noise` of one
/// sample.
pub fn expected_coherence(
    setting: &Setting,
    lines_hz: &[f64],
    accelerance: &[Complex64],
    noise: f64,
) -> Vec<f64> {
    let spectrum = response_spectrum(setting, lines_hz, accelerance);
    let power = setting.samples as f64 * (noise / setting.rate_hz).powi(2);
    lines_hz
        .iter()
        .zip(spectrum)
        .map(|(&hz, size)| 1.0 / (1.0 + power * setting.noise_shape(hz) / (size * size)))
        .collect()
}

fn response_spectrum(setting: &Setting, lines_hz: &[f64], accelerance: &[Complex64]) -> Vec<f64> {
    let pulse = Pulse::nominal(setting);
    let at = |hz: f64| Complex64::new(0.0, 2.0 * std::f64::consts::PI * hz);
    lines_hz
        .iter()
        .zip(accelerance)
        .map(|(&hz, ratio)| (pulse.transform(at(hz)) * setting.filter(at(hz)) * ratio).norm())
        .collect()
}
