//! What is said of a motion: the same kinds of verdicts as of FRFs.

use rayon::prelude::*;

use super::channel_weight::weigh;
use super::context::{Chosen, Context};
use super::data::MotionData;
use super::data_fault::{Contradiction, Covariance, RecordShift, contradictions, faulty, shifts};
use super::decision::{MotionDecisionInputs, amount, conclude};
use super::free_function::RubbingPoints;
use super::gap::{MotionPart, closed_interval, gap_of, part};
use super::misfit_map::{MisfitCell, largest_phase, misfit_map};
use super::noise_floor::{floor_of, noise_of};
use super::null_distribution::MotionNullDistribution;
use super::selection::SelectionStep;
use crate::evidence::share_closed;
use crate::verdict::last_of;
use crate::{Hypothesis, Status, Verdict, VerdictKind};
use dynamics::inverse_dynamics::{InverseError, MotionSignal, Phase, Rigid, free_parameters, inverse, mask_backlash_crossings, unseen};
use identification::motion::estimate_identifiable;
use machine::{Effect, Machine};
use optimizer::Control;

/// How a diagnosis is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSettings {
    /// Seed.
    pub seed: u64,
    /// Draws of the null.
    pub draws: usize,
}

/// A candidate with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedMotion {
    /// Id.
    pub id: String,
    /// What became of it.
    pub status: Status,
    /// Share of what the machine fails to foretell of parts left out that it takes away.
    pub gain: f64,
    /// Share of nulls in which some effect takes as much.
    pub p_value: Option<f64>,
    /// Parameters it adds, by id, at the fit of everything.
    pub parameters: Vec<(String, f64)>,
    /// Held-out records with it.
    pub held_out: Vec<MotionPart>,
}

/// A free shape with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedMotion {
    /// The joint or point of the machine where such a force arises.
    pub interface: String,
    /// Column of a further point whose transmission error it is, none for the force.
    pub column: Option<String>,
    /// What the force may depend on.
    pub over: &'static str,
    /// The shape of dynamic stiffness that this resembles.
    pub shape: &'static str,
    /// As for candidates.
    pub gain: f64,
    /// As for candidates, among free shapes.
    pub p_value: f64,
}

/// A whole diagnosis.
pub struct MotionDiagnosis {
    /// The machine as described, and values of its parameters.
    pub nominal: (Hypothesis, Vec<f64>),
    /// Fitted records with it.
    pub fit: Vec<MotionPart>,
    /// Held-out records with it.
    pub held_out: Vec<MotionPart>,
    /// Candidates, best first; those not tried last.
    pub tried: Vec<TriedMotion>,
    /// Free shapes, best first.
    pub located: Vec<LocatedMotion>,
    /// Nulls of the machine as described.
    pub null: MotionNullDistribution,
    /// The model that explains most: the named effect or combination, or else the machine as described.
    pub chosen: (Hypothesis, Vec<f64>),
    /// Fitted records with it.
    pub chosen_fit: Vec<MotionPart>,
    /// Held-out records with it.
    pub chosen_held_out: Vec<MotionPart>,
    /// Gap that the noise alone leaves, of what was held out, else of what was fitted.
    pub floor: Option<f64>,
    /// The same of what was fitted.
    pub floor_fit: Option<f64>,
    /// 95 % interval of `closed` on what was held out.
    pub closed95: Option<(f64, f64)>,
    /// Where the misfit of the machine as described lies, record by record.
    pub cells: Vec<MisfitCell>,
    /// Delays and factors of the records beside the chosen model, fitted ones first.
    pub shifts: Vec<RecordShift>,
    /// Held-out records that contradict the fitted ones.
    pub contradictions: Vec<Contradiction>,
    /// The verdict.
    pub verdict: Verdict,
    /// The phase of the motion in which what the verdict tells of shows most.
    pub phase: Option<Phase>,
    /// Ran to its end.
    pub complete: bool,
}

impl MotionDiagnosis {
    /// `closed` with some prediction of the held-out records.
    pub fn closed(&self, after: &[MotionPart]) -> Option<f64> {
        share_closed(gap_of(&self.held_out)?, gap_of(after)?, self.floor?)
    }
}

/// Share of nulls that may be called something, and the least gain that is: of a second effect; of one more, and of one that is known, or found, to be mistaken for the first: what an imperfect first one leaves, its likes take best.
pub(super) const ALPHA: f64 = 0.005;
const LEAST_SECOND: f64 = 0.11;
const LEAST_MORE: f64 = 0.25;
/// Gain that leaves so little that one null of twenty is rare enough.
pub(super) const NEARLY_ALL: f64 = 0.8;
pub(super) const RARE: f64 = 0.05;
/// Effects that may be combined.
const MOST: usize = 3;
/// Share of the misfit that something ordinary must take, and close for sure of the held-out gap, to be told.
const SURELY: f64 = 0.2;
/// Draws of the bootstrap of `closed`.
const BOOTSTRAP: usize = 400;

/// Diagnoses motions of a drive by the force of its rigid motion, and by the transmission errors of further points where they were recorded; of effects
/// with one id that for motion ([`Effect::for_data`]).
///
/// # Errors  the machine is not one rigid axis, a record gives force for torque or the reverse, a frozen parameter is unknown. Records that do not
/// determine the machine's own parameters are no error but the verdict «insufficient».
pub fn diagnose_motion(
    machine: &Machine,
    effects: &[Effect],
    frozen: &[String],
    (fit_motions, held_out): (&[&MotionSignal], &[&MotionSignal]),
    settings: MotionSettings,
    control: &Control,
) -> Result<MotionDiagnosis, InverseError> {
    let rigid = Rigid::new(machine, &machine.start())?;
    let without_edges = |motions: &[&MotionSignal]| motions.iter().map(|m| (*m).clone().without_edges()).collect::<Vec<MotionSignal>>();
    let (mut all, fitted) = (without_edges(&[fit_motions, held_out].concat()), fit_motions.len());
    all.iter().try_for_each(|motion| rigid.check(machine, motion))?;
    let asked = free_parameters(machine, frozen)?;
    // What neither channel shows stays where it is.
    let unseen = unseen(&rigid, machine, &asked, fit_motions);
    let free: Vec<usize> = asked.into_iter().filter(|i| !unseen.contains(i)).collect();
    // Springs in series that wind up alike are not told apart, and no verdict needs them apart.
    let spring = |parameter: usize| inverse(machine, &[parameter])[0];
    let fit_of = |all: &mut [MotionSignal]| {
        weigh(&rigid, machine, &free, spring, all, fitted)?;
        estimate_identifiable(&rigid, machine, &machine.start(), &free, &all[..fitted].iter().collect::<Vec<_>>(), spring)
    };
    let fit = fit_of(&mut all)
        .and_then(|first| if mask_backlash_crossings(&mut all, &rigid, machine, &first.values) { fit_of(&mut all) } else { Ok(first) });
    let (fit_motions, held_out): (Vec<&MotionSignal>, Vec<&MotionSignal>) =
        (all[..fitted].iter().collect(), all[fitted..].iter().collect());
    let (fit_motions, held_out) = (fit_motions.as_slice(), held_out.as_slice());
    let nominal = Hypothesis::nominal(machine.clone());
    let fit = match fit {
        Ok(fit) => fit,
        Err(InverseError::Data(why) | InverseError::Unidentifiable { why, .. }) => {
            return Ok(insufficient(&rigid, nominal, fit_motions, held_out, why));
        }
        Err(other) => return Err(other),
    };
    let held = unseen.iter().chain(free.iter().filter(|i| !fit.free.contains(i)));
    let frozen: Vec<String> = frozen.iter().cloned().chain(held.map(|i| machine.parameters[*i].id.clone())).collect();
    let work = Context { data: MotionData::new(fit_motions.to_vec()), rigid, frozen: &frozen, effects, settings, control };
    let base = (nominal.clone(), fit);
    let Some(first) = work.screen(&base, &[]) else {
        let why =
            "the parts of these records do not each determine the machine's parameters; record for longer, or more motions".to_string();
        return Ok(insufficient(&work.rigid, nominal, fit_motions, held_out, why));
    };
    let mut names: Vec<String> = Vec::new();
    let mut chosen = base.clone();
    // What the chosen effects leave of what the machine fails to foretell of parts left out.
    let mut loss = 1.0;
    let plain = work.plain_fits(&first, &base);
    let same = first.class(work.effects, |at| plain[at].as_ref().map_or(0.0, |fitted| 1.0 - fitted.1.squares / base.1.squares));
    // The best that holds of those that are not told apart.
    let holds = |at: &usize| plain[*at].as_ref().is_some_and(|next| work.held(&first, *at, next, &base));
    if first.significant(|id| work.least(&first, id))
        && let Some(at) = same.iter().copied().find(holds)
        && let Some(next) = plain[at].clone()
    {
        names.push(first.id(at).to_string());
        loss *= 1.0 - first.ranked[at].gain;
        chosen = next;
    }
    let alike: Vec<&str> = same.iter().map(|at| first.id(*at)).collect();
    // One effect more, as long as it is no accident.
    while !names.is_empty() && names.len() < MOST && !control.stopped() {
        let Some(second) = work.screen(&chosen, &names) else { break };
        let least_of = |id: &str| if names.len() > 1 || alike.contains(&last_of(id)) { LEAST_MORE } else { LEAST_SECOND };
        if !second.significant(least_of) {
            break;
        }
        let at = second.best_effect().unwrap_or(0);
        let Some(next) = work.refined(&second, &second.ranked[at], &chosen) else { break };
        if !work.held(&second, at, &next, &chosen) {
            break;
        }
        names.push(last_of(second.id(at)).to_string());
        loss *= 1.0 - second.ranked[at].gain;
        chosen = next;
    }
    if names.len() > 1 {
        work.drop_what_is_not_needed(&base, &mut names, &mut chosen);
    }
    let named = names.first().and_then(|name| same.iter().copied().find(|at| first.id(*at) == name));
    let parts = |(hypothesis, values): (&Hypothesis, &[f64]), motions: &[&MotionSignal]| -> Vec<MotionPart> {
        motions.iter().map(|m| part(&work.rigid, &hypothesis.machine, values, m)).collect()
    };
    let (base_fit, base_held_out) = (parts((&base.0, &base.1.values), fit_motions), parts((&base.0, &base.1.values), held_out));
    let (chosen_fit, chosen_held_out) = (parts((&chosen.0, &chosen.1.values), fit_motions), parts((&chosen.0, &chosen.1.values), held_out));
    let floor_fit = floor_of(&noise_of(&chosen_fit, fit_motions), &chosen_fit);
    let noise = noise_of(&chosen_held_out, held_out);
    let floor = if held_out.is_empty() { floor_fit } else { floor_of(&noise, &chosen_held_out) };
    let closed95 = (!names.is_empty() && !held_out.is_empty())
        .then(|| closed_interval(&base_held_out, &chosen_held_out, &noise, BOOTSTRAP, settings.seed))
        .flatten();
    let mut tried: Vec<TriedMotion> = first
        .ranked
        .par_iter()
        .zip(&plain)
        .filter(|(r, _)| first.survey.candidates[r.candidate].free.is_none())
        .map(|(ranked, refined)| {
            let candidate = &first.survey.candidates[ranked.candidate];
            let (parameters, held_out) = refined.as_ref().map_or((Vec::new(), Vec::new()), |(h, f)| {
                let id = |i: &usize| (h.machine.parameters[*i].id.clone(), f.values[*i]);
                (h.added.iter().map(id).collect(), parts((h, &f.values), held_out))
            });
            let p_value = Some(first.null.p_value(ranked));
            TriedMotion { id: candidate.id.clone(), status: Status::Tried, gain: ranked.gain, p_value, parameters, held_out }
        })
        .collect();
    for (at, candidate) in first.survey.candidates.iter().enumerate() {
        if first.ranked.iter().all(|r| r.candidate != at) {
            let status = match &candidate.status {
                Status::Tried => Status::Failed("at every place of its lattice its parameters leave their ranges".into()),
                other => other.clone(),
            };
            tried.push(TriedMotion {
                id: candidate.id.clone(),
                status,
                gain: 0.0,
                p_value: None,
                parameters: Vec::new(),
                held_out: Vec::new(),
            });
        }
    }
    let places = RubbingPoints::new(&work.rigid, &base.0.machine, &base.1.values, fit_motions);
    let located: Vec<LocatedMotion> = first
        .ranked
        .iter()
        .filter_map(|r| {
            let candidate = &first.survey.candidates[r.candidate];
            let (over, shape) = candidate.free?;
            let interface = places.of(over, candidate.column.as_deref());
            Some(LocatedMotion {
                interface,
                column: candidate.column.clone(),
                over,
                shape,
                gain: r.gain,
                p_value: first.null.p_value_free(r),
            })
        })
        .collect();
    let model = (&work.rigid, &chosen.0.machine, chosen.1.values.as_slice());
    let fit_shifts = shifts(model, fit_motions, None);
    let other_shifts = shifts(model, held_out, Covariance::new(&chosen.1, &chosen.0.machine, fit_motions).as_ref());
    let step_s = fit_motions.iter().map(|m| m.step_s).fold(0.0, f64::max);
    // An effect that delays the force of all records must not hide the one whose force is late alone.
    let unhidden = diagnose_together(&chosen).map(|values| shifts((&work.rigid, &chosen.0.machine, &values), fit_motions, None));
    let faulty = faulty(unhidden.as_ref().unwrap_or(&fit_shifts), &base_fit, step_s);
    let contradictions = contradictions(&fit_shifts, &other_shifts, step_s);
    let verdict = conclude(&MotionDecisionInputs {
        work: &work,
        first: &first,
        base: &base,
        chosen: &chosen,
        names: &names,
        loss,
        plain: &plain,
        named,
        same: &same,
        located: &located,
        faulty,
        contradictions: &contradictions,
    });
    let cause = || stretched_nuisance(&work, &first, (&plain, base.1.squares), (&base_held_out, held_out));
    let verdict = match (verdict.kind == VerdictKind::None).then(cause).flatten() {
        Some(cause) => Verdict { reason: format!("{}; {cause}", verdict.reason), ..verdict },
        None => verdict,
    };
    let verdict = if control.stopped() {
        let reason = "stopped early, before enough nulls were drawn to tell what is no accident".to_string();
        Verdict { kind: VerdictKind::Insufficient, effects: Vec::new(), reason, next: None }
    } else {
        verdict
    };
    let told = match verdict.kind {
        kind if kind.explains() => named.map(|at| &first.ranked[at]),
        VerdictKind::Unknown => first.best_free(),
        _ => None,
    };
    let taken = told.and_then(|ranked| first.survey.taken(&work.data, ranked));
    Ok(MotionDiagnosis {
        phase: taken.and_then(|taken| largest_phase(&work.data.motions, taken.as_slice())),
        cells: fit_motions.iter().zip(&base_fit).chain(held_out.iter().zip(&base_held_out)).flat_map(|(m, p)| misfit_map(m, p)).collect(),
        nominal: (base.0, base.1.values),
        fit: base_fit,
        held_out: base_held_out,
        tried,
        located,
        null: first.null,
        chosen: (chosen.0, chosen.1.values),
        chosen_fit,
        chosen_held_out,
        floor,
        floor_fit,
        closed95,
        shifts: fit_shifts.into_iter().chain(other_shifts).collect(),
        contradictions,
        verdict,
        complete: !control.stopped(),
    })
}

/// What machines ordinarily have a little of and takes most of the fitted records' misfit, where it surely closes part of the held-out gap, and more than
/// what it needs to be described at all (springs that give way as described) closes without it.
fn stretched_nuisance(
    work: &Context<'_>,
    first: &SelectionStep,
    (plain, squares): (&[Option<Chosen>], f64),
    (before, held_out): (&[MotionPart], &[&MotionSignal]),
) -> Option<String> {
    let is_ordinary = |at: &usize| work.is_common(last_of(first.id(*at)));
    let best = (0..first.ranked.len())
        .filter(is_ordinary)
        .filter_map(|at| Some((at, plain[at].as_ref()?)))
        .min_by(|a, b| a.1.1.squares.total_cmp(&b.1.1.squares))
        .filter(|(_, (_, fit))| fit.squares < (1.0 - SURELY) * squares);
    let (at, (hypothesis, fit)) = best?;
    let machine = &hypothesis.machine;
    let parts = |values: &[f64]| held_out.iter().map(|m| part(&work.rigid, machine, values, m)).collect::<Vec<MotionPart>>();
    let mut without = fit.values.clone();
    hypothesis.added.iter().for_each(|i| without[*i] = machine.parameters[*i].start);
    let (after, without) = (parts(&fit.values), parts(&without));
    let noise = noise_of(before, held_out);
    let share = |after: &[MotionPart]| share_closed(gap_of(before)?, gap_of(after)?, floor_of(&noise, before)?);
    let closed = share(&after)?;
    let (low, high) = closed_interval(before, &after, &noise, BOOTSTRAP, work.settings.seed)?;
    if low < SURELY || closed - share(&without)? < SURELY {
        return None;
    }
    let amounts: Vec<String> = hypothesis.added.iter().map(|i| amount(&machine.parameters[*i], fit.values[*i])).collect();
    Some(format!(
        "{}, which machines ordinarily have a little of, closes {:.0} % of the held-out gap ({:.0}–{:.0}): {}",
        first.id(at),
        100.0 * closed.min(1.0),
        100.0 * low,
        100.0 * high.min(1.0),
        amounts.join(", ")
    ))
}

/// Values of a fit whose force comes as late as the machine as described says: what effects delay it by is nothing. `None` where none does.
fn diagnose_together((hypothesis, fit): &Chosen) -> Option<Vec<f64>> {
    let delays = hypothesis.machine.drive.as_ref()?.delay_s.depends_on().filter(|i| hypothesis.added.contains(i));
    let mut values = fit.values.clone();
    let mut delayed = false;
    for index in delays {
        let parameter = &hypothesis.machine.parameters[index];
        values[index] = 0.0_f64.clamp(parameter.lower, parameter.upper);
        delayed = true;
    }
    delayed.then_some(values)
}

/// What is said where the records do not determine the machine's own parameters.
fn insufficient(rigid: &Rigid, nominal: Hypothesis, fit: &[&MotionSignal], held_out: &[&MotionSignal], why: String) -> MotionDiagnosis {
    let values = nominal.machine.start();
    let parts = |motions: &[&MotionSignal]| motions.iter().map(|m| part(rigid, &nominal.machine, &values, m)).collect::<Vec<_>>();
    let (fit, held_out) = (parts(fit), parts(held_out));
    let next = Some("a motion with reversals, several speeds and accelerations over the whole travel".to_string());
    MotionDiagnosis {
        chosen: (nominal.clone(), values.clone()),
        nominal: (nominal, values),
        chosen_fit: fit.clone(),
        chosen_held_out: held_out.clone(),
        fit,
        held_out,
        tried: Vec::new(),
        located: Vec::new(),
        null: MotionNullDistribution { scales: Vec::new(), most: Vec::new(), effects: Vec::new(), free: Vec::new() },
        floor: None,
        floor_fit: None,
        closed95: None,
        cells: Vec::new(),
        shifts: Vec::new(),
        contradictions: Vec::new(),
        verdict: Verdict { kind: VerdictKind::Insufficient, effects: Vec::new(), reason: why, next },
        phase: None,
        complete: true,
    }
}
