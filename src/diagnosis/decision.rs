//! Decision on a verdict: none, effect, indistinguishable effects, wrong parameter, faulty measurement, or
//! unknown with its location.

use rayon::prelude::*;

use super::choice::{EXCESS, decide};
use super::confirmation::{Confirmation, confirmation};
use super::cross_validation::cross_validation;
use super::data_fault::{Contradiction, Fault, chain_fault, contradiction, fault, held_out_fault};
use super::evidence::{Domain, PartialGap, closed};
use super::fit::{Ablation, Fitted, Fitter};
use super::further::{DecisionInputs, LEAST_STATISTIC, LOCATIONS, beside};
use super::hypothesis::Hypothesis;
use super::location::Location;
use super::measuring_chain::fault_of_all;
use super::nominal_refit::NominalRefit;
use super::null_distribution::{NullDistribution, simulate};
use super::one_machine::{Mismatch, mismatch};
use super::one_position::one_position;
use super::parsimony::GENERIC_PARAMETERS;
use super::ranking::{TriedEffect, TriedLocation, indistinguishable, keep_predictive, rank};
use super::record_checks::fault_of_records;
use super::screening::{Candidate, hypotheses, nominal, nominal_fits};
use super::search::{Effort, large_misfit, search};
use super::thresholds::Thresholds;
use super::verdict::{NEXT_AT_LOCATION, Verdict, VerdictKind};
use identification::ToleranceEstimate;
use identification::objective::ObjectiveError;
use long_work::Control;
use machine::{Effect, EffectIds, Machine};
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
    /// Null distribution of the statistics.
    pub null: NullDistribution,
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
    /// The verdict.
    pub verdict: Verdict,
    /// Location to which the verdict refers.
    pub location: Location,
    /// Tolerances estimated with the chosen model; empty where they are not fitted.
    pub tolerances: Vec<ToleranceEstimate>,
    /// Whether the diagnosis ran to its end.
    pub complete: bool,
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
}

/// Largest number of global searches for a candidate that explains a large discrepancy.
const SEARCHES: usize = 4;
/// Largest share that a named effect leaves: of the misfit of fitted data beyond null simulations (or
/// [`EXCESS`]), and of the squared gap of held-out data above the noise floor. It may exceed one of both.
const UNEXPLAINED: f64 = 0.5;
/// Least share of it that remains where records may belong to several machines.
const UNRELATED: f64 = 0.1;

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
    let domain = fitter.domain;
    let limits = Thresholds::of(domain);
    control.begin("1/6 fit of the nominal machine");
    let start = nominal(machine, fitter)?;
    let bases = nominal_fits(fitter, &start, settings.seed, control)?;
    let candidates = hypotheses(fitter, machine, &start, effects, &fitter.frozen);
    control.begin(&format!("2/6 {} candidates", candidates.0.len()));
    // Where the records themselves, or a fault of their chain that no effect imitates, account for all that
    // is missing, effects need no search.
    let shown = fault_of_records(fitter, held_out);
    let objective = fitter.objective(&start)?;
    let (count, large) = (objective.observations() as f64, large_misfit(&objective));
    let is_open = shown.is_none() && bases[0].chi_square > large;
    let early = if is_open { fault_of_all(fitter, (&start, &bases[0]), control)? } else { None };
    let mut is_chain =
        shown.is_some() || early.is_some_and(|found| !found.fault.is_gradual() && found.chi_square <= large);
    let sought =
        if is_open && !is_chain { Some(contradiction(fitter, (&start, &bases[0]), control)?) } else { None };
    let corrected =
        |found: &Contradiction| found.rest * count <= large && found.is_corrected_wholly(fitter, &start);
    is_chain |= sought.iter().flatten().any(corrected);
    let effort = Effort {
        located: (LOCATIONS, GENERIC_PARAMETERS),
        searches: if is_chain { 0 } else { SEARCHES },
        seed: settings.seed,
    };
    let first = bases[0].chi_square;
    // Generic impedances locate the discrepancy. They also show whether an effect of the library fits as well
    // as any impedance can.
    let (mut screening, mut located) = search(fitter, start, bases, candidates, effort, control)?;
    let unknowns = fitter.objective(&screening.nominal)?.unknowns(&screening.nominal);
    let fitted: Vec<(&Hypothesis, &Fitted)> =
        screening.candidates.iter().filter_map(|c| c.fitted.as_ref().map(|(h, f)| (h, f))).collect();
    control.begin("3/6 null simulations");
    let null = match &settings.null {
        Some(known) => known.clone(),
        None if fitter.lacks(Ablation::ChiSquare) => NullDistribution::from_tables(&fitted, settings.seed),
        None => simulate(
            fitter,
            &screening.nominal,
            &screening.base,
            &fitted,
            settings.draws,
            settings.seed,
            control,
        )?,
    };
    control.begin("4/6 further effects and cross-validation");
    let mut tried = rank(&screening, &null, count);
    // Where the best candidate leaves much, the search for what is missing beside it may find a deeper
    // minimum of itself.
    let mut next = None;
    let much = |t: &&TriedEffect| {
        !is_chain
            && count > unknowns as f64
            && null.excess(t.candidate.chi_square() / count) > limits.continue_from
    };
    if let Some(chosen) = tried.first().filter(much).and_then(|t| t.candidate.fitted.clone()) {
        let found = beside(fitter, machine, effects, &chosen, settings.seed, control)?;
        let improved = screening.candidates.iter_mut().find(|c| c.id == chosen.0.id());
        if let Some(candidate) = improved {
            *candidate = Candidate::of(chosen.0, Ok(found.base.clone()), &screening.base, fitter.band_hz());
        }
        tried = rank(&screening, &null, count);
        next = Some(found);
    }
    let nominal_loss = cross_validation(fitter, &screening.nominal, &screening.base, control)?;
    let base = screening.base.clone();
    let before = null.excess(base.chi_square / count);
    let mut same = indistinguishable(&tried, &null, count, limits);
    for at in 0..same.len().max(3).min(tried.len()) {
        if let Some((hypothesis, fitted)) = tried[at].candidate.fitted.clone() {
            tried[at].candidate.left_out = cross_validation(fitter, &hypothesis, &fitted, control).ok();
        }
    }
    // Only a generic impedance that fits better than one of these can explain the data better.
    let worst = same.iter().map(|at| tried[*at].candidate.chi_square()).fold(0.0, f64::max);
    for candidate in located.iter_mut().filter(|c| c.chi_square() < worst) {
        if let Some((hypothesis, fitted)) = &candidate.fitted {
            candidate.left_out = cross_validation(fitter, hypothesis, fitted, control).ok();
        }
    }
    let rejected = if fitter.lacks(Ablation::InSample) {
        0..0
    } else {
        keep_predictive(&mut tried, &mut same, nominal_loss, &null, count)
    };
    // With an excess of one a candidate must also improve the prediction of left-out positions.
    let predicts = |t: &TriedEffect| t.candidate.left_out.is_none_or(|loss| loss < nominal_loss);
    let clear = |t: &TriedEffect| t.p_value < limits.alpha && (!limits.calibrated || before > 1.0);
    let accepted = |t: &TriedEffect| clear(t) || (t.p_value < limits.cv_alpha && predicts(t));
    let significant = tried.first().is_some_and(|t| accepted(t) && t.statistic >= LEAST_STATISTIC);
    let nominal_held_out = fitter.gaps(&screening.nominal, &base, held_out)?;
    // A record that agrees with the others once an effect is included is not faulty.
    let best = tried.first().filter(|_| significant).and_then(|t| t.candidate.fitted.as_ref());
    let still = |(hypothesis, fitted): &(Hypothesis, Fitted)| {
        held_out_fault(fitter, held_out, (hypothesis, fitted), &fitter.gaps(hypothesis, fitted, held_out)?)
    };
    let restored = best.map(still).transpose()?;
    let agrees = best.is_some_and(|(_, fitted)| null.excess(fitted.chi_square / count) <= EXCESS);
    let as_described = (&screening.nominal, &base);
    // A fault of the measuring chain that explains the data comes before any effect of the structure.
    let needs_explanation = significant || before > EXCESS;
    let rival = best.map(|(hypothesis, fitted)| (fitted.chi_square, hypothesis.added.len()));
    let of_all = || -> Result<Option<Fault>, ObjectiveError> {
        let chain = match early.filter(|_| needs_explanation && base.chi_square == first) {
            Some(found) => Some(found),
            None if needs_explanation => fault_of_all(fitter, as_described, control)?,
            None => None,
        };
        Ok(chain.and_then(|found| chain_fault(found, base.chi_square, rival, count, &null)))
    };
    let at_one = match shown {
        None if needs_explanation => {
            one_position(fitter, held_out, as_described, rival, (&null, settings.seed), control)?
        }
        _ => None,
    };
    // What agrees with the machine lacks nothing, with or without a resonance.
    let shown = shown.filter(|found| needs_explanation || *found != Fault::NoResonance);
    let faulty = match shown.or(at_one) {
        Some(found) => Some(found),
        None => match held_out_fault(fitter, held_out, as_described, &nominal_held_out)? {
            Some(found) if restored.is_none_or(|still| still == Some(found)) => Some(found),
            _ => match of_all()? {
                None if !agrees && needs_explanation => fault(
                    fitter,
                    held_out,
                    as_described,
                    sought.filter(|_| base.chi_square == first),
                    &null,
                    control,
                )?,
                found => found,
            },
        },
    };
    let (mut verdict, chosen) = decide(&DecisionInputs {
        fitter,
        limits,
        machine,
        effects,
        screening: &screening,
        beside: next.filter(|found| {
            tried.first().is_some_and(|t| t.candidate.fitted.as_ref().is_some_and(|f| f.0 == found.nominal))
        }),
        tried: &tried,
        null: &null,
        count,
        unknowns,
        significant,
        same: &same,
        rejected: &tried[rejected],
        located: &located,
        faulty,
        nominal_loss,
        seed: settings.seed,
        control,
    })?;
    let after = null.excess(chosen.1.chi_square / count);
    if verdict.kind.explains() {
        let better = |c: &&(Hypothesis, Fitted)| c.1.chi_square < chosen.1.chi_square;
        let rival = located
            .iter()
            .filter_map(|c| c.fitted.as_ref())
            .min_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square))
            .filter(better);
        let others = tried
            .iter()
            .filter(|t| verdict.effects.iter().skip(1).any(|ids| *ids == EffectIds::single(&t.candidate.id)));
        let others = others.filter_map(|t| t.candidate.fitted.as_ref()).map(|(h, f)| (h, f));
        let named: Vec<(&Hypothesis, &Fitted)> =
            std::iter::once((&chosen.0, &chosen.1)).chain(others).collect();
        let found = confirmation(
            fitter,
            held_out,
            (as_described, rival.map(|(h, f)| (h, f))),
            &named,
            after,
            control,
        )?;
        // Of combinations the first alone is fitted: the others might be confirmed.
        let are_all_compared = named.len() >= verdict.effects.len();
        verdict = match found {
            Some(found) if are_all_compared => verdict.judged_by_held_out(found.is_certain(), &found.text()),
            found => Verdict { confirmed: found.map(Confirmation::is_certain), ..verdict },
        };
    }
    let chosen_with_nuisances = fitter.gaps(&chosen.0, &chosen.1, held_out)?;
    let leaves_much = after > EXCESS || after - 1.0 > UNEXPLAINED * (before - 1.0);
    let is_inadequate = limits.calibrated && null.exceeds(chosen.1.chi_square / count) && leaves_much;
    let held_out_closed = closed(&nominal_held_out, &chosen_with_nuisances);
    let is_open = held_out_closed.is_none_or(|closed| closed < 1.0 - UNEXPLAINED);
    if verdict.kind == VerdictKind::Effect && is_inadequate && is_open {
        let gap = if held_out_closed.is_some() { ", and more than half of the held-out gap" } else { "" };
        let reason = format!(
            "the best effect leaves a misfit {after:.1} times that of null simulations, {before:.1} times without it{gap}"
        );
        verdict = verdict.unnamed(&reason, NEXT_AT_LOCATION);
    }
    // Records of several machines have a large misfit that no model explains.
    let is_unexplained = after > EXCESS && after - 1.0 > UNRELATED * (before - 1.0);
    if matches!(domain, Domain::Frf(_))
        && is_unexplained
        && (verdict.kind == VerdictKind::Unknown || verdict.kind.explains())
    {
        let all: Vec<usize> = fitter.fit.frfs().iter().chain(held_out.frfs()).copied().collect();
        if let Some((reason, next)) = mismatch(fitter.fit.set(), &all).map(Mismatch::text) {
            verdict = verdict.unnamed(&reason, next);
        }
    }
    let verdict = verdict.or_else(faulty.and_then(|fault| fault.possible(fitter.fit.set())));
    let place = Location::of(&verdict, fitter, as_described, (&chosen.0, &chosen.1), (effects, &located))?;
    let all = fitter.fit.to_predict();
    control.begin("5/6 gaps of the machine as described");
    let refit = NominalRefit::new(machine, effects, fitter, as_described, control)?;
    let gaps_with = |candidate: &Candidate| -> Result<Vec<PartialGap>, ObjectiveError> {
        let Some((hypothesis, fitted)) = candidate.fitted.as_ref().filter(|_| !held_out.is_empty()) else {
            return Ok(Vec::new());
        };
        refit.of((hypothesis, fitted), control)?.map_or(Ok(Vec::new()), |found| refit.gaps(&found, held_out))
    };
    let each: Vec<Vec<PartialGap>> = tried.par_iter().map(|t| gaps_with(&t.candidate)).or_first_error()?;
    tried.iter_mut().zip(each).for_each(|(t, held_out)| t.held_out = held_out);
    let each: Vec<Vec<PartialGap>> = located.par_iter().map(gaps_with).or_first_error()?;
    let located = located
        .into_iter()
        .zip(each)
        .map(|(candidate, held_out)| TriedLocation { candidate, held_out })
        .collect();
    let described = refit.described().clone();
    let explained = refit.of((&chosen.0, &chosen.1), control)?.unwrap_or_else(|| described.clone());
    let not_tried = screening.candidates.iter().filter(|c| c.fitted.is_none());
    tried.extend(not_tried.map(|c| TriedEffect {
        candidate: c.clone(),
        statistic: 0.0,
        p_value: 1.0,
        held_out: Vec::new(),
    }));
    Ok(Diagnosis {
        domain,
        fit: refit.gaps(&described, &all)?,
        held_out: refit.gaps(&described, held_out)?,
        chosen_held_out: refit.gaps(&explained, held_out)?,
        gaps_with_nuisances: fitter.has_nuisances().then_some([nominal_held_out, chosen_with_nuisances]),
        tolerances: fitter.tolerances(&chosen.0, &chosen.1)?,
        chosen_excess: after,
        described,
        explained,
        nominal: (screening.nominal, base),
        located,
        tried,
        null,
        excess: before,
        chosen,
        verdict,
        location: place,
        complete: !control.stopped(),
    })
}
