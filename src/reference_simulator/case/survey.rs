//! A thinned preview of a test: lines, noise-free logarithms and expected variance.

use num_complex::Complex64;

use super::subject::{Subject, axis};
use crate::Result;
use crate::hammer::series::{expected_coherence, noise_level};
use crate::hammer::setting::Setting;
use crate::machine::point::Channel;

/// At most every third line of a test, with its expected noise.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Frequencies of the lines of each record, Hz.
    pub lines_hz: Vec<f64>,
    /// Channels at each position and level.
    pub channels: Vec<Channel>,
    /// Force levels.
    pub levels: Vec<f64>,
    /// Share of the test's lines that the survey contains.
    pub share: f64,
    /// ln H of the machine without effects: positions, then levels, then channels, then lines.
    pub base: Vec<Complex64>,
    /// Variance of each component of ln H; infinite for lines of too low coherence.
    pub variance: Vec<f64>,
}

impl Survey {
    /// Surveys a subject without its effects.
    pub fn new(
        subject: &Subject,
        setting: &Setting,
        channels: &[Channel],
        levels: &[f64],
        spacing: f64,
    ) -> Result<Self> {
        let all = setting.frequencies(&setting.kept_lines(spacing));
        let lines_hz: Vec<f64> = all.iter().copied().skip(1).step_by(3).collect();
        let share = lines_hz.len() as f64 / all.len() as f64;
        let base =
            logarithms(&subject.without_effects(), &all_positions(subject), &lines_hz, channels, levels)?;
        let variance = variances(&base, &lines_hz, channels.len() * levels.len(), setting);
        Ok(Self { lines_hz, channels: channels.to_vec(), levels: levels.to_vec(), share, base, variance })
    }

    /// Returns the same survey with the noise of another setting.
    pub fn with_setting(&self, setting: &Setting) -> Self {
        let variance =
            variances(&self.base, &self.lines_hz, self.channels.len() * self.levels.len(), setting);
        Self { variance, ..self.clone() }
    }

    /// Returns every third line of the survey.
    pub fn thinned(&self) -> Self {
        let count = self.lines_hz.len();
        let kept = |index: usize| (index % count) % 3 == 1;
        let lines_hz: Vec<f64> =
            (0..count).filter(|&index| kept(index)).map(|index| self.lines_hz[index]).collect();
        let of = |index: &usize| kept(*index);
        Self {
            share: self.share * lines_hz.len() as f64 / count as f64,
            lines_hz,
            base: (0..self.base.len()).filter(of).map(|index| self.base[index]).collect(),
            variance: (0..self.variance.len()).filter(of).map(|index| self.variance[index]).collect(),
            channels: self.channels.clone(),
            levels: self.levels.clone(),
        }
    }

    /// Computes ln H of a subject on these lines at all positions.
    pub fn of(&self, subject: &Subject) -> Result<Vec<Complex64>> {
        self.at_positions(subject, &all_positions(subject))
    }

    /// Computes ln H of a subject on these lines at some positions.
    pub fn at_positions(&self, subject: &Subject, positions: &[usize]) -> Result<Vec<Complex64>> {
        logarithms(subject, positions, &self.lines_hz, &self.channels, &self.levels)
    }

    /// Returns the gap due to noise alone: the root of the mean variance of a component over the accepted
    /// lines.
    pub fn floor(&self) -> f64 {
        let kept: Vec<f64> = self.variance.iter().copied().filter(|value| value.is_finite()).collect();
        (kept.iter().sum::<f64>() / kept.len().max(1) as f64).sqrt()
    }
}

fn all_positions(subject: &Subject) -> Vec<usize> {
    (0..subject.drawn.nut_m.len()).collect()
}

/// Computes ln H of all records: positions, then levels, then channels, then lines.
fn logarithms(
    subject: &Subject,
    positions: &[usize],
    lines_hz: &[f64],
    channels: &[Channel],
    levels: &[f64],
) -> Result<Vec<Complex64>> {
    let axis = axis(lines_hz);
    let stations: Vec<(usize, f64)> =
        positions.iter().flat_map(|&position| levels.iter().map(move |&level| (position, level))).collect();
    let curves = subject.at_stations(&stations, channels, &axis)?;
    let misread: Vec<Complex64> = axis.iter().map(|s| s.ln() * subject.misread_power()).collect();
    let logarithm = |(value, misread): (Complex64, &Complex64)| value.ln() + misread;
    Ok(curves
        .into_iter()
        .flatten()
        .flat_map(|values| values.into_iter().zip(&misread).map(logarithm).collect::<Vec<_>>())
        .collect())
}

/// Computes the variances of the components of ln H; `records` is the number of records at each position.
fn variances(logarithms: &[Complex64], lines_hz: &[f64], records: usize, setting: &Setting) -> Vec<f64> {
    let count = lines_hz.len();
    let accelerance = |record: usize| -> Vec<Complex64> {
        let values = &logarithms[record * count..(record + 1) * count];
        values
            .iter()
            .zip(lines_hz)
            .map(|(value, hz)| value.exp() * (2.0 * std::f64::consts::PI * hz).powi(2))
            .collect()
    };
    let mut out = Vec::with_capacity(logarithms.len());
    for record in 0..logarithms.len() / count {
        // The noise belongs to the sensor: the third position sets it for all positions.
        let noise = noise_level(setting, lines_hz, &accelerance(2 * records + record % records));
        for coherence in expected_coherence(setting, lines_hz, &accelerance(record), noise) {
            let accepted = coherence >= 0.8;
            out.push(if accepted {
                (1.0 - coherence) / (2.0 * setting.averages as f64 * coherence)
            } else {
                f64::INFINITY
            });
        }
    }
    out
}
