//! Measured frequency response functions with their noise.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::table::Table;
use super::{MeasurementError, Quantity};
use numeric::unit::omega_rad_s;

/// Noise of a frequency line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrfNoise {
    /// Coherence γ² of the averaged records.
    Coherence(f64),
    /// Standard deviation of the complex mean (both components together) over |H| (1).
    RelativeSd(f64),
    /// Not stated; standard deviation of one component of ln H (1), estimated from the spread of repeated
    /// measurements.
    Repeats(f64),
    /// Not stated; standard deviation of one component of ln H (1), estimated from neighbouring lines.
    Neighbours(f64),
}

/// Origin of the noise of an FRF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseSource {
    /// Stated as coherence.
    Coherence,
    /// Stated as standard deviation.
    RelativeSd,
    /// Estimated from repeated measurements.
    Repeats,
    /// Estimated from neighbouring lines.
    Neighbours,
    /// Neither stated nor estimated: too few lines.
    Unknown,
}

impl NoiseSource {
    /// Whether the measurement states its noise.
    pub fn is_stated(self) -> bool {
        matches!(self, NoiseSource::Coherence | NoiseSource::RelativeSd)
    }
}

/// One frequency line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfLine {
    /// Frequency (Hz), above 0.
    pub frequency_hz: f64,
    /// H = response / force, e^{+iωt}, in the record's quantity.
    pub value: Complex64,
    /// Noise, where known.
    pub noise: Option<FrfNoise>,
}

/// Smallest coherence γ² of an accepted line (1).
pub const LEAST_COHERENCE: f64 = 0.8;
/// Least relative standard deviation that may be stated (1): the rounding of numbers is near.
pub(super) const LEAST_RELATIVE_SD: f64 = 1e-12;

/// Lower bound on 1 − γ² (1): rounding of a coherence printed to four digits.
const LEAST_INCOHERENCE: f64 = 5e-5;

/// Number of lines on either side whose noise power is averaged.
const NEIGHBOURS: usize = 4;

/// Ratio of a line's noise power to the mean of its neighbours above which the difference is not chance (1).
const OUTLIER_RATIO: f64 = 4.0;

/// Operating condition of an FRF in addition to its position; `None` where not stated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Condition {
    /// Level of the exciting force (N).
    pub force_level_n: Option<f64>,
    /// Velocity of the table (m/s).
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²).
    pub acceleration_m_s2: Option<f64>,
    /// Decay rate σ of the exponential window on the response (1/s); 0 without one. The receptance is then
    /// that at the complex frequency ω − iσ.
    pub window_per_s: f64,
}

/// A measured FRF.
#[derive(Debug, Clone, PartialEq)]
pub struct Frf {
    /// Index of its position in the set; `None` where the machine has no positions.
    pub position: Option<usize>,
    /// Name of the repeat or record.
    pub record: Option<String>,
    /// Name of the response point.
    pub response: String,
    /// Name of the excitation point.
    pub excitation: String,
    /// Quantity.
    pub quantity: Quantity,
    /// Operating condition.
    pub condition: Condition,
    /// Number of averages.
    pub averages: Option<u32>,
    /// File of the FRF.
    pub source: String,
    /// Accepted lines in rising frequency.
    pub lines: Vec<FrfLine>,
    /// Rejected lines (coherence too low, f = 0 or H = 0) in rising frequency.
    pub rejected: Vec<FrfLine>,
}

impl Frf {
    /// Returns the standard deviation of one component (real or imaginary) of ln H at a line; `None` where
    /// unknown.
    ///
    /// # Source  Bendat and Piersol: (1 − γ²)/(2·n·γ²) for the H1 estimate without leakage.
    pub fn component_sd(&self, line: &FrfLine) -> Option<f64> {
        match line.noise? {
            FrfNoise::Coherence(gamma2) => {
                let averages = f64::from(self.averages?);
                Some(((1.0 - gamma2).max(LEAST_INCOHERENCE) / (2.0 * averages * gamma2)).sqrt())
            }
            FrfNoise::RelativeSd(sd) => Some(sd / std::f64::consts::SQRT_2),
            FrfNoise::Repeats(sd) | FrfNoise::Neighbours(sd) => Some(sd),
        }
    }

    /// Returns ln H of all lines, of the receptance, with the phase unwrapped from line to line.
    pub fn logarithms(&self) -> Vec<Complex64> {
        let mut unwrapped: Vec<Complex64> = Vec::with_capacity(self.lines.len());
        for line in &self.lines {
            let mut log = self.receptance(line).ln();
            if let Some(last) = unwrapped.last() {
                log.im += ((last.im - log.im) / TAU).round() * TAU;
            }
            unwrapped.push(log);
        }
        unwrapped
    }

    /// Returns the receptance at a line (m/N): what depends on |H|, such as the weights of lines, is the same
    /// whatever quantity was recorded.
    pub fn receptance(&self, line: &FrfLine) -> Complex64 {
        line.value / self.quantity.from_receptance(omega_rad_s(line.frequency_hz))
    }

    /// Returns the value of a line as it was recorded under the window, without the sensor's mount.
    pub fn recorded(&self, line: &FrfLine) -> Complex64 {
        line.value * self.quantity.windowed(self.condition.window_per_s, omega_rad_s(line.frequency_hz))
    }

    /// Returns the origin of its noise: that of its first line with noise.
    pub fn noise_source(&self) -> NoiseSource {
        match self.lines.iter().find_map(|line| line.noise) {
            Some(FrfNoise::Coherence(_)) => NoiseSource::Coherence,
            Some(FrfNoise::RelativeSd(_)) => NoiseSource::RelativeSd,
            Some(FrfNoise::Repeats(_)) => NoiseSource::Repeats,
            Some(FrfNoise::Neighbours(_)) => NoiseSource::Neighbours,
            None => NoiseSource::Unknown,
        }
    }

    /// Returns [`Frf::component_sd`] at every line, with the noise power from coherence, as that of a
    /// receptance, averaged over neighbouring lines, accepted or not.
    ///
    /// With few averages, the coherence of one line is a poor estimate of its noise, and lines that seem
    /// quiet by chance would weigh most. The noise power of the response, unlike its share of |H|, changes
    /// little from line to line. A line with far more noise than its neighbours keeps its own. A line
    /// accepted where most are rejected has a high coherence by chance and carries no information: its
    /// standard deviation is 1.
    ///
    /// # Source  a measured coherence leaves n − 1 of n averages to estimate the noise: (1 − γ²)/(2·(n −
    ///   1)·γ²), unbiased. It is the ratio of
    /// residual to explained power of a complex regression, with 2(n − 1) degrees of freedom.
    pub fn component_sds(&self) -> Vec<Option<f64>> {
        let freedom = |n: u32| f64::from(n) / f64::from(n.saturating_sub(1).max(1));
        let power = |line: &FrfLine| match line.noise? {
            FrfNoise::Coherence(_) => Some(
                self.component_sd(line)?.powi(2) * freedom(self.averages?) * self.receptance(line).norm_sqr(),
            ),
            _ => None,
        };
        let mut all: Vec<(f64, bool, f64)> = Vec::with_capacity(self.lines.len() + self.rejected.len());
        for (lines, accepted) in [(&self.lines, true), (&self.rejected, false)] {
            let powers = lines.iter().filter_map(|line| Some((line.frequency_hz, accepted, power(line)?)));
            all.extend(powers.filter(|(_, _, power)| power.is_finite()));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut at = 0;
        let mut sd = |line: &FrfLine| {
            let own = power(line)?;
            at += all[at..].iter().position(|(frequency_hz, _, _)| *frequency_hz == line.frequency_hz)?;
            let around = &all[at.saturating_sub(NEIGHBOURS)..(at + NEIGHBOURS + 1).min(all.len())];
            let count = around.len() as f64;
            if 2.0 * (around.iter().filter(|(_, accepted, _)| *accepted).count() as f64) < count {
                return Some(1.0);
            }
            let sum = around.iter().map(|(_, _, power)| power).sum::<f64>();
            let is_outlier = own * (count - 1.0) > OUTLIER_RATIO * (sum - own);
            Some(((if is_outlier { own } else { sum / count }) / self.receptance(line).norm_sqr()).sqrt())
        };
        self.lines.iter().map(|line| sd(line).or_else(|| self.component_sd(line))).collect()
    }
}

/// Accepted and rejected lines of an FRF.
pub(super) type ReadLines = (Vec<FrfLine>, Vec<FrfLine>);

/// Reads the lines of `frequency_hz,real,imag[,coherence][,relative_sd]`.
pub(super) fn read_lines(path: &str, text: &str) -> Result<ReadLines, MeasurementError> {
    let table = Table::read(path, text, &["frequency_hz", "real", "imag"], &["coherence", "relative_sd"])?;
    let mut sorted = SortedLines::default();
    for row in table.rows() {
        let row = row?;
        let frequency_hz = row.number("frequency_hz")?;
        let value = Complex64::new(row.number("real")?, row.number("imag")?);
        let (coherence, relative_sd) =
            (row.optional_number("coherence")?, row.optional_number("relative_sd")?);
        sorted.add(frequency_hz, value, coherence, relative_sd).map_err(|fault| row.fault(fault))?;
    }
    sorted.finish(table.has("coherence")).map_err(|fault| MeasurementError::file(path, fault))
}

/// Lines of an FRF, checked one after another and sorted into accepted and rejected ones.
#[derive(Default)]
pub(super) struct SortedLines {
    accepted: Vec<FrfLine>,
    rejected: Vec<FrfLine>,
    last_hz: Option<f64>,
}

/// What is wrong with a line or a record, and what to write instead; without its place.
pub(super) type Fault = String;

impl SortedLines {
    /// Adds a line.
    ///
    /// # Errors  its frequency is negative or does not follow the one before; coherence or standard deviation
    ///   lie outside their ranges.
    pub(super) fn add(
        &mut self,
        frequency_hz: f64,
        value: Complex64,
        coherence: Option<f64>,
        relative_sd: Option<f64>,
    ) -> Result<(), Fault> {
        if frequency_hz < 0.0 {
            return Err(format!("frequency_hz is {frequency_hz}; frequencies are 0 or above"));
        }
        if let Some(last_hz) = self.last_hz.filter(|last_hz| *last_hz >= frequency_hz) {
            return Err(format!(
                "frequency_hz {frequency_hz} does not follow {last_hz}; sort the lines, each frequency once"
            ));
        }
        self.last_hz = Some(frequency_hz);
        if let Some(c) = coherence.filter(|c| !(0.0..=1.0).contains(c)) {
            return Err(format!("coherence is {c}; it lies between 0 and 1"));
        }
        if let Some(sd) = relative_sd.filter(|sd| *sd < LEAST_RELATIVE_SD) {
            let remedy = format!("write a number above {LEAST_RELATIVE_SD}, or leave the column out");
            return Err(format!("relative_sd is {sd}; {remedy}"));
        }
        let is_accepted =
            frequency_hz > 0.0 && value.norm_sqr() > 0.0 && coherence.is_none_or(|c| c >= LEAST_COHERENCE);
        let noise = relative_sd.map(FrfNoise::RelativeSd).or(coherence.map(FrfNoise::Coherence));
        (if is_accepted { &mut self.accepted } else { &mut self.rejected }).push(FrfLine {
            frequency_hz,
            value,
            noise,
        });
        Ok(())
    }

    /// Returns accepted and rejected lines.
    ///
    /// # Errors  no line is accepted.
    pub(super) fn finish(self, has_coherence: bool) -> Result<ReadLines, Fault> {
        if self.accepted.is_empty() {
            let low = "no line has a coherence of 0.8 or more; measure again";
            return Err(if has_coherence { low } else { "holds no line above 0 Hz" }.into());
        }
        Ok((self.accepted, self.rejected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantity;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Returns an FRF (H1 and coherence of `averages` records) with white force and independent response
    /// noise, and its errors; |H| falls from 1.
    fn measured(
        averages: u32,
        (noise, last): (f64, f64),
        random: &mut Xoshiro256PlusPlus,
    ) -> (Frf, Vec<f64>) {
        let mut normal = || {
            let (a, b): (f64, f64) = (random.random_range(f64::MIN_POSITIVE..1.0), random.random());
            Complex64::from_polar((-a.ln()).sqrt(), std::f64::consts::TAU * b)
        };
        let (mut lines, mut rejected, mut errors) = (Vec::new(), Vec::new(), Vec::new());
        for at in 0..400 {
            let level = f64::powf(last, f64::from(at) / 400.0);
            let (mut xx, mut yy, mut xy) = (0.0, 0.0, Complex64::ZERO);
            for _ in 0..averages {
                // The force of a hammer is nearly the same from blow to blow.
                let x = normal();
                let x = x / x.norm();
                let y = x * level + normal() * noise;
                (xx, yy, xy) = (xx + x.norm_sqr(), yy + y.norm_sqr(), xy + x.conj() * y);
            }
            let coherence = xy.norm_sqr() / (xx * yy);
            let line = FrfLine {
                frequency_hz: f64::from(at + 1),
                value: xy / xx,
                noise: Some(FrfNoise::Coherence(coherence)),
            };
            if coherence >= LEAST_COHERENCE {
                lines.push(line);
                errors.push((line.value / level).ln().norm());
            } else {
                rejected.push(line);
            }
        }
        let (response, source) = (String::from("table"), String::from("test"));
        let frf = Frf {
            position: None,
            record: None,
            excitation: response.clone(),
            response,
            quantity: Quantity::Receptance,
            condition: Condition::default(),
            averages: Some(averages),
            source,
            lines,
            rejected,
        };
        (frf, errors)
    }

    /// Squared errors over their estimated variance: mean 1 per component and few beyond three standard
    /// deviations, for few and many averages.
    #[test]
    fn limit_errors_match_their_estimated_deviations() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        for averages in [3, 5, 10, 40] {
            let (mut squares, mut alone) = (Vec::new(), Vec::new());
            for _ in 0..40 {
                let (frf, errors) = measured(averages, (0.02, 0.2), &mut random);
                for ((line, sd), error) in frf.lines.iter().zip(frf.component_sds()).zip(&errors) {
                    squares.push((error / sd.unwrap()).powi(2) / 2.0);
                    alone.push((error / frf.component_sd(line).unwrap()).powi(2) / 2.0);
                }
            }
            let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
            let far = squares.iter().filter(|x| **x > 4.5).count() as f64 / squares.len() as f64;
            // Share of squares over a mean of 9·(n − 1) others beyond three standard deviations: 1.1 % for
            // many averages.
            let expected = (1.0 + 4.5 / (9.0 * f64::from(averages - 1))).powi(-9 * (averages as i32 - 1));
            assert!(
                (0.93..1.07).contains(&mean(&squares)) && far < 1.3 * expected,
                "{averages}: {} {far}, alone {}",
                mean(&squares),
                mean(&alone)
            );
            assert!(averages > 5 || mean(&alone) > 1.5, "{averages}: {}", mean(&alone));
        }
    }

    /// Where noise hides the response, lines are accepted by chance alone and get a standard deviation of 1.
    #[test]
    fn limit_lines_accepted_by_chance_carry_no_information() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
        let (frf, _) = measured(3, (0.1, 0.02), &mut random);
        let lost = |line: &FrfLine| f64::powf(0.02, (line.frequency_hz - 1.0) / 400.0) < 0.05;
        let by_chance: Vec<f64> = frf
            .lines
            .iter()
            .zip(frf.component_sds())
            .filter(|(l, _)| lost(l))
            .map(|(_, sd)| sd.unwrap())
            .collect();
        assert!(by_chance.len() > 3, "{by_chance:?}");
        assert!(by_chance.iter().all(|sd| *sd == 1.0), "{by_chance:?}");
    }
}
