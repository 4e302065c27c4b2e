//! The survey: the nominal machine fitted, and every candidate fitted jointly with it.

use rayon::prelude::*;

use super::cross_validation::cross_validation;
use super::evidence::{Domain, DomainObjective};
use super::fit::{Ablation, Fitted, Fitter, at_start, values_of};
use super::hypothesis::{Hypothesis, interfaces};
use identification::objective::{FrfSettings, ObjectiveError};
use identification::{IdentificationSettings, identify};
use machine::{Base, Data, Effect, Lever, Machine, Operating, Value};
use measurement::{FitSet, HoldOutSet};
use optimizer::Control;

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

impl Candidate {
    /// χ² of its fit; infinite where it was not tried.
    pub fn chi_square(&self) -> f64 {
        self.fitted.as_ref().map_or(f64::INFINITY, |f| f.1.chi_square)
    }

    fn without_fit(id: &str, status: Status) -> Self {
        Candidate { id: id.into(), status, fitted: None, gain: 0.0, left_out: None }
    }
}

/// The nominal machine fitted, and the candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct Screening {
    /// The machine with its nuisances, or with effects that were selected before.
    pub nominal: Hypothesis,
    /// Its best fit.
    pub base: Fitted,
    /// Candidates, the largest decrease of χ² first.
    pub candidates: Vec<Candidate>,
}

/// Steps of the nominal fits, and the relative gain of χ² at which they end: of FRFs, whose valleys are long and known well, and of modes.
const NOMINAL_STEPS: [(u64, f64); 2] = [(400, 1e-7), (120, 1e-4)];
/// Starts of them all over the ranges, and how many go on, of FRFs.
const NOMINAL_SCATTERED: (usize, usize) = (48, 4);
/// Candidates whose nominal parameters the others start from, too.
const SHARED: usize = 2;
/// χ² per number beyond which the best candidate leaves too much to be the end: this multiple of the noise's share, and this.
const MUCH: (f64, f64) = (1.5, 0.1);
/// Share of the best candidate's χ² below which a free shape knows better where the joints are.
const KNOWS_BETTER: f64 = 0.99;
/// A power of iω nearer to 0 than this is no other quantity.
const LEAST_POWER: f64 = 0.6;
/// Arms both shorter than the first, in lengths of the one at which the nut feels a motion, are none: what is found then is a resonator on the way of the
/// force. No table has one longer than the second: there a mass that hardly rocks stands for something else.
const ARMS: (f64, f64) = (0.3, 8.0);

/// The fitter of a diagnosis: for FRFs nut positions, gains and delays of channels are known to a standard deviation, and the model's error is a
/// share of the level around a line.
pub fn fitter<'s>(fit: &FitSet<'s>, domain: Domain, frozen: &[String], ablated: &[Ablation]) -> Fitter<'s> {
    let domain = match domain {
        Domain::Frf(settings) if ablated.contains(&Ablation::NoNuisances) => Domain::Frf(FrfSettings { of_level: true, ..settings }),
        Domain::Frf(settings) => Domain::Frf(FrfSettings { of_level: true, ..settings.with_tolerances(&fit.set.tolerance) }),
        modes @ Domain::Modes(_) => modes,
    };
    Fitter { fit: fit.clone(), domain, frozen: frozen.to_vec(), ablated: ablated.to_vec() }
}

/// The machine a diagnosis starts from: for FRFs with its nuisances; modes are too few to carry them, the error of their model stands for them.
///
/// # Errors  as [`Machine::with_tolerances`].
pub fn nominal(machine: &Machine, fitter: &Fitter<'_>) -> Result<Hypothesis, ObjectiveError> {
    let nuts_m = fitter.fit.set.nuts_m();
    Ok(Hypothesis::nominal(match fitter.domain {
        Domain::Frf(_) if fitter.has_nuisances() => machine.with_tolerances(&nuts_m)?,
        _ => machine.clone(),
    }))
}

/// Fits the nominal machine from searches and from its start values; best first.
///
/// # Errors  as [`identify`].
pub fn nominal_fits(
    machine: &Machine,
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    seed: u64,
    control: &Control,
) -> Result<Vec<Fitted>, ObjectiveError> {
    let none = HoldOutSet { set: fitter.fit.set, positions: Vec::new(), frfs: Vec::new() };
    let mut plan =
        IdentificationSettings { frozen: fitter.frozen.clone(), seed, repeats: 1, profile: false, ..IdentificationSettings::default() };
    match fitter.domain {
        Domain::Frf(settings) => (plan.frf, plan.tolerances) = (Some(settings.as_stated()), fitter.has_nuisances()),
        Domain::Modes(settings) => plan.settings = settings,
    }
    let mut starts = vec![at_start(nominal)];
    // With every parameter frozen there is nothing to search.
    if let Ok(found) = identify(machine, &fitter.fit, &none, &plan, control) {
        for basin in &found.basins {
            let mut start = at_start(nominal);
            for (&index, &u) in found.varied.iter().zip(&basin.place) {
                start.units[index] = u;
            }
            starts.push(start);
        }
    }
    let objective = fitter.objective(nominal)?;
    let mut fits: Vec<Fitted> = starts.par_iter().map(|s| descend_to_minimum(fitter, &objective, s, control)).collect();
    fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    // Basins that few lines hardly tell apart are told apart by all: what is wrong here looks like something missing.
    let ends = match fitter.domain {
        Domain::Frf(_) => fitter.scattered(&objective, nominal, &fits[0], NOMINAL_SCATTERED, control),
        Domain::Modes(_) => vec![fitter.scatter(nominal, &fits[0], control)?],
    };
    fits.par_extend(ends.par_iter().map(|end| descend_to_minimum(fitter, &objective, end, control)));
    fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    // A search that ended far above the best is no place to start from.
    let best = fits[0].chi_square;
    fits.retain(|f| f.chi_square <= 1.5 * best + 10.0);
    fits.dedup_by(|a, b| close(&a.units, &b.units));
    Ok(fits)
}

/// Follows χ² of a nominal machine down from a place.
fn descend_to_minimum(fitter: &Fitter<'_>, objective: &DomainObjective<'_>, from: &Fitted, control: &Control) -> Fitted {
    let [frf, modes] = NOMINAL_STEPS;
    fitter.descend_to(objective, from, if matches!(fitter.domain, Domain::Frf(_)) { frf } else { modes }, control)
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
}

/// Hypotheses of all effects that apply, of frozen parameters released, and candidates that do not apply.
pub fn hypotheses(
    fitter: &Fitter<'_>,
    machine: &Machine,
    nominal: &Hypothesis,
    effects: &[Effect],
    frozen: &[String],
) -> (Vec<Hypothesis>, Vec<Candidate>) {
    let (mut apply, mut others) = (Vec::new(), Vec::new());
    for effect in effects {
        let obstacle = nominal.obstacle(effect, Data::Frf).or_else(|| {
            let circumstance = effect.circumstance().filter(|c| !fitter.varies(*c))?;
            Some(format!("the data to fit are all of one {}", circumstance.words()))
        });
        let applied = match obstacle {
            Some(why) => Err(why),
            None => nominal.with(effect).map_err(|error| error.to_string()),
        };
        match applied {
            Ok(hypothesis) => apply.push(hypothesis),
            Err(why) => others.push(Candidate::without_fit(&effect.id, Status::NotApplicable(why))),
        }
    }
    apply.extend(nominal.releases(machine, frozen, &[]));
    (apply, others)
}

/// Fits every candidate from fits of the nominal machine, then all of them again from the nominal parameters of the best: what one finds, the
/// others must be able to start from. A deeper basin of the nominal machine that turns up on the way becomes its fit. Where even the best leaves much,
/// all are fitted from places all over their ranges.
///
/// # Errors  as [`Fitter::objective`]; a candidate that fails is told among the candidates.
pub fn screen(
    fitter: &Fitter<'_>,
    nominal: Hypothesis,
    bases: Vec<Fitted>,
    (hypotheses, others): (Vec<Hypothesis>, Vec<Candidate>),
    control: &Control,
) -> Result<Screening, ObjectiveError> {
    type Fit = Result<Fitted, ObjectiveError>;
    let better = |first: Fit, second: Fit| match (first, second) {
        (Ok(a), Ok(b)) => Ok(if b.chi_square < a.chi_square { b } else { a }),
        (Ok(a), Err(_)) | (Err(_), Ok(a)) => Ok(a),
        (Err(a), Err(_)) => Err(a),
    };
    let hypotheses: Vec<Hypothesis> = match fitter.lacks(Ablation::FrozenNominal) {
        true => hypotheses.into_iter().map(|h| h.kept_at(&bases[0].units)).collect(),
        false => hypotheses,
    };
    let step = control.steps("candidates", hypotheses.len());
    let told = |fit: Fit| {
        step();
        fit
    };
    let mut fits: Vec<Fit> = hypotheses.par_iter().map(|h| told(fitter.fit(h, &bases, control))).collect();
    let objective = fitter.objective(&nominal)?;
    let own = nominal.machine.parameters.len();
    let mut deepest: Vec<&Fitted> = fits.iter().filter_map(|f| f.as_ref().ok()).collect();
    deepest.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    let mut shared: Vec<Fitted> = Vec::new();
    for fitted in deepest.into_iter().take(6) {
        let start = Fitted { units: fitted.units[..own].to_vec(), ..fitted.clone() };
        let apart = |other: &Fitted| !close(&other.units, &start.units);
        if shared.len() < SHARED && fitted.chi_square < 0.9 * bases[0].chi_square && shared.iter().chain(&bases).all(apart) {
            shared.push(start);
        }
    }
    let mut base = bases[0].clone();
    if !shared.is_empty() && !fitter.lacks(Ablation::FrozenNominal) {
        let again: Vec<Fitted> = shared.par_iter().map(|s| descend_to_minimum(fitter, &objective, s, control)).collect();
        for fitted in again {
            if fitted.chi_square < base.chi_square {
                base = fitted;
            }
        }
        shared.insert(0, base.clone());
        let second: Vec<Fit> = hypotheses.par_iter().map(|h| fitter.fit(h, &shared, control)).collect();
        fits = fits.into_iter().zip(second).map(|(a, b)| better(a, b)).collect();
    }
    let least = fits.iter().filter_map(|f| f.as_ref().ok()).map(|f| f.chi_square).fold(base.chi_square, f64::min);
    let much = |chi_square: f64| chi_square > (MUCH.0 * objective.noise_share() + MUCH.1) * objective.observations() as f64;
    // Of few numbers any candidate takes most away: one basin is no better than another unless all are looked for.
    if much(least) || (much(base.chi_square) && matches!(fitter.domain, Domain::Modes(_))) {
        let third: Vec<Fit> = hypotheses.par_iter().map(|h| fitter.scatter(h, &base, control)).collect();
        fits = fits.into_iter().zip(third).map(|(a, b)| better(a, b)).collect();
    }
    let mut candidates: Vec<Candidate> = hypotheses
        .into_iter()
        .zip(fits)
        .map(|(hypothesis, fit)| match fit {
            // A larger machine that fits worse is a failed fit, not a rejected candidate.
            Ok(fitted) if fitted.chi_square > base.chi_square * (1.0 + 1e-2) + 3.0 => {
                Candidate::without_fit(&hypothesis.id, Status::Failed("its fit ends above the machine without it".into()))
            }
            Ok(fitted) => {
                let told = is_plausible(&hypothesis, &fitted);
                let gain = if told { (base.chi_square - fitted.chi_square).max(0.0) } else { 0.0 };
                Candidate { id: hypothesis.id.clone(), status: Status::Tried, fitted: Some((hypothesis, fitted)), gain, left_out: None }
            }
            Err(error) => Candidate::without_fit(&hypothesis.id, Status::Failed(error.to_string())),
        })
        .collect();
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    candidates.extend(others);
    Ok(Screening { nominal, base, candidates })
}

/// Fits every candidate again from the nominal parameters of free shapes, where those explain more than the best candidate does: they know where
/// the joints are once what is missing is there.
pub fn refit_from_free_shapes(survey: &mut Screening, located: &[Candidate], fitter: &Fitter<'_>, control: &Control) {
    let least = survey.candidates.iter().map(Candidate::chi_square).fold(survey.base.chi_square, f64::min);
    let own = survey.nominal.machine.parameters.len();
    let fits = located.iter().filter_map(|c| c.fitted.as_ref()).map(|(_, fitted)| fitted);
    let better = fits.filter(|fitted| fitted.chi_square < KNOWS_BETTER * least);
    let bases: Vec<Fitted> = better.take(SHARED).map(|f| Fitted { units: f.units[..own].to_vec(), ..f.clone() }).collect();
    if bases.is_empty() || fitter.lacks(Ablation::FrozenNominal) {
        return;
    }
    let base = survey.base.chi_square;
    survey.candidates.par_iter_mut().for_each(|candidate| {
        let Some((hypothesis, fitted)) = &mut candidate.fitted else { return };
        // One that was fitted before fails now only where it was stopped before its turn.
        if let Ok(other) = fitter.fit(hypothesis, &bases, control)
            && other.chi_square < fitted.chi_square
        {
            *fitted = other;
            candidate.gain = if is_plausible(hypothesis, fitted) { (base - fitted.chi_square).max(0.0) } else { 0.0 };
        }
    });
    survey.candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
}

/// Whether what was fitted is what the effect says: another quantity is another power of iω, not a slight slope, and what is felt on arms is felt by the
/// sensor or the hammer, on one that a table may have; and no part of an inertia is larger than the whole.
#[must_use]
pub fn is_plausible(hypothesis: &Hypothesis, fitted: &Fitted) -> bool {
    let values = values_of(hypothesis, fitted);
    // Numbers without unit alone have a size of their own.
    let plain = |index: usize| hypothesis.added.contains(&index) && hypothesis.machine.parameters[index].unit == "1";
    let added = |value: &Value| match value.base {
        Base::Parameter(index) if plain(index) => Some(values[index].abs()),
        _ => None,
    };
    let chain = &hypothesis.machine.chain;
    let felt = |lever: &Lever| {
        let longest = [&lever.read, &lever.struck].into_iter().filter_map(added).reduce(f64::max);
        longest.is_none_or(|arm| arm > ARMS.0 && arm < ARMS.1)
    };
    let there = Operating::default();
    let exhausted = hypothesis.machine.points.iter().any(|point| point.inertia.is_exhausted(&values, &there));
    !exhausted && added(&chain.power).is_none_or(|power| power > LEAST_POWER) && chain.levers.iter().all(felt)
}

/// Every interface and shape, ranked by χ² of positions that were left out, best first: where something is missing. The most promising by one step
/// are fitted.
///
/// # Errors  as [`Fitter::objective`].
pub fn locate(survey: &Screening, fitter: &Fitter<'_>, most: usize, control: &Control) -> Result<Vec<Candidate>, ObjectiveError> {
    let base = &survey.base;
    let bases = [base.clone()];
    let mut promising: Vec<(f64, Hypothesis)> = interfaces(&survey.nominal)
        .into_par_iter()
        .filter_map(|hypothesis| Some((fitter.promise(&hypothesis, &bases, control).ok()?, hypothesis)))
        .collect();
    promising.sort_by(|a, b| a.0.total_cmp(&b.0));
    promising.truncate(2 * most);
    let mut found: Vec<Candidate> = promising
        .into_par_iter()
        .filter_map(|(_, hypothesis)| {
            let fitted = fitter.fit(&hypothesis, &bases, control).ok()?;
            let gain = (base.chi_square - fitted.chi_square).max(0.0);
            Some(Candidate { id: hypothesis.id.clone(), status: Status::Tried, fitted: Some((hypothesis, fitted)), gain, left_out: None })
        })
        .collect();
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    found.truncate(most);
    for candidate in &mut found {
        if let Some((hypothesis, fitted)) = &candidate.fitted {
            candidate.left_out = cross_validation(fitter, hypothesis, fitted, control).ok();
        }
    }
    Ok(found)
}
