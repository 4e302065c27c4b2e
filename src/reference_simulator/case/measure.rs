//! A subject on the test bench: choice of the block, noise-free curves, records.

use num_complex::Complex64;
use rayon::prelude::*;

use super::fault::Trouble;
use super::layout::Quantity;
use super::subject::{Subject, axis};
use crate::TruthError;
use crate::draw::Draw;
use crate::hammer::block::Analyser;
use crate::hammer::series::{Answer, Line, noise_level, strike};
use crate::hammer::setting::Setting;
use crate::machine::point::Channel;

/// Blocks that are tried, shortest first.
const SAMPLES: [usize; 4] = [8192, 16384, 32768, 65536];

/// Largest error of a noise-free H1 at a resonance that is accepted, and largest root mean square over the lines of a record: a response that
/// the block cuts off leaks into lines far from its resonance, where |H| is small, and coherence does not show it.
const LARGEST_BIAS: f64 = 0.003;
const LARGEST_LEAK: f64 = 5e-4;

/// Position and force level of some records.
pub type Station = (usize, f64);

/// A subject with a block long enough for its slowest decay, and its answers to a blow.
pub struct Bench {
    /// Channels.
    pub channels: Vec<Channel>,
    /// Positions and levels.
    pub stations: Vec<Station>,
    /// Numbers of the lines that are kept.
    pub kept: Vec<usize>,
    /// Their frequencies.
    pub lines_hz: Vec<f64>,
    /// Noise-free accelerances on the axis: stations, channels, lines.
    pub exact: Vec<Vec<Vec<Complex64>>>,
    /// Largest error of a noise-free H1 at a resonance.
    pub bias: f64,
    analyser: Analyser,
    answers: Vec<Vec<Answer>>,
    /// What losses of less dispersion make of each line: a blow in time needs causal ones.
    settled: Vec<Vec<Vec<Complex64>>>,
}

impl Bench {
    /// Chooses the block: the shortest that keeps the error of H1 below 0.3 % at every resonance and below 0.05 % over the lines of a record.
    pub fn new(subject: &Subject, setting: &Setting, channels: &[Channel], levels: &[f64], spacing: f64) -> Result<Self, TruthError> {
        let positions = 0..subject.drawn.nut_m.len();
        let stations = positions.flat_map(|position| levels.iter().map(move |&level| (position, level))).collect();
        Self::at(stations, subject, setting, channels, spacing)
    }

    fn at(stations: Vec<Station>, subject: &Subject, setting: &Setting, channels: &[Channel], spacing: f64) -> Result<Self, TruthError> {
        let mut error = EstimatorError::default();
        let causal = &subject.causal();
        for samples in SAMPLES {
            let setting = setting.with_samples(samples);
            let analyser = Analyser::new(setting);
            let kept = setting.kept_lines(spacing);
            let lines_hz = setting.frequencies(&kept);
            let attempt = |stations: &[Station]| -> Result<_, TruthError> {
                let exact = on_lines(causal, channels, stations, &axis(&lines_hz))?;
                let answers = answers(causal, channels, stations, &analyser.contour)?;
                let error = EstimatorError::of(&analyser, &kept, &exact, &answers);
                Ok((exact, answers, error))
            };
            // One station tells cheaply that a block is too short.
            let mut seen = attempt(&stations[..1])?;
            if seen.2.accepted() && stations.len() > 1 {
                seen = attempt(&stations)?;
            }
            let (exact, answers, largest) = seen;
            error = largest;
            if error.accepted() {
                let mut settled = on_lines(subject, channels, &stations, &axis(&lines_hz))?;
                let causal_lines = exact.into_iter().flatten().flatten();
                let kept_exact = settled.clone();
                settled.iter_mut().flatten().flatten().zip(causal_lines).for_each(|(settled, causal)| *settled /= causal);
                let (channels, exact) = (channels.to_vec(), kept_exact);
                return Ok(Self { channels, stations, kept, lines_hz, exact, bias: error.bias, analyser, answers, settled });
            }
        }
        Err(error.refused(setting))
    }

    /// Length of a block.
    pub fn block_s(&self) -> f64 {
        self.analyser.setting.duration_s()
    }

    /// Strikes: accelerance lines of every station and channel.
    pub fn records(&self, trouble: Option<Trouble>, draw: &Draw) -> Vec<Vec<Vec<Line>>> {
        let channels = self.channels.len();
        let strike = |station: usize| {
            (0..channels).into_par_iter().map(|channel| self.record(station, channel, trouble, draw)).collect::<Vec<Vec<Line>>>()
        };
        (0..self.stations.len()).into_par_iter().map(strike).collect()
    }

    /// Strikes for one record, which has its own branch of `draw`. The noise of a sensor is set at the third position and kept.
    pub fn record(&self, station: usize, channel: usize, trouble: Option<Trouble>, draw: &Draw) -> Vec<Line> {
        let third = self.stations.len() / 3;
        let noise = noise_level(&self.analyser.setting, &self.lines_hz, &self.exact[third][channel]);
        let fault = trouble.and_then(|trouble| trouble.fault(station, channel));
        let mut own = draw.branch((station * self.channels.len() + channel) as u64);
        let mut lines = strike(&self.analyser, &self.answers[station][channel], &self.kept, Some(noise), fault, &mut own);
        lines.iter_mut().zip(&self.settled[station][channel]).for_each(|(line, settled)| line.response *= settled);
        lines
    }
}

/// Whether the machine's answers at its first position end within the longest block; cheap for a machine whose answers do.
pub fn decays(subject: &Subject, setting: &Setting, channels: &[Channel], spacing: f64) -> Result<(), TruthError> {
    Bench::at(vec![(0, 1.0)], subject, setting, channels, spacing).map(drop)
}

/// Accelerances on some points of the plane.
pub fn on_lines(
    subject: &Subject,
    channels: &[Channel],
    stations: &[Station],
    lines: &[Complex64],
) -> Result<Vec<Vec<Vec<Complex64>>>, TruthError> {
    stations
        .par_iter()
        .map(|&(position, level)| {
            let mut values = subject.receptances(position, level, channels, lines)?;
            for value in values.iter_mut().flat_map(|values| values.iter_mut().zip(lines)) {
                *value.0 *= value.1 * value.1;
            }
            Ok(values)
        })
        .collect::<Vec<_>>()
        .into_iter()
        .collect()
}

/// Answers on the contour; where the structure depends on the level, with their slope over ln(level).
fn answers(subject: &Subject, channels: &[Channel], stations: &[Station], contour: &[Complex64]) -> Result<Vec<Vec<Answer>>, TruthError> {
    let here = on_lines(subject, channels, stations, contour)?;
    if !subject.effects.iter().any(|effect| effect.kind == crate::effect::EffectKind::ContactLevel) {
        return Ok(here
            .into_iter()
            .map(|station| station.into_iter().map(|accelerance| Answer { accelerance, slope: None }).collect())
            .collect());
    }
    let step: f64 = 0.05;
    let louder: Vec<Station> = stations.iter().map(|&(position, level)| (position, level * step.exp())).collect();
    let there = on_lines(subject, channels, &louder, contour)?;
    let joined = |(accelerance, louder): (Vec<Complex64>, Vec<Complex64>)| {
        let slope = louder.iter().zip(&accelerance).map(|(a, b)| (a - b) / step).collect();
        Answer { accelerance, slope: Some(slope) }
    };
    Ok(here.into_iter().zip(there).map(|(a, b)| a.into_iter().zip(b).map(joined).collect()).collect())
}

/// What a block does to a noise-free H1.
#[derive(Clone, Copy, Debug, Default)]
struct EstimatorError {
    /// Largest relative error at the local maxima of each record that stand within 60 dB of its largest value.
    bias: f64,
    /// Largest root mean square, over the lines of a record, of the relative error.
    leak: f64,
}

impl EstimatorError {
    fn of(analyser: &Analyser, kept: &[usize], exact: &[Vec<Vec<Complex64>>], answers: &[Vec<Answer>]) -> Self {
        let of_record = |(exact, answer): (&Vec<Complex64>, &Answer)| {
            let lines = strike(analyser, answer, kept, None, None, &mut Draw::new(0));
            let errors: Vec<f64> = lines.iter().zip(exact).map(|(line, exact)| (line.response / exact - 1.0).norm()).collect();
            let lowest = 1e-3 * exact.iter().map(|value| value.norm()).fold(0.0, f64::max);
            let bias = (1..kept.len().saturating_sub(1))
                .filter(|&k| exact[k].norm() > lowest && exact[k].norm() > exact[k - 1].norm() && exact[k].norm() > exact[k + 1].norm())
                .map(|k| errors[k])
                .fold(0.0, f64::max);
            let leak = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
            Self { bias, leak }
        };
        let worse = |a: Self, b: Self| Self { bias: a.bias.max(b.bias), leak: a.leak.max(b.leak) };
        let of_station =
            |(exact, answers): (&Vec<Vec<Complex64>>, &Vec<Answer>)| exact.iter().zip(answers).map(of_record).fold(Self::default(), worse);
        exact.par_iter().zip(answers).map(of_station).collect::<Vec<Self>>().into_iter().fold(Self::default(), worse)
    }

    fn accepted(&self) -> bool {
        self.bias < LARGEST_BIAS && self.leak < LARGEST_LEAK
    }

    /// The longest block is too short.
    fn refused(&self, setting: &Setting) -> TruthError {
        TruthError::Ringing { longest_s: SAMPLES[SAMPLES.len() - 1] as f64 / setting.rate_hz, bias: self.bias, leak: self.leak }
    }
}

/// Accelerance lines in another quantity.
pub fn as_quantity(lines: &[Line], quantity: Quantity, misread_power: f64) -> Vec<Line> {
    lines
        .iter()
        .map(|line| Line { response: line.response * from_accelerance(line.frequency_hz, quantity, misread_power), ..*line })
        .collect()
}

/// Factor from accelerance to the numbers that the file states as `quantity`.
pub fn from_accelerance(frequency_hz: f64, quantity: Quantity, misread_power: f64) -> Complex64 {
    let s = Complex64::new(0.0, 2.0 * std::f64::consts::PI * frequency_hz);
    quantity.factor(frequency_hz) / (s * s) * if misread_power == 0.0 { Complex64::ONE } else { s.powf(misread_power) }
}
