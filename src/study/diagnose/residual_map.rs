//! Where the prediction of the machine as described differs from the data: by band, by mode, by channel, and
//! the dynamic stiffness that it lacks.

use num_complex::Complex64;

use crate::{Study, StudyError, StudyResult};
use diagnosis::{Diagnosis, Domain, HypothesisKind, gaps_by_mode, values_of};
use identification::objective::FrfObjective;
use measurement::{FitSet, HoldOutSet};
use report::diagnosis as document;

/// Bands of the residual map.
const BANDS: usize = 12;

/// Returns residuals of all FRFs by band, with the machine as described at its fit.
pub(super) fn residual_map(
    study: &Study,
    (fit, held_out): (&FitSet<'_>, &HoldOutSet<'_>),
    found: &Diagnosis,
) -> StudyResult<Vec<document::ResidualCell>> {
    let Domain::Frf(settings) = found.domain else { return Ok(Vec::new()) };
    let (hypothesis, fitted) = &found.described;
    let all = fit.both(held_out);
    let objective = FrfObjective::held_out(&hypothesis.machine, &all, settings)?;
    let values = values_of(hypothesis, fitted);
    let residuals = objective.residuals(&values, objective.best_gain(&values));
    let frequencies: Vec<Vec<f64>> = objective.records().iter().map(|r| r.frequencies_hz()).collect();
    let (low, high) = (
        frequencies.iter().filter_map(|f| f.first()).fold(f64::INFINITY, |m, f| m.min(*f)),
        frequencies.iter().filter_map(|f| f.last()).fold(0.0_f64, |m, f| m.max(*f)),
    );
    let edge = |at: usize| low * (high / low).powf(at as f64 / BANDS as f64);
    let mut cells = Vec::new();
    for ((&frf, residuals), frequencies) in all.frfs().iter().zip(&residuals).zip(&frequencies) {
        let frf = &study.set.frfs[frf];
        for band in 0..BANDS {
            let (from_hz, to_hz) = (edge(band), edge(band + 1));
            let inside: Vec<Complex64> = frequencies
                .iter()
                .zip(residuals)
                .filter(|(f, _)| **f >= from_hz && (**f < to_hz || band + 1 == BANDS))
                .map(|(_, r)| *r)
                .collect();
            if inside.is_empty() {
                continue;
            }
            let count = inside.len() as f64;
            let mean = inside.iter().sum::<Complex64>() / count;
            cells.push(document::ResidualCell {
                position: frf.position.map_or_else(
                    || frf.record.clone().unwrap_or_default(),
                    |p| study.set.positions[p].name.clone(),
                ),
                channel: format!("{}/{}", frf.response, frf.excitation),
                from_hz,
                to_hz,
                gap: (inside.iter().map(|r| 0.5 * r.norm_sqr()).sum::<f64>() / count).sqrt(),
                log_ratio: mean.re,
                phase_rad: mean.im,
            });
        }
    }
    Ok(cells)
}

/// Returns the gap of each mode over all positions, with the machine as described at its fit.
pub(super) fn by_mode(
    (fit, held_out): (&FitSet<'_>, &HoldOutSet<'_>),
    found: &Diagnosis,
) -> StudyResult<Vec<Option<f64>>> {
    let Domain::Modes(settings) = found.domain else { return Ok(Vec::new()) };
    let (hypothesis, fitted) = &found.described;
    gaps_by_mode(hypothesis, &values_of(hypothesis, fitted), &fit.both(held_out), settings)
        .map_err(StudyError::from)
}

pub(super) fn by_band(map: &[document::ResidualCell]) -> Vec<document::BandGap> {
    let mut bands: Vec<(f64, f64, f64, f64)> = Vec::new();
    for cell in map {
        match bands.iter_mut().find(|b| b.0 == cell.from_hz) {
            Some(band) => (band.2, band.3) = (band.2 + cell.gap * cell.gap, band.3 + 1.0),
            None => bands.push((cell.from_hz, cell.to_hz, cell.gap * cell.gap, 1.0)),
        }
    }
    bands.sort_by(|a, b| a.0.total_cmp(&b.0));
    bands
        .into_iter()
        .map(|(from_hz, to_hz, sum, count)| document::BandGap { from_hz, to_hz, gap: (sum / count).sqrt() })
        .collect()
}

/// # Source  plant–model ratio: a flat magnitude is a gain, a phase in proportion to the frequency a delay
///   (Selvanathan and Tangirala, J. Process
/// Control 20 (2010)).
pub(super) fn ratios(map: &[document::ResidualCell]) -> Vec<document::Ratio> {
    let mut channels: Vec<&String> = map.iter().map(|c| &c.channel).collect();
    channels.sort();
    channels.dedup();
    channels
        .into_iter()
        .map(|channel| {
            let cells: Vec<&document::ResidualCell> = map.iter().filter(|c| c.channel == *channel).collect();
            let count = cells.len() as f64;
            let mean = |of: &dyn Fn(&document::ResidualCell) -> f64| {
                cells.iter().map(|c| of(c)).sum::<f64>() / count
            };
            let log_f = |c: &document::ResidualCell| 0.5 * (c.from_hz * c.to_hz).ln();
            let (x, y) = (mean(&log_f), mean(&|c| c.log_ratio));
            let spread = mean(&|c| (log_f(c) - x).powi(2)).max(1e-12);
            let power = mean(&|c| (log_f(c) - x) * (c.log_ratio - y)) / spread;
            let omega = |c: &document::ResidualCell| std::f64::consts::TAU * (c.from_hz * c.to_hz).sqrt();
            let delay_s = -mean(&|c| omega(c) * c.phase_rad) / mean(&|c| omega(c).powi(2));
            let size = mean(&|c| c.gap * c.gap).sqrt();
            let unexplained = |of: &dyn Fn(&document::ResidualCell) -> f64| mean(&|c| of(c).powi(2)).sqrt();
            let looks_like = if size < 0.02 {
                format!("agrees within {:.1} %", 100.0 * size)
            } else if unexplained(&|c| c.log_ratio - y) < 0.3 * y.abs() && y.abs() > 0.02 {
                format!("constant factor {:.3}, like a gain error", y.exp())
            } else if unexplained(&|c| c.phase_rad + omega(c) * delay_s) < 0.3 * unexplained(&|c| c.phase_rad)
                && unexplained(&|c| c.log_ratio) < 0.5 * unexplained(&|c| c.phase_rad)
            {
                format!("phase proportional to frequency, like a delay of {:.1} µs", 1e6 * delay_s)
            } else {
                let worst = cells.iter().max_by(|a, b| a.gap.total_cmp(&b.gap));
                worst.map_or(String::new(), |c| {
                    format!(
                        "differs by {:.0} % rms, most at {} from {:.0} to {:.0} Hz",
                        100.0 * size,
                        c.position,
                        c.from_hz,
                        c.to_hz
                    )
                })
            };
            document::Ratio { channel: channel.clone(), factor: y.exp(), power, delay_s, looks_like }
        })
        .collect()
}

/// Returns the missing dynamic stiffness at the best interfaces, by their fitted shapes.
pub(super) fn delta_z(found: &Diagnosis) -> Vec<document::DeltaZ> {
    found
        .located
        .iter()
        .take(3)
        .filter_map(|l| {
            let (hypothesis, fitted) = l.candidate.fitted.as_ref()?;
            let HypothesisKind::Interface { interface, shape } = &hypothesis.kind else { return None };
            let values = values_of(hypothesis, fitted);
            let frequency_hz: Vec<f64> =
                (0..120).map(|at| 5.0 * 400.0_f64.powf(f64::from(at) / 119.0)).collect();
            let at = |f: &f64| hypothesis.dynamic_stiffness(&values, std::f64::consts::TAU * f);
            let z: Vec<Complex64> = frequency_hz.iter().filter_map(at).collect();
            Some(document::DeltaZ {
                interface: format!("{interface} ({})", shape.word()),
                real: z.iter().map(|z| z.re).collect(),
                imag: z.iter().map(|z| z.im).collect(),
                frequency_hz,
            })
        })
        .collect()
}
