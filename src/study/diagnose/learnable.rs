//! Residual transmission error that a neural network can learn: the ceiling for any physical effect.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use diagnosis::motion::MotionPart;
use dynamics::inverse_dynamics::MotionSignal;
use identification::neural_residual::{Example, NeuralResidual};
use report::record::LearnableRow;

/// Most examples, spread evenly, and random starts of a training.
const EXAMPLES: usize = 8000;
const BEGINNINGS: usize = 4;

/// Trains a network per extra channel on the residual of the machine as described, from command and position
/// of the fitted records. Returns its residual at held-out records next to that of the chosen model.
pub fn learnable(
    motions: &[&MotionSignal],
    (before, after): (&[&MotionPart], &[&MotionPart]),
    fitted: usize,
    seed: u64,
    stop: &Arc<AtomicBool>,
) -> Vec<LearnableRow> {
    let Some(first) = motions.first().filter(|_| fitted < motions.len()) else { return Vec::new() };
    let row = |(at, further): (usize, &dynamics::inverse_dynamics::ExtraChannel)| {
        let samples = |record: usize, parts: &[&MotionPart]| -> Option<Vec<Example>> {
            let (motion, part) = (motions[record], parts[record].extra_channels.get(at)?);
            let counts = &motion.extra_channels.get(at)?.is_used;
            let all = motion.kept().zip(counts).zip(&part.residual).filter(|((_, counts), _)| **counts);
            let example = |((i, _), residual): ((usize, &bool), &f64)| Example {
                command: motion.command_m[i],
                modelled: motion.position_m[i],
                deviation: residual / part.weight,
            };
            Some(all.map(example).collect())
        };
        let of = |records: std::ops::Range<usize>, parts: &[&MotionPart]| -> Option<Vec<Example>> {
            Some(records.map(|r| samples(r, parts)).collect::<Option<Vec<_>>>()?.concat())
        };
        let lesson = of(0..fitted, before)?;
        let thin: Vec<Example> =
            lesson.iter().step_by(lesson.len().div_ceil(EXAMPLES).max(1)).copied().collect();
        let network = NeuralResidual::train(&thin, seed, BEGINNINGS, stop).ok()?.network;
        let (unseen, chosen) = (of(fitted..motions.len(), before)?, of(fitted..motions.len(), after)?);
        let rms = |of: &dyn Fn(&Example) -> f64, all: &[Example]| {
            (all.iter().map(|e| of(e).powi(2)).sum::<f64>() / all.len().max(1) as f64).sqrt()
        };
        Some(LearnableRow {
            column: further.column.clone(),
            unit: further.unit.into(),
            before: rms(&|e| e.deviation, &unseen),
            with_network: rms(&|e| e.deviation - network.deviation(e.command, e.modelled), &unseen),
            after: rms(&|e| e.deviation, &chosen),
        })
    };
    first.extra_channels.iter().enumerate().filter_map(row).collect()
}
