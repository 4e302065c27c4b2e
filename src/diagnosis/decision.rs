//! What is said: none, an effect, effects that the data cannot tell apart, a wrong parameter, a faulty record, or something unknown and where.

use rayon::prelude::*;

use super::cross_validation::cross_validation;
use super::data_fault::{Fault, fault, held_out_fault};
use super::evidence::{Domain, PartialGap, floor_over, gap_over, share_closed};
use super::fit::{Ablation, Fitted, Fitter, values_of};
use super::hypothesis::{Hypothesis, HypothesisKind};
use super::location::Location;
use super::nominal_refit::NominalRefit;
use super::null_distribution::{LEAST_SCALE, NullDistribution, simulate};
use super::parsimony::{NamedFit, more_parsimonious};
use super::screening::{Candidate, Screening, Status, hypotheses, locate, nominal, nominal_fits, refit_from_free_shapes, screen};
use super::thresholds::Thresholds;
use super::verdict::{Verdict, VerdictKind, last_of, named, nothing_fitted, p_value_text};
use identification::ToleranceEstimate;
use identification::objective::ObjectiveError;
use machine::{Effect, Machine};
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;
use optimizer::Control;

/// A candidate with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedEffect {
    /// The candidate.
    pub candidate: Candidate,
    /// Gain over its scale under the null, less where much stays unexplained.
    pub statistic: f64,
    /// Share of nulls with a statistic as large, whatever the candidate.
    pub p_value: f64,
    /// Held-out gaps of the machine as described with it.
    pub held_out: Vec<PartialGap>,
}

/// An interface with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedLocation {
    /// The candidate.
    pub candidate: Candidate,
    /// Held-out gaps with it.
    pub held_out: Vec<PartialGap>,
}

/// A whole diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// FRFs or modes.
    pub domain: Domain,
    /// The nominal machine, with what is ordinarily a little wrong of FRFs, and its fit.
    pub nominal: (Hypothesis, Fitted),
    /// The machine as described and its fit.
    pub described: (Hypothesis, Fitted),
    /// Gaps of the fitted data with the machine as described.
    pub fit: Vec<PartialGap>,
    /// Gaps of the held-out data with it.
    pub held_out: Vec<PartialGap>,
    /// Interfaces, best first.
    pub located: Vec<TriedLocation>,
    /// Candidates, best first; those not tried last.
    pub tried: Vec<TriedEffect>,
    /// What nulls show.
    pub null: NullDistribution,
    /// Misfit of the nominal fit over that of the middle null.
    pub excess: f64,
    /// The same of what is chosen.
    pub excess_left: f64,
    /// The model that explains most: the named effect or combination, or else the nominal machine.
    pub chosen: (Hypothesis, Fitted),
    /// The machine as described with what is chosen.
    pub explained: (Hypothesis, Fitted),
    /// Held-out gaps with it.
    pub chosen_held_out: Vec<PartialGap>,
    /// Held-out gaps where what is ordinarily a little wrong is fitted along: without and with what is chosen. `None` where it is not.
    pub gaps_with_nuisances: Option<[Vec<PartialGap>; 2]>,
    /// The verdict.
    pub verdict: Verdict,
    /// Where it points to.
    pub place: Location,
    /// Tolerances as fitted with what is chosen; empty where they are held.
    pub tolerances: Vec<ToleranceEstimate>,
    /// Ran to its end.
    pub complete: bool,
}

/// How a diagnosis is made.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnosisSettings {
    /// Seed.
    pub seed: u64,
    /// Draws of the null.
    pub draws: usize,
    /// A null of the same machine and layout that was simulated before.
    pub null: Option<NullDistribution>,
}

/// Smallest statistic that is called something, whatever the null says; of a free shape at an interface, which has no scale of its own.
const LEAST_STATISTIC: f64 = 2.5;
const LEAST_FREE: f64 = 16.0;
/// What a candidate must gain of χ² to be preferred, over its scale under the null.
const PENALTY: f64 = 8.0;
/// What the data can tell apart, in χ² (an error rate of 7 %); and as a share of the gain where the best leaves as much beyond nulls: the model is no better
/// than that.
const APART: f64 = 9.0;
const APART_SHARE: f64 = 0.1;
/// Share of the best's gain that a rival must gain.
const HALF: f64 = 0.5;
/// Share of what the best leaves that one with more parameters may leave to be its rival.
const LESS: f64 = 0.9;
/// Share of what the best foretells of positions left out that another may lack.
const FORETOLD: f64 = 0.2;
/// Effects that may be combined.
const MOST: usize = 3;
/// Excess of the misfit over the middle null beyond which something is still missing.
const EXCESS: f64 = 2.0;
/// Excess beyond which something is missing even where no candidate helps.
const FAR: f64 = 5.0;
/// Share of χ² that a released parameter must take away to be all that is wrong.
const MOSTLY: f64 = 0.75;
/// Share of χ² that an effect must take away where much stays unexplained: one that does what no free shape can, and another.
const LITTLE: (f64, f64) = (0.4, 0.5);
/// Excess beyond which a named effect must hold its own against a free shape at an interface.
const DOUBT: f64 = 1.5;
/// Share of what the best effect leaves below which a free shape is the better explanation.
const BETTER: f64 = 0.7;
/// What a named effect may leave of what the machine without it fails to foretell of positions left out; and the share of what it fails to foretell
/// itself below which a free shape that fits better is the better explanation.
const FORETELLS: (f64, f64) = (1.02, 0.65);
/// Excess at which a released parameter is all that is wrong.
const RIGHT: f64 = 4.0;

/// Diagnoses; of effects with one id that for FRFs ([`Effect::for_data`]).
///
/// # Errors  as [`Fitter::objective`].
pub fn diagnose(
    machine: &Machine,
    effects: &[Effect],
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    settings: &DiagnosisSettings,
    control: &Control,
) -> Result<Diagnosis, ObjectiveError> {
    let domain = fitter.domain;
    let limits = Thresholds::of(domain);
    control.begin("1/7 the machine as described");
    let start = nominal(machine, fitter)?;
    let bases = nominal_fits(machine, fitter, &start, settings.seed, control)?;
    let candidates = hypotheses(fitter, machine, &start, effects, &fitter.frozen);
    control.begin(&format!("2/7 {} candidates", candidates.0.len()));
    let mut surveyed = screen(fitter, start, bases, candidates, control)?;
    // Interfaces say where; they are looked at in any case, since they also tell whether an effect of the library does what can be done.
    control.begin("3/7 interfaces");
    let located: Vec<Candidate> = locate(&surveyed, fitter, 5, control)?;
    refit_from_free_shapes(&mut surveyed, &located, fitter, control);
    let objective = fitter.objective(&surveyed.nominal)?;
    let (count, unknowns) = (objective.observations() as f64, objective.unknowns(&surveyed.nominal));
    let fitted: Vec<(&Hypothesis, &Fitted)> = surveyed.candidates.iter().filter_map(|c| c.fitted.as_ref().map(|(h, f)| (h, f))).collect();
    control.begin("4/7 nulls");
    let null = match &settings.null {
        Some(known) => known.clone(),
        None if fitter.lacks(Ablation::ChiSquare) => NullDistribution::of_tables(&fitted, settings.seed),
        None => simulate(fitter, &surveyed.nominal, &surveyed.base, &fitted, settings.draws, settings.seed, control)?,
    };
    control.begin("5/7 positions left out");
    let mut tried = judge(&surveyed, &null, count);
    let nominal_left_out = cross_validation(fitter, &surveyed.nominal, &surveyed.base, control)?;
    let base = surveyed.base.clone();
    let before = null.excess(base.chi_square / count);
    let mut same = class(&tried, &null, count, limits);
    for at in 0..same.len().max(3).min(tried.len()) {
        if let Some((hypothesis, fitted)) = tried[at].candidate.fitted.clone() {
            tried[at].candidate.left_out = cross_validation(fitter, &hypothesis, &fitted, control).ok();
        }
    }
    let outdone =
        if fitter.lacks(Ablation::InSample) { 0..0 } else { keep_predictive(&mut tried, &mut same, nominal_left_out, &null, count) };
    // Where no more is left than nulls show, what gains there by itself must foretell positions left out, too.
    let foretells = |t: &TriedEffect| t.candidate.left_out.is_none_or(|lost| lost < nominal_left_out);
    let enough = |t: &TriedEffect| t.p_value < limits.alpha && (!limits.known || before > 1.0);
    let seen = |t: &TriedEffect| enough(t) || (t.p_value < limits.foretold_alpha && foretells(t));
    let significant = tried.first().is_some_and(|t| seen(t) && t.statistic >= LEAST_STATISTIC);
    let nominal_held_out = fitter.gaps(&surveyed.nominal, &base, held_out)?;
    // A record that an effect makes agree with the others is no faulty one.
    let best = tried.first().filter(|_| significant).and_then(|t| t.candidate.fitted.as_ref());
    let still = |(hypothesis, fitted): &(Hypothesis, Fitted)| {
        held_out_fault(fitter, held_out, (hypothesis, fitted), &fitter.gaps(hypothesis, fitted, held_out)?)
    };
    let restored = best.map(still).transpose()?;
    let agrees = best.is_some_and(|(_, fitted)| null.excess(fitted.chi_square / count) <= EXCESS);
    let as_described = (&surveyed.nominal, &base);
    let faulty = match held_out_fault(fitter, held_out, as_described, &nominal_held_out)? {
        Some(found) if restored.is_none_or(|still| still == Some(found)) => Some(found),
        _ if !agrees && (before > EXCESS || significant) => fault(fitter, held_out, as_described, &null, control)?,
        _ => None,
    };
    let (verdict, chosen) = conclude(&DecisionInputs {
        fitter,
        limits,
        machine,
        effects,
        surveyed: &surveyed,
        tried: &tried,
        null: &null,
        count,
        unknowns,
        significant,
        same: &same,
        outdone: &tried[outdone],
        located: &located,
        faulty,
        nominal_left_out,
        control,
    })?;
    let place = Location::of(&verdict, fitter, as_described, (&chosen.0, &chosen.1), (effects, &located))?;
    let all = HoldOutSet { set: fitter.fit.set, positions: fitter.fit.positions.clone(), frfs: fitter.fit.frfs.clone() };
    control.begin("6/7 gaps of the machine as described");
    let plain = NominalRefit::new(machine, effects, fitter, as_described, control)?;
    let told = |candidate: &Candidate| -> Result<Vec<PartialGap>, ObjectiveError> {
        let Some((hypothesis, fitted)) = &candidate.fitted else { return Ok(Vec::new()) };
        plain.of((hypothesis, fitted), control)?.map_or(Ok(Vec::new()), |found| plain.gaps(&found, held_out))
    };
    let each: Vec<Vec<PartialGap>> = tried.par_iter().map(|t| told(&t.candidate)).or_first_error()?;
    tried.iter_mut().zip(each).for_each(|(t, held_out)| t.held_out = held_out);
    let each: Vec<Vec<PartialGap>> = located.par_iter().map(told).or_first_error()?;
    let located = located.into_iter().zip(each).map(|(candidate, held_out)| TriedLocation { candidate, held_out }).collect();
    let described = plain.described().clone();
    let explained = plain.of((&chosen.0, &chosen.1), control)?.unwrap_or_else(|| described.clone());
    let not_tried = surveyed.candidates.iter().filter(|c| c.fitted.is_none());
    tried.extend(not_tried.map(|c| TriedEffect { candidate: c.clone(), statistic: 0.0, p_value: 1.0, held_out: Vec::new() }));
    let chosen_beside = fitter.gaps(&chosen.0, &chosen.1, held_out)?;
    Ok(Diagnosis {
        domain,
        fit: plain.gaps(&described, &all)?,
        held_out: plain.gaps(&described, held_out)?,
        chosen_held_out: plain.gaps(&explained, held_out)?,
        gaps_with_nuisances: fitter.has_nuisances().then_some([nominal_held_out, chosen_beside]),
        tolerances: fitter.tolerances(&chosen.0, &chosen.1)?,
        excess_left: null.excess(chosen.1.chi_square / count),
        described,
        explained,
        nominal: (surveyed.nominal, base),
        located,
        tried,
        null,
        excess: before,
        chosen,
        verdict,
        place,
        complete: !control.stopped(),
    })
}

/// Statistics of all candidates that were tried, best first by χ² with a penalty on parameters.
fn judge(survey: &Screening, null: &NullDistribution, count: f64) -> Vec<TriedEffect> {
    let mut tried: Vec<TriedEffect> = survey
        .candidates
        .iter()
        .filter(|c| c.fitted.is_some())
        .map(|candidate| {
            let statistic = candidate.gain / null.scale(&candidate.id) / null.excess(candidate.chi_square() / count);
            TriedEffect { candidate: candidate.clone(), statistic, p_value: null.p_value(statistic), held_out: Vec::new() }
        })
        .collect();
    tried.sort_by(|a, b| penalised(a).total_cmp(&penalised(b)));
    tried
}

/// χ² with a penalty on what a candidate gains where nothing is missing: a flexible one must gain more than a stiff one. What gains nothing it can stand
/// for (another quantity that is none) comes last.
fn penalised(tried: &TriedEffect) -> f64 {
    let TriedEffect { candidate, statistic, .. } = tried;
    if candidate.gain == 0.0 { f64::INFINITY } else { candidate.chi_square() + PENALTY * candidate.gain / statistic }
}

/// Indices of the candidates that the data cannot tell from the best. One with more parameters is no rival where it leaves hardly less: what the
/// simpler one explains needs no more.
fn class(tried: &[TriedEffect], null: &NullDistribution, count: f64, limits: Thresholds) -> Vec<usize> {
    let Some(best) = tried.first() else { return Vec::new() };
    let unit = null.excess(best.candidate.chi_square() / count);
    let reach = penalised(best) + APART * unit + limits.apart(APART_SHARE * best.candidate.gain, best.candidate.chi_square(), unit);
    let added = |t: &TriedEffect| t.candidate.fitted.as_ref().map_or(0, |(hypothesis, _)| hypothesis.added.len());
    let as_simple = |t: &TriedEffect| added(t) <= added(best) || t.candidate.chi_square() < LESS * best.candidate.chi_square();
    let explains = |t: &TriedEffect| t.candidate.gain >= HALF * best.candidate.gain;
    let rival = |t: &TriedEffect| penalised(t) <= reach && explains(t) && as_simple(t);
    (0..tried.len()).filter(|at| rival(&tried[*at])).collect()
}

/// Of candidates that fit alike, those that foretell positions left out much worse than the best of them are no explanation: they go behind it, where
/// the range that is given back says. One that fits clearly better than what foretells best stays beside it.
fn keep_predictive(
    tried: &mut [TriedEffect],
    same: &mut Vec<usize>,
    nominal: f64,
    null: &NullDistribution,
    count: f64,
) -> std::ops::Range<usize> {
    let lost = |t: &TriedEffect| t.candidate.left_out.unwrap_or(f64::INFINITY);
    let Some(foretells) = same.iter().map(|at| &tried[*at]).min_by(|a, b| lost(a).total_cmp(&lost(b))) else { return 0..0 };
    let reach = lost(foretells) + FORETOLD * (nominal - lost(foretells)).max(0.0) + APART;
    let apart = APART * null.excess(tried[0].candidate.chi_square() / count);
    let fits = penalised(&tried[0]) + apart < penalised(foretells);
    let stays = |at: usize| tried[at].candidate.left_out.is_none_or(|l| l <= reach) || (at == 0 && fits);
    let (kept, dropped): (Vec<usize>, Vec<usize>) = same.iter().partition(|at| stays(**at));
    let (count, all) = (kept.len(), same.len());
    let others = (0..tried.len()).filter(|at| !same.contains(at));
    let ordered: Vec<TriedEffect> = kept.into_iter().chain(dropped).chain(others).map(|at| tried[at].clone()).collect();
    tried.clone_from_slice(&ordered);
    *same = (0..count).collect();
    count..all
}

struct DecisionInputs<'e, 's> {
    fitter: &'e Fitter<'s>,
    limits: Thresholds,
    machine: &'e Machine,
    effects: &'e [Effect],
    surveyed: &'e Screening,
    tried: &'e [TriedEffect],
    null: &'e NullDistribution,
    count: f64,
    unknowns: usize,
    significant: bool,
    same: &'e [usize],
    /// What fits as well, but foretells much worse.
    outdone: &'e [TriedEffect],
    located: &'e [Candidate],
    faulty: Option<Fault>,
    nominal_left_out: f64,
    control: &'e Control,
}

fn conclude(evidence: &DecisionInputs<'_, '_>) -> Result<(Verdict, (Hypothesis, Fitted)), ObjectiveError> {
    let DecisionInputs { limits, surveyed, tried, null, count, same, located, .. } = evidence;
    let nothing = (surveyed.nominal.clone(), surveyed.base.clone());
    let before = null.excess(surveyed.base.chi_square / count);
    let say = |kind: VerdictKind, effects: Vec<String>, reason: String, next: Option<String>| Verdict { kind, effects, reason, next };
    if *count <= evidence.unknowns as f64 {
        let reason = format!("{count} numbers were measured for {} unknowns: anything would fit", evidence.unknowns);
        let next = Some("more modes or more positions, or a whole FRF at each".to_string());
        return Ok((say(VerdictKind::Insufficient, Vec::new(), reason, next), nothing));
    }
    if let Some(fault) = evidence.faulty {
        let (reason, next) = fault.fault_text(evidence.fitter.fit.set);
        return Ok((say(VerdictKind::Measurement, Vec::new(), reason, Some(next)), nothing));
    }
    // An interface stands for what no effect of the library has; it has no scale of its own and needs a clear gain.
    let free = located.iter().filter(|c| c.fitted.is_some()).min_by(|a, b| a.chi_square().total_cmp(&b.chi_square()));
    let free_excess = free.map_or(f64::INFINITY, |c| null.excess(c.chi_square() / count));
    let scale = null.scales.iter().map(|s| s.1).fold(3.0 * LEAST_SCALE, f64::max);
    let free_statistic = free.map_or(0.0, |c| c.gain / scale / free_excess);
    if !evidence.significant {
        let clear = free_statistic > LEAST_FREE && null.p_value(free_statistic) < limits.alpha;
        if let Some(found) = free.filter(|_| clear || before > FAR) {
            let reason = format!(
                "what is left is {before:.1} times what nulls show and no effect of the library explains it; most is gained by a free shape at {}",
                named(&found.id)
            );
            let next = Some("an accelerometer at that place, struck there, too".to_string());
            return Ok((say(VerdictKind::Unknown, Vec::new(), reason, next), nothing));
        }
        let best = tried.iter().max_by(|a, b| a.statistic.total_cmp(&b.statistic));
        let worse = |t: &TriedEffect| {
            t.p_value < limits.foretold_alpha && t.candidate.left_out.is_some_and(|lost| lost >= evidence.nominal_left_out)
        };
        let vain = |t: &TriedEffect| if worse(t) { "; it foretells positions left out no better" } else { "" };
        let best = best.map_or("nothing".to_string(), |t| format!("{} with {}{}", t.candidate.id, p_value_text(t.p_value), vain(t)));
        let reason = format!("what is left is no more than nulls of this machine and layout show (most is gained by {best})");
        return Ok((say(VerdictKind::None, Vec::new(), reason, None), nothing));
    }
    let best = &tried[0];
    let release = tried.iter().find(|t| {
        let is = t.candidate.fitted.as_ref().is_some_and(|f| f.0.kind == HypothesisKind::Release);
        let enough =
            t.candidate.chi_square() <= (1.0 - MOSTLY) * surveyed.base.chi_square || null.excess(t.candidate.chi_square() / count) <= RIGHT;
        is && enough && t.candidate.gain >= 0.85 * best.candidate.gain
    });
    if let Some((found, (hypothesis, fitted))) = release.and_then(|t| Some((t, t.candidate.fitted.as_ref()?))) {
        let values = values_of(hypothesis, fitted);
        let index = hypothesis.added[0];
        let parameter = &hypothesis.machine.parameters[index];
        let reason = format!(
            "{} was held at {:.4e} {}; free, it becomes {:.4e} and takes {:.0} % of χ² away: no effect is needed",
            found.candidate.id,
            parameter.start,
            parameter.unit,
            values[index],
            100.0 * found.candidate.gain / surveyed.base.chi_square
        );
        let next = Some(format!("identify without --freeze {}", found.candidate.id));
        return Ok((say(VerdictKind::WrongParameter, Vec::new(), reason, next), (hypothesis.clone(), fitted.clone())));
    }
    let Some((hypothesis, fitted)) = best.candidate.fitted.clone() else { return Ok((nothing_fitted(before), nothing)) };
    let mut chosen = (hypothesis, fitted);
    let mut names = vec![best.candidate.id.clone()];
    let mut after = null.excess(chosen.1.chi_square / count);
    // One effect more, as long as it explains much of what is left and is no accident.
    while after > limits.more && names.len() < MOST {
        let Some(more) = next_effect(evidence, &chosen, &names)? else { break };
        names.push(more.0);
        chosen = (more.1, more.2);
        after = null.excess(chosen.1.chi_square / count);
    }
    // A released parameter is no effect: what was added to it is named.
    let released = tried[same[0]].candidate.fitted.as_ref().is_some_and(|f| f.0.kind == HypothesisKind::Release);
    if released {
        let reason = format!(
            "{} is wrong where it was frozen{}; together they leave {after:.1} times what nulls show",
            names[0],
            if names.len() > 1 { format!(", and {} is missing", names[1..].join(" and ")) } else { String::new() }
        );
        let next = Some(format!("identify without --freeze {}, then diagnose again", names[0]));
        return Ok((say(VerdictKind::WrongParameter, Vec::new(), reason, next), chosen));
    }
    // What stands for the first stands for it in the combination, too; a parameter that is released is no effect.
    let rest: String = names[1..].iter().map(|n| format!("+{n}")).collect();
    let is_effect = |t: &&TriedEffect| t.candidate.fitted.as_ref().is_some_and(|f| f.0.kind == HypothesisKind::Effect);
    let stands = same.iter().map(|at| &tried[*at]).filter(is_effect).map(|t| &t.candidate.id).filter(|id| !names[1..].contains(id));
    let alternatives: Vec<String> = stands.map(|id| format!("{id}{rest}")).collect();
    let least = if after < BETTER * free_excess { LITTLE.0 } else { LITTLE.1 };
    let little = chosen.1.chi_square > (1.0 - least) * surveyed.base.chi_square;
    // What is named must foretell positions left out: better than nothing does, and not much worse than a free shape that fits better, too.
    let foretold = match names.len() {
        1 => best.candidate.left_out,
        _ => cross_validation(evidence.fitter, &chosen.0, &chosen.1, evidence.control).ok(),
    };
    let in_vain = |lost: f64| lost > FORETELLS.0 * evidence.nominal_left_out;
    let beaten = |lost: f64| {
        // Of modes what is left out is foretold by few numbers: a share of it as for effects.
        let apart = |free: f64| APART * after + if limits.known { 0.0 } else { FORETOLD * (evidence.nominal_left_out - free).max(0.0) };
        let foretells = |free: f64| free < FORETELLS.1 * lost && free < lost - apart(free);
        let better = |c: &Candidate| c.chi_square() < chosen.1.chi_square && c.left_out.is_some_and(foretells);
        located.iter().any(better)
    };
    let fails = foretold.is_some_and(|lost| in_vain(lost) || beaten(lost)) && !evidence.fitter.lacks(Ablation::InSample);
    let (gain, apart) = (surveyed.base.chi_square - chosen.1.chi_square, APART * after);
    let about = NamedFit { hypothesis: &chosen.0, fitted: &chosen.1, effects: names.len(), before, after, gain, apart };
    if let Some((plain, how)) = more_parsimonious(&about, located, null, *count, *limits) {
        let shape = plain.id.rsplit_once(':').map_or("shape", |(_, shape)| shape);
        let reason = format!(
            "a plain {shape} at {} does {how} {} would: something of that kind sits there, which effect it is these data do not tell",
            named(&plain.id),
            names.join(" and ")
        );
        let next = Some("an accelerometer at that place, struck there, too".to_string());
        return Ok((say(VerdictKind::Unknown, Vec::new(), reason, next), chosen));
    }
    let several = names.len() > 1 && after > limits.none_of_them;
    if several || (after > limits.little_from && little) || (after > DOUBT && free_excess < BETTER * after) || fails {
        let place = free.map_or("?", |c| named(&c.id));
        let fails = if fails { " and foretells positions left out worse than it fits" } else { "" };
        let reason = format!(
            "the best of the library, {}, leaves {after:.1} times what nulls show{fails}; a free shape at {place} leaves {free_excess:.1} times",
            names.join("+")
        );
        let next = Some("an accelerometer at that place, struck there, too".to_string());
        return Ok((say(VerdictKind::Unknown, Vec::new(), reason, next), chosen));
    }
    let share = |lost: f64| 100.0 * (1.0 - lost / evidence.nominal_left_out).max(0.0);
    let lost = foretold.map(share).filter(|share| *share > 0.0);
    let lost = lost.map_or(String::new(), |share| format!(", and {share:.0} % of that of positions left out"));
    let gained = 100.0 * (1.0 - chosen.1.chi_square / surveyed.base.chi_square);
    let others: Vec<String> =
        evidence.outdone.iter().filter_map(|t| Some(format!("{} ({:.0} %)", t.candidate.id, share(t.candidate.left_out?)))).collect();
    let others = match others.len() {
        0 => String::new(),
        _ => format!("; as good a fit, but worse at foretelling positions left out: {}", others.join(", ")),
    };
    let reason = format!("{} takes {gained:.0} % of χ² away{lost} ({}){others}", names.join(" and "), p_value_text(best.p_value));
    let verdict = if alternatives.len() < 2 {
        let next = None;
        say(VerdictKind::Effect, vec![names.join("+")], reason, next)
    } else {
        let reason = format!("{reason}; these data cannot tell it from {}", alternatives[1..].join(", "));
        let next = same
            .iter()
            .find_map(|at| evidence.effects.iter().find(|e| e.id == tried[*at].candidate.id))
            .and_then(|e| e.discriminating_test.clone());
        say(VerdictKind::Ambiguous, alternatives, reason, next)
    };
    Ok((verdict, chosen))
}

/// The effect that explains most of what an explanation leaves, where it is no accident: its id, hypothesis and fit.
fn next_effect(
    evidence: &DecisionInputs<'_, '_>,
    chosen: &(Hypothesis, Fitted),
    names: &[String],
) -> Result<Option<(String, Hypothesis, Fitted)>, ObjectiveError> {
    let DecisionInputs { fitter, limits, machine, effects, surveyed, null, count, control, tried, .. } = evidence;
    let others: Vec<Effect> = effects.iter().filter(|e| !names.contains(&e.id)).cloned().collect();
    let (apply, _) = hypotheses(fitter, machine, &chosen.0, &others, &[]);
    let second = screen(fitter, chosen.0.clone(), vec![chosen.1.clone()], (apply, Vec::new()), control)?;
    let best = second.candidates.into_iter().filter(|c| c.status == Status::Tried).max_by(|a, b| a.gain.total_cmp(&b.gain));
    let Some((id, gain, (hypothesis, fitted))) = best.and_then(|c| Some((c.id.clone(), c.gain, c.fitted?))) else { return Ok(None) };
    let after = null.excess(fitted.chi_square / count);
    let last = last_of(&id).to_string();
    // What gained nothing alone has shown no scale of its own.
    let scale = if tried.iter().any(|t| t.candidate.id == last && t.statistic > 0.0) { null.scale(&last) } else { LEAST_SCALE };
    let statistic = gain / scale / after;
    let least = if after <= limits.more { limits.much.0 } else { limits.much.1 };
    let much = gain >= least * chosen.1.chi_square && gain >= limits.form * surveyed.base.chi_square;
    Ok((much && statistic >= LEAST_STATISTIC && null.p_value(statistic) < limits.alpha).then_some((last, hypothesis, fitted)))
}

/// `closed` = 1 − (after² − floor²)/(before² − floor²); `None` where the gap before is at the floor, or the floor is not known.
pub fn closed(before: &[PartialGap], after: &[PartialGap]) -> Option<f64> {
    share_closed(gap_over(before)?, gap_over(after)?, floor_over(before)?)
}
