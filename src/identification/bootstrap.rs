//! Bootstrap: spread of the parameters over resampled lines or positions.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::place::Place;
use super::problem::Problem;
use long_work::Control;
use numeric::statistics::quantile;
use optimizer::least_squares;

/// The unit of resampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawn {
    /// Lines (or mode orders) within each position.
    Lines,
    /// Whole positions (or records).
    Positions,
}

/// Spread of the unit-cube coordinates over bootstrap samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Bootstrap {
    /// Unit of resampling.
    pub drawn: Drawn,
    /// Number of samples.
    pub samples: usize,
    /// 2.5 and 97.5 % quantile of each coordinate in its unit interval.
    pub interval95: Vec<(f64, f64)>,
}

/// Draws one sample with replacement and returns how often each row occurs.
///
/// Lines are drawn in runs of `run`, since residuals of neighbouring lines may be correlated.
pub(super) fn draw(
    drawn: Drawn,
    blocks: &[(usize, usize)],
    run: usize,
    generator: &mut Xoshiro256PlusPlus,
) -> Vec<Vec<f64>> {
    match drawn {
        Drawn::Lines => blocks
            .iter()
            .map(|(rows, _)| {
                let run = run.min(*rows).max(1);
                let mut counts = vec![0.0; *rows];
                for _ in 0..rows.div_ceil(run) {
                    let first = generator.random_range(0..*rows);
                    (0..run).for_each(|at| counts[(first + at) % rows] += 1.0);
                }
                counts
            })
            .collect(),
        Drawn::Positions => {
            let groups = groups(blocks);
            let mut times = vec![0.0; groups];
            (0..groups).for_each(|_| times[generator.random_range(0..groups)] += 1.0);
            blocks.iter().map(|(rows, group)| vec![times[*group]; *rows]).collect()
        }
    }
}

fn groups(blocks: &[(usize, usize)]) -> usize {
    blocks.iter().map(|(_, group)| group + 1).max().unwrap_or(0)
}

/// Returns the spread over both units of resampling, as far as they can be drawn: `samples` of each from a
/// seed.
pub fn bootstraps<P: Problem>(
    problem: &P,
    best: &Place,
    (samples, seed): (usize, u64),
    control: &Control,
) -> Vec<Bootstrap> {
    [Drawn::Lines, Drawn::Positions]
        .into_iter()
        .filter_map(|drawn| bootstrap(problem, best, drawn, (samples, seed), control))
        .collect()
}

/// Fits samples drawn with replacement, each from the best coordinates. `None` if stopped, or with fewer than
/// two positions to draw.
///
/// # Source  Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 13 (percentile interval); runs
///   of lines: Künsch,
/// Ann. Stat. 17 (1989) 1217–1241.
fn bootstrap<P: Problem>(
    problem: &P,
    best: &Place,
    drawn: Drawn,
    (samples, seed): (usize, u64),
    control: &Control,
) -> Option<Bootstrap> {
    let blocks = problem.blocks();
    if samples == 0 || (drawn == Drawn::Positions && groups(&blocks) < 2) {
        return None;
    }
    let run = problem.correlation_factor(best).ceil() as usize;
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
    let seeds: Vec<u64> = (0..samples).map(|_| generator.random()).collect();
    let step = control.steps("bootstrap", samples);
    let places: Vec<Option<Vec<f64>>> = seeds
        .par_iter()
        .map(|seed| {
            if control.stopped() {
                return None;
            }
            let place = control.cached(&format!("{drawn:?} {seed}"), || {
                let counts = draw(drawn, &blocks, run, &mut Xoshiro256PlusPlus::seed_from_u64(*seed));
                problem.squares(Some(&counts), |squares| {
                    least_squares(squares, best, &[], 40, control.stop()).place
                })
            });
            step();
            Some(place)
        })
        .collect();
    let places: Vec<Vec<f64>> = places.into_iter().collect::<Option<_>>()?;
    let spread = |d: usize| {
        let end = |share| quantile(places.iter().map(|p| p[d]), share).unwrap_or(best[d]);
        (end(0.025), end(0.975))
    };
    (!control.stopped()).then(|| Bootstrap {
        drawn,
        samples,
        interval95: (0..best.len()).map(spread).collect(),
    })
}
