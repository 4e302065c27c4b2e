//! Gathering of facts: fits and simulations answer what rules ask for.

use rayon::prelude::*;

use super::beside::beside;
use super::case::Need;
use super::cross_validation::cross_validation;
use super::data_fault::{Contradiction, Fault, contradiction, exchanged, held_out_fault};
use super::evidence::{Domain, PartialGap, closed};
use super::facts::{
    Answer, Beside, CandidateFacts, ChainFacts, ContradictionFacts, ExchangedFacts, Facts, ImpedanceFacts,
    Model, Of, Remark, of,
};
use super::fit::{Ablation, Fitted, Fitter, coordinates_of, values_of};
use super::held_out_loss::held_out_loss;
use super::hypothesis::{Hypothesis, HypothesisKind, interfaces};
use super::judgement::Answers;
use super::location::places_of;
use super::measuring_chain::{ChainCandidate, fault_of_all};
use super::nominal_refit::NominalRefit;
use super::null_distribution::NullDistribution;
use super::one_machine::{farthest, mismatch};
use super::one_position::one_position;
use super::policy::{LOCATIONS, Policy};
use super::ranking::Ranking;
use super::screening::{Candidate, Screening};
use super::search::{Effort, search};
use super::verdict::frozen_text;
use super::wrong_number::{ends, number_text};
use identification::objective::ObjectiveError;
use long_work::Control;
use machine::{Effect, Machine};
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;

/// What answers questions: data, machine, and what was fitted so far.
pub(super) struct Gatherer<'g, 's> {
    pub fitter: &'g Fitter<'s>,
    pub held_out: &'g HoldOutSet<'s>,
    pub machine: &'g Machine,
    pub effects: &'g [Effect],
    /// Those of them that are stated numbers.
    pub numbers: &'g [Effect],
    pub seed: u64,
    pub control: &'g Control,
    /// Fits of the nominal machine and of the candidates.
    pub screening: Screening,
    /// Fits of generic impedances.
    pub located: Vec<Candidate>,
    /// Searches beside chosen models, as the facts have them.
    pub beside: Vec<Screening>,
    /// A search beside the best candidate that was made before rules asked for it, with its index.
    pub made: Option<(usize, Screening)>,
    /// Gaps of the held-out data with the nominal machine.
    pub gaps: Vec<PartialGap>,
    /// Fault of a held-out record that the nominal machine leaves.
    pub fault_held_out: Option<Fault>,
    /// The machine as described.
    pub refit: NominalRefit<'g, 's>,
    /// Fault of the chain of all records, and record that contradicts the others, where they were sought with
    /// the same fit of the nominal machine.
    pub early: (Option<ChainCandidate>, Option<Option<Contradiction>>),
}

/// A model and its fit.
type Fit<'m> = (&'m Hypothesis, &'m Fitted);

/// Returns a loss that a document can hold: the largest number where none can be computed.
fn finite(loss: f64) -> f64 {
    if loss.is_finite() { loss } else { f64::MAX }
}

impl Gatherer<'_, '_> {
    /// Returns the facts that every verdict needs.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn first_facts(
        &self,
        fault_in_records: Option<Fault>,
        null: NullDistribution,
    ) -> Result<Facts, ObjectiveError> {
        let Screening { nominal, base, candidates } = &self.screening;
        let objective = self.fitter.objective(nominal)?;
        let set = self.fitter.fit.set();
        Ok(Facts {
            data: self.fitter.domain.kind(),
            count: objective.observations() as f64,
            unknowns: objective.unknowns(nominal),
            in_sample: self.fitter.lacks(Ablation::InSample),
            holds_out: match self.fitter.domain {
                Domain::Frf(_) => !self.held_out.frfs().is_empty(),
                Domain::Modes(_) => !self.held_out.positions().is_empty(),
            },
            chi_square: base.chi_square,
            candidates: candidates.iter().map(|candidate| self.candidate_facts(candidate)).collect(),
            impedances: impedance_facts(&self.located),
            impedances_tried: interfaces(nominal).len(),
            null,
            left_out: Vec::new(),
            beside: Vec::new(),
            held_out_loss: Vec::new(),
            closed: Vec::new(),
            log_occam: Vec::new(),
            farthest: Vec::new(),
            fault_in_records: fault_in_records.map(|fault| fault.facts(set)),
            fault_held_out: self.fault_held_out.as_ref().map(|fault| fault.facts(set)),
            fault_held_out_remains: Vec::new(),
            contradicting_held_out: Vec::new(),
            one_position: None,
            chain: None,
            exchanged: None,
            contradiction: None,
            mismatch: None,
        })
    }

    /// Looks for what is missing beside the best candidate where it leaves much: the search may find a deeper
    /// minimum of itself.
    ///
    /// # Errors  as [`Fitter::objective`].
    pub fn deepen_best(&mut self, facts: &mut Facts, policy: &Policy) -> Result<(), ObjectiveError> {
        let Some(best) = Ranking::of(facts, policy).tried.first().copied() else { return Ok(()) };
        if facts.excess(facts.candidates[best.at].chi_square()) <= policy.continue_from {
            return Ok(());
        }
        let Some(chosen) = self.screening.candidates[best.at].fitted.clone() else { return Ok(()) };
        let found = self.search_beside((&chosen.0, &chosen.1))?;
        let again = Ok(found.base.clone());
        let deeper = Candidate::of(chosen.0, again, &self.screening.base, self.fitter.band_hz());
        facts.candidates[best.at] = self.candidate_facts(&deeper);
        self.screening.candidates[best.at] = deeper;
        self.made = Some((best.at, found));
        Ok(())
    }

    fn search_beside(&self, chosen: Fit<'_>) -> Result<Screening, ObjectiveError> {
        beside(self.fitter, self.machine, self.effects, chosen, self.seed, self.control)
    }

    fn candidate_facts(&self, candidate: &Candidate) -> CandidateFacts {
        let hypothesis = candidate.fitted.as_ref().map(|(hypothesis, _)| hypothesis);
        let ids = hypothesis.map(|h| h.effects.clone()).unwrap_or_default();
        let id = ids.last().unwrap_or(&candidate.id).to_string();
        let released = candidate.fitted.as_ref().filter(|f| f.0.kind == HypothesisKind::Release);
        let library = self.effects.iter().find(|effect| effect.id == id);
        let number = self.numbers.iter().find(|number| number.id == id).zip(candidate.fitted.as_ref());
        let places = candidate.fitted.as_ref().map(|(hypothesis, _)| places_of(hypothesis, self.effects));
        CandidateFacts {
            effects: ids.as_slice().to_vec(),
            names: Effect::unrefined(self.effects, &ids).as_slice().to_vec(),
            places: places.unwrap_or_default(),
            released: released.map(|(h, fitted)| {
                let at = h.added[0];
                frozen_text(&h.machine.parameters[at], values_of(h, fitted)[at])
            }),
            number: number.map(|(number, (hypothesis, fitted))| number_text(number, hypothesis, fitted)),
            at_end: candidate.fitted.as_ref().map_or_else(Vec::new, |(hypothesis, fitted)| {
                let parameters = &hypothesis.machine.parameters;
                ends(&hypothesis.machine, &fitted.units)
                    .into_iter()
                    .map(|at| parameters[at].id.clone())
                    .collect()
            }),
            resembles: Vec::new(),
            discriminating_test: library.and_then(|effect| effect.discriminating_test.clone()),
            added: hypothesis.map_or(0, |h| h.added.len()),
            chi_square: candidate.fitted.as_ref().map(|(_, fitted)| fitted.chi_square),
            gain: candidate.gain,
            is_limit: candidate.is_limit,
            chi_square_in_detail: None,
            impedances: None,
            id,
        }
    }

    /// Returns a model and its fit; the order of candidates is that of the facts.
    pub fn model(&self, model: Model) -> Option<(Hypothesis, Fitted)> {
        let of = |candidate: &Candidate| candidate.fitted.clone();
        match model {
            Model::Nominal => Some((self.screening.nominal.clone(), self.screening.base.clone())),
            Model::Candidate(at) => self.screening.candidates.get(at).and_then(of),
            Model::Impedance(at) => self.located.get(at).and_then(of),
            Model::Deeper(search) => {
                let found = self.beside.get(search)?;
                Some((found.nominal.clone(), found.base.clone()))
            }
            Model::With(search, at) => self.beside.get(search)?.candidates.get(at).and_then(of),
        }
    }

    /// Computes a figure of each model that does not have it yet.
    fn each<T: Send>(
        &self,
        (known, models): (&[Of<T>], &[Model]),
        figure: impl Fn(Fit<'_>) -> Result<T, ObjectiveError> + Sync,
    ) -> Result<Vec<Of<T>>, ObjectiveError> {
        let missing: Vec<(Model, (Hypothesis, Fitted))> = models
            .iter()
            .filter(|model| of(known, **model).is_none())
            .filter_map(|model| Some((*model, self.model(*model)?)))
            .collect();
        let of = |(model, (hypothesis, fitted)): &(Model, (Hypothesis, Fitted))| {
            Ok::<_, ObjectiveError>(Of { model: *model, value: figure((hypothesis, fitted))? })
        };
        missing.par_iter().map(of).or_first_error()
    }

    fn gather_beside(&mut self, model: Model, facts: &mut Facts) -> Result<(), ObjectiveError> {
        let Some(chosen) = self.model(model) else { return Ok(()) };
        let found = match self.made.take() {
            Some((at, found)) if model == Model::Candidate(at) => found,
            _ => self.search_beside((&chosen.0, &chosen.1))?,
        };
        facts.beside.push(Beside {
            of: model,
            chi_square: found.base.chi_square,
            is_deeper: found.base != chosen.1,
            candidates: found.candidates.iter().map(|candidate| self.candidate_facts(candidate)).collect(),
        });
        self.beside.push(found);
        Ok(())
    }

    /// Fits generic impedances beside a chosen model that have no more parameters than an addition to it.
    fn impedances_beside(&self, search_at: usize, at: usize) -> Result<Vec<ImpedanceFacts>, ObjectiveError> {
        let Screening { nominal, base, candidates } = &self.beside[search_at];
        let added = candidates[at].fitted.as_ref().map_or(0, |(hypothesis, _)| hypothesis.added.len());
        let effort =
            Effort { located: (LOCATIONS.0, added - nominal.added.len()), searches: 1, seed: self.seed };
        let none = (Vec::new(), Vec::new());
        let (_, found) =
            search(self.fitter, nominal.clone(), vec![base.clone()], none, effort, self.control)?;
        Ok(impedance_facts(&found))
    }

    /// Returns the least χ² of a candidate in the detail that the library has for it.
    fn chi_square_in_detail(&self, at: usize) -> Result<f64, ObjectiveError> {
        let Some((hypothesis, fitted)) = &self.screening.candidates[at].fitted else { return Ok(f64::MAX) };
        let refines = |e: &&Effect| e.refines.as_ref().is_some_and(|id| hypothesis.effects.contains(id));
        let detail: Vec<Effect> = self.effects.iter().filter(refines).cloned().collect();
        if detail.is_empty() {
            return Ok(fitted.chi_square);
        }
        let fit = (hypothesis, fitted);
        let found = beside(self.fitter, self.machine, &detail, fit, self.seed, self.control)?;
        Ok(found.candidates.iter().map(Candidate::chi_square).fold(found.base.chi_square, f64::min))
    }

    fn gather_fault(&self, need: &Need, facts: &mut Facts) -> Result<(), ObjectiveError> {
        let Gatherer { fitter, held_out, control, .. } = *self;
        let Screening { nominal, base, .. } = &self.screening;
        let set = fitter.fit.set();
        match need {
            Need::FaultHeldOut(model) => {
                let of = |(hypothesis, fitted): (Hypothesis, Fitted)| {
                    let gaps = fitter.gaps(&hypothesis, &fitted, held_out)?;
                    held_out_fault(fitter, held_out, (&hypothesis, &fitted), &gaps)
                };
                let with = self.model(*model).map(of).transpose()?;
                let value = with.is_none_or(|with| with == self.fault_held_out);
                facts.fault_held_out_remains.push(Of { model: *model, value });
            }
            Need::OnePosition => {
                let found = one_position(fitter, held_out, nominal, self.seed, control)?;
                facts.one_position = Some(Answer { found });
            }
            Need::Chain => {
                let found = match self.early.0 {
                    Some(found) => Some(found),
                    None => fault_of_all(fitter, (nominal, base), control)?,
                };
                // Corrected records that cannot be compared with the model are no explanation.
                let found = found.filter(|found| found.chi_square.is_finite()).map(|found| ChainFacts {
                    id: found.fault.id().into(),
                    fault: Fault::OfAll(found).facts(set),
                    parameters: found.fault.parameters(),
                    chi_square: found.chi_square,
                });
                facts.chain = Some(Answer { found });
            }
            Need::Exchanged => {
                let found = exchanged(fitter, held_out, (nominal, base), control)?.into_iter();
                let of = |(fault, chi_square): (Fault, f64)| ExchangedFacts {
                    fault: fault.facts(set),
                    chi_square,
                };
                facts.exchanged = Some(found.map(of).collect());
            }
            Need::Contradiction => {
                let sought = match &self.early.1 {
                    Some(found) => found.clone(),
                    None => contradiction(fitter, (nominal, base), control)?,
                };
                let agrees =
                    |misfit: f64| facts.null.excess(misfit) <= Policy::of(fitter.domain.kind()).agrees;
                let of = |found: Contradiction| {
                    // Whose others do not agree either is no fault: its cause is not sought.
                    let fault = match agrees(found.rest) {
                        true => found.fault(fitter, nominal, agrees, control)?,
                        false => Fault::Contradicts(found.records),
                    };
                    Ok::<_, ObjectiveError>(ContradictionFacts { fault: fault.facts(set), rest: found.rest })
                };
                let found = sought.map(of).transpose()?;
                facts.contradiction = Some(Answer { found });
            }
            _ => {
                let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
                let found = mismatch(set, &all).map(|found| {
                    let (reason, next) = found.text();
                    Remark { reason, next_measurement: next.into() }
                });
                facts.mismatch = Some(Answer { found });
            }
        }
        Ok(())
    }
}

impl Answers for Gatherer<'_, '_> {
    type Error = ObjectiveError;

    fn answer(&mut self, need: &Need, facts: &mut Facts) -> Result<(), ObjectiveError> {
        let Gatherer { fitter, held_out, control, .. } = *self;
        match need {
            Need::LeftOut(models) => {
                let of = |(hypothesis, fitted): Fit<'_>| {
                    Ok(cross_validation(fitter, hypothesis, fitted, control).ok().map(finite))
                };
                let found = self.each((&facts.left_out, models), of)?;
                facts.left_out.extend(found);
            }
            Need::HeldOut(models) => {
                let of = |(hypothesis, fitted): Fit<'_>| {
                    Ok(finite(held_out_loss(fitter, held_out, hypothesis, fitted, control)?))
                };
                let found = self.each((&facts.held_out_loss, models), of)?;
                facts.held_out_loss.extend(found);
                // What was stopped is no figure.
                facts.holds_out &= !control.stopped();
            }
            Need::Closed(model) => {
                let before = self.refit.gaps(self.refit.described(), held_out)?;
                let of = |fit: Fit<'_>| {
                    let Some(with) = self.refit.of(fit, control)? else { return Ok(None) };
                    Ok(closed(&before, &self.refit.gaps(&with, held_out)?))
                };
                let found = self.each((&facts.closed, &[*model]), of)?;
                facts.closed.extend(found);
            }
            Need::Occam(models) => {
                let found = self.each((&facts.log_occam, models), |fit| log_occam(fitter, fit))?;
                facts.log_occam.extend(found);
            }
            Need::Farthest(model) => {
                let found = self.each((&facts.farthest, &[*model]), |fit| Ok(farthest(fit)))?;
                facts.farthest.extend(found);
            }
            Need::Beside(model) => self.gather_beside(*model, facts)?,
            Need::Impedances(search, at) => {
                let found = self.impedances_beside(*search, *at)?;
                facts.beside[*search].candidates[*at].impedances = Some(found);
            }
            Need::Detail(at) => {
                facts.candidates[*at].chi_square_in_detail = Some(self.chi_square_in_detail(*at)?);
            }
            fault => self.gather_fault(fault, facts)?,
        }
        Ok(())
    }
}

/// Computes the natural logarithm of the share of the parameters' ranges that the data leave to a model: its Occam
/// factor. Coordinates are those of the unit cube, with the variance of a uniform law.
///
/// # Source  MacKay, Information Theory, Inference, and Learning Algorithms, section 28.1, by Laplace's method.
fn log_occam(fitter: &Fitter<'_>, (hypothesis, fitted): Fit<'_>) -> Result<f64, ObjectiveError> {
    const VARIANCE: f64 = 1.0 / 12.0;
    let objective = fitter.objective(hypothesis)?;
    let place = coordinates_of(&objective, fitted);
    let information = objective.squares(|squares| squares.normal(&place).information);
    let of = |eigenvalue: &f64| (eigenvalue.max(0.0) * VARIANCE).ln_1p();
    Ok(-0.5 * information.symmetric_eigenvalues().iter().map(of).sum::<f64>())
}

/// Returns the facts of fitted generic impedances.
fn impedance_facts(located: &[Candidate]) -> Vec<ImpedanceFacts> {
    let of = |candidate: &Candidate| {
        let (hypothesis, fitted) = candidate.fitted.as_ref()?;
        let HypothesisKind::Interface { interface, shape } = &hypothesis.kind else { return None };
        Some(ImpedanceFacts {
            interface: interface.clone(),
            shape: shape.word().into(),
            parameters: hypothesis.added.len(),
            chi_square: fitted.chi_square,
            gain: candidate.gain,
        })
    };
    located.iter().filter_map(of).collect()
}
