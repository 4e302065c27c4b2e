//! Fits of candidates beside a model: screening, and joint fits of all parameters.

use rayon::prelude::*;

use super::candidate::{ScreenedFit, start_of};
use super::data::MotionData;
use super::grid::longest_wave;
use super::screening::{MotionScreening, SharedColumns};
use crate::{Hypothesis, Status};
use dynamics::inverse_dynamics::{Rigid, free_parameters};
use identification::motion::{ForceFit, Tolerances, estimate_identifiable};
use long_work::Control;
use machine::{Data, Effect, Machine, ParameterValues};
use numeric::linear_fit::LinearFit;
use numeric::statistics::root_mean_square;
use optimizer::nonzero_columns;

/// Least share of an added parameter's influence, at the end of a fit, that is orthogonal to the other
/// parameters.
const INDEPENDENT: f64 = 0.01;
/// Least share of the force, root mean square, due to inertia with which acceleration is informative.
const LEAST_INERTIA: f64 = 0.2;

/// Settings of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSettings {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of null simulations.
    pub draws: usize,
    /// Whether to gather what other rules may ask for, too.
    pub all_facts: bool,
}

/// A machine, possibly with effects, and its fit.
pub(super) type MotionFit = (Hypothesis, ForceFit);

/// Inputs that are the same for every added effect.
pub(super) struct Context<'w> {
    pub data: MotionData<'w>,
    pub rigid: Rigid,
    pub frozen: &'w [String],
    pub effects: &'w [Effect],
    pub settings: MotionSettings,
    pub control: &'w Control,
}

/// A candidate beside a model.
pub(super) struct Candidate {
    /// Index in the screening.
    pub at: usize,
    /// Its fit there; `None` where it was not fitted.
    pub screened: Option<ScreenedFit>,
    /// Joint fit of all parameters without tolerances.
    pub alone: Option<MotionFit>,
    /// Joint fit of all parameters beside tolerances.
    pub tolerant: Option<MotionFit>,
}

/// What was fitted beside a model.
pub(super) struct Screened {
    pub screening: MotionScreening,
    /// Effects and released parameters, the best fit first; those without a fit last.
    pub candidates: Vec<Candidate>,
    /// Free functions, best first.
    pub functions: Vec<ScreenedFit>,
}

impl Candidate {
    /// Returns the least squared misfit beside tolerances; infinite where it was not fitted.
    pub fn squares(&self) -> f64 {
        self.tolerant.as_ref().map_or(f64::INFINITY, |(_, fit)| fit.squares)
    }
}

/// The effect of all records that is tried as a fault of their chain.
pub(super) const CLOCKS: &str = "measurement-delay";

impl Context<'_> {
    /// Screens all candidates beside a model.
    pub fn screening(&self, from: &MotionFit) -> Option<MotionScreening> {
        let (apply, others) = self.hypotheses(&from.0);
        let columns = SharedColumns {
            data: &self.data,
            rigid: &self.rigid,
            nominal: &from.0,
            fit: &from.1,
            frozen: self.frozen,
        };
        MotionScreening::new(&columns, apply, others, self.control)
    }

    /// Fits all parameters with each candidate of a screening, without tolerances and beside them.
    pub fn screened(
        &self,
        screening: MotionScreening,
        from: &MotionFit,
        tolerances: &Tolerances,
    ) -> Screened {
        let is_free = |fit: &ScreenedFit| screening.candidates[fit.candidate].free.is_some();
        let (mut functions, fits): (Vec<ScreenedFit>, Vec<ScreenedFit>) =
            screening.fits(&self.data).into_iter().partition(is_free);
        functions.sort_by(|a, b| a.squares.total_cmp(&b.squares));
        let of = |at: usize| {
            let Some(screened) = fits.iter().find(|fit| fit.candidate == at).cloned() else {
                return Candidate { at, screened: None, alone: None, tolerant: None };
            };
            let alone = self.joint_fit(&screening, &screened, from, None);
            let tolerant = self.joint_fit(&screening, &screened, from, Some((tolerances, alone.as_ref())));
            Candidate { at, screened: Some(screened), alone: alone.or_else(|| tolerant.clone()), tolerant }
        };
        let named = (0..screening.candidates.len()).filter(|at| screening.candidates[*at].free.is_none());
        let mut candidates: Vec<Candidate> = named.collect::<Vec<usize>>().into_par_iter().map(of).collect();
        candidates.sort_by(|a, b| a.squares().total_cmp(&b.squares()));
        Screened { screening, candidates, functions }
    }

    /// Whether inertia causes only a small share of the force.
    pub fn is_slow(&self, from: &MotionFit) -> bool {
        let inertia = self.rigid.inertia(&from.0.machine, &from.1.values);
        let force = root_mean_square(self.data.motions.iter().flat_map(|m| m.load.iter().copied()));
        let moved = root_mean_square(
            self.data.motions.iter().flat_map(|m| m.acceleration_m_s2.iter().map(|a| inertia * a)),
        );
        moved.zip(force).is_some_and(|(moved, force)| moved < LEAST_INERTIA * force)
    }

    fn hypotheses(&self, from: &Hypothesis) -> (Vec<Hypothesis>, Vec<(String, Status)>) {
        let (mut apply, mut others) = (Vec::new(), Vec::new());
        for effect in self.effects.iter().filter(|e| e.id != CLOCKS && !from.effects.contains(&e.id)) {
            let applied = match from.obstacle(effect, Data::Motion) {
                Some(why) => Err(why),
                None => from.with(effect).map_err(|error| error.to_string()),
            };
            match applied {
                Ok(hypothesis) => apply.push(only_added(hypothesis, from)),
                Err(why) => others.push((effect.id.clone(), Status::NotApplicable(why))),
            }
        }
        apply.extend(from.releases(&from.machine, self.frozen, from.effects.as_slice()));
        (apply, others)
    }

    /// Fits all parameters with a candidate, starting from its estimate in the screening; beside tolerances, if
    /// given, also from a fit without them.
    fn joint_fit(
        &self,
        screening: &MotionScreening,
        screened: &ScreenedFit,
        from: &MotionFit,
        beside: Option<(&Tolerances, Option<&MotionFit>)>,
    ) -> Option<MotionFit> {
        let hypothesis = screening.candidates[screened.candidate].hypothesis.as_ref()?;
        let machine = &hypothesis.machine;
        let mut start = start_of(machine, &from.1.values);
        for (index, value) in &screened.added {
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
        let tolerances = beside.map(|(tolerances, _)| tolerances);
        let fitted = |start: &ParameterValues, free: &[usize]| {
            self.fitted(machine, start, free, &whole.added, tolerances)
                .filter(|fit| is_identifiable(fit, &hypothesis.added) && self.has_waves(machine, fit))
        };
        let fit = fitted(&start, &free).or_else(|| {
            // A parameter at the end of its range may stand for the effect: keep it fixed.
            let kept =
                |i: &usize| machine.parameters[*i].holds_inside(start[*i]) || *i >= from.1.values.len();
            let free: Vec<usize> = free.iter().copied().filter(kept).collect();
            fitted(&start, &free)
        });
        let again = beside.and_then(|(_, alone)| alone).and_then(|(_, alone)| fitted(&alone.values, &free));
        let best = fit.into_iter().chain(again).min_by(|a, b| a.squares.total_cmp(&b.squares))?;
        Some((whole, best))
    }

    /// Whether the travel holds each wave of a machine: a longer one is no wave but a slope along the travel.
    fn has_waves(&self, machine: &Machine, fit: &ForceFit) -> bool {
        fit.free.iter().all(|index| {
            let parameter = &machine.parameters[*index];
            let longest = longest_wave(machine, parameter, &self.data, &self.rigid);
            longest.is_none_or(|longest| fit.values[*index] <= longest)
        })
    }

    /// Returns the best fit in which parameters that the records do not identify next to the added ones keep
    /// their values. Parameters at an end of their range may stand for the missing effect: a second fit
    /// starts them as described.
    pub fn fitted(
        &self,
        machine: &Machine,
        start: &ParameterValues,
        free: &[usize],
        added: &[usize],
        tolerances: Option<&Tolerances>,
    ) -> Option<ForceFit> {
        let may_drop = |parameter: usize| !added.contains(&parameter);
        let motions = &self.data.motions;
        let fit = |start: &ParameterValues| {
            estimate_identifiable((&self.rigid, machine), start, free, motions, tolerances, may_drop).ok()
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

/// Restricts the added parameters of a hypothesis to those of the last effect: the others are free parameters
/// of the model it starts from.
fn only_added(mut hypothesis: Hypothesis, from: &Hypothesis) -> Hypothesis {
    hypothesis.added = (from.machine.parameters.len()..hypothesis.machine.parameters.len()).collect();
    hypothesis
}
