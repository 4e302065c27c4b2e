//! How far predicted and recorded force are apart, and how much of that an effect closes.

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::data::MotionData;
use super::free::free_shapes;
use super::noise::{Noise, repeated};
use crate::diagnosis::domain::share_closed;
use crate::inverse_dynamics::{Motion, Projected, Rigid, prediction};
use crate::machine::Machine;
use crate::numeric::statistics::quantile;

/// One record with a prediction of it.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionPart {
    /// Record.
    pub name: String,
    /// Recorded force (N or N·m), thinned.
    pub recorded: Vec<f64>,
    /// Recorded less predicted.
    pub residual: Vec<f64>,
    /// Samples after which the command repeats.
    pub period: Option<usize>,
    /// Time between samples (s).
    pub step_s: f64,
}

impl MotionPart {
    /// rms(recorded − predicted)/rms(recorded).
    pub fn gap(&self) -> f64 {
        square(&self.residual).sqrt() / square(&self.recorded).sqrt()
    }

    /// The gap that noise alone leaves, where the command repeats: what the residual does not repeat.
    pub fn noise_floor(&self) -> Option<f64> {
        let noise = not_repeating(&self.residual, self.period?);
        Some(square(&noise).sqrt() / square(&self.recorded).sqrt())
    }
}

fn square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// What does not repeat, scaled for the mean taken out.
fn not_repeating(residual: &[f64], period: usize) -> Vec<f64> {
    let mean = repeated(residual, period);
    let scale = (residual.len() as f64 / (residual.len() - period) as f64).sqrt();
    residual.iter().enumerate().map(|(i, e)| scale * (e - mean[i % period])).collect()
}

/// A record with the prediction of a machine.
pub fn part(rigid: &Rigid, machine: &Machine, values: &[f64], motion: &Motion) -> MotionPart {
    let predicted = prediction(rigid, machine, values, &[motion]);
    MotionPart {
        name: motion.name.clone(),
        residual: motion.load.iter().zip(predicted.iter()).map(|(m, p)| m - p).collect(),
        recorded: motion.load.clone(),
        period: motion.period,
        step_s: motion.thinned_step_s(),
    }
}

/// Gap over records together.
pub fn gap_of(parts: &[MotionPart]) -> Option<f64> {
    let force: f64 = parts.iter().map(|p| square(&p.recorded)).sum();
    (force > 0.0).then(|| (parts.iter().map(|p| square(&p.residual)).sum::<f64>() / force).sqrt())
}

/// What the noise alone leaves of each record, sample by sample: where a command repeats, what the residual of the chosen model does not repeat,
/// scaled for the mean taken out; else what smooth functions of speed, position and travel since reversal leave of it.
pub(super) fn noise_of(after: &[MotionPart], motions: &[&Motion]) -> Vec<Vec<f64>> {
    after
        .iter()
        .zip(motions)
        .map(|(part, motion)| {
            if let Some(period) = part.period {
                return not_repeating(&part.residual, period);
            }
            let data = MotionData::new(vec![*motion]);
            let mut left = DVector::from_vec(part.residual.clone());
            for shape in free_shapes(&data) {
                let kept: Vec<usize> = (0..shape.columns.ncols().saturating_sub(1)).collect();
                if let Some(fit) = Projected::new(&shape.columns.select_columns(&kept), &left) {
                    left = fit.residual;
                }
            }
            left.iter().copied().collect()
        })
        .collect()
}

/// Gap that the noise alone leaves over records together.
pub(super) fn floor_of(noise: &[Vec<f64>], parts: &[MotionPart]) -> Option<f64> {
    let force: f64 = parts.iter().map(|p| square(&p.recorded)).sum();
    (force > 0.0).then(|| (noise.iter().map(|n| square(n)).sum::<f64>() / force).sqrt())
}

/// 95 % interval of `closed`: blocks of time are drawn anew from residuals before and after and from the noise together, for longer than what
/// the fit leaves is correlated. What the fitted parameters vary by is small beside it and left out.
pub fn closed_interval(before: &[MotionPart], after: &[MotionPart], noise: &[Vec<f64>], draws: usize, seed: u64) -> Option<(f64, f64)> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut all = Vec::new();
    for ((b, a), n) in before.iter().zip(after).zip(noise) {
        let residual = DVector::from_vec(a.residual.clone());
        let block = Noise::new(&residual, &[(b.residual.len(), b.period)]).block().max((0.25 / b.step_s) as usize);
        all.push((b, a, n, block));
    }
    let drawn: Vec<f64> = (0..draws)
        .filter_map(|_| {
            let (mut g0, mut g1, mut floor) = (0.0, 0.0, 0.0);
            for (b, a, n, block) in &all {
                let count = b.residual.len();
                for _ in 0..count.div_ceil(*block) {
                    let from = random.random_range(0..count);
                    for i in (from..from + block).map(|i| i % count) {
                        g0 += b.residual[i] * b.residual[i];
                        g1 += a.residual[i] * a.residual[i];
                        floor += n[i] * n[i];
                    }
                }
            }
            share_closed(g0.sqrt(), g1.sqrt(), floor.sqrt())
        })
        .collect();
    (drawn.len() > draws / 2).then(|| Some((quantile(drawn.iter().copied(), 0.025)?, quantile(drawn.iter().copied(), 0.975)?)))?
}
