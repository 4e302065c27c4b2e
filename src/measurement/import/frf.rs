//! Imported FRFs and their checks.

use num_complex::Complex64;

use crate::{MeasurementError, Quantity};

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
    /// Quantity.
    pub quantity: Quantity,
    /// Frequencies (Hz), rising, above 0.
    pub frequency_hz: Vec<f64>,
    /// H in SI units.
    pub values: Vec<Complex64>,
    /// Coherence γ², where the file has it.
    pub coherence: Option<Vec<f64>>,
    /// Number of lines dropped (f = 0).
    pub dropped: usize,
    /// Tolerated faults and assumptions.
    pub warnings: Vec<String>,
}

impl ImportedFrf {
    /// Drops the line at 0 Hz and refuses invalid data.
    ///
    /// # Errors  a frequency is negative, repeated or falling; a value is not finite; a coherence is outside [0, 1]; no line remains.
    pub(super) fn checked(mut self) -> Result<Self, MeasurementError> {
        let fault = |text: String| MeasurementError::record(&self.source, &self.name, text);
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
        if let Some(f) = self.frequency_hz.iter().find(|f| !(**f >= 0.0 && f.is_finite())) {
            return Err(fault(format!("a frequency is {f} Hz; frequencies are 0 or above")));
        }
        if let Some(at) = self.values.iter().position(|v| !v.re.is_finite() || !v.im.is_finite()) {
            return Err(fault(format!("the value at {} Hz is not finite", self.frequency_hz[at])));
        }
        if let Some(c) = self.coherence.iter().flatten().find(|c| !(-1e-9..=1.0 + 1e-6).contains(*c)) {
            return Err(fault(format!("a coherence is {c}; it lies between 0 and 1")));
        }
        self.coherence.iter_mut().flatten().for_each(|c| *c = c.clamp(0.0, 1.0));
        if self.frequency_hz.first() == Some(&0.0) {
            self.frequency_hz.remove(0);
            self.values.remove(0);
            if let Some(coherence) = &mut self.coherence {
                coherence.remove(0);
            }
            self.dropped += 1;
        }
        if self.frequency_hz.is_empty() {
            return Err(fault("holds no line above 0 Hz".into()));
        }
        Ok(self)
    }
}
