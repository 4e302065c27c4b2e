//! A whole diagnosis: nominal fit, candidates fitted jointly, ranking inside the fit positions, gap closed on what was held out.

use rayon::prelude::*;

use super::fit::{Fitted, Fitter, at_start};
use super::hypothesis::{CHANNEL_SD, Hypothesis, NUT_SD_M, interfaces, with_nuisances};
use crate::identification::{Plan, identify};
use crate::machine::{Effect, FitRule, Machine};
use crate::measurement::{FitSet, HoldOutSet};
use crate::numeric::statistics::root_mean_square_of_parts;
use crate::objective::{FrfGap, FrfSettings, ObjectiveError};
use crate::optimizer::Control;

/// How a diagnosis is made.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Weights and band of the FRFs.
    pub frf: FrfSettings,
    /// Parameters that keep their start values.
    pub frozen: Vec<String>,
    /// Seed.
    pub seed: u64,
}

/// What became of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    /// Fitted.
    Tried,
    /// Its fit failed: it is neither accepted nor rejected.
    Failed(String),
    /// The machine lacks something it needs, or contains it already.
    NotApplicable(String),
}

/// A candidate and what its fit gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Id.
    pub id: String,
    /// What became of it.
    pub status: Status,
    /// The hypothesis and its fit, where it was tried.
    pub fitted: Option<(Hypothesis, Fitted)>,
    /// By how much it lowers χ² of the fitted data.
    pub gain: f64,
    /// χ² at each fit position predicted by a fit without it, summed; `None` where that was not worked out.
    pub left_out: Option<f64>,
}

/// The nominal machine fitted, and the candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The machine with its nuisances.
    pub nominal: Hypothesis,
    /// Its fits from several places, best first.
    pub bases: Vec<Fitted>,
    /// As [`Candidate::left_out`], of the nominal machine.
    pub nominal_left_out: f64,
    /// Candidates, the largest decrease of χ² first.
    pub candidates: Vec<Candidate>,
}

/// Steps of the nominal fits.
const NOMINAL_STEPS: u64 = 300;
/// Candidates whose positions are left out one after another.
const LEFT_OUT: usize = 6;

/// Fits the nominal machine from a search and from its start values.
///
/// # Errors  as [`identify`].
fn nominal_fits(
    machine: &Machine,
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    seed: u64,
    control: &Control,
) -> Result<Vec<Fitted>, ObjectiveError> {
    let none = HoldOutSet { set: fitter.fit.set, positions: Vec::new(), frfs: Vec::new() };
    let plan = Plan {
        frf: Some(FrfSettings { nut_sd_m: 0.0, channel_sd: (0.0, 0.0), ..fitter.settings }),
        frozen: fitter.frozen.clone(),
        seed,
        repeats: 2,
        profile: false,
        ..Plan::default()
    };
    let mut starts = vec![at_start(nominal)];
    // With every parameter frozen there is nothing to search.
    if let Ok(found) = identify(machine, &fitter.fit, &none, &plan, control) {
        for repeat in &found.repeats {
            let mut start = at_start(nominal);
            for (&index, &u) in found.free.iter().zip(&repeat.found.place) {
                start.units[index] = u;
            }
            starts.push(start);
        }
    }
    let objective = fitter.objective(nominal)?;
    let mut fits: Vec<Fitted> = starts.iter().map(|s| fitter.descend(&objective, s, NOMINAL_STEPS, control)).collect();
    fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    fits.dedup_by(|a, b| (a.chi_square - b.chi_square).abs() < 1e-3 * b.chi_square && close(&a.units, &b.units));
    Ok(fits)
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
}

/// χ² of each group predicted by a fit without it, summed.
fn left_out(fitter: &Fitter<'_>, hypothesis: &Hypothesis, fitted: &Fitted, control: &Control) -> Result<f64, ObjectiveError> {
    let parts: Result<Vec<f64>, ObjectiveError> = fitter
        .fit
        .groups()
        .into_par_iter()
        .map(|group| {
            let without = |list: &[usize]| list.iter().copied().filter(|i| !group.contains(i)).collect::<Vec<usize>>();
            let kept = fitter.on(FitSet { frfs: without(&fitter.fit.frfs), ..fitter.fit.clone() });
            let objective = kept.objective(hypothesis)?;
            let part = kept.descend(&objective, fitted, 15, control);
            fitter.on(FitSet { frfs: group, ..fitter.fit.clone() }).loss(hypothesis, &part)
        })
        .collect();
    Ok(parts?.into_iter().sum())
}

/// Fits the nominal machine and every candidate.
///
/// # Errors  as [`identify`]; a candidate that fails is told among the candidates.
pub fn survey(machine: &Machine, effects: &[Effect], fitter: &Fitter<'_>, seed: u64, control: &Control) -> Result<Survey, ObjectiveError> {
    let nominal = Hypothesis::nominal(with_nuisances(machine)?);
    let mut bases = nominal_fits(machine, fitter, &nominal, seed, control)?;
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut hypotheses: Vec<Hypothesis> = Vec::new();
    for effect in effects {
        let inapplicable =
            |why: String| Candidate { id: effect.id.clone(), status: Status::NotApplicable(why), fitted: None, gain: 0.0, left_out: None };
        if machine.effects.contains(&effect.id) {
            candidates.push(inapplicable("the machine contains it already".into()));
        } else if let Some(name) = machine.lacks(effect) {
            candidates.push(inapplicable(format!("the machine has no «{name}»")));
        } else {
            match nominal.with(effect) {
                Ok(hypothesis) => hypotheses.push(hypothesis),
                Err(error) => candidates.push(inapplicable(error.to_string())),
            }
        }
    }
    for (index, parameter) in machine.parameters.iter().enumerate() {
        if fitter.frozen.contains(&parameter.id) || parameter.fit == FitRule::Never {
            hypotheses.push(nominal.releasing(index));
        }
    }
    let mut fits: Vec<Result<Fitted, ObjectiveError>> =
        hypotheses.par_iter().map(|hypothesis| fitter.fit(hypothesis, &bases, control)).collect();
    // A candidate may have found a deeper basin of the nominal machine: then the nominal fit was the one that failed.
    let objective = fitter.objective(&nominal)?;
    let mut deepest: Vec<&Fitted> = fits.iter().filter_map(|f| f.as_ref().ok()).collect();
    deepest.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    let again: Vec<Fitted> = deepest
        .into_iter()
        .take(3)
        .map(|f| Fitted { units: f.units[..nominal.machine.parameters.len()].to_vec(), ..f.clone() })
        .map(|start| fitter.descend(&objective, &start, NOMINAL_STEPS, control))
        .filter(|f| f.chi_square < bases[0].chi_square * (1.0 - 1e-3) - 1.0)
        .collect();
    if !again.is_empty() {
        bases.extend(again);
        bases.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        fits = hypotheses
            .par_iter()
            .zip(fits)
            .map(|(hypothesis, first)| match (fitter.fit(hypothesis, &bases[..1], control), first) {
                (Ok(second), Ok(first)) => Ok(if second.chi_square < first.chi_square { second } else { first }),
                (second, _) => second,
            })
            .collect();
    }
    let base = bases[0].chi_square;
    let tried: Vec<Candidate> = hypotheses
        .into_par_iter()
        .zip(fits)
        .map(|(hypothesis, fit)| {
            let id = hypothesis.id.clone();
            match fit {
                // A larger machine that fits worse is a failed fit, not a rejected candidate.
                Ok(fitted) if fitted.chi_square > base * (1.0 + 1e-3) + 3.0 => Candidate {
                    id,
                    status: Status::Failed("its fit ends above the machine without it".into()),
                    fitted: None,
                    gain: 0.0,
                    left_out: None,
                },
                Ok(fitted) => {
                    let gain = (base - fitted.chi_square).max(0.0);
                    Candidate { id, status: Status::Tried, fitted: Some((hypothesis, fitted)), gain, left_out: None }
                }
                Err(error) => Candidate { id, status: Status::Failed(error.to_string()), fitted: None, gain: 0.0, left_out: None },
            }
        })
        .collect();
    candidates.extend(tried);
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let nominal_left_out = left_out(fitter, &nominal, &bases[0], control)?;
    for candidate in candidates.iter_mut().filter(|c| c.fitted.is_some()).take(LEFT_OUT) {
        if let Some((hypothesis, fitted)) = &candidate.fitted {
            candidate.left_out = left_out(fitter, hypothesis, fitted, control).ok();
        }
    }
    Ok(Survey { nominal, bases, nominal_left_out, candidates })
}

/// The fitter of a diagnosis: FRFs to fit, nut positions known to half a millimetre.
pub fn fitter<'s>(fit: &FitSet<'s>, settings: &Settings) -> Fitter<'s> {
    Fitter {
        fit: fit.clone(),
        settings: FrfSettings { nut_sd_m: NUT_SD_M, channel_sd: CHANNEL_SD, of_level: true, ..settings.frf },
        frozen: settings.frozen.clone(),
    }
}

/// Every interface and shape, ranked by χ² of positions that were left out, best first: where something is missing.
///
/// # Errors  as [`survey`].
pub fn locate(survey: &Survey, fitter: &Fitter<'_>, most: usize, control: &Control) -> Result<Vec<Candidate>, ObjectiveError> {
    let base = survey.bases[0].chi_square;
    let mut found: Vec<Candidate> = interfaces(&survey.nominal)
        .into_par_iter()
        .filter_map(|hypothesis| {
            let fitted = fitter.fit(&hypothesis, &survey.bases[..1], control).ok()?;
            let gain = (base - fitted.chi_square).max(0.0);
            Some(Candidate { id: hypothesis.id.clone(), status: Status::Tried, fitted: Some((hypothesis, fitted)), gain, left_out: None })
        })
        .collect();
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found.truncate(most);
    for candidate in &mut found {
        if let Some((hypothesis, fitted)) = &candidate.fitted {
            candidate.left_out = left_out(fitter, hypothesis, fitted, control).ok();
        }
    }
    let loss = |c: &Candidate| c.left_out.unwrap_or(f64::INFINITY);
    found.sort_by(|a, b| loss(a).total_cmp(&loss(b)));
    Ok(found)
}

/// Root mean square over FRFs of their gaps, line by line.
pub fn gap_over(gaps: &[FrfGap]) -> Option<f64> {
    root_mean_square_of_parts(gaps.iter().map(|g| (g.gap, g.lines)))
}
