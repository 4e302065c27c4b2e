//! How sure it is how far the gap closes: data drawn from the model that closes it, diagnosed again.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::domain::{Compared, Domain, Part};
use super::fit::{Fitted, Fitter, place_of};
use super::hypothesis::Hypothesis;
use super::null::another_machine;
use super::verdict::closed;
use crate::measurement::{FitSet, HoldOutSet};
use crate::objective::{FrfGap, FrfObjective};
use crate::optimizer::{Control, least_squares_within};

/// Lines of one FRF in a draw, and steps of its fits.
const LINES: usize = 80;
const STEPS: u64 = 10;

/// 95 % interval of `closed`: machines a little richer than the chosen one are drawn about its fit, the nominal and the chosen model are fitted to
/// their fit positions, and both predict the held-out ones. `None` for modes, or where too few draws give a figure.
pub fn closed_interval(
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    nominal: (&Hypothesis, &Fitted),
    chosen: (&Hypothesis, &Fitted),
    (estimate, draws, seed): (f64, usize, u64),
    control: &Control,
) -> Option<(f64, f64)> {
    let Domain::Frf(settings) = fitter.domain else { return None };
    let far = fitter.on(FitSet { set: held_out.set, positions: held_out.positions.clone(), frfs: held_out.frfs.clone() });
    let step = control.steps("draws", draws);
    let one = |draw: usize| -> Option<f64> {
        let random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0xD1B5_4A33).wrapping_add(draw as u64));
        // The same seed draws the same machine for both.
        let near_by = another_machine(fitter, chosen.0, chosen.1, settings, LINES, (1.0, random.clone()))?;
        let far_by = another_machine(&far, chosen.0, chosen.1, settings, LINES, (1.0, random))?;
        let gap = |(hypothesis, fitted): (&Hypothesis, &Fitted)| -> Option<Vec<Part>> {
            let own = coarse(fitter, hypothesis)?.shifted(&near_by);
            let start = {
                let compared = fitter.objective(hypothesis).ok()?;
                place_of(&compared, fitted)
            };
            let polished = least_squares_within(&own, &start, &[], (STEPS, 1e-3), control.stop());
            let there = coarse(&far, hypothesis)?.shifted(&far_by);
            let part = |g: FrfGap| Part { position: None, frf: Some(g.frf), gap: g.gap, floor: g.noise_floor, count: g.lines };
            Some(there.gaps(&own.parameters(&polished.place), own.gain(&polished.place)).into_iter().map(part).collect())
        };
        closed(&gap(nominal)?, &gap(chosen)?)
    };
    let piece = fitter.piece("closed", chosen.0, &[nominal.1.clone(), chosen.1.clone()]);
    let drawn: Vec<f64> = (0..draws)
        .into_par_iter()
        .filter_map(|draw| {
            let closed = control.kept(&format!("{piece} {draw} {seed}"), || one(draw));
            step();
            closed
        })
        .collect();
    if drawn.len() < draws / 2 || drawn.len() < 8 {
        return None;
    }
    let count = drawn.len() as f64;
    let mean = drawn.iter().sum::<f64>() / count;
    let spread = (drawn.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
    // The spread of the draws about the figure of the data, wide enough to hold their mean.
    let half = 1.96 * spread;
    Some((estimate.min(mean) - half, estimate.max(mean) + half))
}

fn coarse<'h>(fitter: &Fitter<'_>, hypothesis: &'h Hypothesis) -> Option<FrfObjective<'h>> {
    match fitter.objective(hypothesis).ok()?.coarse(LINES)? {
        Compared::Frf(objective) => Some(objective),
        Compared::Modes(_) => None,
    }
}
