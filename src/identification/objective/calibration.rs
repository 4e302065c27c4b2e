//! Nuisance parameters of the measurement: gain and delay of channels, nut positions.

use nalgebra::DMatrix;

use super::frf::{FrfChannel, SPAN};
use super::{Excitation, FrfObjective};
use crate::Place;
use dynamics::model::Reals;
use machine::ParameterValues;
use measurement::Gain;

/// Gain and delay of one measurement channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Index of the response point.
    pub response: usize,
    /// Excitation.
    pub excitation: Excitation,
    /// ln(gain).
    pub log_gain: f64,
    /// Delay (s).
    pub delay_s: f64,
}

impl FrfObjective<'_> {
    /// Returns the objective with known gains and delays of channels.
    #[must_use]
    pub fn calibrated(mut self, known: &[Channel]) -> Self {
        for own in &mut self.channels {
            if let Some(channel) = known.iter().find(|c| (c.response, c.excitation) == own.points) {
                own.calibration = (channel.log_gain, channel.delay_s);
            }
        }
        self
    }

    /// Returns gain and delay of each channel at given coordinates.
    pub fn channels_at(&self, place: &Place) -> Vec<Channel> {
        let of = |(own, (log_gain, delay_s)): (&FrfChannel, (f64, f64))| {
            let (response, excitation) = own.points;
            Channel { response, excitation, log_gain, delay_s }
        };
        self.channels.iter().zip(self.decode(place).channels).map(of).collect()
    }

    /// Returns the gain of the set or, if it is unknown, the best gain for the given parameters.
    pub fn best_gain(&self, parameters: &ParameterValues) -> f64 {
        if let Gain::Known(gain) = self.gain {
            return gain;
        }
        let here = self.as_stated(parameters, 1.0);
        let (mut weights, mut sum) = (Reals::ZERO, Reals::ZERO);
        for record in &self.records {
            self.visit(record, &here, 0..record.omega_rad_s.len(), |line, r| {
                weights += record.weights(line);
                sum += record.weights(line) * r.re;
            });
        }
        f64::exp(sum.reduce_add() / weights.reduce_add())
    }

    /// Returns the gain at [`FrfObjective::extended`] coordinates.
    pub fn gain(&self, place: &Place) -> f64 {
        self.log_gain(place).exp()
    }

    /// Returns the width of the unit interval of a nut position, gain or delay, in prior standard deviations.
    pub fn span(&self) -> f64 {
        SPAN
    }

    /// Returns the fitted nut positions: stated position (m) and shift (m) at given coordinates.
    pub fn nuts_at(&self, place: &Place) -> Vec<(f64, f64)> {
        let stated = |at: usize| self.records.iter().find(|r| r.nut == at).and_then(|r| r.operating.nut_m);
        self.decode(place)
            .nut_shift_m
            .into_iter()
            .enumerate()
            .filter_map(|(at, shift_m)| Some((stated(at)?, shift_m)))
            .collect()
    }

    /// Whether any of its coordinates has a prior.
    pub fn has_priors(&self) -> bool {
        self.nuts + self.free_channels() > 0
            || self.free.iter().any(|i| self.machine.parameters[*i].prior.is_some())
    }

    /// Prior information on the coordinate of a nut position, or of a channel's gain or delay.
    pub const NUISANCE_INFORMATION: f64 = SPAN * SPAN;

    /// Returns information on all coordinates as that on the others, with nut positions free within their
    /// tolerances.
    ///
    /// # Source  Schur complement: Golub and Van Loan, Matrix Computations, 4th ed. (2013), 3.2.11.
    pub fn without_nuts(&self, information: DMatrix<f64>) -> DMatrix<f64> {
        let nuts: Vec<usize> = self.nut_coordinates().collect();
        let kept: Vec<usize> = (0..information.nrows()).filter(|at| !nuts.contains(at)).collect();
        let of = |rows: &[usize], columns: &[usize]| information.select_rows(rows).select_columns(columns);
        let own = of(&kept, &kept);
        match of(&nuts, &nuts).cholesky() {
            Some(cholesky) => &own - of(&kept, &nuts) * cholesky.solve(&of(&nuts, &kept)),
            None => own,
        }
    }
}
