//! Diagnosis of motion records, with the same kinds of verdicts as for FRFs.

use rayon::prelude::*;

use super::channel_weight::weigh;
use super::closed_interval::closed_interval;
use super::common_cause::{BOOTSTRAP, common_cause};
use super::context::{Chosen, Context, MotionSettings};
use super::data::{MotionData, side_by_side};
use super::data_fault::{
    Contradiction, Covariance, RecordShift, beyond_effects, contradictions, faulty, shifts,
};
use super::decision::{MotionDecisionInputs, decide};
use super::design::INDEPENDENT;
use super::force_fault::{ForceFault, Nominal, correct, texts, with_force_faults};
use super::free_function::{ForceLocations, FreeFunction, LocatedMotion, free_functions};
use super::gap::{MotionPart, gap_of, part};
use super::misfit_map::{MisfitCell, largest_phase, misfit_map};
use super::noise_floor::{floor_of, noise_of};
use super::nominal_fit::nominal_fit;
use super::null_distribution::MotionNullDistribution;
use crate::evidence::share_closed;
use crate::{Hypothesis, Status, Verdict, VerdictKind};
use dynamics::inverse_dynamics::{
    InverseError, LinearForce, MotionSignal, Phase, Rigid, free_parameters, is_linear_in_inverse,
    mask_backlash_crossings, parameters_without_influence,
};
use long_work::Control;
use machine::{Effect, EffectIds, Machine, ParameterValues};
use numeric::linear_fit::LinearFit;

/// A candidate with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedMotion {
    /// Id.
    pub id: String,
    /// Outcome.
    pub status: Status,
    /// Relative reduction of the squared prediction error at left-out parts.
    pub gain: f64,
    /// −ln(1 − gain) over its scale in null simulations; 0 for a candidate that was not fitted.
    pub statistic: f64,
    /// Share of null simulations in which some effect gains as much.
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
    /// Null distribution of the machine as described.
    pub null: MotionNullDistribution,
    /// Squared prediction error at left-out parts over the median of null simulations (1), of the machine as
    /// described and of the chosen model.
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

/// Least gain of a second effect, and that of a third or of one easily confused with the first: similar
/// effects best explain the residual of an imperfectly modelled first effect.
const LEAST_SECOND: f64 = 0.11;
const LEAST_MORE: f64 = 0.25;
/// Largest number of combined effects.
const MAX_EFFECTS: usize = 3;

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
    let base = (nominal.clone(), fit);
    let Some(first) = context.screen(&base, &EffectIds::default()) else {
        let why =
            "with any part left out, these records do not determine the machine's parameters; record longer or more motions".to_string();
        return Ok(insufficient(&context.rigid, nominal, (fit_motions, held_out), &force_faults, why));
    };
    if control.stopped() {
        let why = "stopped before the candidates were compared".to_string();
        return Ok(MotionDiagnosis {
            complete: false,
            ..insufficient(&context.rigid, nominal, (fit_motions, held_out), &force_faults, why)
        });
    }
    let mut names = EffectIds::default();
    let mut chosen = base.clone();
    // Prediction error at left-out parts with the chosen effects, over that of the machine as described.
    let mut loss = 1.0;
    let full_fits = context.full_fits(&first, &base);
    let same = first.indistinguishable(context.effects, |at| {
        full_fits[at].as_ref().map_or(0.0, |fitted| 1.0 - fitted.1.squares / base.1.squares)
    });
    // Name the best of the indistinguishable effects that the joint fit confirms.
    let confirmed =
        |at: &usize| full_fits[*at].as_ref().is_some_and(|next| context.confirms(&first, *at, next, &base));
    if first.significant(|at| context.least(&first, first.id(at)))
        && let Some(at) = same.iter().copied().find(confirmed)
        && let Some(next) = full_fits[at].clone()
    {
        names.push(first.id(at));
        loss *= 1.0 - first.ranked[at].gain;
        chosen = next;
    }
    let confusable: Vec<&str> = same.iter().map(|at| first.id(*at)).collect();
    // Add effects as long as they are significant.
    while !names.is_empty() && names.len() < MAX_EFFECTS && !control.stopped() {
        let Some(next_step) = context.screen(&chosen, &names) else { break };
        let least_of = |at: usize| {
            let is_similar = confusable.contains(&next_step.last_effect(at));
            if names.len() > 1 || is_similar { LEAST_MORE } else { LEAST_SECOND }
        };
        if !next_step.significant(least_of) {
            break;
        }
        let at = next_step.best_effect().unwrap_or(0);
        let Some(next) = context.refined(&next_step, &next_step.ranked[at], &chosen) else { break };
        if !context.confirms(&next_step, at, &next, &chosen) {
            break;
        }
        names.push(next_step.last_effect(at));
        loss *= 1.0 - next_step.ranked[at].gain;
        chosen = next;
    }
    if names.len() > 1 {
        context.drop_dispensable(&base, &mut names, &mut chosen);
    }
    let named = names.first().and_then(|name| same.iter().copied().find(|at| first.id(*at) == name));
    let parts = |(hypothesis, values): (&Hypothesis, &[f64]), motions: &[&MotionSignal]| -> Vec<MotionPart> {
        motions.iter().map(|m| part(&context.rigid, &hypothesis.machine, values, m)).collect()
    };
    let (base_fit, base_held_out) =
        (parts((&base.0, &base.1.values), fit_motions), parts((&base.0, &base.1.values), held_out));
    let (chosen_fit, chosen_held_out) =
        (parts((&chosen.0, &chosen.1.values), fit_motions), parts((&chosen.0, &chosen.1.values), held_out));
    let floor_fit = floor_of(&noise_of(&chosen_fit, fit_motions), &chosen_fit);
    let noise = noise_of(&chosen_held_out, held_out);
    let floor = if held_out.is_empty() { floor_fit } else { floor_of(&noise, &chosen_held_out) };
    let closed95 = (!names.is_empty() && !held_out.is_empty())
        .then(|| closed_interval(&base_held_out, &chosen_held_out, &noise, BOOTSTRAP, settings.seed))
        .flatten();
    let mut tried: Vec<TriedMotion> = first
        .ranked
        .par_iter()
        .zip(&full_fits)
        .filter(|(r, _)| first.screening.candidates[r.candidate].free.is_none())
        .map(|(ranked, refined)| {
            let candidate = &first.screening.candidates[ranked.candidate];
            let (parameters, held_out) = refined.as_ref().map_or((Vec::new(), Vec::new()), |(h, f)| {
                let id = |i: &usize| (h.machine.parameters[*i].id.clone(), f.values[*i]);
                (h.added.iter().map(id).collect(), parts((h, &f.values), held_out))
            });
            let p_value = Some(first.null.p_value(ranked));
            let statistic = first.null.statistic(ranked);
            TriedMotion {
                id: candidate.id.clone(),
                status: Status::Tried,
                gain: ranked.gain,
                statistic,
                p_value,
                parameters,
                held_out,
            }
        })
        .collect();
    for (at, candidate) in first.screening.candidates.iter().enumerate() {
        if first.ranked.iter().all(|r| r.candidate != at) {
            let status = match &candidate.status {
                Status::Tried => {
                    Status::Failed("its parameters leave their ranges at every grid node".into())
                }
                other => other.clone(),
            };
            tried.push(TriedMotion {
                id: candidate.id.clone(),
                status,
                gain: 0.0,
                statistic: 0.0,
                p_value: None,
                parameters: Vec::new(),
                held_out: Vec::new(),
            });
        }
    }
    let places = ForceLocations::new(&context.rigid, &base.0.machine, &base.1.values, fit_motions);
    let other_data = MotionData::new(held_out.to_vec());
    let functions = free_functions(&context.data);
    let located: Vec<LocatedMotion> = first
        .ranked
        .par_iter()
        .filter_map(|r| {
            let candidate = &first.screening.candidates[r.candidate];
            let variable = candidate.free?;
            let function = functions.iter().find(|f| f.variable == variable && f.column == candidate.column);
            Some(LocatedMotion {
                interface: places.of(variable, candidate.column.as_deref()),
                column: candidate.column.clone(),
                over: variable.word(),
                shape: variable.shape(),
                gain: r.gain,
                p_value: first.null.p_value_free(r),
                gap_held_out: function
                    .and_then(|function| gap_with(function, &base, (&context, &other_data))),
            })
        })
        .collect();
    let model = (&context.rigid, &chosen.0.machine, &chosen.1.values[..]);
    let fit_shifts = shifts(model, fit_motions, None);
    let other_shifts =
        shifts(model, held_out, Covariance::new(&chosen.1, &chosen.0.machine, fit_motions).as_ref());
    let step_s = fit_motions.iter().map(|m| m.step_s).fold(0.0, f64::max);
    // An effect that delays the force of all records must not hide a single record with a delayed force.
    let without_delay = without_added_delay(&chosen)
        .map(|values| shifts((&context.rigid, &chosen.0.machine, &values), fit_motions, None));
    let faulty = faulty(without_delay.as_ref().unwrap_or(&fit_shifts), &base_fit, step_s);
    let contradictions = contradictions(&fit_shifts, &other_shifts, step_s);
    let stated = beyond_effects(&contradictions, &other_shifts, &base_held_out);
    let sound = |motion: &&&MotionSignal| stated.iter().all(|record| record.name != motion.name);
    let sound: Vec<&MotionSignal> = held_out.iter().filter(sound).copied().collect();
    let confirming95 = if sound.is_empty() || sound.len() == held_out.len() {
        closed95
    } else {
        let [before, after] =
            [&base, &chosen].map(|(hypothesis, fit)| parts((hypothesis, &fit.values), &sound));
        closed_interval(&before, &after, &noise_of(&after, &sound), BOOTSTRAP, settings.seed)
    };
    let verdict = decide(&MotionDecisionInputs {
        context: &context,
        first: &first,
        base: &base,
        chosen: &chosen,
        names: &names,
        loss,
        full_fits: &full_fits,
        named,
        same: &same,
        located: &located,
        faulty,
        contradictions: &contradictions,
        stated: &stated,
        closed95: confirming95,
        holds_out: !held_out.is_empty(),
    });
    let verdict = with_force_faults(verdict, &force_faults);
    let remark = || common_cause(&context, &first, (&full_fits, base.1.squares), (&base_held_out, held_out));
    let verdict = match (verdict.kind == VerdictKind::None).then(remark).flatten() {
        Some(remark) => Verdict { reason: format!("{}; {remark}", verdict.reason), ..verdict },
        None => verdict,
    };
    let verdict = if control.stopped() {
        let reason =
            "stopped before enough null simulations were drawn to decide on significance".to_string();
        with_force_faults(Verdict::new(VerdictKind::Insufficient, reason, None), &force_faults)
    } else {
        verdict
    };
    let named_candidate = match verdict.kind {
        kind if kind.explains() => named.map(|at| &first.ranked[at]),
        VerdictKind::Unknown => first.best_free(),
        _ => None,
    };
    let squared_reduction =
        named_candidate.and_then(|ranked| first.screening.squared_reduction(&context.data, ranked));
    Ok(MotionDiagnosis {
        phase: squared_reduction
            .and_then(|squared_reduction| largest_phase(&context.data.motions, squared_reduction.as_slice())),
        cells: fit_motions
            .iter()
            .zip(&base_fit)
            .chain(held_out.iter().zip(&base_held_out))
            .flat_map(|(m, p)| misfit_map(m, p))
            .collect(),
        nominal: (base.0, base.1.values),
        fit: base_fit,
        held_out: base_held_out,
        tried,
        located,
        excess: [1.0, loss].map(|share| first.null.excess(share * first.screening.misfit(&context.data))),
        null: first.null,
        chosen: (chosen.0, chosen.1.values),
        chosen_fit,
        chosen_held_out,
        floor,
        floor_fit,
        closed95,
        shifts: fit_shifts.into_iter().chain(other_shifts).collect(),
        contradictions,
        force_faults: texts(&force_faults),
        verdict,
        loss,
        complete: !control.stopped(),
    })
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
        null: MotionNullDistribution::new(&[], &[]),
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

/// Returns the values of a fit without the delay of the force that effects add. `None` where none does.
fn without_added_delay((hypothesis, fit): &Chosen) -> Option<ParameterValues> {
    let delays =
        hypothesis.machine.drive.as_ref()?.delay_s.depends_on().filter(|i| hypothesis.added.contains(i));
    let mut values = fit.values.clone();
    let mut delayed = false;
    for index in delays {
        let parameter = &hypothesis.machine.parameters[index];
        values[index] = 0.0_f64.clamp(parameter.lower, parameter.upper);
        delayed = true;
    }
    delayed.then_some(values)
}

/// Returns the gap of held-out records with a free function, fitted together with the machine's free
/// parameters to the fitted records.
fn gap_with(
    function: &FreeFunction,
    (hypothesis, fit): &Chosen,
    (context, held_out): (&Context<'_>, &MotionData<'_>),
) -> Option<f64> {
    let own = |data: &MotionData<'_>| {
        LinearForce::new(&context.rigid, &hypothesis.machine, &fit.values, &fit.free, &data.motions)
    };
    let recorded = held_out.y.norm();
    if held_out.motions.is_empty() || !(recorded > 0.0) {
        return None;
    }
    let (here, there) = (own(&context.data), own(held_out));
    let penalty = [vec![0.0; fit.free.len()], vec![function.ridge(); function.columns.ncols()]].concat();
    let columns = side_by_side(&[&here.derivatives, &function.columns]);
    let solved = LinearFit::penalised(&columns, &penalty, &(&context.data.y - here.prediction), INDEPENDENT)?;
    let residual = &held_out.y
        - there.prediction
        - side_by_side(&[&there.derivatives, &function.columns_on(held_out)]) * solved.coefficients;
    Some(residual.norm() / recorded)
}
