//! Common effects that explain most of the misfit of motion records.

use super::closed_interval::closed_interval;
use super::context::{Chosen, Context};
use super::decision::amount;
use super::gap::{MotionPart, gap_of, part};
use super::noise_floor::{floor_of, noise_of};
use super::selection::SelectionStep;
use crate::evidence::share_closed;
use dynamics::inverse_dynamics::MotionSignal;

/// Least share of the misfit that a common effect must explain, and of the held-out gap that it must close
/// with confidence, to be mentioned.
const LEAST_CONFIDENT: f64 = 0.2;
/// Draws of the bootstrap of `closed`.
pub(super) const BOOTSTRAP: usize = 400;

/// Describes a common effect that explains most of the fitted records' misfit. It must close part of the
/// held-out gap with confidence, and more than its patch alone closes, as a description with compliant
/// springs may.
pub(super) fn common_cause(
    context: &Context<'_>,
    first: &SelectionStep,
    (full_fits, squares): (&[Option<Chosen>], f64),
    (before, held_out): (&[MotionPart], &[&MotionSignal]),
) -> Option<String> {
    let is_common = |at: &usize| context.is_common(first.last_effect(*at));
    let best = (0..first.ranked.len())
        .filter(is_common)
        .filter_map(|at| Some((at, full_fits[at].as_ref()?)))
        .min_by(|a, b| a.1.1.squares.total_cmp(&b.1.1.squares))
        .filter(|(_, (_, fit))| fit.squares < (1.0 - LEAST_CONFIDENT) * squares);
    let (at, (hypothesis, fit)) = best?;
    let machine = &hypothesis.machine;
    let parts = |values: &[f64]| {
        held_out.iter().map(|m| part(&context.rigid, machine, values, m)).collect::<Vec<MotionPart>>()
    };
    let mut without = fit.values.clone();
    hypothesis.added.iter().for_each(|i| without[*i] = machine.parameters[*i].start);
    let (after, without) = (parts(&fit.values), parts(&without));
    let noise = noise_of(before, held_out);
    let share =
        |after: &[MotionPart]| share_closed(gap_of(before)?, gap_of(after)?, floor_of(&noise, before)?);
    let closed = share(&after)?;
    let (low, high) = closed_interval(before, &after, &noise, BOOTSTRAP, context.settings.seed)?;
    if low < LEAST_CONFIDENT || closed - share(&without)? < LEAST_CONFIDENT {
        return None;
    }
    let amounts: Vec<String> =
        hypothesis.added.iter().map(|i| amount(&machine.parameters[*i], fit.values[*i])).collect();
    Some(format!(
        "{}, which is common on machines, closes {:.0} % of the held-out gap ({:.0}–{:.0} %): {}",
        first.id(at),
        100.0 * closed.min(1.0),
        100.0 * low,
        100.0 * high.min(1.0),
        amounts.join(", ")
    ))
}
