//! Common effects that explain most of the misfit of motion records.

use super::closed_interval::closed_interval;
use super::context::MotionFit;
use super::gap::{MotionPart, gap_of, part};
use super::gather::MotionGatherer;
use super::noise_floor::{floor_of, noise_of};
use crate::evidence::share_closed;
use machine::{Mechanism, Parameter};

/// Least share of the misfit that a common effect must explain, and of the held-out gap that it must close
/// with confidence, to be mentioned.
const LEAST_CONFIDENT: f64 = 0.2;
/// Draws of the bootstrap of `closed`.
pub(super) const BOOTSTRAP: usize = 400;

/// Describes a common effect that explains most of the fitted records' misfit. It must close part of the
/// held-out gap with confidence, and more than its patch alone closes, as a description with compliant
/// springs may.
pub(super) fn common_cause(gatherer: &MotionGatherer<'_, '_>, before: &[MotionPart]) -> Option<String> {
    let (context, held_out) = (gatherer.context, &gatherer.held_out.motions);
    let squares = gatherer.alone.1.squares;
    let is_common = |(hypothesis, _): &&MotionFit| {
        let last = hypothesis.effects.last();
        context.effects.iter().any(|e| e.common && Some(e.id.as_str()) == last)
    };
    let fits = gatherer.first.candidates.iter().filter_map(|candidate| candidate.alone.as_ref());
    let best = fits
        .filter(is_common)
        .min_by(|a, b| a.1.squares.total_cmp(&b.1.squares))
        .filter(|(_, fit)| fit.squares < (1.0 - LEAST_CONFIDENT) * squares);
    let (hypothesis, fit) = best?;
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
        hypothesis.effects.last().unwrap_or_default(),
        100.0 * closed.min(1.0),
        100.0 * low,
        100.0 * high.min(1.0),
        amounts.join(", ")
    ))
}

/// Formats the value of a parameter; short lengths in µm, expansions of a lead in µm per m.
pub(super) fn amount(p: &Parameter, x: f64) -> String {
    if p.mechanism == Mechanism::LeadExpansion && x.abs() < 1e-3 {
        return format!("{} is {:.1} µm per m", p.id, 1e6 * x);
    }
    match (p.unit.as_str(), x.abs() < 1e-3) {
        ("m", true) => format!("{} is {:.1} µm", p.id, 1e6 * x),
        ("m", false) => format!("{} is {:.2} mm", p.id, 1e3 * x),
        ("s", true) => format!("{} is {:.2} ms", p.id, 1e3 * x),
        _ => format!("{} is {x:.4e} {}", p.id, p.unit),
    }
}
