//! Frequency response functions as measured, with what is known of their noise.

use num_complex::Complex64;

use super::table::Table;
use super::{MeasurementError, Quantity};

/// What is known of the noise of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrfNoise {
    /// Coherence γ² of an average of so many records.
    Coherence(f64),
    /// Total complex standard deviation of the mean over |H|.
    RelativeSd(f64),
}

/// One frequency line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfLine {
    /// Frequency (Hz), above 0.
    pub frequency_hz: f64,
    /// H = response / force, e^{+iωt}, in the record's quantity.
    pub value: Complex64,
    /// Its noise, where known.
    pub noise: Option<FrfNoise>,
}

/// Coherence below which a line is not accepted.
pub const LEAST_COHERENCE: f64 = 0.8;

/// Least 1 − γ² that is believed: a coherence printed to four digits.
const LEAST_INCOHERENCE: f64 = 5e-5;

/// Lines to either side whose noise is looked at together.
const BESIDE: usize = 4;

/// From so many times the noise beside it on a line's own is no chance.
const APART: f64 = 4.0;

/// The condition under which an FRF was measured, beside its position; what is not stated is absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Condition {
    /// Level of the exciting force (N).
    pub force_level_n: Option<f64>,
    /// Velocity of the table (m/s).
    pub velocity_m_s: Option<f64>,
    /// Acceleration of the table (m/s²).
    pub acceleration_m_s2: Option<f64>,
}

/// A measured FRF.
#[derive(Debug, Clone, PartialEq)]
pub struct Frf {
    /// Index of its position in the set; `None` where the machine has no positions.
    pub position: Option<usize>,
    /// Name of the repeat or record.
    pub record: Option<String>,
    /// Name of the point that responds.
    pub response: String,
    /// Name of the point that is excited.
    pub excitation: String,
    /// Its quantity.
    pub quantity: Quantity,
    /// What the machine did while it was measured.
    pub condition: Condition,
    /// Averages taken.
    pub averages: Option<u32>,
    /// File it came from.
    pub source: String,
    /// Accepted lines in rising frequency.
    pub lines: Vec<FrfLine>,
    /// Lines read but not accepted (coherence too low, f = 0), in rising frequency.
    pub rejected: Vec<FrfLine>,
}

impl Frf {
    /// Standard deviation of one component (real or imaginary) of ln H at a line; `None` where nothing is known.
    ///
    /// # Source  Bendat and Piersol: (1 − γ²)/(2·n·γ²) for the H1 estimate without leakage.
    pub fn component_sd(&self, line: &FrfLine) -> Option<f64> {
        match line.noise? {
            FrfNoise::Coherence(gamma2) => {
                let averages = f64::from(self.averages?);
                Some(((1.0 - gamma2).max(LEAST_INCOHERENCE) / (2.0 * averages * gamma2)).sqrt())
            }
            FrfNoise::RelativeSd(sd) => Some(sd / std::f64::consts::SQRT_2),
        }
    }

    /// As [`Frf::component_sd`] at every line, the noise that a coherence tells taken together with that of the lines beside it, accepted or not:
    /// of few averages each tells it badly, and the lines that seem quietest by chance would weigh most. The noise of the response (its power,
    /// not its share of |H|) changes little from line to line; a line with far more noise than those beside it keeps its own. One that was
    /// accepted where most are not has a high coherence by chance and tells nothing: 1.
    ///
    /// # Source  the coherence that is measured leaves n − 1 of n averages to tell the noise: (1 − γ²)/(2·(n − 1)·γ²), unbiased, the ratio of the
    /// residual to the explained power of a complex regression, with 2(n − 1) degrees of freedom.
    pub fn component_sds(&self) -> Vec<Option<f64>> {
        let freedom = |n: u32| f64::from(n) / f64::from(n.saturating_sub(1).max(1));
        let power = |line: &FrfLine| match line.noise? {
            FrfNoise::Coherence(_) => Some(self.component_sd(line)?.powi(2) * freedom(self.averages?) * line.value.norm_sqr()),
            FrfNoise::RelativeSd(_) => None,
        };
        let mut all: Vec<(f64, bool, f64)> = Vec::with_capacity(self.lines.len() + self.rejected.len());
        for (lines, accepted) in [(&self.lines, true), (&self.rejected, false)] {
            let powers = lines.iter().filter_map(|line| Some((line.frequency_hz, accepted, power(line)?)));
            all.extend(powers.filter(|(_, _, power)| power.is_finite()));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut at = 0;
        let mut of = |line: &FrfLine| {
            let own = power(line)?;
            at += all[at..].iter().position(|(frequency_hz, _, _)| *frequency_hz == line.frequency_hz)?;
            let around = &all[at.saturating_sub(BESIDE)..(at + BESIDE + 1).min(all.len())];
            let count = around.len() as f64;
            if 2.0 * (around.iter().filter(|(_, accepted, _)| *accepted).count() as f64) < count {
                return Some(1.0);
            }
            let sum = around.iter().map(|(_, _, power)| power).sum::<f64>();
            let apart = own * (count - 1.0) > APART * (sum - own);
            Some(((if apart { own } else { sum / count }) / line.value.norm_sqr()).sqrt())
        };
        self.lines.iter().map(|line| of(line).or_else(|| self.component_sd(line))).collect()
    }
}

/// Reads the lines of `frequency_hz,real,imag[,coherence][,relative_sd]`: accepted lines and the others.
pub(super) fn read_lines(path: &str, text: &str) -> Result<(Vec<FrfLine>, Vec<FrfLine>), MeasurementError> {
    let table = Table::read(path, text, &["frequency_hz", "real", "imag"], &["coherence", "relative_sd"])?;
    let mut lines: Vec<FrfLine> = Vec::new();
    let mut rejected = Vec::new();
    let mut last: Option<f64> = None;
    for row in table.rows() {
        let frequency_hz = row.number("frequency_hz")?;
        if frequency_hz < 0.0 {
            return Err(row.fault(format!("frequency_hz is {frequency_hz}; frequencies are 0 or above")));
        }
        if last.is_some_and(|l| l >= frequency_hz) {
            let fault = format!("frequency_hz {frequency_hz} does not follow {}; sort the lines, each frequency once", last.unwrap_or(0.0));
            return Err(row.fault(fault));
        }
        last = Some(frequency_hz);
        let value = Complex64::new(row.number("real")?, row.number("imag")?);
        let coherence = row.optional_number("coherence")?;
        if let Some(c) = coherence.filter(|c| !(0.0..=1.0).contains(c)) {
            return Err(row.fault(format!("coherence is {c}; it lies between 0 and 1")));
        }
        let relative_sd = row.optional_number("relative_sd")?;
        if let Some(sd) = relative_sd.filter(|sd| *sd <= 0.0) {
            return Err(row.fault(format!("relative_sd is {sd}; write a number above 0, or leave the column out")));
        }
        let accepted = frequency_hz > 0.0 && value.norm_sqr() > 0.0 && coherence.is_none_or(|c| c >= LEAST_COHERENCE);
        let noise = relative_sd.map(FrfNoise::RelativeSd).or(coherence.map(FrfNoise::Coherence));
        (if accepted { &mut lines } else { &mut rejected }).push(FrfLine { frequency_hz, value, noise });
    }
    if lines.is_empty() {
        let fault =
            if table.has("coherence") { "no line has a coherence of 0.8 or more; measure again" } else { "holds no line above 0 Hz" };
        return Err(MeasurementError::file(path, fault));
    }
    Ok((lines, rejected))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Quantity;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// H1 and coherence of `averages` records with white force and a response with noise of its own; |H| falls from 1.
    fn measured(averages: u32, (noise, last): (f64, f64), random: &mut Xoshiro256PlusPlus) -> (Frf, Vec<f64>) {
        let mut normal = || {
            let (a, b): (f64, f64) = (random.random_range(f64::MIN_POSITIVE..1.0), random.random());
            Complex64::from_polar((-a.ln()).sqrt(), std::f64::consts::TAU * b)
        };
        let (mut lines, mut rejected, mut errors) = (Vec::new(), Vec::new(), Vec::new());
        for at in 0..400 {
            let level = f64::powf(last, f64::from(at) / 400.0);
            let (mut xx, mut yy, mut xy) = (0.0, 0.0, Complex64::ZERO);
            for _ in 0..averages {
                // A hammer's force is nearly the same from blow to blow.
                let x = normal();
                let x = x / x.norm();
                let y = x * level + normal() * noise;
                (xx, yy, xy) = (xx + x.norm_sqr(), yy + y.norm_sqr(), xy + x.conj() * y);
            }
            let coherence = xy.norm_sqr() / (xx * yy);
            let line = FrfLine { frequency_hz: f64::from(at + 1), value: xy / xx, noise: Some(FrfNoise::Coherence(coherence)) };
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

    /// Squares of errors over what is said of them: mean 1 of a component, and few beyond three standard deviations, for few averages and many.
    #[test]
    fn limit_errors_are_as_large_as_the_lines_together_say() {
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
            // Of squares over a mean of 9·(n − 1) others so many are beyond three standard deviations: 1.1 % for many averages.
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

    /// Where the response drowns, lines are accepted by chance alone, and are said to tell nothing.
    #[test]
    fn limit_lines_accepted_by_chance_tell_nothing() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
        let (frf, _) = measured(3, (0.1, 0.02), &mut random);
        let lost = |line: &FrfLine| f64::powf(0.02, (line.frequency_hz - 1.0) / 400.0) < 0.05;
        let by_chance: Vec<f64> = frf.lines.iter().zip(frf.component_sds()).filter(|(l, _)| lost(l)).map(|(_, sd)| sd.unwrap()).collect();
        assert!(by_chance.len() > 3, "{by_chance:?}");
        assert!(by_chance.iter().all(|sd| *sd == 1.0), "{by_chance:?}");
    }
}
