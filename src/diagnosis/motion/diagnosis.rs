//! Diagnosis of motion records: fits, facts, verdict, and the gap before and after.

use rayon::prelude::*;

use super::candidate::ScreenedFit;
use super::channel_weight::weigh;
use super::closed_interval::closed_interval;
use super::common_cause::{BOOTSTRAP, amount, common_cause};
use super::context::{Candidate, Context, MotionFit, MotionSettings};
use super::data::MotionData;
use super::data_fault::{Contradiction, RecordShift};
use super::force_fault::{ForceFault, Nominal, correct, texts, with_force_faults};
use super::free_function::{ForceLocations, LocatedMotion, free_functions};
use super::gap::{MotionPart, gap_of, part};
use super::gather::{MotionGatherer, tolerances_on};
use super::misfit_map::{MisfitCell, largest_phase, misfit_map};
use super::noise_floor::{floor_of, noise_of};
use super::nominal_fit::nominal_fit;
use crate::evidence::share_closed;
use crate::judgement::{Answers, Judgement};
use crate::{Facts, Hypothesis, Model, Status, Verdict, VerdictKind};
use dynamics::inverse_dynamics::{
    InverseError, MotionSignal, Phase, Rigid, free_parameters, is_linear_in_inverse, mask_backlash_crossings,
    parameters_without_influence,
};
use long_work::Control;
use machine::{Effect, Machine, ParameterValues};

/// A candidate with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedMotion {
    /// Id.
    pub id: String,
    /// Outcome.
    pub status: Status,
    /// Relative reduction of the squared prediction error at left-out parts.
    pub gain: f64,
    /// Reduction of χ² over its scale in null simulations and over the excess that it leaves; 0 for a candidate
    /// that was not fitted.
    pub statistic: f64,
    /// Share of null simulations whose largest statistic over all effects is at least as large.
    pub p_value: Option<f64>,
    /// Estimates of its added parameters, by id, from the joint fit.
    pub parameters: Vec<(String, f64)>,
    /// Held-out records, predicted with it.
    pub held_out: Vec<MotionPart>,
}

/// Result of a diagnosis.
pub struct MotionDiagnosis {
    /// The machine as described, with its estimated parameters.
    pub nominal: (Hypothesis, ParameterValues),
    /// Fitted records, predicted by the machine as described.
    pub fit: Vec<MotionPart>,
    /// Held-out records, predicted by the machine as described.
    pub held_out: Vec<MotionPart>,
    /// Candidates, best first; untested ones last.
    pub tried: Vec<TriedMotion>,
    /// Free functions, best first.
    pub located: Vec<LocatedMotion>,
    /// Everything on which the verdict rests, and the verdict of the rules on it; absent where the records do not
    /// determine the machine.
    pub judged: Option<(Facts, Judgement)>,
    /// Misfit over the median of null simulations (1), of the machine as described and of the chosen model.
    pub excess: [f64; 2],
    /// The chosen model: with the named effect or combination, else the machine as described.
    pub chosen: (Hypothesis, ParameterValues),
    /// Fitted records, predicted by the chosen model.
    pub chosen_fit: Vec<MotionPart>,
    /// Held-out records, predicted by the chosen model.
    pub chosen_held_out: Vec<MotionPart>,
    /// Gap due to noise, of the held-out records, else of the fitted ones.
    pub floor: Option<f64>,
    /// Gap due to noise of the fitted records.
    pub floor_fit: Option<f64>,
    /// 95 % interval of `closed` on the held-out records.
    pub closed95: Option<(f64, f64)>,
    /// Map of the misfit of the machine as described, record by record.
    pub cells: Vec<MisfitCell>,
    /// Delays and factors of the records relative to the chosen model, fitted records first.
    pub shifts: Vec<RecordShift>,
    /// Held-out records that contradict the fitted ones.
    pub contradictions: Vec<Contradiction>,
    /// Wrong signs and units of the force, in words; all figures are those of the corrected records.
    pub force_faults: Vec<String>,
    /// The verdict.
    pub verdict: Verdict,
    /// Phase of the motion in which the named effect, or the unknown one, is largest.
    pub phase: Option<Phase>,
    /// Squared prediction error at left-out parts with the chosen effects, over that of the machine as
    /// described (1).
    pub loss: f64,
    /// Whether the diagnosis ran to its end.
    pub complete: bool,
}

impl MotionDiagnosis {
    /// Computes `closed` of a prediction of the held-out records.
    pub fn closed(&self, after: &[MotionPart]) -> Option<f64> {
        share_closed(gap_of(&self.held_out)?, gap_of(after)?, self.floor?)
    }
}

/// Diagnoses motions of a drive by the force of its rigid motion and, where recorded, by the transmission
/// errors of extra measuring points. Of several effects with one id the one for motion is used
/// ([`Effect::for_data`]).
///
/// # Errors  the machine is not one rigid axis, a record gives force instead of torque or the reverse, a
///   frozen parameter is unknown. Records that do
/// not determine the machine's own parameters give the verdict «insufficient», not an error.
pub fn diagnose_motion(
    machine: &Machine,
    effects: &[Effect],
    frozen: &[String],
    (fit_motions, held_out): (&[&MotionSignal], &[&MotionSignal]),
    settings: MotionSettings,
    control: &Control,
) -> Result<MotionDiagnosis, InverseError> {
    let rigid = Rigid::new(machine, &machine.start())?;
    let without_edges = |motions: &[&MotionSignal]| {
        motions.iter().map(|m| (*m).clone().without_edges()).collect::<Vec<MotionSignal>>()
    };
    let (mut all, fitted) = (without_edges(&[fit_motions, held_out].concat()), fit_motions.len());
    all.iter().try_for_each(|motion| rigid.check(machine, motion))?;
    let asked = free_parameters(machine, frozen)?;
    // A parameter that no channel depends on keeps its value.
    let unseen = parameters_without_influence(&rigid, machine, &asked, fit_motions);
    let free: Vec<usize> = asked.into_iter().filter(|i| !unseen.contains(i)).collect();
    // The data do not distinguish springs in series with equal wind-up, and no verdict depends on their
    // distinction.
    let spring = |parameter: usize| is_linear_in_inverse(machine, &[parameter])[0];
    let force_faults =
        correct(&Nominal { rigid: &rigid, machine, free: &free, may_stay: spring }, &mut all, fitted);
    let fit_of = |all: &mut [MotionSignal]| {
        weigh(&rigid, machine, &free, spring, all, fitted)?;
        nominal_fit(&rigid, machine, &free, &all[..fitted].iter().collect::<Vec<_>>(), spring, control)
    };
    let fit = fit_of(&mut all).and_then(|first| {
        if mask_backlash_crossings(&mut all, &rigid, machine, &first.values) {
            fit_of(&mut all)
        } else {
            Ok(first)
        }
    });
    let (fit_motions, held_out): (Vec<&MotionSignal>, Vec<&MotionSignal>) =
        (all[..fitted].iter().collect(), all[fitted..].iter().collect());
    let (fit_motions, held_out) = (fit_motions.as_slice(), held_out.as_slice());
    let nominal = Hypothesis::nominal(machine.clone());
    let fit = match fit {
        Ok(fit) => fit,
        Err(InverseError::Data(why) | InverseError::Unidentifiable { why, .. }) => {
            return Ok(insufficient(&rigid, nominal, (fit_motions, held_out), &force_faults, why));
        }
        Err(other) => return Err(other),
    };
    let held = unseen.iter().chain(free.iter().filter(|i| !fit.free.contains(i)));
    let frozen: Vec<String> =
        frozen.iter().cloned().chain(held.map(|i| machine.parameters[*i].id.clone())).collect();
    let context = Context {
        data: MotionData::new(fit_motions.to_vec()),
        rigid,
        frozen: &frozen,
        effects,
        settings,
        control,
    };
    let alone = (nominal.clone(), fit);
    let insufficient = |why: &str| {
        insufficient(&context.rigid, nominal.clone(), (fit_motions, held_out), &force_faults, why.to_string())
    };
    let Some(mut gatherer) = gatherer(&context, &alone, held_out) else {
        return Ok(insufficient(
            "with any part left out, these records do not determine the machine's parameters; record longer or more motions",
        ));
    };
    let mut facts = gatherer.first_facts();
    if control.stopped() {
        let why = "stopped before the candidates were compared";
        return Ok(MotionDiagnosis { complete: false, ..insufficient(why) });
    }
    let Ok(judgement) = gatherer.judge(&mut facts);
    if settings.all_facts {
        let Ok(()) = gatherer.gather_more(&mut facts);
    }
    Ok(compare(&gatherer, facts, judgement, &force_faults))
}

/// Fits the machine as described and all candidates beside it. `None` where the records do not determine the
/// machine with a part left out.
fn gatherer<'g, 'w>(
    context: &'g Context<'w>,
    alone: &MotionFit,
    held_out: &[&'w MotionSignal],
) -> Option<MotionGatherer<'g, 'w>> {
    let screening = context.screening(alone)?;
    let held_out = MotionData::new(held_out.to_vec());
    let fitted = screening.tolerances()?;
    let others = match held_out.motions.is_empty() {
        true => fitted.clone(),
        false => tolerances_on(context, &held_out, alone, screening.variance())?,
    };
    let tolerances = [fitted, others];
    let (hypothesis, fit) = alone;
    let own = context.fitted(&hypothesis.machine, &fit.values, &fit.free, &[], Some(&tolerances[0]))?;
    let tolerant = (hypothesis.clone(), own);
    let first = context.screened(screening, alone, &tolerances[0]);
    let functions = free_functions(&context.data);
    Some(MotionGatherer {
        context,
        held_out,
        alone: alone.clone(),
        tolerant,
        tolerances,
        first,
        functions,
        beside: Vec::new(),
    })
}

/// Compares the machine as described, without and with the chosen model, at all records.
fn compare(
    gatherer: &MotionGatherer<'_, '_>,
    facts: Facts,
    judgement: Judgement,
    force_faults: &[ForceFault],
) -> MotionDiagnosis {
    let Context { data, control, settings, .. } = gatherer.context;
    let (fit_motions, held_out) = (&data.motions[..], &gatherer.held_out.motions[..]);
    let base = &gatherer.alone;
    let model = judgement.chosen.model;
    let chosen = gatherer.model(model).unwrap_or(base);
    let [base_fit, base_held_out] = [fit_motions, held_out].map(|motions| gatherer.parts(base, motions));
    let [chosen_fit, chosen_held_out] =
        [fit_motions, held_out].map(|motions| gatherer.parts(chosen, motions));
    let floor_fit = floor_of(&noise_of(&chosen_fit, fit_motions), &chosen_fit);
    let noise = noise_of(&chosen_held_out, held_out);
    let floor = if held_out.is_empty() { floor_fit } else { floor_of(&noise, &chosen_held_out) };
    let closed95 = (model != Model::Nominal && !held_out.is_empty())
        .then(|| closed_interval(&base_held_out, &chosen_held_out, &noise, BOOTSTRAP, settings.seed))
        .flatten();
    let shifts = gatherer.shifts(model);
    let contradictions = gatherer.contradictions(&shifts);
    let verdict = verdict_of(gatherer, &judgement, (&base_held_out, chosen), force_faults);
    let named = match verdict.kind {
        kind if kind.explains() => verdict.first_effect().and_then(|id| {
            let row = facts.candidates.iter().position(|candidate| candidate.id == id)?;
            gatherer.first.candidates[row].screened.as_ref()
        }),
        VerdictKind::Unknown => gatherer.first.functions.first(),
        _ => None,
    };
    let squared_reduction = named.and_then(|fit| gatherer.first.screening.squared_reduction(data, fit));
    let motions = fit_motions.iter().zip(&base_fit).chain(held_out.iter().zip(&base_held_out));
    let loss = facts.left_out(model).zip(facts.left_out(Model::Nominal)).map_or(1.0, |(own, all)| own / all);
    MotionDiagnosis {
        phase: squared_reduction
            .and_then(|squared_reduction| largest_phase(fit_motions, squared_reduction.as_slice())),
        cells: motions.flat_map(|(m, p)| misfit_map(m, p)).collect(),
        nominal: (base.0.clone(), base.1.values.clone()),
        tried: tried(gatherer, &judgement),
        located: located(gatherer),
        excess: [facts.before(), facts.excess(judgement.chosen.chi_square)],
        judged: Some((facts, judgement)),
        chosen: (chosen.0.clone(), chosen.1.values.clone()),
        fit: base_fit,
        held_out: base_held_out,
        chosen_fit,
        chosen_held_out,
        floor,
        floor_fit,
        closed95,
        shifts: shifts.concat(),
        contradictions,
        force_faults: texts(force_faults),
        verdict,
        loss,
        complete: !control.stopped(),
    }
}

/// Returns the verdict of the rules with what these records add in words: amounts of effects at extra measuring
/// points, ordinary causes where nothing is missing, and wrong signs and units.
fn verdict_of(
    gatherer: &MotionGatherer<'_, '_>,
    judgement: &Judgement,
    (before, chosen): (&[MotionPart], &MotionFit),
    force_faults: &[ForceFault],
) -> Verdict {
    let context = gatherer.context;
    if context.control.stopped() {
        let reason =
            "stopped before enough null simulations were drawn to decide on significance".to_string();
        return with_force_faults(Verdict::new(VerdictKind::Insufficient, reason, None), force_faults);
    }
    let verdict = judgement.verdict.clone();
    let remark = match verdict.kind {
        kind if kind.explains() && !context.data.columns.is_empty() => amounts(chosen),
        VerdictKind::None => common_cause(gatherer, before),
        _ => None,
    };
    let verdict = match remark {
        Some(remark) => Verdict { reason: format!("{}; {remark}", verdict.reason), ..verdict },
        None => verdict,
    };
    with_force_faults(verdict, force_faults)
}

/// Formats the parameters that a model adds; short lengths in µm.
fn amounts((hypothesis, fit): &MotionFit) -> Option<String> {
    let of = |i: &usize| amount(&hypothesis.machine.parameters[*i], fit.values[*i]);
    let all: Vec<String> = hypothesis.added.iter().map(of).collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// Returns all candidates with their figures, best first.
fn tried(gatherer: &MotionGatherer<'_, '_>, judgement: &Judgement) -> Vec<TriedMotion> {
    let screening = &gatherer.first.screening;
    let before = screening.alone(&gatherer.context.data).1;
    let of = |candidate: &Candidate, figures: Option<(f64, f64)>| {
        let made = &screening.candidates[candidate.at];
        let fit = candidate.alone.as_ref().filter(|_| figures.is_some());
        let status = match &made.status {
            Status::Tried if figures.is_none() => Status::Failed(
                "its parameters leave their ranges at every grid node, or no fit determines them".into(),
            ),
            other => other.clone(),
        };
        let gain = |screened: &ScreenedFit| 1.0 - screened.left_out / before;
        TriedMotion {
            id: made.id.clone(),
            status,
            gain: candidate.screened.as_ref().filter(|_| figures.is_some()).map_or(0.0, gain),
            statistic: figures.map_or(0.0, |(statistic, _)| statistic),
            p_value: figures.map(|(_, p_value)| p_value),
            parameters: fit.map_or_else(Vec::new, |(h, fit)| {
                h.added.iter().map(|i| (h.machine.parameters[*i].id.clone(), fit.values[*i])).collect()
            }),
            held_out: fit.map_or_else(Vec::new, |fit| gatherer.parts(fit, &gatherer.held_out.motions)),
        }
    };
    let all = &gatherer.first.candidates;
    let ranked = judgement.ranked.par_iter().map(|r| of(&all[r.at], Some((r.statistic, r.p_value))));
    let mut found: Vec<TriedMotion> = ranked.collect();
    let is_ranked = |at: usize| judgement.ranked.iter().any(|ranked| ranked.at == at);
    let others = (0..all.len()).filter(|at| !is_ranked(*at));
    found.extend(others.map(|at| of(&all[at], None)));
    found
}

/// Returns the free functions with their figures, best first.
fn located(gatherer: &MotionGatherer<'_, '_>) -> Vec<LocatedMotion> {
    let Context { data, rigid, .. } = gatherer.context;
    let (hypothesis, fit) = &gatherer.alone;
    let places = ForceLocations::new(rigid, &hypothesis.machine, &fit.values, &data.motions);
    let screening = &gatherer.first.screening;
    let of = |(at, screened): (usize, &ScreenedFit)| {
        let made = &screening.candidates[screened.candidate];
        let variable = made.free?;
        let (gain, gap_held_out) = gatherer.figures_of_function(at);
        Some(LocatedMotion {
            interface: places.of(variable, made.column.as_deref()),
            column: made.column.clone(),
            over: variable.word(),
            shape: variable.shape(),
            gain,
            gap_held_out,
        })
    };
    let mut all: Vec<LocatedMotion> =
        gatherer.first.functions.par_iter().enumerate().filter_map(of).collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

/// Returns the verdict «insufficient» for records that do not determine the machine's own parameters.
fn insufficient(
    rigid: &Rigid,
    nominal: Hypothesis,
    (fit, held_out): (&[&MotionSignal], &[&MotionSignal]),
    force_faults: &[ForceFault],
    why: String,
) -> MotionDiagnosis {
    let values = nominal.machine.start();
    let parts = |motions: &[&MotionSignal]| {
        motions.iter().map(|m| part(rigid, &nominal.machine, &values, m)).collect::<Vec<_>>()
    };
    let (fit, held_out) = (parts(fit), parts(held_out));
    let next = Some(
        "record a motion with reversals, several speeds and accelerations over the whole travel".to_string(),
    );
    MotionDiagnosis {
        chosen: (nominal.clone(), values.clone()),
        nominal: (nominal, values),
        chosen_fit: fit.clone(),
        chosen_held_out: held_out.clone(),
        fit,
        held_out,
        tried: Vec::new(),
        located: Vec::new(),
        judged: None,
        excess: [1.0; 2],
        floor: None,
        floor_fit: None,
        closed95: None,
        cells: Vec::new(),
        shifts: Vec::new(),
        contradictions: Vec::new(),
        force_faults: texts(force_faults),
        verdict: with_force_faults(Verdict::new(VerdictKind::Insufficient, why, next), force_faults),
        phase: None,
        loss: 1.0,
        complete: true,
    }
}
