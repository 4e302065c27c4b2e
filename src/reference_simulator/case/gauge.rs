//! Strength of an effect by non-centrality: its whitened change after projection of joints and nuisance
//! parameters.
//!
//! The noise of a line is the noise of the test and, in quadrature, the one per cent that a careful test
//! reproduces after the sensor is mounted anew. Without that term a few lines with a coherence of 0.9999
//! would dominate, and undetectable effects would count. The projection is linear. For larger effects a refit
//! of the joints comes first, and only the nuisance parameters are treated as linear.

use nalgebra::DVector;
use num_complex::Complex64;

use super::fit::{Fit, wrapped};
use super::subject::Subject;
use super::survey::Survey;
use crate::Result;
use crate::projection::Projection;
use crate::sizing::Sizing;

/// Relative error of a line that a careful test reproduces.
pub(super) const REPRODUCED: f64 = 0.01;

/// Settings of the search for the size of an effect.
const SIZING: Sizing =
    Sizing { start: 0.1, trials: 40, close: 0.02, steps: [3.0, 3.0], narrow: 1e-7, leap: 0.0 };

/// Lines, weights and projection of one test of one machine.
pub struct Gauge {
    /// Lines and their noise.
    pub survey: Survey,
    weights: Vec<f64>,
    explained: Projection,
}

/// Part of an effect that joints and nuisance parameters cannot explain.
pub struct Unexplained {
    /// Non-centrality for all lines of the test.
    pub noncentrality: f64,
    /// Whitened squares of the residual at each line of the gauge, summed over all records.
    pub by_line: Vec<f64>,
}

impl Gauge {
    /// Prepares the gauge for a subject without its effects.
    pub fn new(subject: &Subject, survey: Survey) -> Result<Self> {
        let subject = subject.without_effects();
        let weights: Vec<f64> =
            survey.variance.iter().map(|value| (1.0 / (value + REPRODUCED * REPRODUCED)).sqrt()).collect();
        let step = 1e-3;
        let mut moved: Vec<(Subject, f64)> = Vec::new();
        for name in subject.drawn.joints.keys() {
            let mut copy = subject.clone();
            if let Some(value) = copy.drawn.joints.get_mut(name) {
                *value *= f64::exp(step);
            }
            // One standard deviation is a factor of ten: the ranges of machine descriptions.
            moved.push((copy, step / 10f64.ln()));
        }
        for nuisance in subject.nuisance.directions(&survey.channels) {
            moved.push((Subject { nuisance, ..subject.clone() }, 1.0));
        }
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (copy, scale) in moved {
            let change = survey.of(&copy)?;
            columns.push(
                whitened(&change, &survey.base, &weights, survey.share)
                    .into_iter()
                    .map(|value| value / scale)
                    .collect(),
            );
        }
        let explained = Projection::new(&columns)?;
        Ok(Self { survey, weights, explained })
    }

    /// Returns the part of a subject's effects that joints and nuisance parameters cannot explain.
    pub fn unexplained(&self, subject: &Subject) -> Result<Unexplained> {
        let changed = self.survey.of(subject)?;
        let change =
            DVector::from_vec(whitened(&changed, &self.survey.base, &self.weights, self.survey.share));
        let residual = self.explained.residual(&change);
        let count = self.survey.lines_hz.len();
        let mut by_line = vec![0.0; count];
        for (index, value) in residual.iter().enumerate() {
            by_line[(index / 2) % count] += value * value;
        }
        // Squares of the residual plus those of the priors: the minimum of the penalised sum.
        let noncentrality = change.dot(&residual).max(0.0);
        Ok(Unexplained { noncentrality, by_line })
    }

    /// Returns the non-centrality after a nonlinear refit of the joints and a projection of the rest, for
    /// effects that change the joints strongly.
    pub fn after_refit(&self, subject: &Subject) -> Result<f64> {
        let direct = self.unexplained(subject)?.noncentrality;
        if direct < 60.0 {
            return Ok(direct);
        }
        let thin = self.survey.thinned();
        let fit = Fit::of_machine(subject, &thin);
        let found = fit.run(&thin.of(subject)?, &fit.true_point())?;
        let change = whitened(
            &self.survey.of(subject)?,
            &self.survey.of(&fit.at(&found.point))?,
            &self.weights,
            self.survey.share,
        );
        let change = DVector::from_vec(change);
        Ok(change.dot(&self.explained.residual(&change)).clamp(0.0, direct))
    }

    /// Finds the size at which the only effect of a subject has a given non-centrality.
    pub fn size_for(&self, subject: &Subject, wanted: f64) -> Result<f64> {
        let Some(effect) = subject.effects.first().cloned() else {
            return Ok(0.0);
        };
        SIZING.size_for(effect.kind.name(), effect.kind.largest(), wanted, |size| {
            let sized = Subject { effects: vec![effect.sized(size)], ..subject.clone() };
            Ok(self.unexplained(&sized)?.noncentrality)
        })
    }
}

/// Returns ln(H/H₀) over its standard deviation, real and imaginary parts in turn, weighted up to all lines
/// of the test.
fn whitened(changed: &[Complex64], base: &[Complex64], weights: &[f64], share: f64) -> Vec<f64> {
    let up = (1.0 / share).sqrt();
    changed
        .iter()
        .zip(base)
        .zip(weights)
        .flat_map(|((a, b), weight)| {
            let difference = wrapped(a - b);
            [difference.re * weight * up, difference.im * weight * up]
        })
        .collect()
}
