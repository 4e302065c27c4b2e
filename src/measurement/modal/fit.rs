//! Modal fit of one curve, with standard deviations.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::curve::{CurveLines, CurveOptions, FrfCurve};
use super::least_squares::{ModalNormalEquations, refine};
use super::model::{ModalModel, PER_MODE, Term};
use super::peak::maximum;
use super::selection::{Task, gains, prune, select};
use super::stabilisation::{Stability, StablePole, candidates};
use super::{ModalError, noise};
use crate::{Frf, FrfLine};

/// Smallest contribution of a mode over the rest of |H| at its frequency (1); a pole below it is background.
const LEAST_PROMINENCE: f64 = 0.02;

/// Largest damping ratio of a mode (1); a pole above it is background.
const MAX_DAMPING: f64 = 0.4;

/// Largest distance of a candidate from its term, as a share of the frequency (1), in addition to half the
/// half-width.
const MATCH_DISTANCE: f64 = 0.005;

/// Definition of an amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AmplitudeKind {
    /// |H| at a local maximum of the measured quantity.
    Peak,
    /// Contribution of a mode without a maximum, at its damped frequency: |r|/σ in the measured quantity.
    Modal,
}

/// Amplitude of a mode in the measured quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitude {
    /// Value (unit of the measured quantity).
    pub value: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// Frequency of the amplitude (Hz).
    pub frequency_hz: f64,
    /// Definition of the value.
    pub kind: AmplitudeKind,
}

/// A mode of one curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedMode {
    /// Natural frequency |p|/2π (Hz).
    pub frequency_hz: f64,
    /// Its standard deviation (Hz).
    pub frequency_sd_hz: f64,
    /// Damping ratio −Re p/|p|.
    pub damping_ratio: f64,
    /// Its standard deviation.
    pub damping_sd: f64,
    /// Amplitude.
    pub amplitude: Amplitude,
    /// Residue of the receptance (its unit times rad/s).
    pub residue: Complex64,
    /// Stability of the pole over the orders; 0 for a pole found in the residual only.
    pub stability: Stability,
    /// Contribution of the mode over the rest of H at the damped frequency (1): well below 1 for a mode
    /// hidden by others.
    pub prominence: f64,
    /// Signal-to-noise ratio: root of the increase of χ² without the mode, over the residual standard
    /// deviation (1).
    pub signal_to_noise: f64,
}

/// Result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalFit {
    /// Modes inside the band, in rising frequency.
    pub modes: Vec<FittedMode>,
    /// Number of lines used.
    pub lines: usize,
    /// Root mean square of |Ĥ − H|/|H|.
    pub relative_misfit: f64,
    model: ModalModel,
    omega_power: i32,
}

impl ModalFit {
    /// Returns the fitted curve in the measured quantity at a frequency (Hz).
    pub fn measured(&self, frequency_hz: f64) -> Complex64 {
        self.model.at(TAU * frequency_hz) * Complex64::new(0.0, TAU * frequency_hz).powi(self.omega_power)
    }
}

/// Estimates the modes of a curve.
///
/// The steps are stabilisation diagram, selection and refinement of the modal model. Standard deviations
/// follow from the Jacobian of the last weighted fit. Where `component_sd` is `None`, the noise is estimated
/// from the residual as a function of frequency. Where it is given and χ² exceeds the degrees of freedom,
/// standard deviations are multiplied by the root of the ratio. Correlated residuals increase them, too.
///
/// # Units      Hz, rad/s and the units of the curve
/// # Errors     a curve or a band out of range; too few lines; all lines zero; singular equations
/// # Source     Guillaume et al. (2003); Verboven, thesis, Vrije Universiteit Brussel (2002), on deviations
///   of modal parameters;
/// Richardson and Formenti, IMAC I (1982), on the rational-fraction form
pub fn fit_curve(curve: &FrfCurve, options: &CurveOptions) -> Result<ModalFit, ModalError> {
    let lines = CurveLines::of(curve, options)?;
    let known = lines.sd.clone();
    let first = known.clone().unwrap_or_else(|| noise::from_curve(&lines));
    let weight = noise::weights(&lines, &first, None);
    let candidates = candidates(&lines, &first.iter().map(|s| 1.0 / s).collect::<Vec<f64>>(), options);
    let floor_of = |sd: &[f64]| {
        if known.is_some() { 1.0 } else { (noise::SD_FLOOR / noise::median(sd.to_vec())).powi(2) }
    };
    let band = lines.band();
    let task = Task { lines: &lines, weight: &weight, floor: floor_of(&first) };
    let mut model = select(&task, &candidates).ok_or(ModalError::Singular {
        modes: candidates.len(),
        from_hz: band.0 / TAU,
        to_hz: band.1 / TAU,
    })?;
    let mut last = weight.clone();
    for round in 0..3 {
        let sd = known.clone().unwrap_or_else(|| noise::from_residual(&lines, &model));
        last = noise::weights(&lines, &sd, Some(&model));
        let task = Task { lines: &lines, weight: &last, floor: floor_of(&sd) };
        refine(&mut model, &lines, &last, 1e-4, if round == 2 { 40 } else { 10 });
        prune(&mut model, &task);
    }
    refine(&mut model, &lines, &last, 1e-9, 40);
    model.terms.sort_by(|a, b| a.pole.im.total_cmp(&b.pole.im));
    finish(&lines, model, &last, &candidates, curve.omega_power)
}

/// Calls a function with an FRF of any quantity as a receptance, with the lines that are used.
pub fn with_curve_of<T>(
    frf: &Frf,
    is_used: impl Fn(&FrfLine) -> bool,
    work: impl FnOnce(&FrfCurve<'_>) -> T,
) -> T {
    let lines: Vec<_> = frf.lines.iter().zip(frf.component_sds()).filter(|(line, _)| is_used(line)).collect();
    let frequency_hz: Vec<f64> = lines.iter().map(|(line, _)| line.frequency_hz).collect();
    let receptance: Vec<_> = lines.iter().map(|(line, _)| frf.receptance(line)).collect();
    // Where no noise is stated, the residual of the modal fit shows it better than neighbouring lines.
    let component_sd: Option<Vec<f64>> = lines.iter().map(|(_, sd)| *sd).collect();
    let component_sd = component_sd.filter(|_| frf.noise_source().is_stated());
    let curve = FrfCurve {
        frequency_hz: &frequency_hz,
        receptance: &receptance,
        component_sd: component_sd.as_deref(),
        omega_power: frf.quantity.power(),
    };
    work(&curve)
}

/// Computes standard deviations, amplitudes and stability of the final model.
fn finish(
    lines: &CurveLines,
    model: ModalModel,
    weight: &[f64],
    candidates: &[StablePole],
    omega_power: i32,
) -> Result<ModalFit, ModalError> {
    let (low, high) = lines.band();
    let singular =
        || ModalError::Singular { modes: model.terms.len(), from_hz: low / TAU, to_hz: high / TAU };
    let task = Task { lines, weight, floor: 0.0 };
    let (_, gains) = gains(&model, &task).ok_or_else(singular)?;
    let normal = ModalNormalEquations::of(&model, lines, weight);
    let (_, covariance) = normal.solve(1e-13, true).ok_or_else(singular)?;
    let degrees_of_freedom = (2.0 * lines.len() as f64 - model.unknowns() as f64).max(1.0);
    let reduced = normal.chi2 / degrees_of_freedom;
    let (relative_misfit, correlation) = noise::misfit(lines, &model, weight);
    let significant = correlation > 3.0 / (2.0 * lines.len() as f64).sqrt();
    let correlated =
        if significant { (1.0 + correlation.min(0.9)) / (1.0 - correlation.min(0.9)) } else { 1.0 };
    let variance = correlated * if lines.sd.is_some() { reduced.max(1.0) } else { reduced };
    let covariance = covariance * variance;
    let stabilities = stabilities(&model, candidates);
    let mut modes = Vec::new();
    for (at, gain) in gains.iter().enumerate() {
        let stability = stabilities[at];
        let signal_to_noise = (gain / variance.max(f64::MIN_POSITIVE)).sqrt();
        let mode = FittedMode {
            stability,
            signal_to_noise,
            ..describe(&model, at, &covariance, (omega_power, (low, high)))
        };
        let inside = (low..=high).contains(&model.terms[at].pole.im);
        if inside && mode.damping_ratio <= MAX_DAMPING && mode.prominence >= LEAST_PROMINENCE {
            modes.push(mode);
        }
    }
    Ok(ModalFit { modes, lines: lines.len(), relative_misfit, model, omega_power })
}

/// Returns the stability of each term: that of the most stable candidate to which it is the nearest term.
fn stabilities(model: &ModalModel, candidates: &[StablePole]) -> Vec<Stability> {
    let none = candidates
        .first()
        .map_or(Stability { stable: 0, orders: 1 }, |c| Stability { stable: 0, ..c.stability });
    let mut found: Vec<Option<Stability>> = vec![None; model.terms.len()];
    for candidate in candidates {
        let distance = |term: &Term| (term.pole - candidate.pole).norm();
        let near = |term: &Term| {
            let change = term.pole.re / candidate.pole.re;
            distance(term) <= MATCH_DISTANCE * candidate.pole.norm() - 0.5 * candidate.pole.re
                && (0.4..=2.5).contains(&change)
        };
        let nearest = (0..found.len())
            .filter(|at| near(&model.terms[*at]))
            .min_by(|a, b| distance(&model.terms[*a]).total_cmp(&distance(&model.terms[*b])));
        if let Some(at) = nearest {
            found[at] = found[at].or(Some(candidate.stability));
        }
    }
    found.into_iter().map(|s| s.unwrap_or(none)).collect()
}

/// Computes frequency, damping, amplitude and prominence of a term.
fn describe(
    model: &ModalModel,
    at: usize,
    covariance: &DMatrix<f64>,
    (omega_power, band): (i32, (f64, f64)),
) -> FittedMode {
    let term = model.terms[at];
    let size = term.pole.norm();
    let first = PER_MODE * at;
    // Indices of ln σ and ln ω, and their weights in ln |p|.
    let (sigma, omega) = (first + 2, first + 3);
    let (share_sigma, share_omega) = ((term.pole.re / size).powi(2), (term.pole.im / size).powi(2));
    let sd = |entries: &[(usize, f64)]| {
        let variance: f64 = entries
            .iter()
            .flat_map(|(i, a)| entries.iter().map(move |(j, b)| a * b * covariance[(*i, *j)]))
            .sum();
        variance.max(0.0).sqrt()
    };
    let damping = -term.pole.re / size;
    let amplitude = match maximum(model, term.pole, omega_power, band) {
        Some(top) => {
            let mut columns = vec![Complex64::ZERO; model.unknowns()];
            let value = model.derivatives(top, &mut columns);
            let slope = DVector::from_iterator(
                columns.len(),
                columns.iter().map(|c| (value.conj() * c).re / value.norm_sqr()),
            );
            let relative = slope.dot(&(covariance * &slope)).max(0.0).sqrt();
            let size = value.norm() * top.powi(omega_power);
            Amplitude { value: size, sd: size * relative, frequency_hz: top / TAU, kind: AmplitudeKind::Peak }
        }
        None => {
            let size = term.residue.norm() / -term.pole.re * term.pole.im.powi(omega_power);
            let gradient = term.residue / term.residue.norm_sqr();
            let relative = sd(&[
                (first, gradient.re),
                (first + 1, gradient.im),
                (sigma, -1.0),
                (omega, f64::from(omega_power)),
            ]);
            Amplitude {
                value: size,
                sd: size * relative,
                frequency_hz: term.pole.im / TAU,
                kind: AmplitudeKind::Modal,
            }
        }
    };
    let own = term.at(term.pole.im);
    FittedMode {
        frequency_hz: size / TAU,
        frequency_sd_hz: size / TAU * sd(&[(sigma, share_sigma), (omega, share_omega)]),
        damping_ratio: damping,
        damping_sd: damping * share_omega * sd(&[(sigma, 1.0), (omega, -1.0)]),
        amplitude,
        residue: term.residue,
        stability: Stability { stable: 0, orders: 0 },
        prominence: own.norm() / (model.at(term.pole.im) - own).norm(),
        signal_to_noise: 0.0,
    }
}
