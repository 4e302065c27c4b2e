//! Screening: fits of the nominal machine and of every candidate.

use rayon::prelude::*;

use super::cross_validation::cross_validation;
use super::evidence::{Domain, DomainObjective};
use super::fit::{Ablation, Fitted, Fitter, at_start, values_of};
use super::hypothesis::{Hypothesis, interfaces};
use identification::objective::{FrfSettings, ObjectiveError};
use identification::{IdentificationSettings, identify};
use machine::{Base, Data, Effect, Lever, Machine, Mechanism, Operating, Parameter, UnitValues, Value};
use measurement::FitSet;
use optimizer::Control;

/// Outcome of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    /// Fitted.
    Tried,
    /// Its fit failed: it is neither accepted nor rejected.
    Failed(String),
    /// The machine lacks something the effect needs, or already contains the effect, or the data cannot show it.
    NotApplicable(String),
}

/// A candidate and its fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Id.
    pub id: String,
    /// Outcome.
    pub status: Status,
    /// The hypothesis and its fit, where it was fitted.
    pub fitted: Option<(Hypothesis, Fitted)>,
    /// Reduction of χ² of the fitted data.
    pub gain: f64,
    /// Cross-validation loss: −2 ln of the predictive density of each left-out fit position, summed (χ² for modes). `None` where it was not computed.
    pub left_out: Option<f64>,
}

impl Candidate {
    /// Returns χ² of its fit; infinite without a fit.
    pub fn chi_square(&self) -> f64 {
        self.fitted.as_ref().map_or(f64::INFINITY, |f| f.1.chi_square)
    }

    fn without_fit(id: &str, status: Status) -> Self {
        Candidate { id: id.into(), status, fitted: None, gain: 0.0, left_out: None }
    }
}

/// The nominal fit and the candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct Screening {
    /// The machine with its nuisance parameters, or with the effects chosen so far.
    pub nominal: Hypothesis,
    /// Its best fit.
    pub base: Fitted,
    /// Candidates, the largest reduction of χ² first.
    pub candidates: Vec<Candidate>,
}

/// Steps of the nominal fits and the relative decrease of χ² at which they end: for FRFs, which have long and well defined valleys, and for modes.
const NOMINAL_STEPS: [(u64, f64); 2] = [(400, 1e-7), (120, 1e-4)];
/// Starts of the nominal fit of FRFs all over the parameter ranges, and the number that continue.
const NOMINAL_MULTISTART: (usize, usize) = (48, 4);
/// Number of candidates whose nominal parameters serve as starts of the others.
const SHARED_STARTS: usize = 2;
/// χ² per compared number above which the best candidate is fitted from more starts: a multiple of the noise's share, plus a constant.
const LARGE_MISFIT: (f64, f64) = (1.5, 0.1);
/// Largest χ² of a generic impedance, as a share of that of the best candidate, with which its nominal parameters serve as starts.
const BETTER_START: f64 = 0.99;
/// Least distance of a power of iω from 0 that counts as another measured quantity.
const LEAST_POWER: f64 = 0.6;
/// Range of lever arms, in lengths of the arm at which the nut takes part in a motion. Where both arms are below it, the fit is a resonator in the
/// path of the force. No table has a longer arm: a mass that hardly rocks stands for another effect.
const ARMS: (f64, f64) = (0.3, 8.0);

/// Returns the fitter of a diagnosis. For FRFs nut positions and the gains and delays of channels have priors, and the error of the model is a share
/// of the level around a line.
pub fn fitter<'s>(fit: &FitSet<'s>, domain: Domain, frozen: &[String], ablated: &[Ablation]) -> Fitter<'s> {
    let domain = match domain {
        Domain::Frf(settings) if ablated.contains(&Ablation::NoNuisances) => Domain::Frf(FrfSettings { of_level: true, ..settings }),
        Domain::Frf(settings) => Domain::Frf(FrfSettings { of_level: true, ..settings.with_tolerances(&fit.set().tolerance) }),
        modes @ Domain::Modes(_) => modes,
    };
    Fitter { fit: fit.clone(), domain, frozen: frozen.to_vec(), ablated: ablated.to_vec() }
}

/// Returns the machine a diagnosis starts from: for FRFs with its nuisance parameters. Modes are too few for them; the model error of modes covers
/// them.
///
/// # Errors  as [`Machine::with_tolerances`].
pub fn nominal(machine: &Machine, fitter: &Fitter<'_>) -> Result<Hypothesis, ObjectiveError> {
    let nuts_m = fitter.fit.set().nuts_m();
    Ok(Hypothesis::nominal(match fitter.domain {
        Domain::Frf(_) if fitter.has_nuisances() => machine.with_tolerances(&nuts_m)?,
        _ => machine.clone(),
    }))
}

/// Fits the nominal machine from global searches and from its start values; best first.
///
/// # Errors  as [`identify`].
pub fn nominal_fits(
    machine: &Machine,
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    seed: u64,
    control: &Control,
) -> Result<Vec<Fitted>, ObjectiveError> {
    let none = fitter.fit.nothing_to_predict();
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
            for (&index, &u) in found.varied_parameters.iter().zip(&basin.place) {
                start.units[index] = u;
            }
            starts.push(start);
        }
    }
    let objective = fitter.objective(nominal)?;
    let mut fits: Vec<Fitted> = starts.par_iter().map(|s| descend_to_minimum(fitter, &objective, s, control)).collect();
    fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    // Basins that are indistinguishable on few lines are distinct on all. An error here would look like a missing effect.
    let ends = match fitter.domain {
        Domain::Frf(_) => fitter.multistart_ends(&objective, nominal, &fits[0], NOMINAL_MULTISTART, control),
        Domain::Modes(_) => vec![fitter.multistart(nominal, &fits[0], control)?],
    };
    fits.par_extend(ends.par_iter().map(|end| descend_to_minimum(fitter, &objective, end, control)));
    fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    // A search that ended far above the best fit is no start for candidates.
    let best = fits[0].chi_square;
    fits.retain(|f| f.chi_square <= 1.5 * best + 10.0);
    fits.dedup_by(|a, b| close(&a.units, &b.units));
    Ok(fits)
}

/// Minimises χ² of a nominal machine from given coordinates.
fn descend_to_minimum(fitter: &Fitter<'_>, objective: &DomainObjective<'_>, from: &Fitted, control: &Control) -> Fitted {
    let [frf, modes] = NOMINAL_STEPS;
    fitter.descend_until(objective, from, if matches!(fitter.domain, Domain::Frf(_)) { frf } else { modes }, control)
}

fn close(a: &UnitValues, b: &UnitValues) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02)
}

/// Returns the hypotheses of all applicable effects and of released frozen parameters, and the candidates that do not apply.
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
            let variable = effect.operating_variable().filter(|c| !fitter.varies(*c))?;
            Some(format!("the data to fit cover only one {}", variable.name()))
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

/// Fits every candidate from fits of the nominal machine, then again from the nominal parameters of the best candidates. A deeper basin of the
/// nominal machine that turns up becomes its fit. Where even the best candidate leaves a large χ², all are fitted from starts all over their ranges.
///
/// # Errors  as [`Fitter::objective`]; a candidate whose fit fails is reported among the candidates.
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
    let counted = |fit: Fit| {
        step();
        fit
    };
    let mut fits: Vec<Fit> = hypotheses.par_iter().map(|h| counted(fitter.fit(h, &bases, control))).collect();
    let objective = fitter.objective(&nominal)?;
    let own = nominal.machine.parameters.len();
    let mut deepest: Vec<&Fitted> = fits.iter().filter_map(|f| f.as_ref().ok()).collect();
    deepest.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    let mut shared: Vec<Fitted> = Vec::new();
    for fitted in deepest.into_iter().take(6) {
        let start = Fitted { units: UnitValues(fitted.units[..own].to_vec()), ..fitted.clone() };
        let distinct = |other: &Fitted| !close(&other.units, &start.units);
        if shared.len() < SHARED_STARTS && fitted.chi_square < 0.9 * bases[0].chi_square && shared.iter().chain(&bases).all(distinct) {
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
    let is_large =
        |chi_square: f64| chi_square > (LARGE_MISFIT.0 * objective.noise_share() + LARGE_MISFIT.1) * objective.observations() as f64;
    // With few numbers almost any candidate reduces χ² much: compare them only after a global search for each.
    if is_large(least) || (is_large(base.chi_square) && matches!(fitter.domain, Domain::Modes(_))) {
        let third: Vec<Fit> = hypotheses.par_iter().map(|h| fitter.multistart(h, &base, control)).collect();
        fits = fits.into_iter().zip(third).map(|(a, b)| better(a, b)).collect();
    }
    let mut candidates: Vec<Candidate> = hypotheses
        .into_iter()
        .zip(fits)
        .map(|(hypothesis, fit)| match fit {
            // A larger machine that fits worse is a failed fit, not a rejected candidate.
            Ok(fitted) if fitted.chi_square > base.chi_square * (1.0 + 1e-2) + 3.0 => Candidate::without_fit(
                &hypothesis.id(),
                Status::Failed("its fit ends at a larger χ² than that of the machine without it".into()),
            ),
            Ok(fitted) => {
                let plausible = is_plausible(&hypothesis, &fitted);
                let gain = if plausible { (base.chi_square - fitted.chi_square).max(0.0) } else { 0.0 };
                Candidate { id: hypothesis.id(), status: Status::Tried, fitted: Some((hypothesis, fitted)), gain, left_out: None }
            }
            Err(error) => Candidate::without_fit(&hypothesis.id(), Status::Failed(error.to_string())),
        })
        .collect();
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    candidates.extend(others);
    Ok(Screening { nominal, base, candidates })
}

/// Fits every candidate again from the nominal parameters of generic impedances that explain more than the best candidate. With the missing impedance
/// included these are closer to the true joint parameters.
pub fn refit_from_generic_impedances(screening: &mut Screening, located: &[Candidate], fitter: &Fitter<'_>, control: &Control) {
    let least = screening.candidates.iter().map(Candidate::chi_square).fold(screening.base.chi_square, f64::min);
    let own = screening.nominal.machine.parameters.len();
    let fits = located.iter().filter_map(|c| c.fitted.as_ref()).map(|(_, fitted)| fitted);
    let better = fits.filter(|fitted| fitted.chi_square < BETTER_START * least);
    let bases: Vec<Fitted> =
        better.take(SHARED_STARTS).map(|f| Fitted { units: UnitValues(f.units[..own].to_vec()), ..f.clone() }).collect();
    if bases.is_empty() || fitter.lacks(Ablation::FrozenNominal) {
        return;
    }
    let base = screening.base.chi_square;
    screening.candidates.par_iter_mut().for_each(|candidate| {
        let Some((hypothesis, fitted)) = &mut candidate.fitted else { return };
        // A candidate that was fitted before fails now only if the run was stopped.
        if let Ok(other) = fitter.fit(hypothesis, &bases, control)
            && other.chi_square < fitted.chi_square
        {
            *fitted = other;
            candidate.gain = if is_plausible(hypothesis, fitted) { (base - fitted.chi_square).max(0.0) } else { 0.0 };
        }
    });
    screening.candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
}

/// Whether a fit agrees with the meaning of its effect. A changed quantity is another power of iω, not a slight slope. Lever arms lie at the sensor
/// or the hammer and are as long as those of a table. No part of an inertia exceeds the whole. A loss factor does not end at its largest value.
#[must_use]
pub fn is_plausible(hypothesis: &Hypothesis, fitted: &Fitted) -> bool {
    let values = values_of(hypothesis, fitted);
    // Only dimensionless parameters have an absolute size.
    let dimensionless =
        |index: usize| hypothesis.added.contains(&index) && hypothesis.machine.parameters[index].mechanism.is_dimensionless();
    let added = |value: &Value| match value.base {
        Base::Parameter(index) if dimensionless(index) => Some(values[index].abs()),
        _ => None,
    };
    let chain = &hypothesis.machine.chain;
    let in_range = |lever: &Lever| {
        let longest = [&lever.sensor_arm, &lever.hammer_arm].into_iter().filter_map(added).reduce(f64::max);
        longest.is_none_or(|arm| arm > ARMS.0 && arm < ARMS.1)
    };
    let operating = Operating::default();
    let exhausted = hypothesis.machine.points.iter().any(|point| point.inertia.is_over_subtracted(&values, &operating));
    !exhausted
        && largest_loss_factor(hypothesis, fitted).is_none()
        && added(&chain.power).is_none_or(|power| power > LEAST_POWER)
        && chain.levers.iter().all(in_range)
}

/// Returns a loss factor of the addition that ends at the largest value of its range. Such an addition takes up a change that another effect makes: the
/// damping of no part is that large.
#[must_use]
pub fn largest_loss_factor<'h>(hypothesis: &'h Hypothesis, fitted: &Fitted) -> Option<&'h Parameter> {
    let values = values_of(hypothesis, fitted);
    let ends = |index: &usize| {
        let parameter = &hypothesis.machine.parameters[*index];
        parameter.mechanism == Mechanism::LossFactor && parameter.is_at_bound(values[*index]) && values[*index] > parameter.start
    };
    hypothesis.added.iter().copied().find(ends).map(|index| &hypothesis.machine.parameters[index])
}

/// Fits generic impedances at all interfaces, the most promising by one linear step, and returns the best by reduction of χ²: they locate the
/// discrepancy.
///
/// # Errors  as [`Fitter::objective`].
pub fn locate(screening: &Screening, fitter: &Fitter<'_>, most: usize, control: &Control) -> Result<Vec<Candidate>, ObjectiveError> {
    let base = &screening.base;
    let bases = [base.clone()];
    let mut promising: Vec<(f64, Hypothesis)> = interfaces(&screening.nominal)
        .into_par_iter()
        .filter_map(|hypothesis| Some((fitter.predicted_cost(&hypothesis, &bases, control).ok()?, hypothesis)))
        .collect();
    promising.sort_by(|a, b| a.0.total_cmp(&b.0));
    promising.truncate(2 * most);
    let mut found: Vec<Candidate> = promising
        .into_par_iter()
        .filter_map(|(_, hypothesis)| {
            let fitted = fitter.fit(&hypothesis, &bases, control).ok()?;
            let gain = (base.chi_square - fitted.chi_square).max(0.0);
            Some(Candidate { id: hypothesis.id(), status: Status::Tried, fitted: Some((hypothesis, fitted)), gain, left_out: None })
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
