//! Decision on the verdict of a motion.

use super::candidate::releases;
use super::context::{Chosen, Context};
use super::data_fault::Contradiction;
use super::free_function::LocatedMotion;
use super::selection::{ALPHA, NEARLY_ALL, RARE, SelectionStep};
use crate::verdict::{frozen_text, p_value_text, with_first};
use crate::{Verdict, VerdictKind};
use identification::motion::ForceFit;
use machine::{EffectIds, Mechanism, Parameter};

/// Ratio of the loss of the best free function to that of the chosen effects below which these are rejected.
const DOUBTFUL: f64 = 0.5;
/// Least reduction of the prediction error by a free function, and by an effect that shows but is not
/// confirmed, that gives the verdict «unknown».
const LEAST_FREE: f64 = 0.1;

/// Inputs of the decision.
pub(super) struct MotionDecisionInputs<'e> {
    pub context: &'e Context<'e>,
    pub first: &'e SelectionStep,
    pub base: &'e Chosen,
    pub chosen: &'e Chosen,
    pub names: &'e EffectIds,
    /// Prediction error at left-out parts with these effects, over that of the machine alone.
    pub loss: f64,
    /// Joint fits of all parameters with each of the ranked candidates.
    pub full_fits: &'e [Option<Chosen>],
    /// Index of the effect that is named first among the indistinguishable ones.
    pub named: Option<usize>,
    pub same: &'e [usize],
    pub located: &'e [LocatedMotion],
    pub faulty: Vec<Contradiction>,
    /// Held-out records that contradict the fitted ones.
    pub contradictions: &'e [Contradiction],
    /// Those of them that no imperfectly modelled effect explains.
    pub stated: &'e [Contradiction],
    /// 95 % interval of the share that the chosen effects close of the gap of the held-out records, without
    /// those if others remain.
    pub closed95: Option<(f64, f64)>,
    /// Whether records are held out.
    pub holds_out: bool,
}

/// Decides on the verdict. What is named on the fitted records stands as an effect where the held-out ones
/// speak for it.
pub(super) fn decide(inputs: &MotionDecisionInputs<'_>) -> Verdict {
    if !inputs.faulty.is_empty() {
        // Which of two that contradict each other is wrong, is open.
        let faults = if inputs.faulty.len() == 1 { ids(&inputs.faulty) } else { Vec::new() };
        return Verdict { faults, ..at_fault(&inputs.faulty) };
    }
    let verdict = explanation(inputs);
    let contradictions = inputs.contradictions;
    if !verdict.kind.explains() {
        return match verdict.kind {
            VerdictKind::None if !contradictions.is_empty() => at_fault(contradictions),
            VerdictKind::Unknown if !inputs.stated.is_empty() => {
                let fault = at_fault(inputs.stated);
                Verdict { reason: format!("{}; besides, {}", fault.reason, verdict.reason), ..fault }
            }
            _ => verdict,
        };
    }
    let confirmed = inputs.holds_out.then(|| inputs.closed95.is_some_and(|(low, _)| low > 0.0));
    let stated = inputs.stated;
    let beside: String = stated.iter().map(|record| format!("; {}", record.description)).collect();
    let verdict =
        Verdict { confirmed, faults: ids(stated), reason: verdict.reason.clone() + &beside, ..verdict };
    match (confirmed, verdict.kind) {
        (Some(false), _) if !stated.is_empty() => at_fault(stated),
        (Some(false), VerdictKind::Effect) => {
            let reason = "the held-out records do not surely speak for the best effect";
            Verdict {
                confirmed,
                ..verdict.unnamed(reason, "record more motions with other speeds and loads")
            }
        }
        _ => verdict,
    }
}

fn ids(records: &[Contradiction]) -> Vec<String> {
    records.iter().flat_map(|record| record.faults.iter().cloned()).collect()
}

fn at_fault(records: &[Contradiction]) -> Verdict {
    let reason = records.iter().map(|f| f.description.clone()).collect::<Vec<_>>().join("; ");
    let which = records.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(" or ");
    let next = format!("record {which} again with force and position on one clock; exclude it until then");
    Verdict { faults: ids(records), ..Verdict::new(VerdictKind::Measurement, reason, Some(next)) }
}

/// Returns the verdict that the fitted records give.
fn explanation(inputs: &MotionDecisionInputs<'_>) -> Verdict {
    let MotionDecisionInputs {
        context,
        first,
        base,
        chosen,
        names,
        loss: chosen_loss,
        full_fits,
        named,
        same,
        located,
        ..
    } = inputs;
    let no_effect = |reason: String| Verdict::new(VerdictKind::None, reason, None);
    let left = |of: &ForceFit| of.squares / base.1.squares;
    let free = first.best_free();
    let free_loss = free.map_or(f64::INFINITY, |f| 1.0 - f.gain);
    let place = located.first().map_or("?".into(), |l| {
        l.column.as_ref().map_or(l.over.to_string(), |column| format!("{} in {column}", l.over))
    });
    let compared = if located.first().is_some_and(|l| l.column.is_some()) {
        "the transmission error"
    } else {
        "the force"
    };
    let unknown = |reason: String| {
        let next = format!(
            "record the same motion at other speeds and loads: the residual of {compared} depends on {place}"
        );
        Verdict::new(VerdictKind::Unknown, reason, Some(next))
    };
    let Some(best) = first.best_effect() else {
        return Verdict::new(
            VerdictKind::Unknown,
            "no candidate applies to this machine and these records".into(),
            None,
        );
    };
    if names.is_empty() {
        let (id, gain) = (first.id(best), first.ranked[best].gain);
        let is_significant =
            |gain: f64, p: f64| (gain >= LEAST_FREE && p < ALPHA) || (gain >= NEARLY_ALL && p < RARE);
        if let Some(free) = free.filter(|f| is_significant(f.gain, first.null.p_value_free(f))) {
            let reason = format!(
                "a free function of {place} reduces the squared prediction error at left-out parts by {:.0} % ({}), and no effect of the \
                 library is significant (best: {id}, {:.0} %)",
                100.0 * free.gain,
                p_value_text(first.null.p_value_free(free)),
                100.0 * gain.max(0.0)
            );
            return unknown(reason);
        }
        let (p, least) = (first.null.p_value(&first.ranked[best]), context.least(first, id));
        let shows = full_fits[best].as_ref().is_some_and(|next| context.shows(first, best, next, base));
        let reduction = format!(
            "next to the nuisance parameters, {id} reduces the squared prediction error at left-out parts by {:.0} %",
            100.0 * gain.max(0.0)
        );
        let not_confirmed = format!(
            "{reduction}, but in the joint fit without nuisance parameters it reduces the misfit much less"
        );
        if p < ALPHA && gain >= least.max(LEAST_FREE) && shows {
            return unknown(not_confirmed);
        }
        if let Some((nuisance, size)) = &first.implausible {
            let reason = format!(
                "the misfit requires a nuisance parameter at {size:.1} standard deviations ({nuisance}), and no effect of the library \
                 explains it (best: {id}, {:.0} %)",
                100.0 * gain.max(0.0)
            );
            return unknown(reason);
        }
        if p < ALPHA && gain >= least {
            return no_effect(not_confirmed);
        }
        if p < ALPHA {
            let reason = format!(
                "{reduction}; reductions below {:.0} % are common on machines without a missing effect",
                100.0 * least
            );
            return no_effect(reason);
        }
        let reason = format!(
            "the residual is consistent with null simulations of this machine and these motions (best candidate: {id}, which reduces the \
             squared prediction error at left-out parts by {:.0} %, {})",
            100.0 * gain.max(0.0),
            p_value_text(p)
        );
        return no_effect(reason);
    }
    let best = named.unwrap_or(best);
    let gain = first.ranked[best].gain;
    let release = same.iter().find(|at| releases(&first.screening.candidates[first.ranked[**at].candidate]));
    if let Some(&at) = release {
        let ranked = &first.ranked[at];
        let estimate = full_fits[at].as_ref().map_or(String::new(), |(h, f)| {
            let index = h.added[0];
            frozen_text(&h.machine.parameters[index], f.values[index])
        });
        let more = names.len() > 1 && at == best;
        let reason = format!(
            "{estimate} reduces the squared prediction error at left-out parts by {:.0} %{}",
            100.0 * ranked.gain,
            if more {
                format!("; in addition the model lacks {}", names.after_first().join(" and "))
            } else {
                ": no effect is needed".into()
            }
        );
        return Verdict::wrong_parameter(first.id(at), reason);
    }
    // Compare the chosen effects with the best free function.
    if free_loss < DOUBTFUL * chosen_loss && *chosen_loss > DOUBTFUL * DOUBTFUL {
        let reason = format!(
            "the best effect of the library, {names}, leaves {:.0} % of the squared prediction error at left-out parts; a free function of \
             {place} leaves {:.0} %",
            100.0 * chosen_loss,
            100.0 * free_loss
        );
        return unknown(reason);
    }
    let leading = names.first().unwrap_or_default();
    let reason = format!(
        "{leading} reduces the squared prediction error at left-out parts by {:.0} % ({}){}",
        100.0 * gain,
        p_value_text(first.null.p_value(&first.ranked[best])),
        if names.len() > 1 {
            format!(
                "; with {} the squared misfit falls by {:.0} %",
                names.after_first().join(" and "),
                100.0 * (1.0 - left(&chosen.1))
            )
        } else {
            String::new()
        }
    ) + &amounts(context, chosen);
    let alternatives: Vec<EffectIds> = std::iter::once(leading.to_string())
        .chain(
            same.iter()
                .map(|at| first.id(*at).to_string())
                .chain(first.confusable_unidentifiable(context.effects, leading))
                .filter(|id| !names.contains(id)),
        )
        .map(|id| with_first(&id, names))
        .collect();
    let known = |at: &usize| context.effects.iter().find(|effect| effect.id == first.id(*at));
    let test = same.iter().find_map(known).and_then(|effect| effect.discriminating_test.clone());
    Verdict::naming(alternatives, reason, test)
}

/// Formats the parameters of the chosen effects where extra measuring points were recorded; short lengths in
/// µm.
fn amounts(context: &Context<'_>, (hypothesis, fit): &Chosen) -> String {
    if context.data.columns.is_empty() {
        return String::new();
    }
    let of = |i: &usize| amount(&hypothesis.machine.parameters[*i], fit.values[*i]);
    let all: Vec<String> = hypothesis.added.iter().map(of).collect();
    if all.is_empty() { String::new() } else { format!("; {}", all.join(", ")) }
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
