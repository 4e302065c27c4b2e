//! Residuals of predicted modes, and the objective computed from them.

use nalgebra::DVector;

use super::mode_settings::Objective;
use super::modes::{ModeObjective, ModeScratch, PositionData, PositionPrediction};
use super::pairing::{Deviation, MISSING};
use crate::Place;
use measurement::Gain;

/// Gain of the measured amplitudes, and the number of amplitudes behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplitudeFit {
    /// Factor from predicted to measured amplitudes.
    pub gain: f64,
    /// Number of amplitudes from which it is computed.
    pub count: usize,
}

impl ModeObjective<'_> {
    /// Returns the weighted residual of a mode without a partner.
    pub(super) fn missing(&self) -> f64 {
        MISSING / self.settings.frequency_model_error.max(1e-6)
    }

    /// Computes the best gain for the predictions in the sense of the objective.
    pub fn amplitude_fit(&self, predictions: &[PositionPrediction]) -> AmplitudeFit {
        if self.settings.objective == Objective::Frequencies {
            return AmplitudeFit { gain: 1.0, count: 0 };
        }
        let ratios = predictions.iter().flat_map(|p| &p.deviations);
        let ratios =
            ratios.filter_map(|d| Some((d.observed?.amplitude?, d.predicted?.amplitude, d.visibility)));
        let (mut count, mut log_sum, mut present, mut sum, mut square) = (0, 0.0, 0.0, 0.0, 0.0);
        for (measured, predicted, share) in ratios {
            count += 1;
            log_sum += share * (measured / predicted).ln();
            present += share;
            sum += predicted / measured;
            square += (predicted / measured) * (predicted / measured);
        }
        let gain = match (self.gain, count, self.settings.objective) {
            (Gain::Known(gain), _, _) => gain,
            (Gain::Unknown, 0, _) => 1.0,
            (Gain::Unknown, _, Objective::Eq26) => sum / square,
            (Gain::Unknown, ..) if present == 0.0 => 1.0,
            (Gain::Unknown, ..) => (log_sum / present).exp(),
        };
        AmplitudeFit { gain, count }
    }

    /// Returns the weighted residuals in a fixed order: for each position frequencies, amplitudes, and one
    /// residual for modes that one side lacks.
    pub fn residuals(&self, predictions: &[PositionPrediction], gain: f64) -> Vec<f64> {
        let mut residuals = Vec::new();
        self.each_residual(predictions, gain, |residual| residuals.push(residual));
        residuals
    }

    fn each_residual(&self, predictions: &[PositionPrediction], gain: f64, mut each: impl FnMut(f64)) {
        for deviations in predictions.iter().map(|p| &p.deviations) {
            let observed =
                || deviations.iter().filter_map(|d| Some((d.observed?, d.predicted, d.visibility.sqrt())));
            for (observed, predicted, present) in observed() {
                each(predicted.map_or(0.0, |peak| {
                    let measured_hz = observed.frequency_hz.unwrap_or(peak.frequency_hz);
                    present * (peak.frequency_hz / measured_hz - 1.0)
                        / self.settings.frequency_sd(observed.frequency_scatter(self.resolution_hz))
                }));
            }
            if self.settings.objective != Objective::Frequencies {
                for (amplitude, predicted, present) in
                    observed().filter_map(|(o, predicted, present)| Some((o.amplitude?, predicted, present)))
                {
                    each(predicted.map_or(0.0, |peak| {
                        present * (gain * peak.amplitude / amplitude).ln() / self.settings.amplitude_sd
                    }));
                }
            }
            each(self.missing() * f64::sqrt(deviations.iter().map(Deviation::lacking).sum()));
        }
    }

    /// Returns the deviations of free parameters from their priors, in prior standard deviations.
    fn prior_deviations<'p>(&'p self, parameters: &'p [f64]) -> impl Iterator<Item = f64> + 'p {
        let described = |i: &usize| &self.machine.parameters[*i];
        self.free.iter().filter_map(move |i| described(i).deviation(parameters[*i]))
    }

    /// Returns all weighted residuals at [`ModeObjective::extended`] coordinates, with those of the priors
    /// last.
    pub fn residuals_at(&self, place: &Place) -> Vec<f64> {
        self.residuals_of(place)
    }

    /// As [`ModeObjective::residuals_at`] for a place of the optimiser.
    pub(super) fn residuals_of(&self, place: &[f64]) -> Vec<f64> {
        let parameters = self.parameters_of(place);
        self.with_priors(self.residuals(&self.predict(&parameters), self.gain_of(place)), &parameters)
    }

    /// Returns residuals of the data, made independent, and those of the priors after them.
    pub(super) fn with_priors(&self, mut residuals: Vec<f64>, parameters: &[f64]) -> Vec<f64> {
        if let Some(whitening) = &self.whitening {
            residuals = (whitening * DVector::from_vec(residuals)).data.into();
        }
        residuals.extend(self.prior_deviations(parameters));
        residuals
    }

    /// Returns the number of rows of each position in [`ModeObjective::residuals`].
    pub fn rows(&self) -> Vec<usize> {
        let counts_amplitudes = self.settings.objective != Objective::Frequencies;
        let amplitudes = |p: &PositionData| {
            p.observed.iter().filter(|m| counts_amplitudes && m.amplitude.is_some()).count()
        };
        self.positions.iter().map(|p| p.observed.len() + amplitudes(p) + 1).collect()
    }

    /// Whether the sum of squared residuals is a likelihood, so that intervals can be computed.
    pub fn is_likelihood(&self) -> bool {
        self.settings.objective != Objective::Eq26
    }

    /// Returns the objective at given coordinates, always finite. Above `limit` any value above it may be
    /// returned.
    pub fn cost_at(&self, place: &[f64], limit: f64) -> f64 {
        self.with_scratch(|scratch| {
            self.parameters_into(place, &mut scratch.parameters);
            self.cost_at_most(scratch, limit)
        })
    }

    /// Evaluates position by position and stops above the limit.
    ///
    /// With the gain at its best for the positions so far, a sum of squares can only rise with each further
    /// one. Eq. 26 has no such bound.
    fn cost_at_most(&self, scratch: &mut ModeScratch, limit: f64) -> f64 {
        let may_end = limit < f64::INFINITY && self.settings.objective != Objective::Eq26;
        let mut cost = 0.0;
        for at in 0..self.positions.len() {
            self.predict_one(at, scratch);
            if may_end || at + 1 == self.positions.len() {
                cost = self.cost_of(&scratch.predictions[..=at], &scratch.parameters);
            }
            if may_end && cost > limit * (1.0 + 1e-9) {
                break;
            }
        }
        cost
    }

    /// Returns the objective of predictions for some positions.
    fn cost_of(&self, predictions: &[PositionPrediction], parameters: &[f64]) -> f64 {
        let gain = self.amplitude_fit(predictions).gain;
        match self.settings.objective {
            Objective::LeastSquares | Objective::Frequencies => {
                let mut data = 0.0;
                self.each_residual(predictions, gain, |residual| data += residual * residual);
                data + self.prior_deviations(parameters).map(|r| r * r).sum::<f64>()
            }
            Objective::Eq26 => {
                let mut sum = 0.0;
                for deviation in predictions.iter().flat_map(|p| &p.deviations) {
                    sum += match (deviation.observed, deviation.pair()) {
                        (Some(observed), Some((_, peak))) => {
                            let frequency =
                                observed.frequency_hz.map_or(0.0, |f| peak.frequency_hz / f - 1.0);
                            let amplitude = observed
                                .amplitude
                                .map_or(0.0, |a| (gain * peak.amplitude / a - 1.0).clamp(-1e3, 1e3));
                            frequency * frequency + amplitude * amplitude
                        }
                        // Both terms of a mode that is not predicted are 1.
                        (Some(observed), None) => 1.0 + f64::from(u8::from(observed.amplitude.is_some())),
                        _ => 0.0,
                    };
                }
                f64::sqrt(sum)
            }
        }
    }
}
