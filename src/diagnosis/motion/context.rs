//! Context of a diagnosis: screening of candidates on a model, joint fits of all parameters, and the checks
//! that keep an effect from being named.

use rayon::prelude::*;

use super::candidate::{Ranked, start_of};
use super::data::MotionData;
use super::null_distribution::MotionNullDistribution;
use super::screening::{MotionScreening, SharedColumns};
use super::selection::{ALPHA, SelectionStep, simplest_first};
use crate::{Hypothesis, Status};
use dynamics::inverse_dynamics::{Rigid, free_parameters};
use identification::motion::{ForceFit, estimate_identifiable};
use long_work::Control;
use machine::{Data, Effect, EffectIds, Machine, ParameterValues};
use numeric::linear_fit::LinearFit;
use numeric::statistics::root_mean_square;
use optimizer::nonzero_columns;

/// Least reduction of the prediction error by the first named effect, and by a common one.
const LEAST: f64 = 0.03;
const LEAST_COMMON: f64 = 0.06;
/// Largest relative increase of the squared misfit with which an effect is dropped from a combination.
const DISPENSABLE: f64 = 0.03;
/// Least shares of an effect's reduction of the prediction error, either of which the joint fit must
/// reproduce: it may end where the effect has no influence. The first is without, the second with nuisance
/// parameters. A common effect must reproduce the second without them; with the first alone it shows but is
/// not named.
const CONFIRMED: (f64, f64) = (0.02, 0.25);
/// Least share of an added parameter's influence, at the end of a fit, that is orthogonal to the other
/// parameters.
const INDEPENDENT: f64 = 0.01;
/// Least share of the force, root mean square, due to inertia with which acceleration is informative.
const LEAST_INERTIA: f64 = 0.2;
/// Size of a nuisance parameter (standard deviations) above which the machine differs from its description.
/// Not used where an encoder position is estimated from the control loop: its force and settings are too
/// uncertain.
const IMPLAUSIBLE: f64 = 4.0;

/// Settings of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSettings {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of null simulations.
    pub draws: usize,
}

/// A machine, possibly with effects, and its fit.
pub(super) type Chosen = (Hypothesis, ForceFit);

/// Inputs that are the same for every added effect.
pub(super) struct Context<'w> {
    pub data: MotionData<'w>,
    pub rigid: Rigid,
    pub frozen: &'w [String],
    pub effects: &'w [Effect],
    pub settings: MotionSettings,
    pub control: &'w Control,
}

impl Context<'_> {
    /// Screens all candidates on a model that already has the named effects, and simulates its null
    /// distribution.
    pub fn screen(&self, from: &Chosen, names: &EffectIds) -> Option<SelectionStep> {
        let (apply, others) = self.hypotheses(&from.0, names);
        let columns = SharedColumns {
            data: &self.data,
            rigid: &self.rigid,
            nominal: &from.0,
            fit: &from.1,
            frozen: self.frozen,
        };
        let screening = MotionScreening::new(&columns, apply, others, self.control)?;
        let mut ranked = screening.rank(&self.data);
        let best = ranked.iter().find(|r| screening.candidates[r.candidate].free.is_none());
        let seed = self.settings.seed.wrapping_add(names.len() as u64);
        let draws = screening.null_simulations(&self.data, best, self.settings.draws, seed, self.control);
        let null = MotionNullDistribution::new(
            &draws,
            &screening.candidates.iter().map(|c| c.free.is_some()).collect::<Vec<bool>>(),
        );
        // Insignificant candidates, such as a wave of any period, rank behind significant ones.
        ranked.sort_by_key(|r| screening.candidates[r.candidate].free.is_none() && null.p_value(r) >= ALPHA);
        simplest_first(&screening, &null, &mut ranked);
        let extra_points = self.data.motions.iter().any(|m| m.has_extra_points());
        let implausible = screening
            .largest_nuisance(&self.data)
            .filter(|(_, size)| *size > IMPLAUSIBLE && !self.data.is_identifiable());
        let implausible = implausible.map(|(name, size)| (name.to_string(), size));
        Some(SelectionStep { screening, ranked, null, extra_points, slow: self.slow(from), implausible })
    }

    /// Whether inertia causes only a small share of the force.
    fn slow(&self, from: &Chosen) -> bool {
        let inertia = self.rigid.inertia(&from.0.machine, &from.1.values);
        let force = root_mean_square(self.data.motions.iter().flat_map(|m| m.load.iter().copied()));
        let moved = root_mean_square(
            self.data.motions.iter().flat_map(|m| m.acceleration_m_s2.iter().map(|a| inertia * a)),
        );
        moved.zip(force).is_some_and(|(moved, force)| moved < LEAST_INERTIA * force)
    }

    fn hypotheses(&self, from: &Hypothesis, names: &EffectIds) -> (Vec<Hypothesis>, Vec<(String, Status)>) {
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
        apply.extend(from.releases(&from.machine, self.frozen, names.as_slice()));
        (apply, others)
    }

    /// Fits all parameters with a candidate, starting from its estimate in the screening.
    pub fn refined(&self, step: &SelectionStep, ranked: &Ranked, from: &Chosen) -> Option<Chosen> {
        let hypothesis = step.screening.candidates[ranked.candidate].hypothesis.as_ref()?;
        let machine = &hypothesis.machine;
        let mut start = start_of(machine, &from.1.values);
        for (index, value) in &ranked.added {
            start[*index] = value.clamp(machine.parameters[*index].lower, machine.parameters[*index].upper);
        }
        let mut whole = hypothesis.clone();
        whole.added = from.0.added.iter().chain(&hypothesis.added).copied().collect();
        let frozen: Vec<String> = self
            .frozen
            .iter()
            .filter(|id| !whole.added.iter().any(|i| machine.parameters[*i].id == **id))
            .cloned()
            .collect();
        let free = free_parameters(machine, &frozen).ok()?;
        let fitted = |free: &[usize]| {
            self.fitted(machine, &start, free, &whole.added)
                .filter(|fit| is_identifiable(fit, &hypothesis.added))
        };
        let fit = fitted(&free).or_else(|| {
            // A parameter at the end of its range may stand for the effect: keep it fixed.
            let kept =
                |i: &usize| machine.parameters[*i].holds_inside(start[*i]) || *i >= from.1.values.len();
            let free: Vec<usize> = free.iter().copied().filter(kept).collect();
            fitted(&free)
        })?;
        Some((whole, fit))
    }

    /// Returns the best fit in which parameters that the records do not identify next to the added ones keep
    /// their values. Parameters at an end of their range may stand for the missing effect: a second fit
    /// starts them as described.
    fn fitted(
        &self,
        machine: &Machine,
        start: &ParameterValues,
        free: &[usize],
        added: &[usize],
    ) -> Option<ForceFit> {
        let may_drop = |parameter: usize| !added.contains(&parameter);
        let fit = |start: &ParameterValues| {
            estimate_identifiable(&self.rigid, machine, start, free, &self.data.motions, may_drop).ok()
        };
        let described = machine.start();
        let back = |(index, x): (usize, &f64)| {
            let at_end = free.contains(&index)
                && !added.contains(&index)
                && !machine.parameters[index].holds_inside(*x);
            if at_end { described[index] } else { *x }
        };
        let again = ParameterValues(start.iter().enumerate().map(back).collect());
        let from_description = if again == *start { None } else { fit(&again) };
        fit(start).into_iter().chain(from_description).min_by(|a, b| a.squares.total_cmp(&b.squares))
    }

    /// Whether an effect is common: most machines have a little of it.
    pub fn is_common(&self, id: &str) -> bool {
        self.effects.iter().any(|e| e.common && e.id == id)
    }

    /// Returns the least reduction of the prediction error with which an effect is named first. Where
    /// nuisance parameters are implausibly large, common effects need no more than others.
    pub fn least(&self, step: &SelectionStep, id: &str) -> f64 {
        if step.implausible.is_none() && self.is_common(id) { LEAST_COMMON } else { LEAST }
    }

    /// Fits all parameters with each of the ranked candidates.
    pub fn full_fits(&self, step: &SelectionStep, from: &Chosen) -> Vec<Option<Chosen>> {
        step.ranked.par_iter().map(|ranked| self.refined(step, ranked, from)).collect()
    }

    /// Whether the joint fit reproduces the effect's reduction of the prediction error: without nuisance
    /// parameters or, unless the effect is common, with them.
    pub fn confirms(&self, step: &SelectionStep, at: usize, next: &Chosen, before: &Chosen) -> bool {
        let gain = step.ranked[at].gain;
        let common = self.is_common(step.last_effect(at));
        let with_nuisances =
            |of: &Chosen| step.screening.squares(&self.data, &self.rigid, &of.0.machine, &of.1.values);
        reduces(next.1.squares, before.1.squares, gain, if common { CONFIRMED.1 } else { CONFIRMED.0 })
            || (!common
                && with_nuisances(next)
                    .zip(with_nuisances(before))
                    .is_some_and(|(after, before)| reduces(after, before, gain, CONFIRMED.1)))
    }

    /// Whether an effect reduces the misfit of the joint fit at all, without nuisance parameters.
    pub fn shows(&self, step: &SelectionStep, at: usize, next: &Chosen, before: &Chosen) -> bool {
        reduces(next.1.squares, before.1.squares, step.ranked[at].gain, CONFIRMED.0)
    }

    /// Drops one effect from a combination that fits almost as well without it.
    pub fn drop_dispensable(&self, base: &Chosen, names: &mut EffectIds, chosen: &mut Chosen) {
        for at in (0..names.len() - 1).rev() {
            let kept = names.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, n)| n);
            let effects: Option<Vec<&Effect>> =
                kept.map(|id| self.effects.iter().find(|e| e.id == id)).collect();
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
                && fit.squares <= (1.0 + DISPENSABLE) * chosen.1.squares
            {
                *chosen = (hypothesis, fit);
                names.remove(at);
                return;
            }
        }
    }
}

/// Whether some added parameter has, at the end of a fit, an influence that the other parameters cannot
/// reproduce.
fn is_identifiable(fit: &ForceFit, added: &[usize]) -> bool {
    let (own, others): (Vec<usize>, Vec<usize>) =
        nonzero_columns(&fit.derivatives).into_iter().partition(|at| added.contains(&fit.free[*at]));
    let others = fit.derivatives.select_columns(&others);
    own.into_iter().any(|at| {
        let column = fit.derivatives.column(at).clone_owned();
        LinearFit::new(&others, &column).is_none_or(|left| left.residual.norm() > INDEPENDENT * column.norm())
    })
}

/// Whether a fit reduces the squared misfit by a share of a gain.
fn reduces(after: f64, before: f64, gain: f64, share: f64) -> bool {
    after < (1.0 - share * gain) * before
}

/// Restricts the added parameters of a hypothesis to those of the last effect: the others are free parameters
/// of the model it starts from.
fn only_added(mut hypothesis: Hypothesis, from: &Hypothesis) -> Hypothesis {
    hypothesis.added = (from.machine.parameters.len()..hypothesis.machine.parameters.len()).collect();
    hypothesis
}
