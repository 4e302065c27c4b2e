//! Objectives as sums of squares: FRFs with exact derivatives; modes by central differences, since peaks of |H| have no closed form.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use rayon::prelude::*;

use super::frf::SPAN;
use super::record::{Here, Record, log_factor, pieces, wrapped};
use super::{FrfObjective, GAIN_RANGE, ModeObjective};
use crate::model::{ABREAST, Complexes, LANES, Reals};
use crate::optimizer::{LeastSquares, Normal};

/// Step of the central differences in the unit interval.
const STEP: f64 = 2e-4;

/// A mode objective whose residuals count with weights, as in a bootstrap sample; without weights each counts once.
pub struct ModeSquares<'o, 'm> {
    objective: &'o ModeObjective<'m>,
    /// Weight of the square of each residual.
    weights: Option<Vec<f64>>,
}

impl<'o, 'm> ModeSquares<'o, 'm> {
    /// Of an objective; `weights` one for each residual of [`ModeObjective::residuals_at`].
    pub fn new(objective: &'o ModeObjective<'m>, weights: Option<Vec<f64>>) -> Self {
        ModeSquares { objective, weights }
    }

    fn weight(&self, row: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w.get(row).copied().unwrap_or(1.0))
    }
}

impl LeastSquares for ModeSquares<'_, '_> {
    fn dimension(&self) -> usize {
        self.objective.free.len() + usize::from(self.objective.estimates_gain())
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        self.objective.residuals_at(place).iter().enumerate().map(|(row, r)| self.weight(row) * r * r).sum()
    }

    fn normal(&self, place: &[f64]) -> Normal {
        let dimension = self.dimension();
        let here = self.objective.residuals_at(place);
        let columns: Vec<Vec<f64>> = (0..dimension)
            .into_par_iter()
            .map(|column| {
                let shifted = |by: f64| {
                    let mut other = place.to_vec();
                    other[column] = (other[column] + by).clamp(0.0, 1.0);
                    other
                };
                let (low, high) = (shifted(-STEP), shifted(STEP));
                let width = high[column] - low[column];
                let (from, to) = (self.objective.residuals_at(&low), self.objective.residuals_at(&high));
                to.iter().zip(&from).map(|(b, a)| (b - a) / width).collect()
            })
            .collect();
        let mut normal = Normal::zero(dimension);
        for (row, residual) in here.iter().enumerate() {
            let slopes: Vec<f64> = columns.iter().map(|c| c[row]).collect();
            normal.add(self.weight(row), *residual, &slopes);
        }
        normal.mirror();
        normal
    }
}

impl FrfObjective<'_> {
    /// Column of the gain, where it is unknown.
    fn gain_column(&self) -> Option<usize> {
        self.estimates_gain().then_some(self.free.len())
    }

    /// Column of a nut position that is known only to a standard deviation.
    fn nut_column(&self, nut: usize) -> Option<usize> {
        (nut < self.nuts).then(|| self.free.len() + usize::from(self.estimates_gain()) + nut)
    }

    /// First of the two columns of a channel whose gain and delay are known only to a standard deviation.
    fn channel_column(&self, channel: usize) -> Option<usize> {
        (channel < self.channels()).then(|| self.free.len() + usize::from(self.estimates_gain()) + self.nuts + 2 * channel)
    }

    /// Normal equations of some lines of a record, in coordinates of the unit cube.
    fn piece(&self, record: &Record, here: &Here, columns: &[Option<usize>], lines: std::ops::Range<usize>) -> Normal {
        let mut normal = Normal::zero(LeastSquares::dimension(self));
        self.rows(record, here, columns, lines, |weight, residual, slopes| normal.add(weight, residual, slopes));
        normal
    }

    /// Calls `each(weight, residual, slopes)` for real and imaginary part of some lines of a record, in coordinates of the unit cube.
    fn rows(
        &self,
        record: &Record,
        here: &Here,
        columns: &[Option<usize>],
        lines: std::ops::Range<usize>,
        mut each: impl FnMut(f64, f64, &[f64]),
    ) {
        let dimension = LeastSquares::dimension(self);
        let mut scratch = self.borrow(record.structure);
        let (parameters, operating) = (&here.parameters, here.operating(record));
        let nut = self.nut_column(record.nut);
        scratch.network.update(self.machine, parameters, &operating);
        let sensitivity = scratch.network.sensitivity(self.machine, parameters, &operating, columns, nut);
        let chain = self.machine.chain.at(parameters, &operating);
        let mut chain_slopes: Vec<(usize, usize, f64)> = Vec::new();
        for (which, value) in [&self.machine.chain.gain, &self.machine.chain.delay, &self.machine.chain.power].into_iter().enumerate() {
            value.gradient(parameters, &operating, |p, d| chain_slopes.extend(columns[p].map(|c| (which, c, d))));
        }
        // From parameters to the unit cube.
        let mut unit = vec![0.0; dimension];
        for (slope, i) in unit.iter_mut().zip(&self.free) {
            *slope = self.machine.parameters[*i].unit_slope(parameters[*i]);
        }
        nut.into_iter().for_each(|column| unit[column] = SPAN * self.settings.nut_sd_m);
        let channel = here.channel(record);
        let (mut re, mut im) = (vec![0.0; dimension], vec![0.0; dimension]);
        let mut slopes = vec![[Complex64::default(); LANES]; dimension];
        let groups = lines.start / LANES..lines.end.div_ceil(LANES);
        for from in groups.clone().step_by(ABREAST) {
            let omegas = &record.lines.omega_rad_s()[from..groups.end.min(from + ABREAST)];
            scratch.row.clear();
            scratch.row.resize(dimension * omegas.len(), Complexes::ZERO);
            let predicted = scratch.network.gradient(omegas, &sensitivity, &mut scratch.work, &mut scratch.row);
            for (w, (predicted, omega)) in predicted.iter().zip(omegas).enumerate() {
                let first = (from + w) * LANES;
                let residuals = wrapped(record.measured(first) - predicted.ln() - log_factor(chain, channel, *omega)).apart();
                let inverse = predicted.inverse();
                for (slopes, row) in slopes.iter_mut().zip(scratch.row[w..].iter().step_by(omegas.len())) {
                    *slopes = (*row * inverse).apart();
                }
                for (lane, line) in (first..lines.end.min(first + LANES)).enumerate() {
                    let (omega, residual) = (record.omega_rad_s[line], residuals[lane]);
                    for (column, (slope, all)) in unit.iter().zip(&slopes).enumerate() {
                        (re[column], im[column]) = (-all[lane].re * slope, -all[lane].im * slope);
                    }
                    for &(which, column, slope) in &chain_slopes {
                        let by = slope
                            * unit[column]
                            * match which {
                                0 => Complex64::new(1.0 / chain.0, 0.0),
                                1 => Complex64::new(0.0, -omega),
                                _ => Complex64::new(omega.ln(), std::f64::consts::FRAC_PI_2),
                            };
                        re[column] -= by.re;
                        im[column] -= by.im;
                    }
                    if let Some(column) = self.gain_column() {
                        (re[column], im[column]) = (-(GAIN_RANGE.1 / GAIN_RANGE.0).ln(), 0.0);
                    }
                    if let Some(column) = self.channel_column(record.structure) {
                        (re[column], im[column]) = (-SPAN * self.settings.channel_sd.0, 0.0);
                        (re[column + 1], im[column + 1]) = (0.0, omega * SPAN * self.settings.channel_sd.1);
                    }
                    each(record.weight[line], residual.re - here.log_gain, &re);
                    each(record.weight[line], residual.im, &im);
                }
            }
        }
        self.give_back(record.structure, scratch);
    }

    /// Weighted residuals of all lines, real and imaginary parts in turn, and their derivatives with the place, row by row.
    pub fn weighted(&self, place: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let (here, columns) = (self.here(place), self.columns());
        let dimension = LeastSquares::dimension(self);
        let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
        for record in &self.records {
            self.rows(record, &here, &columns, 0..record.omega_rad_s.len(), |weight, residual, row| {
                residuals.push(weight.sqrt() * residual);
                slopes.extend(row.iter().map(|d| weight.sqrt() * d));
            });
        }
        let count = residuals.len();
        (DVector::from_vec(residuals), DMatrix::from_row_slice(count, dimension, &slopes))
    }

    /// Weighted residuals alone.
    pub fn weighted_residuals(&self, place: &[f64]) -> DVector<f64> {
        let residuals = self.residuals_at(place);
        let parts = self
            .records
            .iter()
            .zip(&residuals)
            .flat_map(|(record, r)| r.iter().zip(&record.weight).flat_map(|(r, weight)| [weight.sqrt() * r.re, weight.sqrt() * r.im]));
        DVector::from_iterator(2 * residuals.iter().map(Vec::len).sum::<usize>(), parts)
    }
}

impl LeastSquares for FrfObjective<'_> {
    fn dimension(&self) -> usize {
        self.free.len() + usize::from(self.estimates_gain()) + self.nuts + 2 * self.channels()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let here = self.here(place);
        let sums: Vec<f64> = pieces(&self.records)
            .par_iter()
            .map(|(record, lines)| {
                let record = &self.records[*record];
                let (mut sum, gain) = (Reals::ZERO, Complexes::real(Reals::splat(here.log_gain)));
                self.visit(record, &here, lines.clone(), |line, r| sum += record.weights(line) * (r - gain).norm_sqr());
                sum.reduce_add()
            })
            .collect();
        let chi_square = sums.iter().sum::<f64>() + self.prior(&here);
        if chi_square.is_finite() { chi_square } else { f64::MAX }
    }

    fn normal(&self, place: &[f64]) -> Normal {
        let here = self.here(place);
        let columns = self.columns();
        let parts: Vec<Normal> = pieces(&self.records)
            .par_iter()
            .map(|(record, lines)| self.piece(&self.records[*record], &here, &columns, lines.clone()))
            .collect();
        let dimension = LeastSquares::dimension(self);
        let mut normal = Normal::zero(dimension);
        parts.iter().for_each(|part| normal.merge(part));
        let mut known = |column: usize, residual: f64, slope: f64| {
            let mut row = vec![0.0; dimension];
            row[column] = slope;
            normal.add(1.0, residual, &row);
        };
        for (column, &index) in self.free.iter().enumerate() {
            let parameter = &self.machine.parameters[index];
            if let Some(sd) = parameter.sd {
                let value = here.parameters[index];
                known(column, (value - parameter.start) / sd, parameter.unit_slope(value) / sd);
            }
        }
        for (nut, shift_m) in here.nut_shift_m.iter().enumerate() {
            self.nut_column(nut).into_iter().for_each(|column| known(column, shift_m / self.settings.nut_sd_m, SPAN));
        }
        for (channel, (log_gain, delay_s)) in here.channels.iter().enumerate() {
            if let Some(column) = self.channel_column(channel) {
                known(column, log_gain / self.settings.channel_sd.0, SPAN);
                known(column + 1, delay_s / self.settings.channel_sd.1, SPAN);
            }
        }
        normal.mirror();
        normal
    }
}
