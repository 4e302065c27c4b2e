//! Bootstrap of residuals: noise with the autocorrelation of a residual.

use nalgebra::{DMatrix, DVector};
use numeric::long_run::long_run_covariance;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Residuals of records, split into the part that repeats with the command and the rest.
#[derive(Debug, Clone)]
pub(super) struct ResidualBootstrap {
    records: Vec<RecordResidual>,
    /// Block length (samples): about twice the time over which the residual is correlated.
    block: usize,
    /// Variance of a mean over that of white noise.
    inflation: f64,
}

#[derive(Debug, Clone)]
struct RecordResidual {
    /// Repeating part: one period, or empty.
    repeating: Vec<f64>,
    /// The rest.
    rest: Vec<f64>,
}

/// Shortest block (samples).
const SHORTEST: usize = 12;

impl ResidualBootstrap {
    /// Splits the residual of records with given lengths and periods.
    pub fn new(residual: &DVector<f64>, records: &[(usize, Option<usize>)]) -> Self {
        let mut from = 0;
        let parts: Vec<RecordResidual> = records
            .iter()
            .map(|&(length, period)| {
                let part = &residual.as_slice()[from..from + length];
                from += length;
                let repeating = period.map_or(Vec::new(), |period| period_mean(part, period));
                let rest = part
                    .iter()
                    .enumerate()
                    .map(|(i, e)| if repeating.is_empty() { *e } else { e - repeating[i % repeating.len()] });
                RecordResidual { rest: rest.collect(), repeating }
            })
            .collect();
        let shortest = records.iter().map(|r| r.1.unwrap_or(r.0)).min().unwrap_or(SHORTEST);
        let block = (2 * correlation_length(residual)).max(SHORTEST).min((shortest / 8).max(2));
        ResidualBootstrap { inflation: inflation(residual, block), records: parts, block }
    }

    /// Returns the block length (samples).
    pub fn block(&self) -> usize {
        self.block
    }

    /// Returns the variance of a mean over that of white noise of the same size, at least 1.
    pub fn inflation(&self) -> f64 {
        self.inflation
    }

    /// Draws noise by blocks. Moved in time, they keep the autocorrelation; `in_place` with random signs,
    /// they also keep the distribution of the level over time. The repeating part repeats in the draw.
    pub fn draw(&self, in_place: bool, random: &mut Xoshiro256PlusPlus) -> DVector<f64> {
        let mut all = Vec::new();
        for part in &self.records {
            let repeating = self.resampled(&part.repeating, in_place, random);
            let rest = self.resampled(&part.rest, in_place, random);
            all.extend(
                rest.iter()
                    .enumerate()
                    .map(|(i, e)| if repeating.is_empty() { *e } else { e + repeating[i % repeating.len()] }),
            );
        }
        DVector::from_vec(all)
    }

    fn resampled(&self, series: &[f64], in_place: bool, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
        let count = series.len();
        if count == 0 {
            return Vec::new();
        }
        let mut drawn = Vec::with_capacity(count);
        // The first block has a random length: block boundaries differ between draws.
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

/// Returns the mean over periods.
pub(super) fn period_mean(part: &[f64], period: usize) -> Vec<f64> {
    (0..period)
        .map(|phase| {
            let same: Vec<f64> = part.iter().skip(phase).step_by(period).copied().collect();
            same.iter().sum::<f64>() / same.len().max(1) as f64
        })
        .collect()
}

/// Returns the long-run variance over that of white noise, at least 1.
fn inflation(residual: &DVector<f64>, reach: usize) -> f64 {
    (long_run_covariance(&DMatrix::from_columns(std::slice::from_ref(residual)), reach)[(0, 0)]
        / residual.norm_squared())
    .max(1.0)
}

/// Returns the lag (samples) at which the autocorrelation first falls below a tenth.
fn correlation_length(residual: &DVector<f64>) -> usize {
    let last = residual.len() / 4;
    (1..last).find(|lag| autocorrelation(residual, *lag) < 0.1).unwrap_or(last)
}

fn autocorrelation(residual: &DVector<f64>, lag: usize) -> f64 {
    let count = residual.len() - lag;
    residual.rows(lag, count).dot(&residual.rows(0, count)) / residual.norm_squared()
}
