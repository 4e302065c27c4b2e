//! Strength of an effect as the fitted data show it: the misfit that remains after joints and tolerances are
//! fitted along.
//!
//! The machine without the effect is fitted to noise-free data of the machine with it, at the positions that
//! a diagnosis is given:
//!
//! ```text
//! min over u of  |r(u)|² + |u|²
//! ```
//!
//! r is the difference of ln H over its standard deviation, as in the module `gauge`; u counts joints and
//! tolerances in standard deviations from their true values. The priors are normal without bounds. They are
//! centred at the truth: so centred, the fit without an effect leaves 0, and the cross term with the truth's
//! own deviation, whose mean over machines is 0, is left out. The search begins at the truth's joints, and at
//! those that robust refits of the described and of the true machine give to the data; the least misfit
//! counts.

use num_complex::Complex64;

use super::fit::{Fit, wrapped};
use super::gauge::REPRODUCED;
use super::subject::Subject;
use super::survey::Survey;
use crate::Result;
use crate::least_squares::{Minimum, minimum};
use crate::machine::leeway::Leeway;

/// Non-centrality below which an effect may be none: even with its exact shape known, so small a change of χ²
/// does not outweigh prior odds among some twenty candidates, each at several sizes and shapes, against none.
pub const VISIBLE: f64 = 20.0;

/// A machine without its effects, the given positions of its test, and all that may be fitted along.
pub struct FittedGauge {
    /// The machine without its effects.
    pub family: Subject,
    /// Numbers that are fitted along.
    pub leeway: Vec<Leeway>,
    positions: Vec<usize>,
    survey: Survey,
    weights: Vec<f64>,
}

impl FittedGauge {
    /// Prepares the gauge of a machine for the given positions of its test.
    pub fn new(subject: &Subject, survey: &Survey, positions: Vec<usize>) -> Self {
        let block = survey.base.len() / subject.drawn.nut_m.len();
        let up = 1.0 / survey.share;
        let weight = |variance: &f64| (up / (variance + REPRODUCED * REPRODUCED)).sqrt();
        let weights = positions
            .iter()
            .flat_map(|position| survey.variance[position * block..(position + 1) * block].iter().map(weight))
            .collect();
        let leeway = Leeway::all(&subject.drawn, &subject.nuisance, &positions, &survey.channels);
        Self { family: subject.without_effects(), leeway, positions, survey: survey.clone(), weights }
    }

    /// Returns ln H of a subject at the given positions.
    pub fn data(&self, subject: &Subject) -> Result<Vec<Complex64>> {
        self.survey.at_positions(subject, &self.positions)
    }

    /// Returns a subject with its joints and tolerances shifted, in standard deviations.
    pub fn shifted(&self, subject: &Subject, by: &[f64]) -> Subject {
        let mut shifted = subject.clone();
        for (leeway, by) in self.leeway.iter().zip(by) {
            leeway.shift(&mut shifted.drawn, &mut shifted.nuisance, *by);
        }
        shifted
    }

    /// Returns the whitened difference of data to a subject.
    pub fn residual(&self, data: &[Complex64], subject: &Subject) -> Result<Vec<f64>> {
        let model = self.data(subject)?;
        let differences = data.iter().zip(&model).zip(&self.weights);
        let whitened = |((data, model), weight): ((&Complex64, &Complex64), &f64)| {
            let difference = wrapped(data - model) * *weight;
            [difference.re, difference.im]
        };
        Ok(differences.flat_map(whitened).collect())
    }

    /// Fits the machine without effects to noise-free data of a subject, from all starts, and returns the
    /// least minimum.
    pub fn fit(&self, subject: &Subject) -> Result<Minimum> {
        let data = self.data(subject)?;
        let residuals = |point: &[f64]| self.residual(&data, &self.shifted(&self.family, point));
        let penalties = vec![1.0; self.leeway.len()];
        let mut least = minimum(&residuals, &penalties, vec![0.0; self.leeway.len()])?;
        let everywhere = self.survey.of(subject)?;
        for fit in
            [Fit::of_chain(&self.family.drawn, &self.survey), Fit::of_machine(&self.family, &self.survey)]
        {
            let fit = Fit { fitted: self.positions.clone(), ..fit };
            let joints = fit.run(&everywhere, &fit.true_point())?.point;
            let found = minimum(&residuals, &penalties, self.at_joints(&joints))?;
            if found.cost < least.cost {
                least = found;
            }
        }
        Ok(least)
    }

    /// Returns the point of joint values, as logarithms in the order of their names, with all else as it is.
    fn at_joints(&self, logarithms: &[f64]) -> Vec<f64> {
        let joints = &self.family.drawn.joints;
        let shift = |leeway: &Leeway| match leeway {
            Leeway::Joint(name, sd) => {
                let place = joints.keys().position(|known| known == name);
                place.map_or(0.0, |place| (logarithms[place] - joints[name].ln()) / sd)
            }
            _ => 0.0,
        };
        self.leeway.iter().map(shift).collect()
    }

    /// Returns the non-centrality of the effects of a subject.
    pub fn noncentrality(&self, subject: &Subject) -> Result<f64> {
        Ok(self.fit(subject)?.cost)
    }
}
