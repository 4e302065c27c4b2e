//! Derivatives of the residuals of natural frequencies and amplitudes.

use nalgebra::DMatrix;

use super::mode_settings::Objective;
use super::modes::{ModeObjective, ModeScratch};
use super::pairing::Deviation;
use super::setup::GAIN_RANGE;
use crate::Place;
use dynamics::model::{Peak, PeakSlopes};
use machine::{Operating, Value};
use numeric::unit::omega_rad_s;

/// Columns of the derivatives: the free parameters, then the gain where it is unknown.
struct Columns {
    /// Column of each parameter of the machine; `None` for a fixed one.
    of: Vec<Option<usize>>,
    /// Column of ln(gain).
    gain: Option<usize>,
    /// d(parameter or ln(gain))/d(coordinate), column by column.
    unit: Vec<f64>,
}

impl ModeObjective<'_> {
    /// Returns [`ModeObjective::residuals_at`] and their derivatives with respect to the coordinates: one row
    /// per residual.
    pub fn linearised_at(&self, place: &Place) -> (Vec<f64>, DMatrix<f64>) {
        self.linearised_of(place)
    }

    /// As [`ModeObjective::linearised_at`] for a place of the optimiser.
    pub(super) fn linearised_of(&self, place: &[f64]) -> (Vec<f64>, DMatrix<f64>) {
        let parameters = self.parameters_of(place).0;
        let (residuals, mut data) = self.data_linearised(place);
        if let Some(whitening) = &self.whitening {
            data = whitening * data;
        }
        let prior_slope = |index: usize| self.machine.parameters[index].deviation_slope(parameters[index]);
        let of_column = |(column, &index): (usize, &usize)| Some((column, prior_slope(index)?));
        let priors: Vec<(usize, f64)> = self.free.iter().enumerate().filter_map(of_column).collect();
        let count = data.nrows();
        let mut slopes = data.resize_vertically(count + priors.len(), 0.0);
        (count..).zip(priors).for_each(|(row, (column, slope))| slopes[(row, column)] = slope);
        (self.with_priors(residuals, &parameters), slopes)
    }

    /// Returns [`ModeObjective::residuals`] of the data alone, as if they were independent, and their
    /// derivatives.
    pub(crate) fn data_linearised(&self, place: &[f64]) -> (Vec<f64>, DMatrix<f64>) {
        let parameters = self.parameters_of(place).0;
        let mut of = vec![None; parameters.len()];
        self.free.iter().enumerate().for_each(|(column, index)| of[*index] = Some(column));
        let slopes =
            self.free.iter().map(|&index| self.machine.parameters[index].unit_slope(parameters[index]));
        let gain_column = self.estimates_gain().then_some(self.free.len());
        let unit = slopes.chain(gain_column.map(|_| (GAIN_RANGE.1 / GAIN_RANGE.0).ln())).collect();
        let columns = Columns { of, gain: gain_column, unit };
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let gain = self.gain_of(place);
        let residuals = self.with_scratch(|scratch| {
            scratch.parameters.clone_from(&parameters);
            for at in 0..self.positions.len() {
                self.predict_one(at, scratch);
                rows.extend(self.rows_of(at, scratch, (gain, &columns)));
            }
            self.residuals(&scratch.predictions, gain)
        });
        let slopes = DMatrix::from_fn(rows.len(), columns.unit.len(), |row, column| {
            rows[row][column] * columns.unit[column]
        });
        (residuals, slopes)
    }

    /// Computes the rows of a predicted position, in the order of its residuals: frequencies, amplitudes,
    /// modes that one side lacks.
    fn rows_of(
        &self,
        at: usize,
        scratch: &mut ModeScratch,
        (gain, columns): (f64, &Columns),
    ) -> Vec<Vec<f64>> {
        let ModeScratch { network, work, parameters, predictions, .. } = scratch;
        let (deviations, operating) = (&predictions[at].deviations, &self.positions[at].operating);
        let predicted: Vec<Peak> = deviations.iter().filter_map(|d| d.predicted).collect();
        let sensitivity = network.sensitivity(self.machine, parameters, operating, &columns.of, None);
        let of_peaks = network.peak_slopes(
            &predicted,
            self.search.omega_power,
            (&sensitivity, columns.unit.len()),
            work,
        );
        let zero = || vec![0.0; columns.unit.len()];
        let mut of_peaks = of_peaks.into_iter();
        let (mut frequencies, mut amplitudes, mut lacking) = (Vec::new(), Vec::new(), zero());
        let all = deviations.iter().map(Deviation::lacking).sum::<f64>().sqrt();
        for d in deviations {
            let amplitude = d
                .observed
                .and_then(|o| o.amplitude)
                .filter(|_| self.settings.objective != Objective::Frequencies);
            let Some((peak, slopes)) = d.predicted.and_then(|peak| Some((peak, of_peaks.next()?))) else {
                frequencies.push(zero());
                amplitudes.extend(amplitude.map(|_| zero()));
                continue;
            };
            let ramp = self.visibility_slopes(d, &peak, &slopes);
            if d.lacking() > 0.0 {
                let by_visibility =
                    0.5 * self.missing() / all * if d.observed.is_some() { -1.0 } else { 1.0 };
                lacking.iter_mut().zip(&ramp).for_each(|(sum, slope)| *sum += by_visibility * slope);
            }
            // The residual of a pair is √visibility·e.
            let seen = d.visibility.sqrt();
            let row = |e: f64, slopes: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
                let by_ramp = if seen > 0.0 { 0.5 * e / seen } else { 0.0 };
                slopes.zip(&ramp).map(|(slope, ramp)| seen * slope + by_ramp * ramp).collect()
            };
            if let Some((observed, measured_hz)) = d.observed.and_then(|o| Some((o, o.frequency_hz?))) {
                let ratio = peak.frequency_hz / measured_hz;
                let sd = self.settings.frequency_sd(observed.frequency_scatter(self.resolution_hz));
                frequencies.push(row(
                    (ratio - 1.0) / sd,
                    &mut slopes.log_frequency.iter().map(|slope| ratio / sd * slope),
                ));
            }
            if let Some(amplitude) = amplitude {
                let (e, sd) = ((gain * peak.amplitude / amplitude).ln(), self.settings.amplitude_sd);
                let slopes = self.log_amplitude_slopes(&peak, &slopes, (parameters, operating), columns);
                amplitudes.push(row(e / sd, &mut slopes.iter().map(|slope| slope / sd)));
            }
        }
        frequencies.into_iter().chain(amplitudes).chain([lacking]).collect()
    }

    /// Computes the derivatives of the visibility of a pair or a lone peak; 0 off its ramp.
    fn visibility_slopes(&self, d: &Deviation, peak: &Peak, slopes: &PeakSlopes) -> Vec<f64> {
        if d.visibility == 0.0 || d.visibility == 1.0 {
            return vec![0.0; slopes.log_frequency.len()];
        }
        let [of_lone, of_pair] = self.candidate_slopes(peak);
        let [by_prominence, by_frequency] = if d.observed.is_some() { of_pair } else { of_lone };
        slopes
            .log_prominence
            .iter()
            .zip(&slopes.log_frequency)
            .map(|(p, f)| by_prominence * p + by_frequency * f)
            .collect()
    }

    /// Computes d ln(recorded amplitude) of a peak, with the measuring chain and the gain.
    fn log_amplitude_slopes(
        &self,
        peak: &Peak,
        slopes: &PeakSlopes,
        at: (&[f64], &Operating),
        columns: &Columns,
    ) -> Vec<f64> {
        let (chain, (parameters, operating)) = (&self.machine.chain, at);
        let (gain, _, power) = chain.at(parameters, operating);
        let log_omega = omega_rad_s(peak.frequency_hz).ln();
        let mut row: Vec<f64> =
            slopes.log_amplitude.iter().zip(&slopes.log_frequency).map(|(a, f)| a + power * f).collect();
        let mut add = |value: &Value, by: f64| {
            value.gradient(parameters, operating, |p, d| {
                columns.of[p].into_iter().for_each(|column| row[column] += by * d)
            });
        };
        add(&chain.gain, 1.0 / gain);
        add(&chain.power, log_omega);
        columns.gain.into_iter().for_each(|column| row[column] = 1.0);
        row
    }
}
