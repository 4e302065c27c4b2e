//! A refit of the engineer's chain to noise-free data: the gap that no joint values can close.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::subject::Subject;
use super::survey::Survey;
use crate::Result;
use crate::machine::catalogue::DrawnMachine;
use crate::machine::nuisance::Nuisance;

/// Returns the fitted positions of a test of so many: l1, l3, l5. The others are held out.
pub fn fitted_of(positions: usize) -> Vec<usize> {
    (0..positions).step_by(2).collect()
}

/// A fit: model family, positions and lines.
pub struct Fit<'a> {
    /// Machine without effects whose joints are free.
    pub family: Subject,
    /// Fitted positions.
    pub fitted: Vec<usize>,
    /// Lines and their noise.
    pub survey: &'a Survey,
    /// A frozen joint and its value.
    pub frozen: Option<(&'static str, f64)>,
}

/// Result of a refit.
#[derive(Clone, Debug, PartialEq)]
pub struct Refit {
    /// Gap at the fitted positions.
    pub fit: f64,
    /// Gap at the held-out positions.
    pub held_out: f64,
    /// Logarithms of the fitted joint values, in the order of their names.
    pub point: Vec<f64>,
}

impl<'a> Fit<'a> {
    /// Prepares a fit of the engineer's chain with the usual split: no nuisance parameters, nut at one point,
    /// uniform screw.
    pub fn of_chain(drawn: &DrawnMachine, survey: &'a Survey) -> Self {
        let family = Subject {
            drawn: drawn.clone(),
            nuisance: Nuisance::none(drawn.nut_m.len()),
            effects: Vec::new(),
        };
        Self { family, fitted: fitted_of(drawn.nut_m.len()), survey, frozen: None }
    }

    /// Prepares a fit of the true machine without its effects at all positions.
    pub fn of_machine(subject: &Subject, survey: &'a Survey) -> Self {
        Self {
            family: subject.without_effects(),
            fitted: (0..subject.drawn.nut_m.len()).collect(),
            survey,
            frozen: None,
        }
    }

    /// Returns the machine of the family with other joint values.
    pub fn at(&self, point: &[f64]) -> Subject {
        let mut subject = self.family.clone();
        for (value, logarithm) in subject.drawn.joints.values_mut().zip(point) {
            *value = logarithm.exp();
        }
        subject
    }

    /// Returns the logarithms of the true joint values.
    pub fn true_point(&self) -> Vec<f64> {
        self.family.drawn.joints.values().map(|value| value.ln()).collect()
    }

    /// Fits all joints within their ranges at the fitted positions (Levenberg–Marquardt with robust weights)
    /// and evaluates the other positions.
    pub fn run(&self, data: &[Complex64], start: &[f64]) -> Result<Refit> {
        let block = self.survey.base.len() / self.family.drawn.nut_m.len();
        let fitted: Vec<Complex64> = self
            .fitted
            .iter()
            .flat_map(|&position| &data[position * block..(position + 1) * block])
            .copied()
            .collect();
        let variance: Vec<f64> = self
            .fitted
            .iter()
            .flat_map(|&position| &self.survey.variance[position * block..(position + 1) * block])
            .copied()
            .collect();
        // A model error of one per cent in addition to the noise keeps single lines from dominating.
        let weights: Vec<f64> = variance.iter().map(|value| 1.0 / (value + 1e-4)).collect();
        let mut point = self.clamped(start.to_vec());
        let mut residual = self.residual(&point, &fitted, &self.fitted)?;
        let mut cost = robust_cost(&residual, &weights);
        let mut damping = 1e-3;
        for _ in 0..20 {
            let (normal, slope) = self.normal(&point, &residual, &fitted, &weights)?;
            let before = cost;
            for _ in 0..8 {
                let mut damped = normal.clone();
                for index in 0..point.len() {
                    damped[(index, index)] += damping * (normal[(index, index)] + 1.0);
                }
                let Some(step) = nalgebra::Cholesky::new(damped).map(|factors| factors.solve(&slope)) else {
                    damping *= 10.0;
                    continue;
                };
                let moved: Vec<f64> = self
                    .clamped(point.iter().zip(step.iter()).map(|(a, b)| a - b.clamp(-1.0, 1.0)).collect());
                let there = self.residual(&moved, &fitted, &self.fitted)?;
                let value = robust_cost(&there, &weights);
                if value < cost {
                    (point, residual, cost) = (moved, there, value);
                    damping = (damping * 0.3).max(1e-9);
                    break;
                }
                damping *= 5.0;
            }
            if before - cost < 1e-4 * before {
                break;
            }
        }
        let all: Vec<usize> = (0..self.family.drawn.nut_m.len()).collect();
        let residual = self.residual(&point, data, &all)?;
        let gap = |is_fit: bool| self.gap(&residual, |line| self.fitted.contains(&(line / block)) == is_fit);
        Ok(Refit { fit: gap(true), held_out: gap(false), point })
    }

    /// Computes the normal equations of one step by finite differences.
    fn normal(
        &self,
        point: &[f64],
        residual: &[Complex64],
        data: &[Complex64],
        weights: &[f64],
    ) -> Result<(DMatrix<f64>, DVector<f64>)> {
        let count = point.len();
        let mut columns = Vec::with_capacity(count);
        for index in 0..count {
            let mut moved = point.to_vec();
            moved[index] += 1e-4;
            let there = self.residual(&moved, data, &self.fitted)?;
            columns.push(
                there.iter().zip(residual).map(|(a, b)| wrapped(a - b) / 1e-4).collect::<Vec<Complex64>>(),
            );
        }
        let (mut normal, mut slope) = (DMatrix::<f64>::zeros(count, count), DVector::<f64>::zeros(count));
        for (line, (value, &weight)) in residual.iter().zip(weights).enumerate() {
            let weight = weight / (1.0 + value.norm_sqr() * weight / ROBUST_LIMIT).sqrt();
            for a in 0..count {
                slope[a] += weight * (columns[a][line].conj() * value).re;
                for b in 0..=a {
                    normal[(a, b)] += weight * (columns[a][line].conj() * columns[b][line]).re;
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        Ok((normal, slope))
    }

    /// Returns ln(model / data) of the lines at some positions.
    fn residual(&self, point: &[f64], data: &[Complex64], positions: &[usize]) -> Result<Vec<Complex64>> {
        let model = self.survey.at_positions(&self.at(point), positions)?;
        Ok(model.iter().zip(data).map(|(a, b)| wrapped(a - b)).collect())
    }

    fn clamped(&self, mut point: Vec<f64>) -> Vec<f64> {
        for (value, name) in point.iter_mut().zip(self.family.drawn.joints.keys()) {
            if let Some(parameter) = self.family.drawn.description.parameter(name) {
                *value = value.clamp(parameter.lower.ln(), parameter.upper.ln());
            }
            if let Some((_, kept)) = self.frozen.as_ref().filter(|(frozen, _)| frozen == name) {
                *value = kept.ln();
            }
        }
        point
    }

    /// Returns the rms of a component of ln H over some lines.
    fn gap(&self, residual: &[Complex64], chosen: impl Fn(usize) -> bool) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (line, (value, variance)) in residual.iter().zip(&self.survey.variance).enumerate() {
            if variance.is_finite() && chosen(line) {
                sum += 0.5 * value.norm_sqr();
                count += 1.0;
            }
        }
        if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
    }
}

/// Whitened square beyond which the robust cost grows about linearly.
const ROBUST_LIMIT: f64 = 9.0;

fn robust_cost(residual: &[Complex64], weights: &[f64]) -> f64 {
    residual
        .iter()
        .zip(weights)
        .map(|(value, weight)| {
            2.0 * ROBUST_LIMIT * ((1.0 + value.norm_sqr() * weight / ROBUST_LIMIT).sqrt() - 1.0)
        })
        .sum()
}

/// Wraps the phase of a logarithm to ± π.
pub fn wrapped(value: Complex64) -> Complex64 {
    let turn = 2.0 * std::f64::consts::PI;
    Complex64::new(value.re, value.im - turn * (value.im / turn).round())
}
