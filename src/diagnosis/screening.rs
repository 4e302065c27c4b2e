//! Screening: fits of the nominal machine and of every candidate.

use rayon::prelude::*;

use super::evidence::{Domain, DomainObjective};
use super::fit::{Ablation, COARSE_STEPS, Fitted, Fitter, at_start, distinct_minima, values_of};
use super::hypothesis::Hypothesis;
use super::policy::{ARMS, LEAST_POWER};
use identification::objective::{FrfSettings, ObjectiveError};
use long_work::Control;
use machine::{Base, Data, Effect, Joint, Lever, Machine, Mechanism, Operating, Value};
use measurement::FitSet;
use numeric::unit::frequency_hz;

/// Outcome of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    /// Fitted.
    Tried,
    /// Its fit failed: it is neither accepted nor rejected.
    Failed(String),
    /// The machine lacks something the effect needs, or already contains the effect, or the data cannot show
    /// it.
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
    /// Whether its fit is hardly different from that of another effect ([`relaxes_within`] is false).
    pub is_limit: bool,
}

impl Candidate {
    /// Returns χ² of its fit; infinite without a fit.
    pub fn chi_square(&self) -> f64 {
        self.fitted.as_ref().map_or(f64::INFINITY, |f| f.1.chi_square)
    }

    pub(super) fn without_fit(id: &str, status: Status) -> Self {
        Candidate { id: id.into(), status, fitted: None, gain: 0.0, is_limit: false }
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

/// Steps of the nominal fits and the relative decrease of χ² at which they end: for FRFs, which have long and
/// well defined valleys, and for modes.
const NOMINAL_STEPS: [(u64, f64); 2] = [(400, 1e-7), (120, 1e-4)];
/// Starts of the nominal fit of FRFs all over the parameter ranges, and the number that continue.
const NOMINAL_MULTISTART: (usize, usize) = (48, 4);
/// Returns the fitter of a diagnosis. For FRFs nut positions and the gains and delays of channels have
/// priors, and the error of the model is a share of the level around a line.
pub fn fitter<'s>(fit: &FitSet<'s>, domain: Domain, frozen: &[String], ablated: &[Ablation]) -> Fitter<'s> {
    let domain = match domain {
        Domain::Frf(settings) if ablated.contains(&Ablation::NoNuisances) => {
            Domain::Frf(FrfSettings { of_level: true, ..settings })
        }
        Domain::Frf(settings) => {
            Domain::Frf(FrfSettings { of_level: true, ..settings.with_tolerances(&fit.set().tolerance) })
        }
        modes @ Domain::Modes(_) => modes,
    };
    Fitter { fit: fit.clone(), domain, frozen: frozen.to_vec(), ablated: ablated.to_vec() }
}

/// Returns the machine a diagnosis starts from: for FRFs with its nuisance parameters. Modes are too few for
/// them; the model error of modes covers them.
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
/// # Errors  as [`Fitter::objective`].
pub fn nominal_fits(
    fitter: &Fitter<'_>,
    nominal: &Hypothesis,
    seed: u64,
    control: &Control,
) -> Result<Vec<Fitted>, ObjectiveError> {
    let objective = fitter.objective(nominal)?;
    let start = at_start(nominal);
    let mut starts = match &objective {
        DomainObjective::Frf(_) => {
            let key = fitter.cache_key("nominal", nominal, &[]);
            fitter.searched(&objective, &start, seed, &control.within(&key))
        }
        DomainObjective::Modes(_) => {
            fitter.search_globally(nominal, (seed, 0), control)?.into_iter().collect()
        }
    };
    starts.push(start);
    let mut fits = fitter.minima(&objective, &starts, control);
    if matches!(objective, DomainObjective::Frf(_)) {
        // Basins that are indistinguishable on few lines are distinct on all. An error here would look like a
        // missing effect.
        let ends = fitter.multistart_ends(&objective, nominal, &fits[0], (NOMINAL_MULTISTART, 0), control);
        fits.extend(fitter.minima(&objective, &ends, control));
        fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    }
    fits.truncate(near_least(&fits));
    Ok(distinct_minima(&objective, fits))
}

/// Returns the number of fits, in rising order of χ², that ended near the best one: others are no start for
/// candidates.
fn near_least(fits: &[Fitted]) -> usize {
    fits.iter().take_while(|fit| fit.chi_square <= 1.5 * fits[0].chi_square + 10.0).count()
}

impl Fitter<'_> {
    /// Returns the minima of a nominal machine to which some starts lead on few lines, refined on all where
    /// they ended near the best one; best first.
    fn minima(&self, objective: &DomainObjective<'_>, starts: &[Fitted], control: &Control) -> Vec<Fitted> {
        let coarse = self.coarse(objective);
        let mut near: Vec<Fitted> = match &coarse {
            Some(few) => {
                starts.par_iter().map(|start| self.descend(few, start, COARSE_STEPS, control)).collect()
            }
            None => starts.to_vec(),
        };
        if let Some(few) = &coarse {
            near.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
            near.truncate(near_least(&near));
            near = distinct_minima(few, near);
        }
        let mut fits: Vec<Fitted> =
            near.par_iter().map(|start| descend_to_minimum(self, objective, start, control)).collect();
        fits.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
        fits
    }
}

/// Minimises χ² of a nominal machine from given coordinates.
pub(super) fn descend_to_minimum(
    fitter: &Fitter<'_>,
    objective: &DomainObjective<'_>,
    from: &Fitted,
    control: &Control,
) -> Fitted {
    let [frf, modes] = NOMINAL_STEPS;
    fitter.descend_until(
        objective,
        from,
        if matches!(fitter.domain, Domain::Frf(_)) { frf } else { modes },
        control,
    )
}

/// Returns the hypotheses of all applicable effects and of released frozen parameters, and the candidates
/// that do not apply.
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
            None => nominal.with(effect).map_err(|error| error.to_string()).and_then(|hypothesis| {
                let (open, closed) =
                    (hypothesis.machine.linear_parameters(), hypothesis.machine.closed_loop_parameters());
                // Those before belong to effects that are already included.
                let acts = (nominal.machine.parameters.len()..open.len()).any(|own| open[own] || closed[own]);
                acts.then_some(hypothesis).ok_or_else(|| {
                    "frequency responses of this machine do not depend on what it changes".to_string()
                })
            }),
        };
        match applied {
            Ok(hypothesis) => apply.push(hypothesis),
            Err(why) => others.push(Candidate::without_fit(&effect.id, Status::NotApplicable(why))),
        }
    }
    apply.extend(nominal.releases(machine, frozen, &[]));
    (apply, others)
}

/// Returns why a fit does not agree with the meaning of its effect; `None` where it does. A changed quantity is
/// another power of iω, not a slight slope. Lever arms lie at the sensor or the hammer and are as long as those
/// of a table. No part of an inertia exceeds the whole. A loss factor does not end at its largest value: such an
/// addition takes up a change that another effect makes.
#[must_use]
pub fn implausibility(hypothesis: &Hypothesis, fitted: &Fitted) -> Option<String> {
    let (values, operating) = (values_of(hypothesis, fitted), Operating::default());
    let parameters = &hypothesis.machine.parameters;
    // Only dimensionless parameters have an absolute size.
    let dimensionless =
        |index: usize| hypothesis.added.contains(&index) && parameters[index].mechanism.is_dimensionless();
    let added = |value: &Value| match value.base {
        Base::Parameter(index) if dimensionless(index) => Some(values[index].abs()),
        _ => None,
    };
    let chain = &hypothesis.machine.chain;
    let longest =
        |lever: &Lever| [&lever.sensor_arm, &lever.hammer_arm].into_iter().filter_map(added).reduce(f64::max);
    let is_armless = |arm: &f64| !(*arm > ARMS.0 && *arm < ARMS.1);
    let whole = hypothesis.machine.points.iter().find(|p| p.inertia.is_over_subtracted(&values, &operating));
    let is_largest = |index: &&usize| {
        let (parameter, value) = (&parameters[**index], values[**index]);
        parameter.mechanism == Mechanism::LossFactor
            && parameter.is_at_bound(value)
            && value > parameter.start
    };
    let loss = || {
        let id = &parameters[*hypothesis.added.iter().find(is_largest)?].id;
        Some(format!(
            "{id} ends at the largest value of its range: the effect takes up a change that another one makes"
        ))
    };
    let power = || {
        let power = added(&chain.power).filter(|power| *power <= LEAST_POWER)?;
        Some(format!("a power of iω of {power:.2} is no other quantity"))
    };
    let arm = || {
        let arm = chain.levers.iter().filter_map(longest).find(is_armless)?;
        Some(format!(
            "its best fit has lever arms of {arm:.2} times their unit: it stands for another effect"
        ))
    };
    let part = whole.map(|point| format!("its part of the inertia of {} exceeds the whole", point.name));
    part.or_else(loss).or_else(power).or_else(arm)
}

/// Whether each damper in series with a spring that the addition brings changes from the one into the other
/// within a band (Hz). Below its corner it is mostly a damper, above it mostly a spring: where the corner is
/// outside the band, its fit is hardly different from that of another effect.
#[must_use]
pub fn relaxes_within(hypothesis: &Hypothesis, fitted: &Fitted, (from_hz, to_hz): (f64, f64)) -> bool {
    let values = values_of(hypothesis, fitted);
    let operating = Operating::default();
    let is_added =
        |value: &Value| matches!(value.base, Base::Parameter(index) if hypothesis.added.contains(&index));
    let corner_hz = |joint: &Joint| {
        let spring = joint
            .relaxation_stiffness
            .as_ref()
            .filter(|spring| is_added(spring) && is_added(&joint.damping))?;
        Some(frequency_hz(spring.at(&values, &operating) / joint.damping.at(&values, &operating)))
    };
    hypothesis
        .machine
        .joints
        .iter()
        .filter_map(corner_hz)
        .all(|corner_hz| (from_hz..=to_hz).contains(&corner_hz))
}
