//! What candidates are tried on: surveys beside a model, fits of everything, and what keeps an effect from being named.

use rayon::prelude::*;

use super::data::MotionData;
use super::diagnosis::{ALPHA, MotionSettings};
use super::screening::{MotionScreening, Ranked, SharedColumns, start_of};
use super::selection::{SelectionStep, simplest_first};
use crate::verdict::last_of;
use crate::{Hypothesis, Status};
use dynamics::inverse_dynamics::{Rigid, free_parameters};
use identification::motion::{ForceFit, estimate_identifiable};
use machine::{Data, Effect, Machine};
use numeric::linear_fit::LinearFit;
use numeric::statistics::root_mean_square;
use optimizer::Control;
use optimizer::live_columns;

/// Least gain of the first effect that is called something, and of one that machines ordinarily have a little of.
const LEAST: f64 = 0.03;
const LEAST_ORDINARY: f64 = 0.06;
/// Share of the misfit by which a combination may be worse without one of its effects, for that one to be dropped.
const SPARED: f64 = 0.03;
/// Shares of what an effect gains of parts left out one of which it must take where the fit of everything ends, lest that be where it does nothing: by
/// itself, and beside what is ordinarily wrong. One that machines have a little of must take the second by itself; if it takes the first, something is there.
const HELD: (f64, f64) = (0.02, 0.25);
/// Share of what an added parameter does where a fit ended that the others must not do.
const APART: f64 = 0.01;
/// Share of the force that inertia takes at least, root mean square, for acceleration to tell anything.
const SLOW: f64 = 0.2;
/// Standard deviations of what is ordinarily wrong beyond which a machine is not as described. Where loops tell of a point nothing is said: their force
/// and settings are no such gauge.
const STRETCHED: f64 = 4.0;

/// A machine, perhaps with effects, and its fit.
pub(super) type Chosen = (Hypothesis, ForceFit);

/// What does not change from one effect to the next.
pub(super) struct Context<'w> {
    pub data: MotionData<'w>,
    pub rigid: Rigid,
    pub frozen: &'w [String],
    pub effects: &'w [Effect],
    pub settings: MotionSettings,
    pub control: &'w Control,
}

impl Context<'_> {
    /// All candidates beside a model that has the named effects already, and nulls of it.
    pub fn screen(&self, from: &Chosen, names: &[String]) -> Option<SelectionStep> {
        let (apply, others) = self.hypotheses(&from.0, names);
        let ground = SharedColumns { data: &self.data, rigid: &self.rigid, nominal: &from.0, fit: &from.1, frozen: self.frozen };
        let survey = MotionScreening::new(&ground, apply, others, self.control)?;
        let mut ranked = survey.rank(&self.data, &self.data.y);
        let best = ranked.iter().find(|r| survey.candidates[r.candidate].free.is_none());
        let seed = self.settings.seed.wrapping_add(names.len() as u64);
        let null = survey.null(&self.data, &self.data.y, best, self.settings.draws, seed, self.control);
        // What a wave of any period gains by accident does not stand before what is no accident.
        ranked.sort_by_key(|r| survey.candidates[r.candidate].free.is_none() && null.p_value(r) >= ALPHA);
        simplest_first(&survey, &null, &mut ranked);
        let further = self.data.motions.iter().any(|m| m.records_points());
        let stretched = survey.stretched(&self.data).filter(|(_, size)| *size > STRETCHED && !self.data.is_identifiable());
        let stretched = stretched.map(|(name, size)| (name.trim_start_matches('~').to_string(), size));
        Some(SelectionStep { survey, ranked, null, further, slow: self.slow(from), stretched })
    }

    /// Whether inertia takes next to no force in these records.
    fn slow(&self, from: &Chosen) -> bool {
        let inertia = self.rigid.inertia(&from.0.machine, &from.1.values);
        let force = root_mean_square(self.data.motions.iter().flat_map(|m| m.load.iter().copied()));
        let moved = root_mean_square(self.data.motions.iter().flat_map(|m| m.acceleration_m_s2.iter().map(|a| inertia * a)));
        moved.zip(force).is_some_and(|(moved, force)| moved < SLOW * force)
    }

    fn hypotheses(&self, from: &Hypothesis, names: &[String]) -> (Vec<Hypothesis>, Vec<(String, Status)>) {
        let (mut apply, mut others) = (Vec::new(), Vec::new());
        for effect in self.effects.iter().filter(|e| !names.contains(&e.id)) {
            let applied = match from.obstacle(effect, Data::Motion) {
                Some(why) => Err(why),
                None => from.with(effect).map_err(|error| error.to_string()),
            };
            match applied {
                Ok(hypothesis) => apply.push(only_added(hypothesis, from)),
                Err(why) => others.push((effect.id.clone(), Status::NotApplicable(why))),
            }
        }
        apply.extend(from.releases(&from.machine, self.frozen, names));
        (apply, others)
    }

    /// A candidate fitted with everything, from where the survey found it.
    pub fn refined(&self, stage: &SelectionStep, ranked: &Ranked, from: &Chosen) -> Option<Chosen> {
        let hypothesis = stage.survey.candidates[ranked.candidate].hypothesis.as_ref()?;
        let machine = &hypothesis.machine;
        let mut start = start_of(machine, &from.1.values);
        for (index, value) in &ranked.added {
            start[*index] = value.clamp(machine.parameters[*index].lower, machine.parameters[*index].upper);
        }
        let mut whole = hypothesis.clone();
        whole.added = from.0.added.iter().chain(&hypothesis.added).copied().collect();
        let frozen: Vec<String> =
            self.frozen.iter().filter(|id| !whole.added.iter().any(|i| machine.parameters[*i].id == **id)).cloned().collect();
        let free = free_parameters(machine, &frozen).ok()?;
        let fitted =
            |free: &[usize]| self.fitted(machine, &start, free, &whole.added).filter(|fit| is_identifiable(fit, &hypothesis.added));
        let fit = fitted(&free).or_else(|| {
            // What the machine has at an end of its range may be what the effect stands for.
            let kept = |i: &usize| machine.parameters[*i].holds_inside(start[*i]) || *i >= from.1.values.len();
            let free: Vec<usize> = free.iter().copied().filter(kept).collect();
            fitted(&free)
        })?;
        Some((whole, fit))
    }

    /// The best fit in which what the records do not tell beside the effects' own parameters stays where the machine's fit has it. What that fit took to an
    /// end of its range, to stand for what is missing, need not find back from there: it starts as described, too.
    fn fitted(&self, machine: &Machine, start: &[f64], free: &[usize], added: &[usize]) -> Option<ForceFit> {
        let may = |parameter: usize| !added.contains(&parameter);
        let fit = |start: &[f64]| estimate_identifiable(&self.rigid, machine, start, free, &self.data.motions, may).ok();
        let described = machine.start();
        let back = |(index, x): (usize, &f64)| {
            let astray = free.contains(&index) && !added.contains(&index) && !machine.parameters[index].holds_inside(*x);
            if astray { described[index] } else { *x }
        };
        let again: Vec<f64> = start.iter().enumerate().map(back).collect();
        let others = if again == start { None } else { fit(&again) };
        fit(start).into_iter().chain(others).min_by(|a, b| a.squares.total_cmp(&b.squares))
    }

    /// Whether machines have a little of an effect ordinarily.
    pub fn is_common(&self, id: &str) -> bool {
        self.effects.iter().any(|e| e.common && e.id == id)
    }

    /// Gain below which an effect is not named first. Where what is ordinary is not enough, an effect that machines have a little of needs no more than others.
    pub fn least(&self, stage: &SelectionStep, id: &str) -> f64 {
        if stage.stretched.is_none() && self.is_common(id) { LEAST_ORDINARY } else { LEAST }
    }

    /// Fits of everything with each of the ranked effects.
    pub fn plain_fits(&self, stage: &SelectionStep, from: &Chosen) -> Vec<Option<Chosen>> {
        stage.ranked.par_iter().map(|ranked| self.refined(stage, ranked, from)).collect()
    }

    /// Whether the fit of everything ends where an effect shows that gained so much of parts left out: by itself, or, of one that machines have none of
    /// ordinarily, beside what is ordinarily wrong.
    pub fn held(&self, stage: &SelectionStep, at: usize, next: &Chosen, before: &Chosen) -> bool {
        let gain = stage.ranked[at].gain;
        let ordinary = self.is_common(last_of(stage.id(at)));
        let beside = |of: &Chosen| stage.survey.squares(&self.data, &self.rigid, &of.0.machine, &of.1.values);
        reduces(next.1.squares, before.1.squares, gain, if ordinary { HELD.1 } else { HELD.0 })
            || (!ordinary && beside(next).zip(beside(before)).is_some_and(|(after, before)| reduces(after, before, gain, HELD.1)))
    }

    /// Whether an effect takes anything of the misfit by itself where the fit of everything ends.
    pub fn shows(&self, stage: &SelectionStep, at: usize, next: &Chosen, before: &Chosen) -> bool {
        reduces(next.1.squares, before.1.squares, stage.ranked[at].gain, HELD.0)
    }

    /// Takes effects out of a combination that it hardly misses.
    pub fn drop_what_is_not_needed(&self, base: &Chosen, names: &mut Vec<String>, chosen: &mut Chosen) {
        for at in (0..names.len() - 1).rev() {
            let kept: Vec<&String> = names.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, n)| n).collect();
            let effects: Option<Vec<&Effect>> = kept.iter().map(|id| self.effects.iter().find(|e| e.id == **id)).collect();
            let Some(effects) = effects else { continue };
            let hypothesis = effects.iter().try_fold(base.0.clone(), |h, e| h.with(e));
            let Ok(hypothesis) = hypothesis else { continue };
            let machine = &hypothesis.machine;
            let mut start = start_of(machine, &base.1.values);
            for (index, p) in machine.parameters.iter().enumerate() {
                if let Some(known) = chosen.0.machine.parameter(&p.id) {
                    start[index] = chosen.1.values[known];
                }
            }
            let Ok(free) = free_parameters(machine, self.frozen) else { continue };
            if let Some(fit) = self.fitted(machine, &start, &free, &hypothesis.added)
                && fit.squares <= (1.0 + SPARED) * chosen.1.squares
            {
                *chosen = (hypothesis, fit);
                names.remove(at);
                return;
            }
        }
    }
}

/// Whether what some of the added parameters do where a fit ended is not what the others do, too.
fn is_identifiable(fit: &ForceFit, added: &[usize]) -> bool {
    let (own, others): (Vec<usize>, Vec<usize>) = live_columns(&fit.derivatives).into_iter().partition(|at| added.contains(&fit.free[*at]));
    let others = fit.derivatives.select_columns(&others);
    own.into_iter().any(|at| {
        let column = fit.derivatives.column(at).clone_owned();
        LinearFit::new(&others, &column).is_none_or(|left| left.residual.norm() > APART * column.norm())
    })
}

/// Whether a fit takes such a share of a gain of what one before it leaves.
fn reduces(after: f64, before: f64, gain: f64, share: f64) -> bool {
    after < (1.0 - share * gain) * before
}

/// A hypothesis whose added parameters are those of the last effect alone: the others are free in what it starts from.
fn only_added(mut hypothesis: Hypothesis, from: &Hypothesis) -> Hypothesis {
    hypothesis.added = (from.machine.parameters.len()..hypothesis.machine.parameters.len()).collect();
    hypothesis
}
