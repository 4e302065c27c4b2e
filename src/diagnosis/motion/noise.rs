//! Noise that keeps the colour of what a fit leaves.

use nalgebra::DVector;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// What is left of records: what repeats with the command, and what does not.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    records: Vec<Part>,
    /// Samples within which it keeps its sign, about.
    block: usize,
}

#[derive(Debug, Clone)]
struct Part {
    /// What repeats: one period, or nothing.
    repeating: Vec<f64>,
    /// The rest.
    rest: Vec<f64>,
}

/// Shortest block (samples).
const SHORTEST: usize = 12;

impl Noise {
    /// Takes the residual of records with these lengths and periods apart.
    pub fn new(residual: &DVector<f64>, records: &[(usize, Option<usize>)]) -> Self {
        let mut from = 0;
        let parts: Vec<Part> = records
            .iter()
            .map(|&(length, period)| {
                let part = &residual.as_slice()[from..from + length];
                from += length;
                let repeating = period.map_or(Vec::new(), |period| repeated(part, period));
                let rest = part.iter().enumerate().map(|(i, e)| if repeating.is_empty() { *e } else { e - repeating[i % repeating.len()] });
                Part { rest: rest.collect(), repeating }
            })
            .collect();
        let shortest = records.iter().map(|r| r.1.unwrap_or(r.0)).min().unwrap_or(SHORTEST);
        let block = (2 * correlated(residual)).max(SHORTEST).min((shortest / 8).max(2));
        Noise { records: parts, block }
    }

    /// Samples over which a sum of residuals grows as if it were one: 1 for white noise.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Draws noise: moved in time block by block, which keeps its colour, or left in its place with the sign of each block drawn, which keeps where
    /// it is large. What repeats repeats in the draw.
    pub fn draw(&self, in_place: bool, random: &mut Xoshiro256PlusPlus) -> DVector<f64> {
        let mut all = Vec::new();
        for part in &self.records {
            let repeating = self.drawn(&part.repeating, in_place, random);
            let rest = self.drawn(&part.rest, in_place, random);
            all.extend(rest.iter().enumerate().map(|(i, e)| if repeating.is_empty() { *e } else { e + repeating[i % repeating.len()] }));
        }
        DVector::from_vec(all)
    }

    fn drawn(&self, series: &[f64], in_place: bool, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
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

/// Samples after which the autocorrelation has first fallen below a tenth.
fn correlated(residual: &DVector<f64>) -> usize {
    let square = residual.norm_squared();
    let count = residual.len();
    (1..count / 4).find(|lag| residual.rows(*lag, count - lag).dot(&residual.rows(0, count - lag)) < 0.1 * square).unwrap_or(count / 4)
}
