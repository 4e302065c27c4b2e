//! Objectives as sums of squares, with their derivatives.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::closed_loop::encoder_gradients;
use super::frf::SPAN;
use super::record::{Decoded, FrfRecord, factor, log_factor, pieces, wrapped};
use super::{FrfObjective, FrfSettings, GAIN_RANGE, ModeObjective};
use crate::Place;
use dynamics::model::{ABREAST, Complexes, Frequencies, LANES, Reals};
use machine::Value;
use optimizer::{LeastSquares, NormalEquations};

/// A mode objective with weighted residuals, as in a bootstrap sample; without weights each residual counts
/// once.
pub struct ModeSquares<'o, 'm> {
    objective: &'o ModeObjective<'m>,
    /// Weight of the square of each residual.
    weights: Option<Vec<f64>>,
    /// Numbers added to the residuals; empty for none.
    shift: Vec<f64>,
}

impl<'o, 'm> ModeSquares<'o, 'm> {
    /// Wraps an objective; `weights` has one entry per residual of [`ModeObjective::residuals_at`].
    pub fn new(objective: &'o ModeObjective<'m>, weights: Option<Vec<f64>>) -> Self {
        ModeSquares { objective, weights, shift: Vec::new() }
    }

    /// Adds numbers to the residuals, one each: those of redrawn data and priors.
    #[must_use]
    pub fn shifted(self, shift: Vec<f64>) -> Self {
        ModeSquares { shift, ..self }
    }

    fn residuals(&self, place: &[f64]) -> Vec<f64> {
        self.shifted_by(self.objective.residuals_of(place))
    }

    fn shifted_by(&self, mut residuals: Vec<f64>) -> Vec<f64> {
        residuals.iter_mut().zip(&self.shift).for_each(|(r, by)| *r += by);
        residuals
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
        self.residuals(place).iter().enumerate().map(|(row, r)| self.weight(row) * r * r).sum()
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let dimension = self.dimension();
        let mut normal = NormalEquations::zero(dimension);
        let (residuals, slopes) = self.objective.linearised_of(place);
        for (row, residual) in self.shifted_by(residuals).iter().enumerate() {
            let slopes: Vec<f64> = slopes.row(row).iter().copied().collect();
            normal.add(self.weight(row), *residual, &slopes);
        }
        normal.mirror();
        normal
    }
}

/// Columns of the derivatives: one per unit-cube coordinate.
struct Columns {
    /// Column of each parameter of the machine; `None` for a fixed one.
    of: Vec<Option<usize>>,
    /// d(parameter or nut position)/d(coordinate), column by column; 0 for gains and delays.
    unit: Vec<f64>,
}

/// Prior of a coordinate: its deviation in prior standard deviations, and the derivative of that with respect
/// to the coordinate.
pub(super) struct PriorTerm {
    pub(super) column: usize,
    pub(super) deviation: f64,
    pub(super) slope: f64,
}

/// Returns a deviation over its standard deviation; 0 for a fixed quantity.
fn standardised(deviation: f64, sd: f64) -> f64 {
    if sd > 0.0 { deviation / sd } else { 0.0 }
}

/// Computes Re Σ a*·b, lane by lane.
#[inline]
fn product(a: &[Complexes], b: &[Complexes]) -> Reals {
    let (re, im) = a.iter().zip(b).fold((Reals::ZERO, Reals::ZERO), |(re, im), (a, b)| {
        (a.re.mul_add(b.re, re), a.im.mul_add(b.im, im))
    });
    re + im
}

impl FrfObjective<'_> {
    /// Returns the column of the gain, if it is unknown.
    fn gain_column(&self) -> Option<usize> {
        self.estimates_gain().then_some(self.free.len())
    }

    /// Returns the column of a nut position with a tolerance.
    fn nut_column(&self, nut: usize) -> Option<usize> {
        (nut < self.nuts).then(|| self.free.len() + usize::from(self.estimates_gain()) + nut)
    }

    /// Returns the first of the two columns of a channel with tolerances of gain and delay.
    fn channel_column(&self, channel: usize) -> Option<usize> {
        (channel < self.free_channels())
            .then(|| self.free.len() + usize::from(self.estimates_gain()) + self.nuts + 2 * channel)
    }

    /// Returns the columns of the machine's parameters and of the data's own nuisance parameters.
    fn columns(&self, here: &Decoded) -> Columns {
        let mut of = vec![None; here.parameters.len()];
        let mut unit = vec![0.0; LeastSquares::dimension(self)];
        for (column, (&parameter, slope)) in self.free.iter().zip(&mut unit).enumerate() {
            of[parameter] = Some(column);
            *slope = self.machine.parameters[parameter].unit_slope(here.parameters[parameter]);
        }
        (0..self.nuts)
            .filter_map(|nut| self.nut_column(nut))
            .for_each(|column| unit[column] = SPAN * self.settings.nut_sd_m);
        Columns { of, unit }
    }

    /// Returns the columns on which a record depends: all parameters, the gain, and the record's own nut
    /// position and channel.
    fn columns_of(&self, record: &FrfRecord) -> Vec<usize> {
        let shared = 0..self.free.len() + usize::from(self.estimates_gain());
        let channel = self.channel_column(record.structure);
        shared
            .chain(self.nut_column(record.nut))
            .chain(channel.into_iter().flat_map(|column| [column, column + 1]))
            .collect()
    }

    /// Returns the priors of free parameters, nut positions, and gains and delays of channels.
    pub(super) fn priors<'h>(&'h self, here: &'h Decoded) -> impl Iterator<Item = PriorTerm> + 'h {
        let FrfSettings { nut_sd_m, channel_sd: (gain_sd, delay_sd_s), .. } = self.settings;
        let parameters = self.free.iter().enumerate().filter_map(move |(column, &index)| {
            let (parameter, value) = (&self.machine.parameters[index], here.parameters[index]);
            let slope = parameter.deviation_slope(value)?;
            Some(PriorTerm { column, deviation: parameter.deviation(value)?, slope })
        });
        let channels =
            here.channels.iter().take(self.free_channels()).flat_map(move |(log_gain, delay_s)| {
                [standardised(*log_gain, gain_sd), standardised(*delay_s, delay_sd_s)]
            });
        let own = here.nut_shift_m.iter().map(move |shift_m| shift_m / nut_sd_m).chain(channels);
        let first = self.free.len() + usize::from(self.estimates_gain());
        parameters.chain(own.enumerate().map(move |(at, deviation)| PriorTerm {
            column: first + at,
            deviation,
            slope: SPAN,
        }))
    }

    /// Computes the normal equations of some lines of a record, in unit-cube coordinates.
    fn piece(
        &self,
        record: &FrfRecord,
        here: &Decoded,
        columns: &Columns,
        lines: std::ops::Range<usize>,
    ) -> NormalEquations {
        let own = self.columns_of(record);
        let dimension = own.len();
        let mut chi_square = Reals::ZERO;
        let mut gradient = vec![Reals::ZERO; dimension];
        // Lower triangle, row by row.
        let mut information = vec![Reals::ZERO; dimension * (dimension + 1) / 2];
        self.weighted_rows(record, here, (columns, &own), lines, |_, residuals, slopes| {
            let abreast = residuals.len();
            chi_square += product(residuals, residuals);
            let mut sums = information.iter_mut();
            for (row, (a, slope)) in slopes.chunks_exact(abreast).zip(&mut gradient).enumerate() {
                *slope += product(a, residuals);
                slopes
                    .chunks_exact(abreast)
                    .take(row + 1)
                    .zip(&mut sums)
                    .for_each(|(b, sum)| *sum += product(a, b));
            }
        });
        let mut normal = NormalEquations::zero(columns.unit.len());
        normal.chi_square = chi_square.reduce_add();
        own.iter().zip(gradient).for_each(|(column, sum)| normal.gradient[*column] = sum.reduce_add());
        let mut sums = information.into_iter();
        for (at, row) in own.iter().enumerate() {
            own[..=at]
                .iter()
                .zip(&mut sums)
                .for_each(|(column, sum)| normal.information[(*row, *column)] = sum.reduce_add());
        }
        normal
    }

    /// Calls `each(line, residuals, slopes)` for groups of lines of a record.
    ///
    /// Residuals come group by group. `slopes` holds their derivatives with respect to the record's own
    /// coordinates ([`FrfObjective::columns_of`]), column c of group w at c·groups + w. Both are multiplied
    /// by the square root of the weight, which is 0 past the last line.
    fn weighted_rows(
        &self,
        record: &FrfRecord,
        here: &Decoded,
        (columns, own): (&Columns, &[usize]),
        lines: std::ops::Range<usize>,
        mut each: impl FnMut(usize, &[Complexes], &[Complexes]),
    ) {
        let Columns { of: columns, unit } = columns;
        let unit: Vec<f64> = own.iter().map(|column| unit[*column]).collect();
        let dimension = own.len();
        let of_own = |column: usize| own.iter().position(|known| *known == column);
        let mut scratch = self.borrow(record.structure);
        let (parameters, operating) = (&here.parameters, here.operating(record));
        let nut = self.nut_column(record.nut).and_then(of_own);
        scratch.network.update(self.machine, parameters, &operating);
        let sensitivity = scratch.network.sensitivity(self.machine, parameters, &operating, columns, nut);
        let loops = self.loops(record.structure, (here, operating), &mut scratch.encoders, columns);
        let by_encoders: Vec<_> = scratch
            .encoders
            .iter()
            .map(|of| of.network.sensitivity(self.machine, parameters, &operating, columns, nut))
            .collect();
        let chain = self.machine.chain.at(parameters, &operating);
        // Derivatives of the chain's ln(gain), delay and power with respect to the coordinates.
        let mut chain_slopes: Vec<(usize, (f64, f64, f64))> = Vec::new();
        let numbers = &self.machine.chain;
        let mut push = |value: &Value, slope: &dyn Fn(f64, f64) -> (f64, f64, f64)| {
            value.gradient(parameters, &operating, |p, d| {
                chain_slopes.extend(columns[p].map(|c| (c, slope(d, unit[c]))))
            });
        };
        push(&numbers.gain, &|d, unit| (d / chain.0 * unit, 0.0, 0.0));
        push(&numbers.delay, &|d, unit| (0.0, d * unit, 0.0));
        push(&numbers.power, &|d, unit| (0.0, 0.0, d * unit));
        // Derivatives with respect to the gain of the set and the channel's gain and delay.
        chain_slopes.extend(
            self.gain_column().map(|column| (column, ((GAIN_RANGE.1 / GAIN_RANGE.0).ln(), 0.0, 0.0))),
        );
        if let Some(column) = self.channel_column(record.structure).and_then(of_own) {
            let (gain, delay_s) = self.settings.channel_sd;
            chain_slopes
                .extend([(column, (SPAN * gain, 0.0, 0.0)), (column + 1, (0.0, SPAN * delay_s, 0.0))]);
        }
        let factor = factor(chain, here.channel(record));
        let log_gain = Complexes::real(Reals::splat(here.log_gain));
        let (mut residuals, mut followed) = ([Complexes::ZERO; ABREAST], [Complexes::ZERO; ABREAST]);
        let groups = lines.start / LANES..lines.end.div_ceil(LANES);
        for from in groups.clone().step_by(ABREAST) {
            let some = from..groups.end.min(from + ABREAST);
            let (omegas, at) =
                (&record.lines.omega_rad_s()[some.clone()], Frequencies::of(&record.lines, some));
            let abreast = omegas.len();
            scratch.row.clear();
            scratch.row.resize(dimension * abreast, Complexes::ZERO);
            let mut predicted =
                scratch.network.gradient(at, &sensitivity, &mut scratch.work, &mut scratch.row);
            if let Some(loops) = &loops {
                followed[..abreast].copy_from_slice(predicted);
                let open = encoder_gradients(&mut scratch.encoders, at, &by_encoders, dimension);
                loops.close_with_slopes(
                    omegas,
                    &scratch.encoders,
                    &open,
                    &mut followed[..abreast],
                    &mut scratch.row,
                );
                predicted = &followed[..abreast];
            }
            for (w, (predicted, omega)) in predicted.iter().zip(omegas).enumerate() {
                let line = (from + w) * LANES;
                let root = record.weights(line).sqrt();
                let residual = wrapped(record.measured(line) - predicted.ln() - log_factor(factor, *omega));
                residuals[w] = (residual - log_gain) * root;
                let scaled = predicted.inverse() * -root;
                for (slope, unit) in scratch.row[w..].iter_mut().step_by(abreast).zip(&unit) {
                    *slope = *slope * scaled * *unit;
                }
                for (column, slopes) in &chain_slopes {
                    scratch.row[column * abreast + w] -= log_factor(*slopes, *omega) * root;
                }
            }
            each(from * LANES, &residuals[..abreast], &scratch.row);
        }
        self.give_back(record.structure, scratch);
    }

    /// Returns all terms whose squares sum to χ²: weighted residuals, real and imaginary parts in turn, then
    /// the priors.
    pub fn rows(&self, place: &Place) -> DVector<f64> {
        let here = self.decode(place);
        let priors = self.priors(&here).map(|k| k.deviation);
        DVector::from_vec(self.weighted_residuals(place).iter().copied().chain(priors).collect())
    }

    /// Returns the derivatives of [`FrfObjective::rows`] with respect to the coordinates.
    pub fn slopes(&self, place: &Place) -> DMatrix<f64> {
        let here = self.decode(place);
        let columns = self.columns(&here);
        let count = 2 * self.lines().iter().sum::<usize>();
        let priors: Vec<PriorTerm> = self.priors(&here).collect();
        let mut slopes = DMatrix::zeros(count + priors.len(), LeastSquares::dimension(self));
        (count..).zip(priors).for_each(|(row, k)| slopes[(row, k.column)] = k.slope);
        let mut first = 0;
        for record in &self.records {
            let (lines, own) = (record.omega_rad_s.len(), self.columns_of(record));
            self.weighted_rows(record, &here, (&columns, &own), 0..lines, |from, residuals, derivatives| {
                for (column, groups) in own.iter().zip(derivatives.chunks_exact(residuals.len())) {
                    let mut column = slopes.column_mut(*column);
                    let numbers = groups.iter().flat_map(|group| group.lanes()).flat_map(|z| [z.re, z.im]);
                    let entries = &mut column.as_mut_slice()[2 * (first + from)..2 * (first + lines)];
                    entries.iter_mut().zip(numbers).for_each(|(entry, number)| *entry = number);
                }
            });
            first += lines;
        }
        slopes
    }

    /// Returns the weighted residuals of all lines, without priors.
    pub fn weighted_residuals(&self, place: &Place) -> DVector<f64> {
        let residuals = self.residuals_at(place);
        let parts = self.records.iter().zip(&residuals).flat_map(|(record, r)| {
            r.iter().zip(&record.weight).flat_map(|(r, weight)| [weight.sqrt() * r.re, weight.sqrt() * r.im])
        });
        DVector::from_iterator(2 * residuals.iter().map(Vec::len).sum::<usize>(), parts)
    }
}

impl LeastSquares for FrfObjective<'_> {
    fn dimension(&self) -> usize {
        self.free.len() + usize::from(self.estimates_gain()) + self.nuts + 2 * self.free_channels()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let here = self.decode(place);
        let sums: Vec<f64> = pieces(&self.records)
            .par_iter()
            .map(|(record, lines)| {
                let record = &self.records[*record];
                let (mut sum, gain) = (Reals::ZERO, Complexes::real(Reals::splat(here.log_gain)));
                self.visit(record, &here, lines.clone(), |line, r| {
                    sum += record.weights(line) * (r - gain).norm_sqr()
                });
                sum.reduce_add()
            })
            .collect();
        let chi_square =
            sums.iter().sum::<f64>() + self.priors(&here).map(|k| k.deviation * k.deviation).sum::<f64>();
        if chi_square.is_finite() { chi_square } else { f64::MAX }
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let here = self.decode(place);
        let columns = self.columns(&here);
        let parts: Vec<NormalEquations> = pieces(&self.records)
            .par_iter()
            .map(|(record, lines)| self.piece(&self.records[*record], &here, &columns, lines.clone()))
            .collect();
        let dimension = LeastSquares::dimension(self);
        let mut normal = NormalEquations::zero(dimension);
        parts.iter().for_each(|part| normal.merge(part));
        for PriorTerm { column, deviation, slope } in self.priors(&here) {
            normal.chi_square += deviation * deviation;
            normal.gradient[column] += deviation * slope;
            normal.information[(column, column)] += slope * slope;
        }
        normal.mirror();
        normal
    }
}
