//! Objectives with redrawn data and priors: their minima are draws of the parameters that data and priors
//! leave possible.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use rand::{Rng, RngExt};

use super::{FrfObjective, ModeObjective, ModeSquares};
use crate::Place;
use crate::uncertainty::RANGE_SD;
use numeric::random::normal;
use optimizer::{LeastSquares, NormalEquations};

/// Whole FRFs with redrawn lines and priors.
pub struct RedrawnFrfs<'m> {
    objective: FrfObjective<'m>,
    /// Numbers added to the deviations from the priors, in their order.
    priors: Vec<f64>,
    /// Redrawn centre of the range of each coordinate without a prior; `None` for one with a prior.
    ranges: Vec<Option<f64>>,
}

impl<'m> FrfObjective<'m> {
    /// Draws each line of the FRFs from its weight, the centre of each prior from the prior, and the centre
    /// of each range evenly over the range.
    pub fn redrawn(&self, generator: &mut impl Rng) -> RedrawnFrfs<'m> {
        let mut line = |weight: &f64| {
            let sd = if *weight > 0.0 { 1.0 / weight.sqrt() } else { 0.0 };
            Complex64::new(sd * normal(generator), sd * normal(generator))
        };
        let by: Vec<Vec<Complex64>> =
            self.records.iter().map(|record| record.weight.iter().map(&mut line).collect()).collect();
        let dimension = LeastSquares::dimension(self);
        let here = self.decode(&vec![0.5; dimension]);
        let mut with_prior = vec![false; dimension];
        let priors = self
            .priors(&here)
            .map(|term| with_prior[term.column] = true)
            .map(|()| normal(generator))
            .collect();
        let ranges = with_prior.into_iter().map(|stated| (!stated).then(|| generator.random())).collect();
        RedrawnFrfs { objective: self.shifted(&by), priors, ranges }
    }
}

impl LeastSquares for RedrawnFrfs<'_> {
    fn dimension(&self) -> usize {
        self.ranges.len()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let here = self.objective.decode(place);
        let priors =
            self.objective.priors(&here).zip(&self.priors).map(|(term, by)| by * (2.0 * term.deviation + by));
        LeastSquares::chi_square(&self.objective, place)
            + priors.sum::<f64>()
            + range_squares(&self.ranges, place)
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let mut normal = LeastSquares::normal(&self.objective, place);
        let here = self.objective.decode(place);
        for (term, by) in self.objective.priors(&here).zip(&self.priors) {
            normal.chi_square += by * (2.0 * term.deviation + by);
            normal.gradient[term.column] += by * term.slope;
        }
        add_ranges(&mut normal, &self.ranges, place);
        normal
    }
}

/// Modes with redrawn frequencies, amplitudes, tolerances and priors.
pub struct RedrawnModes<'o, 'm> {
    squares: ModeSquares<'o, 'm>,
    ranges: Vec<Option<f64>>,
    /// Redrawn deviations of the tolerances in prior standard deviations.
    tolerances: DVector<f64>,
    /// Numbers added to the whitened residuals.
    shift: DVector<f64>,
    /// Whitened change of the residuals by one standard deviation of each tolerance.
    whitened: &'o DMatrix<f64>,
}

impl<'m> ModeObjective<'m> {
    /// Returns columns of changes of the residuals in the units in which correlated residuals are
    /// independent.
    pub fn whitened(&self, columns: &[Vec<f64>]) -> DMatrix<f64> {
        let rows = self.rows().iter().sum();
        let changes = DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row]);
        self.whitening.as_ref().map_or_else(|| changes.clone(), |whitening| whitening * &changes)
    }

    /// Draws each residual with the standard deviation `data_sd` in its own units, each tolerance and the
    /// centre of each prior from its prior, and the centre of each range evenly over the range. `whitened` is
    /// that of the columns to which the residuals are correlated.
    pub fn redrawn<'o>(
        &'o self,
        data_sd: f64,
        whitened: &'o DMatrix<f64>,
        generator: &mut impl Rng,
    ) -> RedrawnModes<'o, 'm> {
        let noise = DVector::from_fn(whitened.nrows(), |_, _| data_sd * normal(generator));
        let noise = self.whitening.as_ref().map_or_else(|| noise.clone(), |whitening| whitening * &noise);
        let tolerances = DVector::from_fn(whitened.ncols(), |_, _| normal(generator));
        let shift = noise + whitened * &tolerances;
        let stated = |i: &usize| self.machine.parameters[*i].prior.is_some();
        let gain = self.estimates_gain().then_some(false);
        let priors = self.free.iter().filter(|i| stated(i)).map(|_| normal(generator));
        let all: Vec<f64> = shift.iter().copied().chain(priors).collect();
        let ranges = self
            .free
            .iter()
            .map(stated)
            .chain(gain)
            .map(|stated| (!stated).then(|| generator.random()))
            .collect();
        RedrawnModes {
            squares: ModeSquares::new(self, None).shifted(all),
            ranges,
            tolerances,
            shift,
            whitened,
        }
    }
}

impl RedrawnModes<'_, '_> {
    /// Returns the deviations of the tolerances that belong to a minimum, in prior standard deviations.
    ///
    /// They minimise |r + C·t + ε|² + |t − t₀|², with the residuals r, their noise ε, and t₀ drawn from the
    /// prior.
    pub fn tolerances_at(&self, objective: &ModeObjective<'_>, place: &Place) -> Vec<f64> {
        let residuals = objective.residuals_at(place);
        let left = DVector::from_iterator(self.shift.len(), residuals.iter().take(self.shift.len()).copied())
            + &self.shift;
        (&self.tolerances - self.whitened.transpose() * left).data.into()
    }
}

impl LeastSquares for RedrawnModes<'_, '_> {
    fn dimension(&self) -> usize {
        self.ranges.len()
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        self.squares.chi_square(place) + range_squares(&self.ranges, place)
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let mut normal = self.squares.normal(place);
        add_ranges(&mut normal, &self.ranges, place);
        normal
    }
}

fn range_squares(ranges: &[Option<f64>], place: &[f64]) -> f64 {
    ranges.iter().zip(place).filter_map(|(centre, u)| Some(((u - (*centre)?) / RANGE_SD).powi(2))).sum()
}

fn add_ranges(normal: &mut NormalEquations, ranges: &[Option<f64>], place: &[f64]) {
    normal.chi_square += range_squares(ranges, place);
    for (column, (centre, u)) in ranges.iter().zip(place).enumerate() {
        if let Some(centre) = centre {
            normal.gradient[column] += (u - centre) / (RANGE_SD * RANGE_SD);
            normal.information[(column, column)] += 1.0 / (RANGE_SD * RANGE_SD);
        }
    }
}
