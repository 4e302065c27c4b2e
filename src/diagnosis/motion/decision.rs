//! From figures to a verdict.

use super::context::{Chosen, Context};
use super::data_fault::Contradiction;
use super::diagnosis::{ALPHA, LocatedMotion, NEARLY_ALL, RARE};
use super::screening::releases;
use super::selection::SelectionStep;
use crate::verdict::p_value_text;
use crate::{Verdict, VerdictKind};
use identification::motion::ForceFit;
use machine::Parameter;

/// What a free shape must leave of what the chosen effects leave, for these to be doubted.
const DOUBT: f64 = 0.5;
/// Least gain of a free shape that is called something, and of an effect that shows and yet is not it.
const LEAST_FREE: f64 = 0.1;

/// What the verdict rests on.
pub(super) struct MotionDecisionInputs<'e> {
    pub work: &'e Context<'e>,
    pub first: &'e SelectionStep,
    pub base: &'e Chosen,
    pub chosen: &'e Chosen,
    pub names: &'e [String],
    /// What they leave of what the machine fails to foretell of parts left out.
    pub loss: f64,
    /// Fits of everything with each of the ranked effects.
    pub plain: &'e [Option<Chosen>],
    /// Place of the effect that is named first, if it is one of those that are not told apart.
    pub named: Option<usize>,
    pub same: &'e [usize],
    pub located: &'e [LocatedMotion],
    pub faulty: Vec<Contradiction>,
    /// Held-out records that contradict the fitted ones.
    pub contradictions: &'e [Contradiction],
}

/// The verdict.
pub(super) fn conclude(evidence: &MotionDecisionInputs<'_>) -> Verdict {
    let MotionDecisionInputs { work, first, base, chosen, names, loss: chosen_loss, plain, named, same, located, faulty, contradictions } =
        evidence;
    let say = |kind: VerdictKind, effects: Vec<String>, reason: String, next: Option<String>| Verdict { kind, effects, reason, next };
    let at_fault = |records: &[Contradiction]| {
        let reason = records.iter().map(|f| f.description.clone()).collect::<Vec<_>>().join("; ");
        let which = records.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(" or ");
        let next = Some(format!("record {which} again, force and position by one clock; hold it out until then"));
        say(VerdictKind::Measurement, Vec::new(), reason, next)
    };
    if !faulty.is_empty() {
        return at_fault(faulty);
    }
    // Nothing is missing where a record says otherwise: then that record is at fault.
    let nothing = |reason: String| match contradictions.is_empty() {
        true => say(VerdictKind::None, Vec::new(), reason, None),
        false => at_fault(contradictions),
    };
    let left = |of: &ForceFit| of.squares / base.1.squares;
    let free = first.best_free();
    let free_loss = free.map_or(f64::INFINITY, |f| 1.0 - f.gain);
    let place =
        located.first().map_or("?".into(), |l| l.column.as_ref().map_or(l.over.to_string(), |column| format!("{} in {column}", l.over)));
    let what = if located.first().is_some_and(|l| l.column.is_some()) { "the transmission error" } else { "the force" };
    let listen = || Some(format!("the same motion at other speeds and loads: {what} left depends on {place}"));
    let Some(best) = first.best_effect() else {
        return say(VerdictKind::Unknown, Vec::new(), "no candidate applies to this machine and these records".into(), None);
    };
    if names.is_empty() {
        let (id, gain) = (first.id(best), first.ranked[best].gain);
        let tells = |gain: f64, p: f64| (gain >= LEAST_FREE && p < ALPHA) || (gain >= NEARLY_ALL && p < RARE);
        if let Some(free) = free.filter(|f| tells(f.gain, first.null.p_value_free(f))) {
            let reason = format!(
                "a free function of {place} takes {:.0} % of what the machine fails to foretell of parts left out ({}), and no effect of the library \
                 does as much as nulls show (most {id}, {:.0} %)",
                100.0 * free.gain,
                p_value_text(first.null.p_value_free(free)),
                100.0 * gain.max(0.0)
            );
            return say(VerdictKind::Unknown, Vec::new(), reason, listen());
        }
        let (p, least) = (first.null.p_value(&first.ranked[best]), work.least(first, id));
        let shows = plain[best].as_ref().is_some_and(|next| work.shows(first, best, next, base));
        let takes = format!("{id} takes {:.0} % of what parts left out leave beside what is ordinarily wrong", 100.0 * gain.max(0.0));
        let not_it = format!("{takes}, but the fit of everything with it ends where it does little of that by itself");
        if p < ALPHA && gain >= least.max(LEAST_FREE) && shows {
            return say(VerdictKind::Unknown, Vec::new(), not_it, listen());
        }
        if let Some((wrong, size)) = &first.stretched {
            let reason = format!(
                "what is ordinarily a little wrong explains it only at {size:.1} standard deviations ({wrong}), and no effect of the library stands for \
                 it (most {id}, {:.0} %)",
                100.0 * gain.max(0.0)
            );
            return say(VerdictKind::Unknown, Vec::new(), reason, listen());
        }
        if p < ALPHA && gain >= least {
            return nothing(not_it);
        }
        if p < ALPHA {
            let reason = format!("{takes}, less than {:.0} % is no more than machines leave that are as described", 100.0 * least);
            return nothing(reason);
        }
        let reason = format!(
            "what is left is no more than nulls of this machine and these motions show (most is gained by {id}, {:.0} % of what parts left out leave, \
             {})",
            100.0 * gain.max(0.0),
            p_value_text(p)
        );
        return nothing(reason);
    }
    let best = named.unwrap_or(best);
    let gain = first.ranked[best].gain;
    let release = same.iter().find(|at| releases(&first.survey.candidates[first.ranked[**at].candidate]));
    if let Some(&at) = release {
        let ranked = &first.ranked[at];
        let told = plain[at].as_ref().map_or(String::new(), |(h, f)| {
            let index = h.added[0];
            let p = &h.machine.parameters[index];
            format!("{} was held at {:.4e} {}; free, it becomes {:.4e}", p.id, p.start, p.unit, f.values[index])
        });
        let more = names.len() > 1 && at == best;
        let reason = format!(
            "{told} and takes {:.0} % of what parts left out leave away{}",
            100.0 * ranked.gain,
            if more { format!("; beside it {} is missing", names[1..].join(" and ")) } else { ": no effect is needed".into() }
        );
        let next = Some(format!("identify without --freeze {}", first.id(at)));
        return say(VerdictKind::WrongParameter, Vec::new(), reason, next);
    }
    // What the chosen effects leave, beside what the best free shape leaves.
    if free_loss < DOUBT * chosen_loss && *chosen_loss > DOUBT * DOUBT {
        let reason = format!(
            "the best of the library, {}, leaves {:.0} % of what the machine fails to foretell of parts left out; a free function of {place} leaves {:.0} %",
            names.join("+"),
            100.0 * chosen_loss,
            100.0 * free_loss
        );
        return say(VerdictKind::Unknown, Vec::new(), reason, listen());
    }
    let reason = format!(
        "{} takes {:.0} % of what the machine fails to foretell of parts left out away ({}){}",
        names[0],
        100.0 * gain,
        p_value_text(first.null.p_value(&first.ranked[best])),
        if names.len() > 1 {
            format!("; with {} {:.0} % of the squared misfit are gone", names[1..].join(" and "), 100.0 * (1.0 - left(&chosen.1)))
        } else {
            String::new()
        }
    ) + &amounts(work, chosen);
    let rest: String = names[1..].iter().map(|n| format!("+{n}")).collect();
    let alternatives: Vec<String> = std::iter::once(names[0].clone())
        .chain(
            same.iter()
                .map(|at| first.id(*at).to_string())
                .chain(first.confusable_unseen(work.effects, &names[0]))
                .filter(|id| !names.contains(id)),
        )
        .map(|id| format!("{id}{rest}"))
        .collect();
    if alternatives.len() == 1 {
        return say(VerdictKind::Effect, alternatives, reason, None);
    }
    let reason = format!("{reason}; these data cannot tell it from {}", alternatives[1..].join(", "));
    let next = same.iter().find_map(|at| work.effects.iter().find(|e| e.id == first.id(*at))).and_then(|e| e.discriminating_test.clone());
    say(VerdictKind::Ambiguous, alternatives, reason, next)
}

/// How much the chosen effects are, where further points tell it: lengths in µm.
fn amounts(work: &Context<'_>, (hypothesis, fit): &Chosen) -> String {
    if work.data.columns.is_empty() {
        return String::new();
    }
    let of = |i: &usize| amount(&hypothesis.machine.parameters[*i], fit.values[*i]);
    let all: Vec<String> = hypothesis.added.iter().map(of).collect();
    if all.is_empty() { String::new() } else { format!("; {}", all.join(", ")) }
}

/// How much a parameter is, short lengths in µm.
pub(super) fn amount(p: &Parameter, x: f64) -> String {
    match (p.unit.as_str(), x.abs() < 1e-3) {
        ("m", true) => format!("{} is {:.1} µm", p.id, 1e6 * x),
        ("1", true) => format!("{} is {:.1} µm per m", p.id, 1e6 * x),
        ("m", false) => format!("{} is {:.2} mm", p.id, 1e3 * x),
        ("s", true) => format!("{} is {:.2} ms", p.id, 1e3 * x),
        _ => format!("{} is {x:.4e} {}", p.id, p.unit),
    }
}
