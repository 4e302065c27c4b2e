//! Interval of the share of the gap that an effect closes.

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::gap::{MotionPart, flat};
use super::noise_floor::NoiseFloor;
use super::residual_bootstrap::ResidualBootstrap;
use crate::evidence::share_closed;
use numeric::statistics::quantile;

/// Returns the 95 % interval of `closed`. Blocks of time, longer than the correlation of the residual, are
/// redrawn jointly from the residuals before and after and from the noise. Noise given by its level is
/// redrawn among the lags of its differences. The interval holds for these models at these parameters.
pub(super) fn closed_interval(
    before: &[MotionPart],
    after: &[MotionPart],
    noise: &[NoiseFloor],
    draws: usize,
    seed: u64,
) -> Option<(f64, f64)> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut all = Vec::new();
    for ((b, a), n) in flat(before).zip(flat(after)).zip(noise) {
        let residual = DVector::from_vec(a.residual.clone());
        let block = ResidualBootstrap::new(&residual, &[(b.residual.len(), b.period)])
            .block()
            .max((0.25 / b.step_s) as usize);
        all.push((b, a, n, block));
    }
    let drawn: Vec<f64> = (0..draws)
        .filter_map(|_| {
            let (mut g0, mut g1, mut floor) = (0.0, 0.0, 0.0);
            for (b, a, n, block) in &all {
                let (count, lag) = (b.residual.len(), random.random::<f64>());
                for _ in 0..count.div_ceil(*block) {
                    let from = random.random_range(0..count);
                    for i in (from..from + block).map(|i| i % count) {
                        g0 += b.residual[i] * b.residual[i];
                        g1 += a.residual[i] * a.residual[i];
                        floor += n.square(i, lag);
                    }
                }
            }
            share_closed(g0.sqrt(), g1.sqrt(), floor.sqrt())
        })
        .collect();
    (drawn.len() > draws / 2)
        .then(|| Some((quantile(drawn.iter().copied(), 0.025)?, quantile(drawn.iter().copied(), 0.975)?)))?
}
