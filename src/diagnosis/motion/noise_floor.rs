//! Noise floor of records.

use nalgebra::DVector;

use super::channel_weight::without_smooth_functions;
use super::data::MotionData;
use super::gap::{MotionPart, flat, non_repeating, square};
use dynamics::inverse_dynamics::MotionSignal;
use numeric::statistics::median;

/// Longest lag (s) of differences used to estimate noise: over longer times the misfit changes, too.
const LONGEST_LAG_S: f64 = 0.06;
/// Least number of differences for an estimate.
const LEAST_COUNT: usize = 30;
/// Standard deviation of a normal variable over the median of its absolute value.
const OVER_MEDIAN: f64 = 1.4826;

/// Noise of one channel of one record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NoiseFloor {
    /// Noise by sample: the part of the residual that does not repeat with the command.
    Sampled(Vec<f64>),
    /// One level for all samples in the mask, estimated from differences.
    Level {
        /// Standard deviations, by lag of the differences.
        by_lag: Vec<f64>,
        /// Mask of the samples.
        counts: Vec<bool>,
    },
}

impl NoiseFloor {
    /// Returns the sum of squares of the noise.
    pub fn squares(&self) -> f64 {
        match self {
            NoiseFloor::Sampled(noise) => square(noise),
            NoiseFloor::Level { by_lag, counts } => {
                let level = median(by_lag.iter().copied()).unwrap_or(0.0);
                level * level * counts.iter().filter(|c| **c).count() as f64
            }
        }
    }

    /// Returns the square of a sample; `lag` (from 0 to 1) selects among the lags of the differences.
    pub fn square(&self, sample: usize, lag: f64) -> f64 {
        match self {
            NoiseFloor::Sampled(noise) => noise[sample].powi(2),
            NoiseFloor::Level { by_lag, counts } => {
                let at = ((lag * by_lag.len() as f64) as usize).min(by_lag.len() - 1);
                if counts[sample] { by_lag[at].powi(2) } else { 0.0 }
            }
        }
    }

    /// Estimates the noise of a record that does not repeat. Misfit is large at reversals and elsewhere
    /// constant for a while, noise is everywhere. Hence the estimate is the median absolute difference over
    /// some hundredths of a second, of samples with an uninterrupted mask. An oscillating misfit would be
    /// overestimated: the residual beyond smooth functions is an upper bound. It is also the estimate of a
    /// channel that is too short.
    fn of(channel: &MotionPart, counts: &[bool], beyond_smooth: Vec<f64>) -> Self {
        let residual = &channel.residual;
        let most = (square(&beyond_smooth) / counts.iter().filter(|c| **c).count().max(1) as f64).sqrt();
        let level = |lag: usize| -> Option<f64> {
            let whole = |at: &usize| counts[at - lag..=*at].iter().all(|c| *c);
            let differences: Vec<f64> = (lag..residual.len())
                .filter(whole)
                .map(|at| (residual[at] - residual[at - lag]).abs())
                .collect();
            let level = OVER_MEDIAN * median(differences.iter().copied())? / std::f64::consts::SQRT_2;
            (differences.len() >= LEAST_COUNT).then_some(level.min(most))
        };
        let longest = ((LONGEST_LAG_S / channel.step_s).round() as usize).max(1);
        match (1..=longest).map(level).collect() {
            Some(by_lag) => NoiseFloor::Level { by_lag, counts: counts.to_vec() },
            None => NoiseFloor::Sampled(beyond_smooth),
        }
    }
}

/// Returns the noise of each channel of each record. For a repeating command it is the non-repeating part of
/// the chosen model's residual, scaled for the mean that was removed; else its level.
pub(super) fn noise_of(after: &[MotionPart], motions: &[&MotionSignal]) -> Vec<NoiseFloor> {
    let of = |(part, motion): (&MotionPart, &&MotionSignal)| -> Vec<NoiseFloor> {
        let counts =
            std::iter::once(&motion.is_moving).chain(motion.extra_channels.iter().map(|f| &f.is_used));
        let left = non_systematic(part, motion);
        let one = |((channel, counts), left): ((&MotionPart, &Vec<bool>), Vec<f64>)| match part.period {
            Some(_) => NoiseFloor::Sampled(left),
            None => NoiseFloor::of(channel, counts, left),
        };
        part.channels().zip(counts).zip(left).map(one).collect()
    };
    after.iter().zip(motions).flat_map(of).collect()
}

/// Returns the part of each channel's residual that does not repeat with the command, scaled for the mean
/// that was removed. Without a repeating command, it is the residual beyond smooth functions of speed,
/// position and travel since reversal: more than its noise.
pub(super) fn non_systematic(part: &MotionPart, motion: &MotionSignal) -> Vec<Vec<f64>> {
    if let Some(period) = part.period {
        return part.channels().map(|c| non_repeating(&c.residual, period)).collect();
    }
    let data = MotionData::new(vec![motion]);
    let all =
        DVector::from_iterator(data.samples(), part.channels().flat_map(|c| c.residual.iter().copied()));
    without_smooth_functions(&data, all)
        .as_slice()
        .chunks(motion.load.len().max(1))
        .map(<[f64]>::to_vec)
        .collect()
}

/// Returns the gap due to noise over all records.
pub(super) fn floor_of(noise: &[NoiseFloor], parts: &[MotionPart]) -> Option<f64> {
    let recorded: f64 = flat(parts).map(|p| square(&p.recorded)).sum();
    (recorded > 0.0).then(|| (noise.iter().map(NoiseFloor::squares).sum::<f64>() / recorded).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Returns normal noise of size 1 that is correlated over `blur` samples, with peaks of ±15 at reversals
    /// and a slow wave of 0.5.
    fn residual(blur: usize, reversals: bool) -> Vec<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut uniform = || random.random::<f64>() - 0.5;
        let normal: Vec<f64> = (0..2000 + blur).map(|_| (0..12).map(|_| uniform()).sum()).collect();
        let noise = normal.windows(blur).map(|w| w.iter().sum::<f64>() / (blur as f64).sqrt());
        let reversal =
            |at: usize| if reversals && at % 40 < 3 { 15.0 - 10.0 * (at % 40) as f64 } else { 0.0 };
        noise.enumerate().map(|(at, noise)| noise + reversal(at) + 0.5 * (0.02 * at as f64).sin()).collect()
    }

    fn noise_of(residual: Vec<f64>, counts: &[bool], beyond_smooth: Vec<f64>) -> NoiseFloor {
        let part = MotionPart {
            name: "record".into(),
            column: "force_n".into(),
            recorded: Vec::new(),
            residual,
            period: None,
            step_s: 0.01,
            samples: counts.len(),
            weight: 1.0,
            tracking: None,
            extra_channels: Vec::new(),
        };
        NoiseFloor::of(&part, counts, beyond_smooth)
    }

    fn level_of(noise: &NoiseFloor, counts: &[bool]) -> f64 {
        (noise.squares() / counts.iter().filter(|c| **c).count() as f64).sqrt()
    }

    #[test]
    fn limit_noise_is_distinguished_from_reversal_transients() {
        for (blur, reversals) in [(1, false), (1, true), (3, false), (3, true)] {
            let residual = residual(blur, reversals);
            let all = (square(&residual) / residual.len() as f64).sqrt();
            let counts = vec![true; residual.len()];
            let level = level_of(&noise_of(residual.clone(), &counts, residual), &counts);
            // Peaks affect every second of the longer differences, which raises the median slightly.
            assert!((0.9..1.25).contains(&level), "{level} for noise of 1 over {blur} samples");
            assert!(!reversals || all > 2.0, "{all}");
        }
    }

    #[test]
    fn limit_noise_of_a_wave_is_bounded_by_the_residual_beyond_smooth_functions() {
        // Differences of a wave of 10 Hz give 1.7 times its root mean square.
        let wave: Vec<f64> =
            (0..2000).map(|at| 3.0 * (0.2 * std::f64::consts::PI * at as f64).sin()).collect();
        let counts = vec![true; wave.len()];
        let half: Vec<f64> = wave.iter().map(|x| 0.5 * x).collect();
        assert!(
            level_of(&noise_of(wave.clone(), &counts, wave.clone()), &counts)
                < 3.0 / std::f64::consts::SQRT_2 + 1e-9
        );
        assert!(level_of(&noise_of(wave, &counts, half), &counts) < 1.5 / std::f64::consts::SQRT_2 + 1e-9);
    }

    #[test]
    fn limit_masked_samples_do_not_affect_the_noise_floor() {
        let mut residual = residual(1, false);
        let counts: Vec<bool> = (0..residual.len()).map(|at| at % 100 >= 30).collect();
        residual.iter_mut().zip(&counts).filter(|(_, c)| !**c).for_each(|(x, _)| *x = 0.0);
        let noise = noise_of(residual.clone(), &counts, residual.clone());
        assert!((0.9..1.1).contains(&level_of(&noise, &counts)));
        assert_eq!(noise.square(0, 0.5), 0.0);
        assert!((0.8..1.3).contains(&noise.square(50, 0.999)));
        // No interval is long enough: use the residual beyond smooth functions.
        let few: Vec<bool> = (0..residual.len()).map(|at| at % 4 != 0).collect();
        assert_eq!(noise_of(residual.clone(), &few, residual.clone()), NoiseFloor::Sampled(residual));
    }
}
