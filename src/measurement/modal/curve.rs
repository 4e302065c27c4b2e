//! One FRF and the options of its modal fit, with their checks.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::ModalError;

/// Smallest number of usable lines of a fit: one mode and the background have eight real unknowns, a line
/// gives two equations.
pub const LEAST_LINES: usize = 12;

/// One frequency response function, e^{+iωt}.
///
/// # Units
///
/// `frequency_hz` Hz, rising, above 0, in any spacing; `receptance` response over force (m/N or any other
/// unit: kept in the results); `component_sd` standard deviation of the real and of the imaginary part of ln
/// H (1), `None` where unknown. `omega_power` is the measured quantity, in which amplitudes are returned: 0
/// receptance, 1 mobility, 2 accelerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfCurve<'a> {
    /// Frequency lines (Hz).
    pub frequency_hz: &'a [f64],
    /// Receptance at the lines.
    pub receptance: &'a [Complex64],
    /// Standard deviation per component of ln H.
    pub component_sd: Option<&'a [f64]>,
    /// Power of iω that converts receptance to the measured quantity.
    pub omega_power: i32,
}

/// Fitted part of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum CurveFit {
    /// All lines; background −L/ω² + U.
    #[default]
    Full,
    /// The lines of a band; modes outside it enter as a background linear in frequency.
    Local {
        /// Lower end (Hz).
        from_hz: f64,
        /// Upper end (Hz).
        to_hz: f64,
    },
}

/// Settings of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveOptions {
    /// Fitted part of the curve.
    pub fit: CurveFit,
    /// Highest polynomial order of the stabilisation diagram over the whole band (two per mode).
    pub max_order: usize,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self { fit: CurveFit::Full, max_order: 48 }
    }
}

/// Checked lines of the fitted band.
#[derive(Debug, Clone)]
pub(super) struct CurveLines {
    /// Angular frequency (rad/s), rising.
    pub omega: Vec<f64>,
    /// Receptance, nowhere 0.
    pub h: Vec<Complex64>,
    /// Standard deviation per component of ln H.
    pub sd: Option<Vec<f64>>,
    /// Whether the background is that of a local fit.
    pub local: bool,
}

impl CurveLines {
    /// Selects the usable lines (H ≠ 0) of the requested band.
    pub fn of(curve: &FrfCurve, options: &CurveOptions) -> Result<Self, ModalError> {
        check(curve)?;
        let (from_hz, to_hz, local) = match options.fit {
            CurveFit::Full => (
                curve.frequency_hz.first().copied().unwrap_or(0.0),
                curve.frequency_hz.last().copied().unwrap_or(0.0),
                false,
            ),
            CurveFit::Local { from_hz, to_hz } if from_hz >= 0.0 && to_hz > from_hz && to_hz.is_finite() => {
                (from_hz, to_hz, true)
            }
            CurveFit::Local { from_hz, to_hz } => return Err(ModalError::Band { from_hz, to_hz }),
        };
        if !curve.receptance.is_empty() && curve.receptance.iter().all(|h| *h == Complex64::ZERO) {
            return Err(ModalError::AllZero { lines: curve.receptance.len() });
        }
        let mut lines =
            Self { omega: Vec::new(), h: Vec::new(), sd: curve.component_sd.map(|_| Vec::new()), local };
        for (at, (f, h)) in curve.frequency_hz.iter().zip(curve.receptance).enumerate() {
            if *f >= from_hz && *f <= to_hz && *h != Complex64::ZERO {
                lines.omega.push(TAU * f);
                lines.h.push(*h);
                if let (Some(sd), Some(all)) = (&mut lines.sd, curve.component_sd) {
                    sd.push(all[at]);
                }
            }
        }
        if lines.len() < LEAST_LINES {
            return Err(ModalError::TooFewLines { found: lines.len(), needed: LEAST_LINES, from_hz, to_hz });
        }
        Ok(lines)
    }

    /// Returns the number of lines.
    pub fn len(&self) -> usize {
        self.omega.len()
    }

    /// Returns the ends of the band (rad/s).
    pub fn band(&self) -> (f64, f64) {
        (self.omega.first().copied().unwrap_or(0.0), self.omega.last().copied().unwrap_or(0.0))
    }

    /// Returns the index of the line nearest to ω.
    pub fn nearest(&self, omega: f64) -> usize {
        let above = self.omega.partition_point(|w| *w < omega).min(self.len() - 1);
        if above > 0 && omega - self.omega[above - 1] < self.omega[above] - omega { above - 1 } else { above }
    }

    /// Returns the spacing of the lines around ω (rad/s).
    pub fn spacing(&self, omega: f64) -> f64 {
        let at = self.nearest(omega);
        let (low, high) = (at.saturating_sub(1), (at + 1).min(self.len() - 1));
        (self.omega[high] - self.omega[low]) / (high - low).max(1) as f64
    }
}

/// Refuses slices of different length, values that are not finite, and frequencies that do not rise.
fn check(curve: &FrfCurve) -> Result<(), ModalError> {
    let lines = curve.frequency_hz.len();
    if curve.receptance.len() != lines {
        return Err(ModalError::Length { what: "receptance", found: curve.receptance.len(), lines });
    }
    if let Some(sd) = curve.component_sd
        && sd.len() != lines
    {
        return Err(ModalError::Length { what: "component_sd", found: sd.len(), lines });
    }
    let mut previous_hz = 0.0;
    for (line, f) in curve.frequency_hz.iter().enumerate() {
        if !(f.is_finite() && *f > 0.0) {
            return Err(ModalError::Value {
                line,
                what: "frequency_hz",
                value: *f,
                remedy: "remove lines at or below 0 Hz",
            });
        }
        if line > 0 && *f <= previous_hz {
            return Err(ModalError::Order { line, frequency_hz: *f, previous_hz });
        }
        previous_hz = *f;
    }
    for (line, h) in curve.receptance.iter().enumerate() {
        if !h.is_finite() {
            let value = if h.re.is_finite() { h.im } else { h.re };
            return Err(ModalError::Value {
                line,
                what: "H",
                value,
                remedy: "remove lines without a finite value",
            });
        }
    }
    for (line, sd) in curve.component_sd.unwrap_or(&[]).iter().enumerate() {
        if !(sd.is_finite() && *sd > 0.0) {
            return Err(ModalError::Value {
                line,
                what: "component_sd",
                value: *sd,
                remedy: "write a number above 0, or give no standard deviations",
            });
        }
    }
    Ok(())
}
