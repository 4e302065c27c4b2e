//! Strength of an effect by non-centrality: what is left of it after joints and nuisances are projected out, in units of noise.
//!
//! The noise of a line is that of the test and one per cent beside it, in quadrature: what a careful test reproduces after the sensor
//! was mounted anew. Without it the few lines with a coherence of 0.9999 would decide, and effects that nobody can claim would count.
//! The projection is linear; for larger effects the joints are refitted first, and nuisances alone are followed on a straight line.

use nalgebra::DVector;
use num_complex::Complex64;

use super::fit::{Fit, wrapped};
use super::subject::Subject;
use super::survey::Survey;
use crate::TruthError;
use crate::projection::Projection;
use crate::sizing::Sizing;

/// Relative error of a line that a careful test reproduces.
const REPRODUCED: f64 = 0.01;

/// How the size of an effect is looked for.
const SIZING: Sizing = Sizing { start: 0.1, trials: 40, close: 0.02, steps: [3.0, 3.0], narrow: 1e-7, leap: 0.0 };

/// Lines, weights and projection of one test of one machine.
pub struct Gauge {
    /// Lines and their noise.
    pub survey: Survey,
    weights: Vec<f64>,
    explained: Projection,
}

/// What an effect leaves.
pub struct Left {
    /// Non-centrality for all lines of the test.
    pub noncentrality: f64,
    /// Whitened squares left at each line of the gauge, all records together.
    pub by_line: Vec<f64>,
}

impl Gauge {
    /// Prepares the gauge for a subject, whose effects are left out.
    pub fn new(subject: &Subject, survey: Survey) -> Result<Self, TruthError> {
        let subject = subject.without_effects();
        let weights: Vec<f64> = survey.variance.iter().map(|value| (1.0 / (value + REPRODUCED * REPRODUCED)).sqrt()).collect();
        let step = 1e-3;
        let mut moved: Vec<(Subject, f64)> = Vec::new();
        for name in subject.drawn.joints.keys() {
            let mut copy = subject.clone();
            if let Some(value) = copy.drawn.joints.get_mut(name) {
                *value *= f64::exp(step);
            }
            // A factor of ten for one standard deviation: the ranges of machine descriptions.
            moved.push((copy, step / 10f64.ln()));
        }
        for nuisance in subject.nuisance.directions(&survey.channels) {
            moved.push((Subject { nuisance, ..subject.clone() }, 1.0));
        }
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (copy, scale) in moved {
            let change = survey.of(&copy)?;
            columns.push(whitened(&change, &survey.base, &weights, survey.share).into_iter().map(|value| value / scale).collect());
        }
        let explained = Projection::new(&columns)?;
        Ok(Self { survey, weights, explained })
    }

    /// What the effects of a subject leave.
    pub fn left(&self, subject: &Subject) -> Result<Left, TruthError> {
        let changed = self.survey.of(subject)?;
        let change = DVector::from_vec(whitened(&changed, &self.survey.base, &self.weights, self.survey.share));
        let residual = self.explained.residual(&change);
        let count = self.survey.lines_hz.len();
        let mut by_line = vec![0.0; count];
        for (index, value) in residual.iter().enumerate() {
            by_line[(index / 2) % count] += value * value;
        }
        // Squares of what stays and of what the priors charge: the minimum of the penalised sum.
        let noncentrality = change.dot(&residual).max(0.0);
        Ok(Left { noncentrality, by_line })
    }

    /// Non-centrality with the joints refitted on their curve before the rest is projected out: for effects that move the joints far.
    pub fn after_refit(&self, subject: &Subject) -> Result<f64, TruthError> {
        let direct = self.left(subject)?.noncentrality;
        if direct < 60.0 {
            return Ok(direct);
        }
        let thin = self.survey.thinned();
        let fit = Fit::of_machine(subject, &thin);
        let found = fit.run(&thin.of(subject)?, &fit.truth())?;
        let change = whitened(&self.survey.of(subject)?, &self.survey.of(&fit.at(&found.point))?, &self.weights, self.survey.share);
        let change = DVector::from_vec(change);
        Ok(change.dot(&self.explained.residual(&change)).clamp(0.0, direct))
    }

    /// Size at which an effect, the only one of a subject, has a non-centrality.
    pub fn size_for(&self, subject: &Subject, wanted: f64) -> Result<f64, TruthError> {
        let Some(effect) = subject.effects.first().cloned() else {
            return Ok(0.0);
        };
        SIZING.size_for(effect.kind.id(), effect.kind.largest(), wanted, |size| {
            let sized = Subject { effects: vec![effect.sized(size)], ..subject.clone() };
            Ok(self.left(&sized)?.noncentrality)
        })
    }
}

/// ln(H/H₀) over its standard deviation, real and imaginary parts in turn, weighted up to all lines of the test.
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
