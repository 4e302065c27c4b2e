//! Bootstrap: how far the parameters move when lines, or positions, are drawn anew.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::problem::Problem;
use crate::numeric::statistics::quantile;
use crate::optimizer::{Control, least_squares};

/// What is drawn anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawn {
    /// Lines (or orders) inside each position.
    Lines,
    /// Whole positions (or records).
    Positions,
}

/// Spread of the places over bootstrap samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Bootstrap {
    /// What was drawn.
    pub drawn: Drawn,
    /// Samples.
    pub samples: usize,
    /// 2.5 and 97.5 % quantile of each place in its unit interval.
    pub interval95: Vec<(f64, f64)>,
}

/// Counts of one sample: with replacement, as many as there are.
fn draw(drawn: Drawn, blocks: &[usize], generator: &mut Xoshiro256PlusPlus) -> Vec<Vec<f64>> {
    let mut tally = |count: usize| {
        let mut counts = vec![0.0; count];
        (0..count).for_each(|_| counts[generator.random_range(0..count)] += 1.0);
        counts
    };
    match drawn {
        Drawn::Lines => blocks.iter().map(|count| tally(*count)).collect(),
        Drawn::Positions => tally(blocks.len()).into_iter().zip(blocks).map(|(times, rows)| vec![times; *rows]).collect(),
    }
}

/// Fits again, from the best place, to samples drawn with replacement; `None` where it was stopped, or with fewer than two blocks to draw.
///
/// # Source  Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 13 (percentile interval).
pub fn bootstrap<P: Problem>(problem: &P, best: &[f64], drawn: Drawn, samples: usize, seed: u64, control: &Control) -> Option<Bootstrap> {
    let blocks = problem.blocks();
    if samples == 0 || (drawn == Drawn::Positions && blocks.len() < 2) {
        return None;
    }
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
    let draws: Vec<Vec<Vec<f64>>> = (0..samples).map(|_| draw(drawn, &blocks, &mut generator)).collect();
    let places: Vec<Vec<f64>> = draws
        .par_iter()
        .map(|counts| problem.squares(Some(counts), |squares| least_squares(squares, best, &[], 40, control.stop()).place))
        .collect();
    let spread = |d: usize| {
        let end = |share| quantile(places.iter().map(|p| p[d]), share).unwrap_or(best[d]);
        (end(0.025), end(0.975))
    };
    (!control.stopped()).then(|| Bootstrap { drawn, samples, interval95: (0..best.len()).map(spread).collect() })
}
