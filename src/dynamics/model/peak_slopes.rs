//! Derivatives of peaks of |H| with parameters.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::assembled_model::AssembledModel;
use super::frequency_grid::Frequencies;
use super::peaks::Peak;
use super::sensitivity::Sensitivity;
use super::simd::{ABREAST, Complexes, LANES, grouped};
use super::solution::Row;
use super::workspace::Workspace;

/// Half the distance of the two frequencies from which second derivatives at a peak are computed, relative to
/// its frequency. Far below the width of any peak, far above the rounding of a first derivative.
const STEP: f64 = 1e-6;

/// Derivatives of a peak with the columns of a [`Sensitivity`].
#[derive(Debug, Clone, PartialEq)]
pub struct PeakSlopes {
    /// d ln(frequency).
    pub log_frequency: Vec<f64>,
    /// d ln(amplitude).
    pub log_amplitude: Vec<f64>,
    /// d ln(prominence).
    pub log_prominence: Vec<f64>,
}

impl AssembledModel {
    /// Computes the derivatives of peaks of |H|·ω^p with `columns` columns.
    ///
    /// A peak is where g(ω, θ) = ln|H| + p·ln ω has no slope, so that dω/dθ = −(∂²g/∂ω∂θ)/(∂²g/∂ω²) and
    /// d(amplitude)/dθ is its partial derivative. The second derivatives are differences of exact first ones
    /// at two frequencies close to the peak.
    ///
    /// # Source  implicit function theorem; envelope theorem.
    pub fn peak_slopes(
        &self,
        peaks: &[Peak],
        omega_power: i32,
        (sensitivity, columns): (&Sensitivity, usize),
        work: &mut Workspace,
    ) -> Vec<PeakSlopes> {
        let omegas: Vec<f64> = peaks
            .iter()
            .flat_map(|peak| {
                let at = TAU * peak.frequency_hz;
                [at * (1.0 - STEP), at * (1.0 + STEP), TAU * peak.valley_hz]
            })
            .collect();
        let mut points = Vec::new();
        self.at_each(&omegas, work, &mut points);
        let by_column = self.log_slopes(&points, (sensitivity, columns), work);
        let by_omega =
            |point: &Row| (point.slope / point.receptance).re + f64::from(omega_power) / point.omega_rad_s;
        let of_peak = |(points, by_column): (&[Row], &[Vec<f64>])| {
            let bend = by_omega(&points[1]) - by_omega(&points[0]);
            let middle = 0.5 * (points[0].omega_rad_s + points[1].omega_rad_s);
            let each = |of: &dyn Fn(f64, f64, f64) -> f64| {
                (0..columns).map(|c| of(by_column[0][c], by_column[1][c], by_column[2][c])).collect()
            };
            PeakSlopes {
                log_frequency: each(&|below, above, _| -(above - below) / (bend * middle)),
                log_amplitude: each(&|below, above, _| 0.5 * (below + above)),
                log_prominence: each(&|below, above, valley| 0.5 * (below + above) - valley),
            }
        };
        points.chunks_exact(3).zip(by_column.chunks_exact(3)).map(of_peak).collect()
    }

    /// Computes d ln|H| with each column at some frequencies.
    fn log_slopes(
        &self,
        points: &[Row],
        (sensitivity, columns): (&Sensitivity, usize),
        work: &mut Workspace,
    ) -> Vec<Vec<f64>> {
        let mut slopes = Vec::with_capacity(points.len());
        for some in points.chunks(ABREAST * LANES) {
            let omegas: Vec<f64> = some.iter().map(|p| p.omega_rad_s).collect();
            let (groups, abreast) = grouped(&omegas);
            let mut gradient = vec![Complexes::ZERO; columns * abreast];
            self.gradient(Frequencies::any(&groups[..abreast]), sensitivity, work, &mut gradient);
            let lanes: Vec<[Complex64; LANES]> = gradient.iter().map(|group| group.lanes()).collect();
            slopes.extend(some.iter().enumerate().map(|(at, point)| {
                let of =
                    |column: usize| (lanes[column * abreast + at / LANES][at % LANES] / point.receptance).re;
                (0..columns).map(of).collect()
            }));
        }
        slopes
    }
}
