//! Noise that keeps the colour of what a fit leaves.

use nalgebra::{DMatrix, DVector};
use numeric::long_run::long_run_covariance;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// What is left of records: what repeats with the command, and what does not.
#[derive(Debug, Clone)]
pub(super) struct ResidualBootstrap {
    records: Vec<RecordResidual>,
    /// Samples within which it keeps its sign, about.
    block: usize,
    /// By how much a mean varies more than that of white noise.
    inflation: f64,
}

#[derive(Debug, Clone)]
struct RecordResidual {
    /// What repeats: one period, or nothing.
    repeating: Vec<f64>,
    /// The rest.
    rest: Vec<f64>,
}

/// Shortest block (samples).
const SHORTEST: usize = 12;

impl ResidualBootstrap {
    /// Takes the residual of records with these lengths and periods apart.
    pub fn new(residual: &DVector<f64>, records: &[(usize, Option<usize>)]) -> Self {
        let mut from = 0;
        let parts: Vec<RecordResidual> = records
            .iter()
            .map(|&(length, period)| {
                let part = &residual.as_slice()[from..from + length];
                from += length;
                let repeating = period.map_or(Vec::new(), |period| repeated(part, period));
                let rest = part.iter().enumerate().map(|(i, e)| if repeating.is_empty() { *e } else { e - repeating[i % repeating.len()] });
                RecordResidual { rest: rest.collect(), repeating }
            })
            .collect();
        let shortest = records.iter().map(|r| r.1.unwrap_or(r.0)).min().unwrap_or(SHORTEST);
        let block = (2 * correlated(residual)).max(SHORTEST).min((shortest / 8).max(2));
        ResidualBootstrap { inflation: inflation(residual, block), records: parts, block }
    }

    /// Samples within which it keeps its sign, about.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Variance of a mean over that of white noise of its size, at least 1.
    pub fn inflation(&self) -> f64 {
        self.inflation
    }

    /// Draws noise: moved in time block by block, which keeps its colour, or left in its place with the sign of each block drawn, which keeps where
    /// it is large. What repeats repeats in the draw.
    pub fn draw(&self, in_place: bool, random: &mut Xoshiro256PlusPlus) -> DVector<f64> {
        let mut all = Vec::new();
        for part in &self.records {
            let repeating = self.resampled(&part.repeating, in_place, random);
            let rest = self.resampled(&part.rest, in_place, random);
            all.extend(rest.iter().enumerate().map(|(i, e)| if repeating.is_empty() { *e } else { e + repeating[i % repeating.len()] }));
        }
        DVector::from_vec(all)
    }

    fn resampled(&self, series: &[f64], in_place: bool, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
        let count = series.len();
        if count == 0 {
            return Vec::new();
        }
        let mut drawn = Vec::with_capacity(count);
        // The first block is cut at random, so that blocks do not begin at the same places in every draw.
        let mut length = 1 + random.random_range(0..self.block);
        while drawn.len() < count {
            let from = if in_place { drawn.len() } else { random.random_range(0..count) };
            let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
            let more = length.min(count - drawn.len());
            drawn.extend((0..more).map(|i| sign * series[(from + i) % count]));
            length = self.block;
        }
        drawn
    }
}

/// Mean over periods.
pub(super) fn repeated(part: &[f64], period: usize) -> Vec<f64> {
    (0..period)
        .map(|phase| {
            let same: Vec<f64> = part.iter().skip(phase).step_by(period).copied().collect();
            same.iter().sum::<f64>() / same.len().max(1) as f64
        })
        .collect()
}

/// Long-run variance over that of white noise, at least 1.
fn inflation(residual: &DVector<f64>, reach: usize) -> f64 {
    (long_run_covariance(&DMatrix::from_columns(std::slice::from_ref(residual)), reach)[(0, 0)] / residual.norm_squared()).max(1.0)
}

/// Samples after which the autocorrelation has first fallen below a tenth.
fn correlated(residual: &DVector<f64>) -> usize {
    let last = residual.len() / 4;
    (1..last).find(|lag| autocorrelation(residual, *lag) < 0.1).unwrap_or(last)
}

fn autocorrelation(residual: &DVector<f64>, lag: usize) -> f64 {
    let count = residual.len() - lag;
    residual.rows(lag, count).dot(&residual.rows(0, count)) / residual.norm_squared()
}
