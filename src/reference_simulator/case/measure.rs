//! Simulated test of a subject: choice of the block, noise-free curves, records.

use num_complex::Complex64;
use rayon::prelude::*;

use super::channel_set::Quantity;
use super::fault::DataFault;
use super::subject::{Curves, Subject, axis};
use crate::draw::Draw;
use crate::effect::EffectKind;
use crate::hammer::block::Analyser;
use crate::hammer::series::{Line, StructureResponse, noise_level, strike};
use crate::hammer::setting::Setting;
use crate::machine::point::Channel;
use crate::{Result, SimulatorError};

/// Block lengths in samples, shortest first.
const SAMPLES: [usize; 4] = [8192, 16384, 32768, 65536];

/// Largest accepted relative error of a noise-free H1 at a resonance.
const LARGEST_BIAS: f64 = 0.003;

/// Largest accepted relative error of a noise-free H1, rms over the lines of a record. A response that the
/// block truncates leaks into lines far from its resonance, where |H| is small, and coherence does not show
/// it.
const LARGEST_LEAK: f64 = 5e-4;

/// Nut position (index) and force level of records.
pub type Station = (usize, f64);

/// A test of a subject with a block long enough for its slowest decay.
pub struct TestRig {
    /// Channels.
    pub channels: Vec<Channel>,
    /// Positions and force levels.
    pub stations: Vec<Station>,
    /// Numbers of the kept lines.
    pub kept: Vec<usize>,
    /// Frequencies of the kept lines, Hz.
    pub lines_hz: Vec<f64>,
    /// Noise-free accelerances on the imaginary axis: stations, channels, lines.
    pub exact: Curves,
    /// Largest relative error of a noise-free H1 at a resonance.
    pub bias: f64,
    analyser: Analyser,
    responses: Vec<Vec<StructureResponse>>,
    /// Factor on each line from causal losses, which a simulation in time needs, to the subject's share of
    /// dispersion.
    loss_correction: Curves,
}

impl TestRig {
    /// Chooses the shortest block whose error of H1 is below 0.3 % at every resonance and below 0.05 % rms
    /// over the lines of a record.
    pub fn new(
        subject: &Subject,
        setting: &Setting,
        channels: &[Channel],
        levels: &[f64],
        spacing: f64,
    ) -> Result<Self> {
        let positions = 0..subject.drawn.nut_m.len();
        let stations =
            positions.flat_map(|position| levels.iter().map(move |&level| (position, level))).collect();
        Self::at(stations, subject, setting, channels, spacing)
    }

    fn at(
        stations: Vec<Station>,
        subject: &Subject,
        setting: &Setting,
        channels: &[Channel],
        spacing: f64,
    ) -> Result<Self> {
        let mut error = EstimatorError::default();
        let causal = &subject.causal();
        for samples in SAMPLES {
            let setting = setting.with_samples(samples);
            let analyser = Analyser::new(setting);
            let kept = setting.kept_lines(spacing);
            let lines_hz = setting.frequencies(&kept);
            let attempt = |stations: &[Station]| -> Result<_> {
                let exact = on_lines(causal, channels, stations, &axis(&lines_hz))?;
                let responses = responses(causal, channels, stations, &analyser.contour)?;
                let error = EstimatorError::of(&analyser, &kept, &exact, &responses);
                Ok((exact, responses, error))
            };
            // The first station alone shows at low cost that a block is too short.
            let mut tried = attempt(&stations[..1])?;
            if tried.2.accepted() && stations.len() > 1 {
                tried = attempt(&stations)?;
            }
            let (causal_lines, responses, largest) = tried;
            error = largest;
            if error.accepted() {
                let exact = on_lines(subject, channels, &stations, &axis(&lines_hz))?;
                let ratio = |(a, b): (&Vec<Complex64>, &Vec<Complex64>)| {
                    a.iter().zip(b).map(|(a, b)| a / b).collect()
                };
                let loss_correction = exact
                    .iter()
                    .zip(&causal_lines)
                    .map(|(a, b)| a.iter().zip(b).map(ratio).collect())
                    .collect();
                let channels = channels.to_vec();
                return Ok(Self {
                    channels,
                    stations,
                    kept,
                    lines_hz,
                    exact,
                    bias: error.bias,
                    analyser,
                    responses,
                    loss_correction,
                });
            }
        }
        Err(error.refused(setting))
    }

    /// Returns the length of a block, s.
    pub fn block_s(&self) -> f64 {
        self.analyser.setting.duration_s()
    }

    /// Simulates the blows of all records: accelerance lines of every station and channel.
    pub fn records(&self, data_fault: Option<DataFault>, draw: &Draw) -> Vec<Vec<Vec<Line>>> {
        let channels = self.channels.len();
        let strike = |station: usize| {
            (0..channels)
                .into_par_iter()
                .map(|channel| self.record(station, channel, data_fault, draw))
                .collect::<Vec<Vec<Line>>>()
        };
        (0..self.stations.len()).into_par_iter().map(strike).collect()
    }

    /// Simulates the blows of one record with its own branch of `draw`. The sensor noise follows from the
    /// third position and is the same at all positions.
    pub fn record(
        &self,
        station: usize,
        channel: usize,
        data_fault: Option<DataFault>,
        draw: &Draw,
    ) -> Vec<Line> {
        let third = self.stations.len() / 3;
        let noise = noise_level(&self.analyser.setting, &self.lines_hz, &self.exact[third][channel]);
        let fault = data_fault.and_then(|data_fault| data_fault.fault(station, channel));
        let mut own = draw.branch((station * self.channels.len() + channel) as u64);
        let mut lines = strike(
            &self.analyser,
            &self.responses[station][channel],
            &self.kept,
            Some(noise),
            fault,
            &mut own,
        );
        lines
            .iter_mut()
            .zip(&self.loss_correction[station][channel])
            .for_each(|(line, loss_correction)| line.response *= loss_correction);
        lines
    }
}

/// Checks at low cost whether the response at the first position decays within the longest block.
pub fn check_decay(subject: &Subject, setting: &Setting, channels: &[Channel], spacing: f64) -> Result<()> {
    TestRig::at(vec![(0, 1.0)], subject, setting, channels, spacing).map(drop)
}

/// Computes accelerances at points of the Laplace plane.
pub fn on_lines(
    subject: &Subject,
    channels: &[Channel],
    stations: &[Station],
    lines: &[Complex64],
) -> Result<Curves> {
    let mut curves = subject.at_stations(stations, channels, lines)?;
    for (value, s) in curves.iter_mut().flatten().flat_map(|values| values.iter_mut().zip(lines)) {
        *value *= s * s;
    }
    Ok(curves)
}

/// Computes the responses on the contour, with their slope over ln(level) if the structure depends on the
/// level.
fn responses(
    subject: &Subject,
    channels: &[Channel],
    stations: &[Station],
    contour: &[Complex64],
) -> Result<Vec<Vec<StructureResponse>>> {
    let here = on_lines(subject, channels, stations, contour)?;
    let step: f64 = 0.05;
    let mut there = Vec::new();
    if subject.effects.iter().any(|effect| effect.kind == EffectKind::ContactLevel) {
        let higher_level: Vec<Station> =
            stations.iter().map(|&(position, level)| (position, level * step.exp())).collect();
        there = on_lines(subject, channels, &higher_level, contour)?;
    }
    let of_record = |station: usize, channel: usize, accelerance: Vec<Complex64>| {
        let slope = |there: &Vec<Vec<Complex64>>| {
            there[channel].iter().zip(&accelerance).map(|(a, b)| (a - b) / step).collect()
        };
        StructureResponse { slope: there.get(station).map(slope), accelerance }
    };
    let of_station = |(station, records): (usize, Vec<Vec<Complex64>>)| {
        records
            .into_iter()
            .enumerate()
            .map(|(channel, accelerance)| of_record(station, channel, accelerance))
            .collect()
    };
    Ok(here.into_iter().enumerate().map(of_station).collect())
}

/// Error that a block causes in a noise-free H1.
#[derive(Clone, Copy, Debug, Default)]
struct EstimatorError {
    /// Largest relative error at the local maxima within 60 dB of the largest value of each record.
    bias: f64,
    /// Largest rms, over the lines of a record, of the relative error.
    leak: f64,
}

impl EstimatorError {
    fn of(
        analyser: &Analyser,
        kept: &[usize],
        exact: &[Vec<Vec<Complex64>>],
        responses: &[Vec<StructureResponse>],
    ) -> Self {
        let of_record = |(exact, response): (&Vec<Complex64>, &StructureResponse)| {
            let lines = strike(analyser, response, kept, None, None, &mut Draw::new(0));
            let errors: Vec<f64> =
                lines.iter().zip(exact).map(|(line, exact)| (line.response / exact - 1.0).norm()).collect();
            let lowest = 1e-3 * exact.iter().map(|value| value.norm()).fold(0.0, f64::max);
            let bias = (1..kept.len().saturating_sub(1))
                .filter(|&k| {
                    exact[k].norm() > lowest
                        && exact[k].norm() > exact[k - 1].norm()
                        && exact[k].norm() > exact[k + 1].norm()
                })
                .map(|k| errors[k])
                .fold(0.0, f64::max);
            let leak = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
            Self { bias, leak }
        };
        let worse = |a: Self, b: Self| Self { bias: a.bias.max(b.bias), leak: a.leak.max(b.leak) };
        let of_station = |(exact, responses): (&Vec<Vec<Complex64>>, &Vec<StructureResponse>)| {
            exact.iter().zip(responses).map(of_record).fold(Self::default(), worse)
        };
        exact
            .par_iter()
            .zip(responses)
            .map(of_station)
            .collect::<Vec<Self>>()
            .into_iter()
            .fold(Self::default(), worse)
    }

    fn accepted(&self) -> bool {
        self.bias < LARGEST_BIAS && self.leak < LARGEST_LEAK
    }

    /// Returns the error that even the longest block is too short.
    fn refused(&self, setting: &Setting) -> SimulatorError {
        SimulatorError::Ringing {
            longest_s: SAMPLES[SAMPLES.len() - 1] as f64 / setting.rate_hz,
            bias: self.bias,
            leak: self.leak,
        }
    }
}

/// Converts accelerance lines to another quantity.
pub fn as_quantity(lines: &[Line], quantity: Quantity, misread_power: f64) -> Vec<Line> {
    lines
        .iter()
        .map(|line| Line {
            response: line.response * from_accelerance(line.frequency_hz, quantity, misread_power),
            ..*line
        })
        .collect()
}

/// Returns the factor from accelerance to the values that the file states as `quantity`.
pub fn from_accelerance(frequency_hz: f64, quantity: Quantity, misread_power: f64) -> Complex64 {
    let s = Complex64::new(0.0, 2.0 * std::f64::consts::PI * frequency_hz);
    quantity.factor(frequency_hz) / (s * s)
        * if misread_power == 0.0 { Complex64::ONE } else { s.powf(misread_power) }
}
