//! Map of the misfit over phase of the motion, speed, position and direction.

use super::gap::{MotionPart, square};
use dynamics::inverse_dynamics::{MotionSignal, Phase, phases};
use numeric::statistics::extremes;

/// Variable by which a cell is defined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MisfitAxis {
    /// A phase of the motion.
    Phase(Phase),
    /// Range of speed (m/s).
    Speed(f64, f64),
    /// Range of position (m).
    Position(f64, f64),
}

/// A cell: some samples of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct MisfitCell {
    /// Name of the record.
    pub record: String,
    /// Name of the extra channel; `None` for the force.
    pub column: Option<String>,
    /// Variable and range of the cell.
    pub kind: MisfitAxis,
    /// Direction: 1 forward, −1 backward, 0 both.
    pub direction: i8,
    /// Number of samples.
    pub samples: usize,
    /// Root mean square of the residual in the cell over that of the record's force (of the transmission
    /// error for an extra channel).
    pub gap: f64,
    /// Share of the record's squared misfit.
    pub share: f64,
    /// Mean of recorded less predicted force (N or N·m; m or rad for an extra channel).
    pub mean: f64,
}

/// Number of bands of speed and of position.
const BANDS: usize = 5;

/// Returns the non-empty cells of a record. Samples at standstill belong to no cell: there the force of a
/// rigid drive does not follow from its motion.
pub fn misfit_map(motion: &MotionSignal, part: &MotionPart) -> Vec<MisfitCell> {
    let mut found = cells_of(motion, part, (None, &motion.is_moving, 1.0));
    for (further, part) in motion.extra_channels.iter().zip(&part.extra_channels) {
        found.extend(cells_of(motion, part, (Some(&further.column), &further.is_used, further.weight)));
    }
    found
}

/// Returns the cells of one channel, with the mask of its samples and its weight.
fn cells_of(
    motion: &MotionSignal,
    part: &MotionPart,
    (column, counts, weight): (Option<&String>, &[bool], f64),
) -> Vec<MisfitCell> {
    let kept: Vec<usize> = motion.kept().collect();
    let all = phases(motion);
    let moving = counts.iter().filter(|m| **m).count();
    let force = (square(&part.recorded) / moving.max(1) as f64).sqrt();
    let total = square(&part.residual);
    let cell = |kind: MisfitAxis, direction: i8, inside: &dyn Fn(usize) -> bool| {
        let own: Vec<f64> = kept
            .iter()
            .zip(&part.residual)
            .zip(counts)
            .filter(|((at, _), moves)| {
                **moves
                    && inside(**at)
                    && (direction == 0 || motion.velocity_m_s[**at] * f64::from(direction) > 0.0)
            })
            .map(|((_, e), _)| *e)
            .collect();
        let square = square(&own);
        (!own.is_empty()).then(|| MisfitCell {
            record: motion.name.clone(),
            column: column.cloned(),
            kind,
            direction,
            samples: own.len(),
            gap: (square / own.len() as f64).sqrt() / force,
            share: square / total.max(f64::MIN_POSITIVE),
            mean: own.iter().sum::<f64>() / own.len() as f64 / weight,
        })
    };
    let mut found: Vec<MisfitCell> = Vec::new();
    for phase in Phase::ALL {
        for direction in [0, 1, -1] {
            found.extend(cell(MisfitAxis::Phase(phase), direction, &|at| all[at] == phase));
        }
    }
    let fastest = motion.velocity_m_s.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (low, high) = extremes(&motion.position_m);
    for band in 0..BANDS {
        let edge = |from: f64, to: f64, k: usize| from + (to - from) * k as f64 / BANDS as f64;
        let last = band + 1 == BANDS;
        let (a, b) = (edge(0.0, fastest, band), edge(0.0, fastest, band + 1));
        for direction in [1, -1] {
            let inside = |at: usize| {
                let v = motion.velocity_m_s[at].abs();
                v >= a && (v < b || last)
            };
            found.extend(cell(MisfitAxis::Speed(a, b), direction, &inside));
        }
        let (a, b) = (edge(low, high, band), edge(low, high, band + 1));
        for direction in [1, -1] {
            let inside = |at: usize| motion.position_m[at] >= a && (motion.position_m[at] < b || last);
            found.extend(cell(MisfitAxis::Position(a, b), direction, &inside));
        }
    }
    found
}

/// Least share of the masked samples in a phase whose mean is used.
const LEAST_SAMPLES: f64 = 0.01;

/// Returns the phase with the largest mean amount per sample. Amounts are given for the force, record after
/// record, each followed by its extra channels.
pub(super) fn largest_phase(motions: &[&MotionSignal], amount: &[f64]) -> Option<Phase> {
    let mut sums = [(0.0, 0_usize); Phase::ALL.len()];
    let mut amounts = amount.iter();
    for motion in motions {
        let (kept, all): (Vec<usize>, _) = (motion.kept().collect(), phases(motion));
        for counts in
            std::iter::once(&motion.is_moving).chain(motion.extra_channels.iter().map(|f| &f.is_used))
        {
            for ((at, counts), amount) in kept.iter().zip(counts).zip(&mut amounts) {
                if *counts {
                    let (sum, count) = &mut sums[all[*at] as usize];
                    *sum += amount;
                    *count += 1;
                }
            }
        }
    }
    let least = LEAST_SAMPLES * sums.iter().map(|(_, count)| *count as f64).sum::<f64>();
    let means = Phase::ALL
        .into_iter()
        .zip(sums)
        .filter(|(_, (sum, count))| *count > 0 && *count as f64 >= least && *sum > 0.0);
    means.max_by(|a, b| (a.1.0 / a.1.1 as f64).total_cmp(&(b.1.0 / b.1.1 as f64))).map(|(phase, _)| phase)
}
