//! Diagnosis of FRFs or modes: fits, facts, verdict, and the gap before and after.

use rayon::prelude::*;

use super::data_fault::{Contradiction, Fault, contradiction, held_out_fault};
use super::evidence::{Domain, DomainObjective, PartialGap};
use super::facts::Facts;
use super::fit::{Ablation, Fitted, Fitter};
use super::gather::Gatherer;
use super::hypothesis::Hypothesis;
use super::interval::intervals;
use super::judgement::{Answers, Judgement};
use super::location::Location;
use super::measuring_chain::{ChainCandidate, fault_of_all};
use super::nominal_refit::NominalRefit;
use super::null_distribution::{NullDistribution, simulate};
use super::policy::{LOCATIONS, Policy};
use super::record_checks::fault_of_records;
use super::screening::{Candidate, hypotheses, nominal, nominal_fits};
use super::search::{Effort, large_misfit, search};
use super::wrong_number::wrong_numbers;
use identification::ToleranceEstimate;
use identification::objective::ObjectiveError;
use long_work::Control;
use machine::{Effect, Machine};
use measurement::HoldOutSet;
use numeric::parallel::OrFirstError;

/// Result of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// Compared data: FRFs or modes.
    pub domain: Domain,
    /// The nominal machine, for FRFs with its nuisance parameters, and its fit.
    pub nominal: (Hypothesis, Fitted),
    /// The machine as described and its fit.
    pub described: (Hypothesis, Fitted),
    /// Gaps of the fitted data, predicted by the machine as described.
    pub fit: Vec<PartialGap>,
    /// Gaps of the held-out data, predicted by the machine as described.
    pub held_out: Vec<PartialGap>,
    /// Generic impedances at interfaces, best first.
    pub located: Vec<TriedLocation>,
    /// Candidates, best first; untested ones last.
    pub tried: Vec<TriedEffect>,
    /// Everything on which the verdict rests.
    pub facts: Facts,
    /// The verdict, and the rules that led to it.
    pub judgement: Judgement,
    /// Excess of the nominal fit: its misfit over the median of null simulations.
    pub excess: f64,
    /// Excess of the chosen model.
    pub chosen_excess: f64,
    /// The chosen model: with the named effect or combination, else the nominal machine.
    pub chosen: (Hypothesis, Fitted),
    /// The machine as described with the effects of the chosen model, and its fit.
    pub explained: (Hypothesis, Fitted),
    /// Gaps of the held-out data, predicted by `explained`.
    pub chosen_held_out: Vec<PartialGap>,
    /// Gaps of the held-out data with nuisance parameters fitted: nominal and chosen model. `None` where
    /// nuisance parameters are not fitted.
    pub gaps_with_nuisances: Option<[Vec<PartialGap>; 2]>,
    /// Location to which the verdict refers.
    pub location: Location,
    /// Tolerances estimated with the chosen model; empty where they are not fitted.
    pub tolerances: Vec<ToleranceEstimate>,
    /// Candidates that are stated numbers.
    pub numbers: Vec<Effect>,
    /// 95 % intervals of the parameters that the chosen model adds, by id; empty where none is named.
    pub intervals: Vec<(String, (f64, f64))>,
    /// Whether the diagnosis ran to its end.
    pub complete: bool,
}

/// A candidate effect with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedEffect {
    /// The candidate.
    pub candidate: Candidate,
    /// Reduction of χ² over its scale in null simulations and over the excess that the candidate leaves.
    pub statistic: f64,
    /// Share of null simulations whose largest statistic over all candidates is at least as large.
    pub p_value: f64,
    /// Gaps of the held-out data, predicted by the machine as described with the candidate.
    pub held_out: Vec<PartialGap>,
}

/// A generic impedance at an interface with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedLocation {
    /// The candidate.
    pub candidate: Candidate,
    /// Gaps of the held-out data, predicted with it.
    pub held_out: Vec<PartialGap>,
}

/// Settings of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnosisSettings {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of null simulations whose fits are made in full.
    pub draws: usize,
    /// A null distribution of the same machine and layout from an earlier diagnosis.
    pub null: Option<NullDistribution>,
    /// Whether to gather what other rules may ask for, too.
    pub all_facts: bool,
    /// Effects of the library for these data, beside which stated numbers are candidates; empty where the given
    /// effects alone are.
    pub library: Vec<Effect>,
}

/// Largest number of global searches for a candidate that explains a large discrepancy.
const SEARCHES: usize = 4;

/// Faults that are sought before effects: where the records themselves, or a fault of their chain that no
/// effect imitates, account for all that is missing, effects need no search.
struct EarlyFaults {
    in_records: Option<Fault>,
    of_all: Option<ChainCandidate>,
    contradiction: Option<Option<Contradiction>>,
    explain_all: bool,
}

impl EarlyFaults {
    fn of(
        fitter: &Fitter<'_>,
        held_out: &HoldOutSet<'_>,
        (start, base, objective): (&Hypothesis, &Fitted, &DomainObjective<'_>),
        control: &Control,
    ) -> Result<Self, ObjectiveError> {
        let (count, large) = (objective.observations() as f64, large_misfit(objective));
        let in_records = fault_of_records(fitter, held_out);
        let is_open = in_records.is_none() && base.chi_square > large;
        let of_all = if is_open { fault_of_all(fitter, (start, base), control)? } else { None };
        let is_whole = |found: ChainCandidate| !found.fault.is_gradual() && found.chi_square <= large;
        let is_chain = in_records.is_some() || of_all.is_some_and(is_whole);
        let contradiction = match is_open && !is_chain {
            true => Some(contradiction(fitter, (start, base), control)?),
            false => None,
        };
        let is_corrected =
            |found: &Contradiction| found.rest * count <= large && found.is_corrected_wholly(fitter, start);
        let explain_all = is_chain || contradiction.iter().flatten().any(is_corrected);
        Ok(EarlyFaults { in_records, of_all, contradiction, explain_all })
    }
}

/// Diagnoses FRFs or modes. Of several effects with one id the one for FRFs is used ([`Effect::for_data`]).
///
/// # Errors  as [`identification::objective::FrfObjective::new`] and
///   [`identification::objective::ModeObjective::new`].
pub fn diagnose(
    machine: &Machine,
    effects: &[Effect],
    fitter: &Fitter<'_>,
    held_out: &HoldOutSet<'_>,
    settings: &DiagnosisSettings,
    control: &Control,
) -> Result<Diagnosis, ObjectiveError> {
    let machine = &machine.without_guide_tolerance();
    let policy = Policy::of(fitter.domain.kind());
    control.begin("1/6 fit of the nominal machine");
    let start = nominal(machine, fitter)?;
    let bases = nominal_fits(fitter, &start, settings.seed, control)?;
    let numbers = match fitter.has_nuisances() && !settings.library.is_empty() {
        true => wrong_numbers(&start, &bases[0], &settings.library),
        false => Vec::new(),
    };
    let effects = &[effects, &numbers].concat()[..];
    let candidates = hypotheses(fitter, machine, &start, effects, &fitter.frozen);
    control.begin(&format!("2/6 {} candidates", candidates.0.len()));
    let objective = fitter.objective(&start)?;
    let early = EarlyFaults::of(fitter, held_out, (&start, &bases[0], &objective), control)?;
    let effort = Effort {
        located: LOCATIONS,
        searches: if early.explain_all { 0 } else { SEARCHES },
        seed: settings.seed,
    };
    let first = bases[0].chi_square;
    // Generic impedances locate the discrepancy. They also show whether an effect of the library fits as well
    // as any impedance can.
    let (screening, located) = search(fitter, start.clone(), bases, candidates, effort, control)?;
    control.begin("3/6 null simulations");
    let fitted: Vec<(&Hypothesis, &Fitted)> =
        screening.candidates.iter().filter_map(|c| c.fitted.as_ref().map(|(h, f)| (h, f))).collect();
    let null = match &settings.null {
        Some(known) => known.clone(),
        None if fitter.lacks(Ablation::ChiSquare) => NullDistribution::from_tables(&fitted, settings.seed),
        None => {
            let (draws, seed) = (settings.draws, settings.seed);
            simulate(fitter, &screening.nominal, &screening.base, &fitted, draws, seed, control)?
        }
    };
    control.begin("4/6 further effects and cross-validation");
    let is_first = screening.base.chi_square == first;
    let as_described = (&screening.nominal, &screening.base);
    let gaps = fitter.gaps(as_described.0, as_described.1, held_out)?;
    let fault_held_out = held_out_fault(fitter, held_out, as_described, &gaps)?;
    let refit = NominalRefit::new(machine, effects, fitter, as_described, control)?;
    let mut gatherer = Gatherer {
        fitter,
        held_out,
        machine,
        effects,
        numbers: &numbers,
        seed: settings.seed,
        control,
        gaps,
        fault_held_out,
        refit,
        screening,
        located,
        beside: Vec::new(),
        made: None,
        early: if is_first { (early.of_all, early.contradiction) } else { (None, None) },
    };
    let mut facts = gatherer.first_facts(early.in_records, null)?;
    if !early.explain_all && facts.count > facts.unknowns as f64 {
        gatherer.deepen_best(&mut facts, policy)?;
    }
    let judgement = gatherer.judge(&mut facts)?;
    gatherer.gather_evidence(&mut facts)?;
    if settings.all_facts {
        gatherer.gather_more(&mut facts)?;
    }
    compare(gatherer, facts, judgement)
}

/// Compares the machine as described, without and with the chosen model, at all data.
fn compare(
    gatherer: Gatherer<'_, '_>,
    facts: Facts,
    judgement: Judgement,
) -> Result<Diagnosis, ObjectiveError> {
    let Gatherer { fitter, held_out, effects, numbers, control, .. } = gatherer;
    let chosen = gatherer.model(judgement.chosen.model);
    let Gatherer { screening, located, gaps, refit, .. } = gatherer;
    let as_described = (&screening.nominal, &screening.base);
    let chosen = chosen.unwrap_or_else(|| (screening.nominal.clone(), screening.base.clone()));
    let fit = (&chosen.0, &chosen.1);
    let location = Location::of(&judgement.verdict, fitter, as_described, fit, (effects, &located))?;
    let with_nuisances = fitter.gaps(&chosen.0, &chosen.1, held_out)?;
    control.begin("5/6 gaps of the machine as described");
    let gaps_with = |candidate: &Candidate| -> Result<Vec<PartialGap>, ObjectiveError> {
        let Some((hypothesis, fitted)) = candidate.fitted.as_ref().filter(|_| !held_out.is_empty()) else {
            return Ok(Vec::new());
        };
        refit.of((hypothesis, fitted), control)?.map_or(Ok(Vec::new()), |found| refit.gaps(&found, held_out))
    };
    let ranked = judgement.ranked.par_iter().map(|ranked| {
        let candidate = screening.candidates[ranked.at].clone();
        let (statistic, p_value) = (ranked.statistic, ranked.p_value);
        let held_out = gaps_with(&candidate)?;
        Ok::<_, ObjectiveError>(TriedEffect { candidate, statistic, p_value, held_out })
    });
    let mut tried: Vec<TriedEffect> = ranked.or_first_error()?;
    let located = located.into_par_iter().map(|candidate| {
        let held_out = gaps_with(&candidate)?;
        Ok::<_, ObjectiveError>(TriedLocation { candidate, held_out })
    });
    let located = located.or_first_error()?;
    let described = refit.described().clone();
    let explained = refit.of(fit, control)?.unwrap_or_else(|| described.clone());
    let untried = |candidate: &Candidate| TriedEffect {
        candidate: candidate.clone(),
        statistic: 0.0,
        p_value: 1.0,
        held_out: Vec::new(),
    };
    tried.extend(screening.candidates.iter().filter(|c| c.fitted.is_none()).map(untried));
    Ok(Diagnosis {
        domain: fitter.domain,
        fit: refit.gaps(&described, &fitter.fit.to_predict())?,
        held_out: refit.gaps(&described, held_out)?,
        chosen_held_out: refit.gaps(&explained, held_out)?,
        gaps_with_nuisances: fitter.has_nuisances().then_some([gaps, with_nuisances]),
        tolerances: fitter.tolerances(&chosen.0, &chosen.1)?,
        numbers: numbers.to_vec(),
        intervals: intervals(fitter, fit, (&judgement, &facts), control)?,
        excess: facts.before(),
        chosen_excess: facts.excess(judgement.chosen.chi_square),
        described,
        explained,
        nominal: (screening.nominal, screening.base),
        located,
        tried,
        facts,
        chosen,
        judgement,
        location,
        complete: !control.stopped(),
    })
}
