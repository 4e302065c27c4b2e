//! Facts of motion records: fits and simulations answer what rules ask for.

use std::convert::Infallible;

use super::context::{CLOCKS, Candidate, Context, MotionFit, Screened};
use super::data::{MotionData, side_by_side};
use super::data_fault::{
    Contradiction, Covariance, RecordShift, beyond_effects, contradictions, faulty, outlying, shifts,
};
use super::free_function::{ForceLocations, FreeFunction};
use super::gap::{MotionPart, gap_of, part};
use super::noise_floor::{floor_of, noise_of};
use super::nuisance::{columns_of, nuisances};
use super::screening::NullDraw;
use super::two_clocks::TwoClocks;
use crate::DataKind;
use crate::case::Need;
use crate::evidence::share_closed;
use crate::facts::{
    Answer, Beside, CandidateFacts, ChainFacts, ContradictingHeldOut, Facts, Farthest, FaultFacts,
    ImpedanceFacts, Model, Of, of,
};
use crate::judgement::Answers;
use crate::location::places_of;
use crate::null_distribution::{NullDistribution, least_scale};
use crate::verdict::frozen_text;
use crate::{HypothesisKind, Policy};
use dynamics::inverse_dynamics::{LinearForce, MotionSignal, prediction, recorded};
use identification::motion::Tolerances;
use machine::{Effect, ParameterValues};
use nalgebra::DVector;
use numeric::linear_fit::LinearFit;

/// What answers questions: records, machine, and what was fitted so far.
pub(super) struct MotionGatherer<'g, 'w> {
    pub context: &'g Context<'w>,
    pub held_out: MotionData<'w>,
    /// The machine as described, fitted without tolerances and beside them.
    pub alone: MotionFit,
    pub tolerant: MotionFit,
    /// Tolerances on the fitted records, and on the held-out ones.
    pub tolerances: [Tolerances; 2],
    /// Candidates beside the machine as described.
    pub first: Screened,
    /// Free functions on the fitted records.
    pub functions: Vec<FreeFunction>,
    /// Candidates beside chosen models, as the facts have them.
    pub beside: Vec<Option<Screened>>,
}

/// Returns what tolerances leave on some records of a machine with given values.
pub(super) fn tolerances_on(
    context: &Context<'_>,
    data: &MotionData<'_>,
    (hypothesis, fit): &MotionFit,
    variance: f64,
) -> Option<Tolerances> {
    let all = nuisances(data, &context.rigid, &hypothesis.machine, &fit.values);
    Tolerances::new(&columns_of(&all), variance)
}

impl<'g, 'w> MotionGatherer<'g, 'w> {
    /// Returns the facts that every verdict needs.
    pub fn first_facts(&self) -> Facts {
        let Screened { screening, .. } = &self.first;
        let mut facts = Facts {
            data: DataKind::Motion,
            count: screening.count(&self.context.data),
            unknowns: self.tolerant.1.free.len(),
            in_sample: false,
            holds_out: !self.held_out.motions.is_empty(),
            chi_square: self.chi_square(self.tolerant.1.squares),
            candidates: self.candidates(&self.first, &self.tolerant),
            impedances: self.impedances(),
            impedances_tried: 0,
            null: self.null(),
            left_out: Vec::new(),
            beside: Vec::new(),
            held_out_loss: Vec::new(),
            closed: Vec::new(),
            log_occam: Vec::new(),
            farthest: Vec::new(),
            fault_in_records: None,
            fault_held_out: None,
            fault_held_out_remains: Vec::new(),
            contradicting_held_out: Vec::new(),
            one_position: Some(Answer { found: None }),
            chain: None,
            exchanged: Some(Vec::new()),
            contradiction: Some(Answer { found: None }),
            mismatch: Some(Answer { found: None }),
        };
        self.add_resemblances(&mut facts.candidates);
        // Which of two that contradict each other is wrong, is open.
        let faulty = self.faulty(self.leading(&facts));
        facts.fault_in_records = fault_of(&faulty).map(|fault| match &faulty[..] {
            [_] => fault,
            _ => FaultFacts { ids: Vec::new(), ..fault },
        });
        facts
    }

    /// Returns squares of a misfit in units of the variance of the noise, corrected for its autocorrelation.
    fn chi_square(&self, squares: f64) -> f64 {
        squares / self.first.screening.variance()
    }

    /// Returns a model and its fit without tolerances; `None` for a free function.
    pub fn model(&self, model: Model) -> Option<&MotionFit> {
        match model {
            Model::Nominal => Some(&self.alone),
            _ => self.candidate(model)?.alone.as_ref(),
        }
    }

    /// Returns the fit of a model beside tolerances.
    fn tolerant(&self, model: Model) -> Option<&MotionFit> {
        match model {
            Model::Nominal => Some(&self.tolerant),
            _ => self.candidate(model)?.tolerant.as_ref(),
        }
    }

    /// Returns the candidate that is the last addition of a model.
    pub fn candidate(&self, model: Model) -> Option<&Candidate> {
        match model {
            Model::Candidate(at) => self.first.candidates.get(at),
            Model::With(search, at) => self.beside.get(search)?.as_ref()?.candidates.get(at),
            _ => None,
        }
    }

    fn candidates(&self, screened: &Screened, before: &MotionFit) -> Vec<CandidateFacts> {
        let of = |candidate: &Candidate| {
            let made = &screened.screening.candidates[candidate.at];
            let hypothesis = made.hypothesis.as_ref();
            let ids = hypothesis.map(|h| h.effects.clone()).unwrap_or_default();
            let id = ids.last().unwrap_or(&made.id).to_string();
            let tolerant = candidate.tolerant.as_ref();
            let released = tolerant.filter(|(h, _)| h.kind == HypothesisKind::Release);
            let library = self.context.effects.iter().find(|effect| effect.id == id);
            CandidateFacts {
                effects: ids.as_slice().to_vec(),
                names: Effect::unrefined(self.context.effects, &ids).as_slice().to_vec(),
                places: hypothesis.map_or_else(Vec::new, |h| places_of(h, self.context.effects)),
                released: released.and_then(|(h, fit)| {
                    let at = *h.added.last()?;
                    Some(frozen_text(&h.machine.parameters[at], fit.values[at]))
                }),
                number: None,
                at_end: Vec::new(),
                resembles: Vec::new(),
                discriminating_test: library.and_then(|effect| effect.discriminating_test.clone()),
                added: tolerant.map_or(0, |(h, _)| h.added.len()),
                chi_square: tolerant.map(|(_, fit)| self.chi_square(fit.squares)),
                gain: tolerant
                    .map_or(0.0, |(_, fit)| self.chi_square(before.1.squares - fit.squares).max(0.0)),
                is_limit: false,
                chi_square_in_detail: None,
                impedances: Some(Vec::new()),
                id,
            }
        };
        screened.candidates.iter().map(of).collect()
    }

    /// Adds to each candidate those that these records cannot tell from it: without an extra measuring point, or
    /// where inertia causes little of the force.
    fn add_resemblances(&self, candidates: &mut [CandidateFacts]) {
        let Context { data, effects, .. } = self.context;
        let lacks_points = !data.motions.iter().any(|m| m.has_extra_points());
        let is_slow = self.context.is_slow(&self.alone);
        let made = &self.first.screening.candidates;
        let counts = |id: &String, all: &[CandidateFacts]| {
            id == CLOCKS
                || all.iter().any(|c| c.id == *id && c.gain > 0.0)
                || made.iter().any(|c| c.unidentifiable && c.id == *id)
        };
        for at in 0..candidates.len() {
            let Some(effect) = effects.iter().find(|e| e.id == candidates[at].id) else { continue };
            let lists = [(&effect.confusable_with, lacks_points), (&effect.confusable_with_slow, is_slow)];
            let all = lists.into_iter().filter(|(_, is_lacking)| *is_lacking).flat_map(|(ids, _)| ids);
            candidates[at].resembles = all.filter(|id| counts(id, candidates)).cloned().collect();
        }
    }

    fn impedances(&self) -> Vec<ImpedanceFacts> {
        let Context { rigid, data, .. } = self.context;
        let (hypothesis, fit) = &self.alone;
        let places = ForceLocations::new(rigid, &hypothesis.machine, &fit.values, &data.motions);
        let (before, _) = self.first.screening.alone(data);
        let of = |screened: &super::candidate::ScreenedFit| {
            let made = &self.first.screening.candidates[screened.candidate];
            let over = made.free?;
            let point = places.of(over, made.column.as_deref());
            let column = made.column.as_ref().map_or(String::new(), |column| format!(" in {column}"));
            let gain = self.chi_square(before - screened.squares).max(0.0);
            Some(ImpedanceFacts {
                interface: format!("{point}, over {}{column}", over.word()),
                shape: over.shape().into(),
                parameters: self.function(made).map_or(0, |function| function.columns.ncols()),
                chi_square: (self.chi_square(self.tolerant.1.squares) - gain).max(0.0),
                gain,
            })
        };
        self.first.functions.iter().filter_map(of).collect()
    }

    fn function(&self, made: &super::candidate::MotionCandidate) -> Option<&FreeFunction> {
        self.functions.iter().find(|f| Some(f.variable) == made.free && f.column == made.column)
    }

    /// Simulates the machine without a missing effect: scales of the reduction of χ² by each effect, its largest
    /// statistics, and the misfit of the machine.
    fn null(&self) -> NullDistribution {
        let Context { data, settings, control, .. } = self.context;
        let Screened { screening, candidates, .. } = &self.first;
        let best = candidates.first().and_then(|candidate| candidate.screened.as_ref());
        let draws: Vec<NullDraw> =
            screening.null_simulations(data, best, settings.draws, settings.seed, control);
        let gain = |draw: &NullDraw, at: usize| self.chi_square(draw.gains[at]);
        let fitted: Vec<(usize, String, usize)> = candidates
            .iter()
            .filter_map(|candidate| {
                let hypothesis = screening.candidates[candidate.at].hypothesis.as_ref()?;
                Some((candidate.at, hypothesis.effects.last()?.to_string(), hypothesis.added.len()))
            })
            .collect();
        let scale = |at: usize, added: usize| {
            let mean = draws.iter().map(|draw| gain(draw, at)).sum::<f64>() / draws.len().max(1) as f64;
            mean.max(least_scale(DataKind::Motion, added))
        };
        let scales: Vec<(usize, String, f64)> =
            fitted.into_iter().map(|(at, id, added)| (at, id, scale(at, added))).collect();
        let ratio =
            |draw: &NullDraw| scales.iter().map(|(at, _, scale)| gain(draw, *at) / scale).fold(0.0, f64::max);
        let count = screening.count(data);
        let sorted = |mut all: Vec<f64>| {
            all.sort_by(f64::total_cmp);
            all
        };
        NullDistribution {
            largest: sorted(draws.iter().map(ratio).collect()),
            fitted: Vec::new(),
            misfit: sorted(draws.iter().map(|draw| self.chi_square(draw.squares) / count).collect()),
            scales: scales.into_iter().map(|(_, id, scale)| (id, scale)).collect(),
            seen_from: Vec::new(),
        }
    }

    /// Returns the model beside which faults of records show: the best fitting candidate where it is significant.
    fn leading(&self, facts: &Facts) -> Model {
        let policy = Policy::of(DataKind::Motion);
        let is_significant = |best: &CandidateFacts| {
            let excess = facts.excess(best.chi_square());
            let statistic = best.gain / facts.null.scale(&best.id) / excess;
            facts.null.p_value(statistic) < policy.alpha && best.gain >= policy.least_share * facts.chi_square
        };
        match facts.candidates.first().filter(|best| is_significant(best)) {
            Some(_) => Model::Candidate(0),
            None => Model::Nominal,
        }
    }

    /// Predicts records by a fit.
    pub fn parts(&self, (hypothesis, fit): &MotionFit, motions: &[&MotionSignal]) -> Vec<MotionPart> {
        motions.iter().map(|m| part(&self.context.rigid, &hypothesis.machine, &fit.values, m)).collect()
    }

    /// Returns delays and factors of the fitted and of the held-out records relative to a model.
    pub fn shifts(&self, model: Model) -> [Vec<RecordShift>; 2] {
        let (hypothesis, fit) = self.model(model).unwrap_or(&self.alone);
        let machine = (&self.context.rigid, &hypothesis.machine, &fit.values[..]);
        let motions = &self.context.data.motions;
        let covariance = Covariance::new(fit, &hypothesis.machine, motions);
        [shifts(machine, motions, None), shifts(machine, &self.held_out.motions, covariance.as_ref())]
    }

    /// Returns the longest step of the fitted records (s).
    fn step_s(&self) -> f64 {
        self.context.data.motions.iter().map(|m| m.step_s).fold(0.0, f64::max)
    }

    /// Returns held-out records that contradict the fitted ones, by the shifts of both.
    pub fn contradictions(&self, [fitted, others]: &[Vec<RecordShift>; 2]) -> Vec<Contradiction> {
        contradictions(fitted, others, self.step_s())
    }

    /// Returns fitted records that contradict the others beside a model. An effect that delays the force of all
    /// records must not hide a single record with a delayed force.
    fn faulty(&self, model: Model) -> Vec<Contradiction> {
        let motions = &self.context.data.motions;
        let (hypothesis, fit) = self.model(model).unwrap_or(&self.alone);
        let values = without_added_delay(&(hypothesis.clone(), fit.clone()));
        let values = values.as_ref().unwrap_or(&fit.values);
        let found = shifts((&self.context.rigid, &hypothesis.machine, values), motions, None);
        faulty(&found, &self.parts(&self.alone, motions), self.step_s())
    }

    /// Returns squared errors at left-out parts, with the penalty of the nuisance parameters.
    fn left_out(&self, model: Model) -> Option<f64> {
        let squares = match model {
            Model::Nominal => self.first.screening.alone(&self.context.data).1,
            Model::Impedance(at) => self.first.functions.get(at)?.left_out,
            _ => self.candidate(model)?.screened.as_ref()?.left_out,
        };
        Some(self.chi_square(squares)).filter(|loss| loss.is_finite())
    }

    /// Returns what a model and the tolerances leave of the held-out records, squared.
    fn held_out_loss(&self, model: Model) -> Option<f64> {
        let mut left = match model {
            Model::Impedance(at) => self.left_by(&self.with_function(at)?),
            _ => {
                let (hypothesis, fit) = self.tolerant(model)?;
                let predicted =
                    prediction(&self.context.rigid, &hypothesis.machine, &fit.values, &self.held_out.motions);
                recorded(&self.held_out.motions) - predicted
            }
        };
        self.tolerances[1].apply(&mut left);
        Some(self.chi_square(left.norm_squared()))
    }

    /// Fits a free function together with the machine's free parameters, without tolerances.
    fn with_function(&self, at: usize) -> Option<(&FreeFunction, LinearFit)> {
        let function =
            self.function(&self.first.screening.candidates[self.first.functions.get(at)?.candidate])?;
        let here = self.own_columns(&self.context.data);
        let (own, added) = (here.derivatives.ncols(), function.columns.ncols());
        let penalty = [vec![0.0; own], vec![function.ridge(); added]].concat();
        let columns = side_by_side(&[&here.derivatives, &function.columns]);
        let left = &self.context.data.y - here.prediction;
        let solved = LinearFit::penalised(&columns, &penalty, &left, super::design::INDEPENDENT)?;
        Some((function, solved))
    }

    fn own_columns(&self, data: &MotionData<'_>) -> LinearForce {
        let (hypothesis, fit) = &self.alone;
        LinearForce::new(&self.context.rigid, &hypothesis.machine, &fit.values, &fit.free, &data.motions)
    }

    /// Returns what a fitted free function leaves of the held-out records.
    fn left_by(&self, (function, solved): &(&FreeFunction, LinearFit)) -> DVector<f64> {
        let there = self.own_columns(&self.held_out);
        let more = side_by_side(&[&there.derivatives, &function.columns_on(&self.held_out)]);
        &self.held_out.y - there.prediction - more * &solved.coefficients
    }

    /// Returns the share of the squared misfit of the machine, without tolerances, that a free function takes away,
    /// and the gap of the held-out records with it. Beside tolerances of the same form it would show nothing.
    pub fn figures_of_function(&self, at: usize) -> (f64, Option<f64>) {
        let Some(with) = self.with_function(at) else { return (0.0, None) };
        let recorded = self.held_out.y.norm();
        let gap = (recorded > 0.0).then(|| self.left_by(&with).norm() / recorded);
        (1.0 - with.1.residual.norm_squared() / self.alone.1.squares, gap)
    }

    /// Returns the share of the squared held-out gap above the noise floor that a model closes.
    fn closed(&self, model: Model) -> Option<f64> {
        let motions = &self.held_out.motions;
        let before = self.parts(&self.alone, motions);
        let after = self.parts(self.model(model)?, motions);
        let floor = floor_of(&noise_of(&after, motions), &after)?;
        share_closed(gap_of(&before)?, gap_of(&after)?, floor)
    }

    /// Returns the tolerance that a model moves farthest.
    fn farthest(&self, model: Model) -> Option<Farthest> {
        self.farthest_of(self.tolerant(model)?)
    }

    fn farthest_of(&self, (hypothesis, fit): &MotionFit) -> Option<Farthest> {
        let data = &self.context.data;
        // Force and settings of a loop from which an encoder is estimated are too uncertain.
        if data.is_identifiable() {
            return None;
        }
        let left = &data.y - prediction(&self.context.rigid, &hypothesis.machine, &fit.values, &data.motions);
        let sizes = self.tolerances[0].sizes(&left);
        let names = self.first.screening.nuisances.iter().map(|nuisance| nuisance.name.clone());
        let farthest = names.zip(sizes.iter()).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        Some(Farthest { name: farthest.0, deviation: *farthest.1 })
    }

    /// Fits two clocks of all records; `None` where something else is missing besides.
    fn two_clocks(&self) -> Option<ChainFacts> {
        let TwoClocks { shifted, fault } = TwoClocks::new(self.context, &self.tolerant, &self.tolerances[0])?;
        let implausible = Policy::of(DataKind::Motion).implausible;
        let is_plausible = self.farthest_of(&shifted).is_none_or(|far| far.deviation.abs() <= implausible);
        let chi_square = self.chi_square(shifted.1.squares);
        is_plausible.then(|| ChainFacts { id: CLOCKS.into(), fault, parameters: 1, chi_square })
    }

    fn each<T>(&self, known: &[Of<T>], models: &[Model], figure: impl Fn(Model) -> T) -> Vec<Of<T>> {
        let missing = models.iter().filter(|model| of(known, **model).is_none());
        missing.map(|model| Of { model: *model, value: figure(*model) }).collect()
    }
}

impl Answers for MotionGatherer<'_, '_> {
    type Error = Infallible;

    fn answer(&mut self, need: &Need, facts: &mut Facts) -> Result<(), Infallible> {
        match need {
            Need::LeftOut(models) => {
                let found = self.each(&facts.left_out, models, |model| self.left_out(model));
                facts.left_out.extend(found);
            }
            Need::HeldOut(models) => {
                let loss = |model| self.held_out_loss(model).unwrap_or(f64::MAX);
                let found = self.each(&facts.held_out_loss, models, loss);
                facts.held_out_loss.extend(found);
            }
            Need::Closed(model) => {
                let found = self.each(&facts.closed, &[*model], |model| self.closed(model));
                facts.closed.extend(found);
            }
            Need::Farthest(model) => {
                let found = self.each(&facts.farthest, &[*model], |model| self.farthest(model));
                facts.farthest.extend(found);
            }
            Need::ContradictingHeldOut(model) => {
                let shifts = self.shifts(*model);
                let all = self.contradictions(&shifts);
                let before = self.parts(&self.alone, &self.held_out.motions);
                let beyond = beyond_effects(&all, &shifts[1], &before);
                let [all, beyond] = [all, beyond].map(|found| match found.is_empty() {
                    true => outlying(&shifts).into_iter().collect(),
                    false => found,
                });
                let value = ContradictingHeldOut { fault: fault_of(&all), beyond_effects: fault_of(&beyond) };
                facts.contradicting_held_out.push(Of { model: *model, value });
            }
            Need::Chain => facts.chain = Some(Answer { found: self.two_clocks() }),
            Need::Beside(model) => self.gather_beside(*model, facts),
            Need::Detail(at) => {
                facts.candidates[*at].chi_square_in_detail = Some(facts.candidates[*at].chi_square());
            }
            // Answered from the start: these records show no such fault, or are corrected for it. Occam factors
            // need ranges, which linear parameters do not have.
            Need::Occam(_)
            | Need::FaultHeldOut(_)
            | Need::Impedances(..)
            | Need::OnePosition
            | Need::Exchanged
            | Need::Contradiction
            | Need::Mismatch => {}
        }
        Ok(())
    }
}

impl MotionGatherer<'_, '_> {
    fn gather_beside(&mut self, model: Model, facts: &mut Facts) {
        let tolerant = self.tolerant(model).unwrap_or(&self.tolerant).clone();
        let alone = self.model(model).unwrap_or(&self.alone).clone();
        let screening = if self.context.control.stopped() { None } else { self.context.screening(&alone) };
        let found = screening.map(|screening| self.context.screened(screening, &alone, &self.tolerances[0]));
        let candidates = found.as_ref().map_or_else(Vec::new, |found| self.candidates(found, &tolerant));
        let chi_square = self.chi_square(tolerant.1.squares);
        facts.beside.push(Beside { of: model, chi_square, is_deeper: false, candidates });
        self.beside.push(found);
    }
}

/// Returns the fault that contradictions state.
fn fault_of(records: &[Contradiction]) -> Option<FaultFacts> {
    let names = records.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(" or ");
    (!records.is_empty()).then(|| FaultFacts {
        ids: records.iter().flat_map(|record| record.faults.iter().cloned()).collect(),
        reason: records.iter().map(|f| f.description.clone()).collect::<Vec<_>>().join("; "),
        next_measurement: format!(
            "record {names} again with force and position on one clock; exclude it until then"
        ),
        is_insufficient: false,
    })
}

/// Returns the values of a fit without the delay of the force that effects add. `None` where none does.
fn without_added_delay((hypothesis, fit): &MotionFit) -> Option<ParameterValues> {
    let machine = &hypothesis.machine;
    let of_drive = machine.drive.as_ref()?.delay_s.depends_on();
    let delays = of_drive.chain(machine.chain.delay.depends_on()).filter(|i| hypothesis.added.contains(i));
    let mut values = fit.values.clone();
    let mut delayed = false;
    for index in delays {
        let parameter = &machine.parameters[index];
        values[index] = 0.0_f64.clamp(parameter.lower, parameter.upper);
        delayed = true;
    }
    delayed.then_some(values)
}
