//! What noise alone leaves of records.

use nalgebra::DVector;

use super::channel_weight::smooth_taken;
use super::data::MotionData;
use super::gap::{MotionPart, flat, not_repeating, square};
use dynamics::inverse_dynamics::MotionSignal;
use numeric::statistics::median;

/// Longest time (s) over which noise is looked at: further apart misfit differs, too.
const APART_S: f64 = 0.06;
/// Fewest differences that tell a level.
const FEWEST: usize = 30;
/// Standard deviation of a normal variable over the median of its size.
const OVER_MEDIAN: f64 = 1.4826;

/// Noise of one channel of one record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NoiseFloor {
    /// Sample by sample: what does not repeat with the command.
    Sampled(Vec<f64>),
    /// The same size in each sample that counts, as differences over some times tell it.
    Level {
        /// Standard deviations, by the time of the differences.
        by_lag: Vec<f64>,
        /// Samples that count.
        counts: Vec<bool>,
    },
}

impl NoiseFloor {
    /// Sum of its squares.
    pub fn squares(&self) -> f64 {
        match self {
            NoiseFloor::Sampled(noise) => square(noise),
            NoiseFloor::Level { by_lag, counts } => {
                let level = median(by_lag.iter().copied()).unwrap_or(0.0);
                level * level * counts.iter().filter(|c| **c).count() as f64
            }
        }
    }

    /// Square of a sample, where `lag` (from 0 to 1) chooses among the times of the differences.
    pub fn square(&self, sample: usize, lag: f64) -> f64 {
        match self {
            NoiseFloor::Sampled(noise) => noise[sample].powi(2),
            NoiseFloor::Level { by_lag, counts } => {
                let at = ((lag * by_lag.len() as f64) as usize).min(by_lag.len() - 1);
                if counts[sample] { by_lag[at].powi(2) } else { 0.0 }
            }
        }
    }

    /// Where a record does not repeat: misfit shows at turns and is the same for a while elsewhere, noise everywhere. Hence the median size of
    /// differences over some hundredths of a second, of samples all of which count between; of a misfit that swings, the differences tell more than there
    /// is, hence at most what smooth functions leave. A channel too short to tell has what these leave.
    fn of(channel: &MotionPart, counts: &[bool], not_smooth: Vec<f64>) -> Self {
        let residual = &channel.residual;
        let most = (square(&not_smooth) / counts.iter().filter(|c| **c).count().max(1) as f64).sqrt();
        let level = |lag: usize| -> Option<f64> {
            let whole = |at: &usize| counts[at - lag..=*at].iter().all(|c| *c);
            let differences: Vec<f64> = (lag..residual.len()).filter(whole).map(|at| (residual[at] - residual[at - lag]).abs()).collect();
            let level = OVER_MEDIAN * median(differences.iter().copied())? / std::f64::consts::SQRT_2;
            (differences.len() >= FEWEST).then_some(level.min(most))
        };
        let longest = ((APART_S / channel.step_s).round() as usize).max(1);
        match (1..=longest).map(level).collect() {
            Some(by_lag) => NoiseFloor::Level { by_lag, counts: counts.to_vec() },
            None => NoiseFloor::Sampled(not_smooth),
        }
    }
}

/// Noise of each channel of each record: where a command repeats, what the residual of the chosen model does not repeat, scaled for the mean taken
/// out; else its level.
pub(super) fn noise_of(after: &[MotionPart], motions: &[&MotionSignal]) -> Vec<NoiseFloor> {
    let of = |(part, motion): (&MotionPart, &&MotionSignal)| -> Vec<NoiseFloor> {
        let counts = std::iter::once(&motion.moves).chain(motion.further.iter().map(|f| &f.counts));
        let left = not_systematic(part, motion);
        let one = |((channel, counts), left): ((&MotionPart, &Vec<bool>), Vec<f64>)| match part.period {
            Some(_) => NoiseFloor::Sampled(left),
            None => NoiseFloor::of(channel, counts, left),
        };
        part.channels().zip(counts).zip(left).map(one).collect()
    };
    after.iter().zip(motions).flat_map(of).collect()
}

/// What of the residual of each channel does not repeat with the command, scaled for the mean taken out; where that does not repeat, what smooth functions of
/// speed, position and travel since reversal leave: more than its noise.
pub(super) fn not_systematic(part: &MotionPart, motion: &MotionSignal) -> Vec<Vec<f64>> {
    if let Some(period) = part.period {
        return part.channels().map(|c| not_repeating(&c.residual, period)).collect();
    }
    let data = MotionData::new(vec![motion]);
    let all = DVector::from_iterator(data.samples(), part.channels().flat_map(|c| c.residual.iter().copied()));
    smooth_taken(&data, all).as_slice().chunks(motion.load.len().max(1)).map(<[f64]>::to_vec).collect()
}

/// Gap that the noise alone leaves over records together.
pub(super) fn floor_of(noise: &[NoiseFloor], parts: &[MotionPart]) -> Option<f64> {
    let recorded: f64 = flat(parts).map(|p| square(&p.recorded)).sum();
    (recorded > 0.0).then(|| (noise.iter().map(NoiseFloor::squares).sum::<f64>() / recorded).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Normal noise of size 1 that is correlated over `blur` samples, with peaks of ±15 where the axis turns and a slow wave of 0.5.
    fn residual(blur: usize, turns: bool) -> Vec<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut uniform = || random.random::<f64>() - 0.5;
        let normal: Vec<f64> = (0..2000 + blur).map(|_| (0..12).map(|_| uniform()).sum()).collect();
        let noise = normal.windows(blur).map(|w| w.iter().sum::<f64>() / (blur as f64).sqrt());
        let turn = |at: usize| if turns && at % 40 < 3 { 15.0 - 10.0 * (at % 40) as f64 } else { 0.0 };
        noise.enumerate().map(|(at, noise)| noise + turn(at) + 0.5 * (0.02 * at as f64).sin()).collect()
    }

    fn noise_of(residual: Vec<f64>, counts: &[bool], not_smooth: Vec<f64>) -> NoiseFloor {
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
            further: Vec::new(),
        };
        NoiseFloor::of(&part, counts, not_smooth)
    }

    fn level_of(noise: &NoiseFloor, counts: &[bool]) -> f64 {
        (noise.squares() / counts.iter().filter(|c| **c).count() as f64).sqrt()
    }

    #[test]
    fn limit_noise_is_distinguished_from_reversal_transients() {
        for (blur, turns) in [(1, false), (1, true), (3, false), (3, true)] {
            let residual = residual(blur, turns);
            let all = (square(&residual) / residual.len() as f64).sqrt();
            let counts = vec![true; residual.len()];
            let level = level_of(&noise_of(residual.clone(), &counts, residual), &counts);
            // Peaks take part in every second of the longer differences, which the median sees as a little more noise.
            assert!((0.9..1.25).contains(&level), "{level} for noise of 1 over {blur} samples");
            assert!(!turns || all > 2.0, "{all}");
        }
    }

    #[test]
    fn limit_a_wave_is_at_most_what_smooth_functions_leave() {
        // Differences of a wave of 10 Hz tell 1.7 of its root mean square.
        let wave: Vec<f64> = (0..2000).map(|at| 3.0 * (0.2 * std::f64::consts::PI * at as f64).sin()).collect();
        let counts = vec![true; wave.len()];
        let half: Vec<f64> = wave.iter().map(|x| 0.5 * x).collect();
        assert!(level_of(&noise_of(wave.clone(), &counts, wave.clone()), &counts) < 3.0 / std::f64::consts::SQRT_2 + 1e-9);
        assert!(level_of(&noise_of(wave, &counts, half), &counts) < 1.5 / std::f64::consts::SQRT_2 + 1e-9);
    }

    #[test]
    fn limit_samples_that_do_not_count_say_nothing_of_noise() {
        let mut residual = residual(1, false);
        let counts: Vec<bool> = (0..residual.len()).map(|at| at % 100 >= 30).collect();
        residual.iter_mut().zip(&counts).filter(|(_, c)| !**c).for_each(|(x, _)| *x = 0.0);
        let noise = noise_of(residual.clone(), &counts, residual.clone());
        assert!((0.9..1.1).contains(&level_of(&noise, &counts)));
        assert_eq!(noise.square(0, 0.5), 0.0);
        assert!((0.8..1.3).contains(&noise.square(50, 0.999)));
        // Nothing that lasts long enough: what smooth functions leave.
        let few: Vec<bool> = (0..residual.len()).map(|at| at % 4 != 0).collect();
        assert_eq!(noise_of(residual.clone(), &few, residual.clone()), NoiseFloor::Sampled(residual));
    }
}
