//! Frequency response functions as measured, with what is known of their noise.

use num_complex::Complex64;

use super::table::Table;
use super::{MeasurementError, Quantity};

/// What is known of the noise of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Noise {
    /// Coherence γ² of an average of so many records.
    Coherence(f64),
    /// Total complex standard deviation of the mean over |H|.
    RelativeSd(f64),
}

/// One frequency line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Frequency (Hz), above 0.
    pub frequency_hz: f64,
    /// H = response / force, e^{+iωt}, in the record's quantity.
    pub value: Complex64,
    /// Its noise, where known.
    pub noise: Option<Noise>,
}

/// Coherence below which a line is not accepted.
pub const LEAST_COHERENCE: f64 = 0.8;

/// Least 1 − γ² that is believed: a coherence printed to four digits.
const LEAST_INCOHERENCE: f64 = 5e-5;

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
    pub lines: Vec<Line>,
    /// Lines read but not accepted (coherence too low, f = 0).
    pub rejected: usize,
}

impl Frf {
    /// Standard deviation of one component (real or imaginary) of ln H at a line; `None` where nothing is known.
    ///
    /// # Source  Bendat and Piersol: (1 − γ²)/(2·n·γ²) for the H1 estimate without leakage.
    pub fn component_sd(&self, line: &Line) -> Option<f64> {
        match line.noise? {
            Noise::Coherence(gamma2) => {
                let averages = f64::from(self.averages?);
                Some(((1.0 - gamma2).max(LEAST_INCOHERENCE) / (2.0 * averages * gamma2)).sqrt())
            }
            Noise::RelativeSd(sd) => Some(sd / std::f64::consts::SQRT_2),
        }
    }
}

/// Reads the lines of `frequency_hz,real,imag[,coherence][,relative_sd]`: accepted lines and the number of the others.
pub(super) fn read_lines(path: &str, text: &str) -> Result<(Vec<Line>, usize), MeasurementError> {
    let table = Table::read(path, text, &["frequency_hz", "real", "imag"], &["coherence", "relative_sd"])?;
    let mut lines: Vec<Line> = Vec::new();
    let mut rejected = 0;
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
        if accepted {
            let noise = relative_sd.map(Noise::RelativeSd).or(coherence.map(Noise::Coherence));
            lines.push(Line { frequency_hz, value, noise });
        } else {
            rejected += 1;
        }
    }
    if lines.is_empty() {
        let fault =
            if table.has("coherence") { "no line has a coherence of 0.8 or more; measure again" } else { "holds no line above 0 Hz" };
        return Err(MeasurementError::file(path, fault));
    }
    Ok((lines, rejected))
}
