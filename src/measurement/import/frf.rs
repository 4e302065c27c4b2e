//! Imported FRFs and their checks.

use file_access::LARGEST_NUMBER;
use num_complex::Complex64;

use crate::frf::LEAST_RELATIVE_SD;
use crate::{MeasurementError, Quantity};

/// Largest excess of a coherence over 1 (1) that rounding in single precision explains.
const ROUNDING: f64 = 1e-3;

/// Highest frequency (Hz) below which many lines are more likely a time in s or a frequency in kHz: no machine
/// shows a mode there.
const LEAST_BAND_HZ: f64 = 5.0;
/// Least number of lines of such a record: a few may be of a slow test.
const MANY_LINES: usize = 50;

/// An imported FRF, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedFrf {
    /// Name: that of its file, numbered where the file holds several.
    pub name: String,
    /// File of the FRF.
    pub source: String,
    /// Texts that may name a position: identification lines and entity names.
    pub texts: Vec<String>,
    /// Point and direction of the response, for example `7:+Z`.
    pub response: String,
    /// Point and direction of the excitation.
    pub excitation: String,
    /// Direction of the response: ±1, ±2, ±3 along X, Y, Z; ±4, ±5, ±6 about them; 0 where the file states
    /// none.
    pub response_direction: i64,
    /// Direction of the excitation.
    pub excitation_direction: i64,
    /// Whether the excitation is a torque (N·m) instead of a force (N).
    pub by_torque: bool,
    /// Quantity.
    pub quantity: Quantity,
    /// Frequencies (Hz), rising, above 0.
    pub frequency_hz: Vec<f64>,
    /// H in SI units.
    pub values: Vec<Complex64>,
    /// Coherence γ², where the file has it; NaN at a line without it.
    pub coherence: Option<Vec<f64>>,
    /// Relative standard deviation, where the file has it; NaN at a line without it.
    pub relative_sd: Option<Vec<f64>>,
    /// Number of lines dropped (f = 0, or no finite value).
    pub dropped: usize,
    /// Tolerated faults and assumptions.
    pub warnings: Vec<String>,
}

/// Number of lines left out that a warning names.
const MOST_NAMED: usize = 5;

impl ImportedFrf {
    /// Drops the line at 0 Hz and lines without a finite value, clamps coherences that rounding puts above 1,
    /// and refuses invalid data.
    ///
    /// # Errors  a frequency is negative, repeated or falling; no line remains; where `strict`, also a value
    ///   that is not finite and a
    /// coherence outside [0, 1].
    pub(super) fn checked(mut self, strict: bool) -> Result<Self, MeasurementError> {
        let fault = |text: String| MeasurementError::record(&self.source, &self.name, text);
        if let Some(f) = self.frequency_hz.iter().find(|f| !(0.0..=LARGEST_NUMBER).contains(*f)) {
            return Err(fault(format!(
                "a frequency is {f:e} Hz; frequencies are 0 or above, and below {LARGEST_NUMBER:e}"
            )));
        }
        for (at, pair) in self.frequency_hz.windows(2).enumerate() {
            if pair[0] >= pair[1] {
                return Err(fault(format!(
                    "frequency {} Hz (line {}) does not follow {} Hz; sort the lines, each frequency once",
                    pair[1],
                    at + 2,
                    pair[0]
                )));
            }
        }
        if let Some(v) =
            self.values.iter().find(|v| v.re.is_finite() && v.im.is_finite() && v.norm() > LARGEST_NUMBER)
        {
            return Err(fault(format!("a value is {:e}; no quantity in SI units is that large", v.norm())));
        }
        let is_bad = |v: &Complex64| !v.re.is_finite() || !v.im.is_finite();
        let bad = |at: usize| self.frequency_hz[at] > 0.0 && is_bad(&self.values[at]);
        let all_bad: Vec<usize> = (0..self.values.len()).filter(|at| bad(*at)).collect();
        if let Some(&at) = all_bad.first() {
            let count = all_bad.len();
            if strict || count == self.frequency_hz.iter().filter(|f| **f > 0.0).count() {
                return Err(fault(format!(
                    "the value at {} Hz (line {}) is not finite",
                    self.frequency_hz[at],
                    at + 1
                )));
            }
            let named: Vec<String> =
                all_bad.iter().take(MOST_NAMED).map(|at| format!("{} Hz", self.frequency_hz[*at])).collect();
            let more = if count > MOST_NAMED { " …" } else { "" };
            let text = if count == 1 {
                "1 line without a finite value is".into()
            } else {
                format!("{count} lines without a finite value are")
            };
            self.warnings.push(format!("{}: {text} left out, at {}{more}", self.name, named.join(", ")));
        }
        if let Some(sd) =
            self.relative_sd.iter().flatten().find(|sd| !(LEAST_RELATIVE_SD..=LARGEST_NUMBER).contains(*sd))
        {
            return Err(fault(format!(
                "a relative_sd is {sd}; write a number above {LEAST_RELATIVE_SD}, or leave the column out"
            )));
        }
        self.check_coherence(strict)?;
        let keep: Vec<bool> =
            self.frequency_hz.iter().zip(&self.values).map(|(f, v)| *f > 0.0 && !is_bad(v)).collect();
        let left = keep.iter().filter(|k| **k).count();
        self.dropped += keep.len() - left;
        if left == 0 {
            return Err(MeasurementError::record(&self.source, &self.name, "holds no line above 0 Hz"));
        }
        if left < keep.len() {
            let columns = [Some(&mut self.frequency_hz), self.coherence.as_mut(), self.relative_sd.as_mut()];
            columns.into_iter().flatten().for_each(|column| retain(column, &keep));
            retain(&mut self.values, &keep);
        }
        if let (Some(first), Some(last)) = (self.frequency_hz.first(), self.frequency_hz.last())
            && *last < LEAST_BAND_HZ
            && self.frequency_hz.len() >= MANY_LINES
        {
            self.warnings.push(format!(
                "{}: the {} frequencies lie between {first} and {last} Hz, below the modes of any machine; if the column is a time in s, compute FRFs from the time record first (frf), if it is in kHz, state the unit",
                self.name,
                self.frequency_hz.len()
            ));
        }
        Ok(self)
    }

    /// Clamps coherences that rounding puts outside [0, 1]; leaves out a coherence that lies farther outside.
    fn check_coherence(&mut self, strict: bool) -> Result<(), MeasurementError> {
        let Some(coherence) = &mut self.coherence else { return Ok(()) };
        let above_zero =
            || self.frequency_hz.iter().zip(coherence.iter()).filter(|(f, _)| **f > 0.0).map(|(_, c)| *c);
        let farthest = above_zero()
            .filter(|c| c.is_finite())
            .fold(0.5, |far: f64, c| if (c - 0.5).abs() > (far - 0.5).abs() { c } else { far });
        let has_gap = above_zero().any(|c| !c.is_finite());
        let tolerance = if strict { 1e-6 } else { ROUNDING };
        if !(-tolerance..=1.0 + tolerance).contains(&farthest) || (strict && has_gap) {
            let text = format!(
                "a coherence is {}; it lies between 0 and 1",
                if has_gap { f64::NAN } else { farthest }
            );
            if strict {
                return Err(MeasurementError::record(&self.source, &self.name, text));
            }
            self.warnings.push(format!("{}: {text}; the coherence is left out", self.name));
            self.coherence = None;
            return Ok(());
        }
        if !(-1e-6..=1.0 + 1e-6).contains(&farthest) {
            self.warnings.push(format!(
                "{}: a coherence is {farthest}; values outside 0 to 1 are taken as 0 or 1",
                self.name
            ));
        }
        if has_gap {
            self.warnings.push(format!(
                "{}: some lines have no coherence; they are left out where the coherence is used",
                self.name
            ));
        }
        coherence.iter_mut().for_each(|c| *c = if c.is_finite() { c.clamp(0.0, 1.0) } else { f64::NAN });
        Ok(())
    }
}

/// Keeps the marked items.
fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut marks = keep.iter();
    items.retain(|_| marks.next().copied().unwrap_or(false));
}
