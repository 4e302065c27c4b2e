//! What noise alone leaves of records.

use nalgebra::DVector;

use super::data::MotionData;
use super::gap::{MotionPart, flat, not_repeating, square};
use super::weight::smooth_taken;
use crate::inverse_dynamics::Motion;
use crate::numeric::statistics::median;

/// Thinned samples between which noise is looked at: further apart misfit differs, too.
const LAGS: std::ops::RangeInclusive<usize> = 1..=6;
/// Fewest differences that tell a level.
const FEWEST: usize = 30;
/// Standard deviation of a normal variable over the median of its size.
const OVER_MEDIAN: f64 = 1.4826;

/// Noise of one channel of one record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Noise {
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

impl Noise {
    /// Sum of its squares.
    pub fn squares(&self) -> f64 {
        match self {
            Noise::Sampled(noise) => square(noise),
            Noise::Level { by_lag, counts } => {
                let level = median(by_lag.iter().copied()).unwrap_or(0.0);
                level * level * counts.iter().filter(|c| **c).count() as f64
            }
        }
    }

    /// Square of a sample, where `lag` (from 0 to 1) chooses among the times of the differences.
    pub fn square(&self, sample: usize, lag: f64) -> f64 {
        match self {
            Noise::Sampled(noise) => noise[sample].powi(2),
            Noise::Level { by_lag, counts } => {
                let at = ((lag * by_lag.len() as f64) as usize).min(by_lag.len() - 1);
                if counts[sample] { by_lag[at].powi(2) } else { 0.0 }
            }
        }
    }

    /// Where a record does not repeat: misfit shows at turns and is the same for a while elsewhere, noise everywhere. Hence the median size of
    /// differences over some hundredths of a second, of samples all of which count between.
    fn level(residual: &[f64], counts: &[bool]) -> Option<Self> {
        let of = |lag: usize| -> Option<f64> {
            let whole = |at: &usize| counts[at - lag..=*at].iter().all(|c| *c);
            let differences: Vec<f64> = (lag..residual.len()).filter(whole).map(|at| (residual[at] - residual[at - lag]).abs()).collect();
            (differences.len() >= FEWEST).then(|| OVER_MEDIAN * median(differences).unwrap_or(0.0) / std::f64::consts::SQRT_2)
        };
        let by_lag: Option<Vec<f64>> = LAGS.map(of).collect();
        Some(Noise::Level { by_lag: by_lag?, counts: counts.to_vec() })
    }
}

/// Noise of each channel of each record: where a command repeats, what the residual of the chosen model does not repeat, scaled for the mean taken
/// out; else its level; of a record too short to tell that, what smooth functions leave.
pub(super) fn noise_of(after: &[MotionPart], motions: &[&Motion]) -> Vec<Noise> {
    let of = |(part, motion): (&MotionPart, &&Motion)| -> Vec<Noise> {
        let counts = std::iter::once(&motion.moves).chain(motion.further.iter().map(|f| &f.counts));
        let level = |(c, counts): (&MotionPart, &Vec<bool>)| Noise::level(&c.residual, counts);
        let levels = part.period.is_none().then(|| part.channels().zip(counts).map(level).collect::<Option<Vec<Noise>>>());
        levels.flatten().unwrap_or_else(|| not_systematic(part, motion).into_iter().map(Noise::Sampled).collect())
    };
    after.iter().zip(motions).flat_map(of).collect()
}

/// What of the residual of each channel does not repeat with the command, scaled for the mean taken out; where that does not repeat, what smooth functions of
/// speed, position and travel since reversal leave: more than its noise.
pub(super) fn not_systematic(part: &MotionPart, motion: &Motion) -> Vec<Vec<f64>> {
    if let Some(period) = part.period {
        return part.channels().map(|c| not_repeating(&c.residual, period)).collect();
    }
    let data = MotionData::new(vec![motion]);
    let all = DVector::from_iterator(data.samples(), part.channels().flat_map(|c| c.residual.iter().copied()));
    smooth_taken(&data, all).as_slice().chunks(motion.load.len().max(1)).map(<[f64]>::to_vec).collect()
}

/// Gap that the noise alone leaves over records together.
pub(super) fn floor_of(noise: &[Noise], parts: &[MotionPart]) -> Option<f64> {
    let recorded: f64 = flat(parts).map(|p| square(&p.recorded)).sum();
    (recorded > 0.0).then(|| (noise.iter().map(Noise::squares).sum::<f64>() / recorded).sqrt())
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

    fn level_of(residual: &[f64], counts: &[bool]) -> Option<f64> {
        Noise::level(residual, counts).map(|noise| (noise.squares() / counts.iter().filter(|c| **c).count() as f64).sqrt())
    }

    #[test]
    fn limit_noise_is_told_from_what_happens_at_turns() {
        for (blur, turns) in [(1, false), (1, true), (3, false), (3, true)] {
            let residual = residual(blur, turns);
            let level = level_of(&residual, &vec![true; residual.len()]).unwrap();
            // Peaks take part in every second of the longer differences, which the median sees as a little more noise.
            assert!((0.9..1.25).contains(&level), "{level} for noise of 1 over {blur} samples");
            let all = (square(&residual) / residual.len() as f64).sqrt();
            assert!(!turns || all > 2.0, "{all}");
        }
    }

    #[test]
    fn limit_samples_that_do_not_count_say_nothing_of_noise() {
        let mut residual = residual(1, false);
        let counts: Vec<bool> = (0..residual.len()).map(|at| at % 100 >= 30).collect();
        residual.iter_mut().zip(&counts).filter(|(_, c)| !**c).for_each(|(x, _)| *x = 0.0);
        let level = level_of(&residual, &counts).unwrap();
        assert!((0.9..1.1).contains(&level), "{level}");
        assert_eq!(Noise::level(&residual, &vec![false; residual.len()]), None);
        let noise = Noise::level(&residual, &counts).unwrap();
        assert_eq!(noise.square(0, 0.5), 0.0);
        assert!((0.8..1.3).contains(&noise.square(50, 0.999)));
    }
}
