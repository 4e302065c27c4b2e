//! Posterior: minima and covariance of all fitted coordinates, tolerances included, and draws of the
//! parameters that the data leave possible.
//!
//! A draw is the minimum of χ² after data, priors and ranges have been redrawn within their uncertainty. For
//! a linear model the draws have exactly the posterior distribution. For a nonlinear one they follow curved
//! valleys of χ², which a normal distribution about the minimum leaves: two springs in series whose sum of
//! compliances is known to 0.1 % may each be known to a factor of two. A first-order (delta) interval has the
//! same fault, and a profile of every predicted number at every line takes a search each.
//!
//! # Source  randomised maximum likelihood: Oliver, He and Reynolds, Proc. 5th ECMOR, 1996; Bardsley et al.,
//!   SIAM J. Sci. Comput. 36 (2014)
//! A1895–A1910.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::bootstrap::{Drawn, draw as draw_sample};
use super::mode_evidence::{ModeResidual, mode_residuals};
use super::place::{Coordinate, Place};
use super::problem::Problem;
use super::settings::IdentificationSettings;
use super::tolerance::mode_columns;
use super::uncertainty::certainty;
use crate::objective::{FrfObjective, ModeObjective, ObjectiveError};
use long_work::Control;
use machine::{Machine, ParameterValues, Prior};
use measurement::FitSet;
use optimizer::{LeastSquares, least_squares_within};

/// Minima and covariance of all fitted coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// The coordinates, in the order of a [`Place`].
    pub coordinates: Vec<Coordinate>,
    /// Minima that the data do not distinguish, the best first.
    pub minima: Vec<Place>,
    /// Covariance of the coordinates about the best minimum, with ranges and priors.
    pub covariance: DMatrix<f64>,
    /// Factor of the variance of the data, by misfit and correlation of the residuals (1).
    pub variance: f64,
    /// Residuals of modes; empty for whole FRFs.
    pub residuals: Vec<ModeResidual>,
}

/// One draw: a machine that the data leave possible.
#[derive(Debug, Clone, PartialEq)]
pub struct PosteriorDraw {
    /// Values of all parameters of the machine with its tolerances.
    pub values: ParameterValues,
    /// Fitted nut positions: as stated (m), and their shift (m).
    pub nut_shifts_m: Vec<(f64, f64)>,
}

/// Machines that the data leave possible.
#[derive(Debug, Clone, PartialEq)]
pub struct PosteriorSample {
    /// The machine with its tolerances as parameters.
    pub machine: Machine,
    /// The best fit.
    pub best: PosteriorDraw,
    /// The draws about each minimum.
    pub draws: Vec<Vec<PosteriorDraw>>,
    /// Whether all draws were made.
    pub complete: bool,
}

/// How machines are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Drawing {
    /// From the posterior.
    #[default]
    Posterior,
    /// By a bootstrap over the lines of FRFs, for comparison: it leaves out what tolerances and ranges leave
    /// possible.
    Lines,
}

/// End of the least squares of a draw: number of steps, and relative reduction of χ².
const END: (u64, f64) = (25, 3e-6);

/// The same for modes, which are compared more coarsely.
const MODES_END: (u64, f64) = (12, 1e-3);
/// Standard deviation of a nut position in its unit interval (1).
const NUT_SD: f64 = 0.05;

/// The objective on which the intervals of a fit are computed.
enum Objective<'m> {
    Frfs(Box<FrfObjective<'m>>),
    Modes(Box<ModePosterior<'m>>),
}

impl Objective<'_> {
    /// Returns the machine of the best minimum; with modes the identified values, and tolerances as described.
    fn best(&self, estimate: &ParameterValues, minimum: &Place) -> PosteriorDraw {
        match self {
            Objective::Frfs(own) => {
                PosteriorDraw { values: own.parameters(minimum), nut_shifts_m: own.nuts_at(minimum) }
            }
            Objective::Modes(own) => {
                let added = own.fitted.parameters.iter().skip(own.described).map(|p| p.start);
                let values = ParameterValues(estimate.iter().copied().chain(added).collect());
                PosteriorDraw { values, nut_shifts_m: Vec::new() }
            }
        }
    }
}

/// A mode objective in which tolerances correlate the residuals. They follow from the minimum, to first
/// order.
struct ModePosterior<'m> {
    objective: ModeObjective<'m>,
    /// Changes of the residuals by one standard deviation of each tolerance.
    columns: Vec<Vec<f64>>,
    /// The same for the correlated residuals, made independent.
    whitened: DMatrix<f64>,
    /// The machine with its tolerances as parameters, equal to that as described where they have their start
    /// values.
    fitted: Machine,
    /// Tolerance of each column: index of its parameter, coordinate, and change of the parameter by one
    /// standard deviation; 0 for one that is held.
    tolerances: Vec<(usize, Coordinate, f64)>,
    /// Fitted nut positions with a tolerance: name, position (m).
    nuts: Vec<(String, f64)>,
    nut_sd_m: f64,
    described: usize,
}

/// Returns the machine with the tolerances that a fit varies.
fn fitted_machine(
    machine: &Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
) -> Result<Machine, ObjectiveError> {
    Ok(if plan.tolerances { machine.with_tolerances(&fit.set().nuts_m())? } else { machine.clone() })
}

impl<'m> ModePosterior<'m> {
    /// Builds the objective about an estimate of the parameters as described.
    fn new(
        machine: &'m Machine,
        fit: &FitSet<'_>,
        plan: &IdentificationSettings,
        estimate: &[f64],
    ) -> Result<Self, ObjectiveError> {
        let mut fitted = fitted_machine(machine, fit, plan)?;
        let tolerances = neutral_tolerances(&mut fitted, machine.parameters.len());
        let narrow = ModeObjective::new(machine, fit, plan.settings, &plan.frozen)?;
        let own: Vec<f64> = narrow
            .free
            .iter()
            .map(|i| machine.parameters[*i].to_unit(estimate[*i]).clamp(0.0, 1.0))
            .collect();
        let columns = if plan.tolerances {
            mode_columns(machine, fit, plan, (&narrow, &narrow.extended(&own)))?
        } else {
            Vec::new()
        };
        let objective = match plan.tolerances {
            true => ModeObjective::with_all_free(machine, fit, plan.settings, &plan.frozen, &narrow.free)?
                .correlated(&columns),
            false => narrow,
        };
        let set = fit.set();
        let position = |p: &usize| Some((set.positions[*p].name.clone(), set.positions[*p].nut_m?));
        let nuts: Vec<(String, f64)> = if columns.len() > tolerances.len() {
            fit.positions().iter().filter_map(position).collect()
        } else {
            Vec::new()
        };
        let whitened = objective.whitened(&columns);
        let described = machine.parameters.len();
        Ok(ModePosterior {
            objective,
            columns,
            whitened,
            fitted,
            tolerances,
            nuts,
            nut_sd_m: set.tolerance.nut_m,
            described,
        })
    }

    /// Returns the number of coordinates that least squares varies.
    fn dimension(&self) -> usize {
        self.objective.free.len() + usize::from(self.objective.estimates_gain())
    }

    /// Returns the machine at coordinates of the objective, with deviations of the tolerances in prior
    /// standard deviations.
    fn draw(&self, place: &Place, deviations: &[f64]) -> PosteriorDraw {
        let own = self.objective.parameters(place);
        let mut values: Vec<f64> = own
            .iter()
            .copied()
            .chain(self.fitted.parameters.iter().skip(self.described).map(|p| p.start))
            .collect();
        let mut left = deviations.iter();
        for ((index, _, sd), deviation) in self.tolerances.iter().zip(&mut left) {
            let parameter = &self.fitted.parameters[*index];
            values[*index] = (parameter.start + sd * deviation).clamp(parameter.lower, parameter.upper);
        }
        let nut_shifts_m = self
            .nuts
            .iter()
            .zip(left)
            .map(|((_, nut_m), deviation)| (*nut_m, deviation * self.nut_sd_m))
            .collect();
        PosteriorDraw { values: ParameterValues(values), nut_shifts_m }
    }

    /// Returns the weighted, independent residuals at a place without those of the priors, and their
    /// derivatives.
    fn linearised(&self, place: &Place) -> (DVector<f64>, DMatrix<f64>) {
        let rows = self.whitened.nrows();
        let (residuals, slopes) = self.objective.linearised_at(place);
        (DVector::from_iterator(rows, residuals.into_iter().take(rows)), slopes.rows(0, rows).into_owned())
    }

    /// Returns the coordinates: those of the objective, tolerances, nut positions.
    fn coordinates(&self, machine: &Machine) -> Vec<Coordinate> {
        let own = self.objective.free.iter().map(|i| parameter_coordinate(&machine.parameters[*i]));
        let gain = self.objective.estimates_gain().then(|| of_measurement("gain".into(), None));
        let tolerances = self.tolerances.iter().map(|(_, coordinate, _)| coordinate.clone());
        let nuts = self
            .nuts
            .iter()
            .map(|(name, _)| of_measurement(format!("nut position of {name}"), Some((NUT_SD, 0.5))));
        own.chain(gain).chain(tolerances).chain(nuts).collect()
    }

    /// Returns the posterior of some minima.
    ///
    /// Given the parameters, tolerances have the mean −Gᵀ·r and the covariance 1 − Gᵀ·G, with the whitened
    /// residuals r and columns G.
    fn posterior(
        &self,
        machine: &Machine,
        fit: &FitSet<'_>,
        (minima, variance): (&[Place], f64),
    ) -> Posterior {
        let coordinates = self.coordinates(machine);
        let (dimension, columns) = (self.dimension(), &self.whitened);
        let (_, slopes) = self.linearised(&minima[0]);
        let mut information = slopes.transpose() * &slopes / variance;
        for (column, (sd, _)) in
            coordinates.iter().take(dimension).enumerate().filter_map(|(column, c)| Some((column, c.prior?)))
        {
            information[(column, column)] += 1.0 / (sd * sd);
        }
        let own = certainty(&information, 1.0).covariance;
        let follow = columns.transpose() * &slopes;
        let count = columns.ncols();
        let cross = -(&own * follow.transpose());
        let rest = DMatrix::identity(count, count) - columns.transpose() * columns
            + &follow * &own * follow.transpose();
        // Tolerances in prior standard deviations become coordinates of their unit intervals.
        let unit: Vec<f64> =
            coordinates.iter().skip(dimension).map(|c| c.prior.map_or(0.0, |(sd, _)| sd)).collect();
        let covariance = DMatrix::from_fn(dimension + count, dimension + count, |row, column| {
            match (row.checked_sub(dimension), column.checked_sub(dimension)) {
                (None, None) => own[(row, column)],
                (None, Some(at)) => cross[(row, at)] * unit[at],
                (Some(at), None) => cross[(column, at)] * unit[at],
                (Some(a), Some(b)) => rest[(a, b)] * unit[a] * unit[b],
            }
        });
        let whole = |minimum: &Place| {
            let (residuals, _) = self.linearised(minimum);
            let deviations = -(columns.transpose() * residuals);
            let tolerances = coordinates.iter().skip(dimension).zip(deviations.iter());
            let tolerances =
                tolerances.filter_map(|(c, t)| c.prior.map(|(sd, centre)| (centre + sd * t).clamp(0.0, 1.0)));
            Place(minimum.iter().copied().chain(tolerances).collect())
        };
        let minima: Vec<Place> = minima.iter().map(whole).collect();
        let residuals = mode_residuals(&self.objective, fit, (&coordinates, &minima), &self.columns);
        Posterior { coordinates, minima, covariance, variance, residuals }
    }
}

/// Sets the tolerances of a machine to the values that leave it as described, since modes are fitted without
/// them. Returns the tolerances.
///
/// Such a value is 0. A nut without length and joints without loss are only approached: these tolerances stay
/// at the lower end of their range, and with them the load centre of the nut. A machine with estimates of its
/// tolerances is described with these.
fn neutral_tolerances(fitted: &mut Machine, described: usize) -> Vec<(usize, Coordinate, f64)> {
    let offsets: Vec<usize> = fitted
        .shafts
        .iter()
        .flat_map(|shaft| shaft.nut_support_offset.depends_on().collect::<Vec<_>>())
        .collect();
    let is_estimated = !fitted.held.is_empty();
    let mut tolerances = Vec::new();
    for (index, parameter) in fitted.parameters.iter_mut().enumerate().skip(described) {
        let Some(prior) = parameter.prior else { continue };
        let coordinate = parameter_coordinate(parameter);
        let has_zero = (parameter.lower..=parameter.upper).contains(&0.0);
        let sd = match prior {
            Prior::Normal(sd) if is_estimated || (has_zero && !offsets.contains(&index)) => sd,
            _ => 0.0,
        };
        if !is_estimated {
            parameter.start = if has_zero { 0.0 } else { parameter.lower };
        }
        tolerances.push((index, coordinate, sd));
    }
    tolerances
}

fn parameter_coordinate(parameter: &machine::Parameter) -> Coordinate {
    let prior = parameter.prior.and_then(|prior| {
        let centre = prior.value(parameter.start, 0.0);
        let slope = parameter.deviation_slope(centre)?;
        Some((1.0 / slope.abs(), parameter.to_unit(centre)))
    });
    Coordinate { name: parameter.name().into(), of_machine: true, prior }
}

fn of_measurement(name: String, prior: Option<(f64, f64)>) -> Coordinate {
    Coordinate { name, of_machine: false, prior }
}

/// Returns the coordinates of whole FRFs.
fn frf_coordinates(objective: &FrfObjective<'_>, fit: &FitSet<'_>) -> Vec<Coordinate> {
    let machine = objective.machine();
    let mut all: Vec<Coordinate> =
        objective.free.iter().map(|i| parameter_coordinate(&machine.parameters[*i])).collect();
    all.extend(objective.estimates_gain().then(|| of_measurement("gain".into(), None)));
    let prior = Some((1.0 / objective.span(), 0.5));
    let middle = Place(vec![0.5; LeastSquares::dimension(objective)]);
    for (nut_m, _) in objective.nuts_at(&middle) {
        let name = fit.set().positions.iter().find(|p| p.nut_m == Some(nut_m)).map(|p| p.name.clone());
        all.push(of_measurement(
            format!("nut position of {}", name.unwrap_or_else(|| format!("{nut_m} m"))),
            prior,
        ));
    }
    for (at, channel) in objective.channels_at(&middle).iter().enumerate() {
        if objective.nut_coordinates().end + 2 * at < middle.len() {
            let channel =
                format!("{}/{}", machine.points[channel.response].name, channel.excitation.name(machine));
            all.extend(["gain", "delay"].map(|what| of_measurement(format!("{what} of {channel}"), prior)));
        }
    }
    all
}

/// Builds the posterior of a fit of whole FRFs: its minima, and the covariance about the best of them.
pub(super) fn of_frfs(
    objective: &FrfObjective<'_>,
    fit: &FitSet<'_>,
    minima: Vec<Place>,
    (misfit, correlation): (f64, f64),
) -> Posterior {
    let variance = misfit.max(1.0) * correlation.max(1.0);
    let inflated = objective.with_inflated_variance(variance);
    let information = LeastSquares::normal(inflated.as_ref().unwrap_or(objective), &minima[0]).information;
    let covariance = certainty(&information, if inflated.is_some() { 1.0 } else { variance }).covariance;
    let coordinates = frf_coordinates(objective, fit);
    Posterior { coordinates, minima, covariance, variance, residuals: Vec::new() }
}

/// Builds the posterior of a fit of modes from its minima, coordinates of the objective on which its
/// intervals are computed.
///
/// # Errors  as [`ModeObjective::new`].
pub(super) fn of_modes(
    machine: &Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    estimate: &ParameterValues,
    (minima, misfit): (&[Place], f64),
) -> Result<Posterior, ObjectiveError> {
    Ok(ModePosterior::new(machine, fit, plan, estimate)?.posterior(machine, fit, (minima, misfit.max(1.0))))
}

/// Draws `count` machines about each minimum of a posterior. The seed alone decides the draws, not the number
/// of threads.
///
/// `estimate` are the identified values of the parameters as described. With modes the best machine has
/// tolerances as described, as its fit.
///
/// # Errors  as [`FrfObjective::new`] and [`ModeObjective::new`]; the posterior is that of other data.
pub fn draw_posterior(
    machine: &Machine,
    fit: &FitSet<'_>,
    plan: &IdentificationSettings,
    (estimate, minima, variance): (&ParameterValues, &[Place], f64),
    (count, seed, drawing): (usize, u64, Drawing),
    control: &Control,
) -> Result<PosteriorSample, ObjectiveError> {
    let fitted = fitted_machine(machine, fit, plan)?;
    let objective = match plan.frf {
        Some(settings) => {
            let settings =
                if plan.tolerances { settings.with_tolerances(&fit.set().tolerance) } else { settings };
            Objective::Frfs(Box::new(FrfObjective::new(&fitted, fit, settings, &plan.frozen)?))
        }
        None => Objective::Modes(Box::new(ModePosterior::new(machine, fit, plan, estimate)?)),
    };
    let (dimension, whole) = match &objective {
        Objective::Frfs(own) => {
            (LeastSquares::dimension(own.as_ref()), LeastSquares::dimension(own.as_ref()))
        }
        Objective::Modes(own) => (own.dimension(), own.dimension() + own.whitened.ncols()),
    };
    if minima.is_empty() || minima.iter().any(|minimum| minimum.len() != whole) {
        return Err(ObjectiveError::Data(
            "the posterior of the result is that of other data or of another machine; identify again".into(),
        ));
    }
    let best = objective.best(estimate, &minima[0]);
    let lines = match (&objective, drawing) {
        (_, Drawing::Posterior) => None,
        (Objective::Frfs(own), Drawing::Lines) => {
            Some((own.blocks(), own.correlation_factor(&minima[0]).ceil() as usize))
        }
        (Objective::Modes(_), Drawing::Lines) => {
            return Err(ObjectiveError::Data("a bootstrap draws the lines of FRFs, not modes".into()));
        }
    };
    let objective = match objective {
        // Without priors the weights of the lines alone carry the variance. A bootstrap repeats the fit as it
        // was.
        Objective::Frfs(own) if variance > 1.0 && lines.is_none() => {
            Objective::Frfs(Box::new(own.with_inflated_variance(variance).unwrap_or_else(|| {
                let weights: Vec<Vec<f64>> =
                    own.lines().iter().map(|lines| vec![1.0 / variance; *lines]).collect();
                own.resampled(&weights)
            })))
        }
        other => other,
    };
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
    let seeds: Vec<Vec<u64>> =
        minima.iter().map(|_| (0..count).map(|_| generator.random()).collect()).collect();
    let step = control.steps("draws", count * minima.len());
    let draw = |minimum: &[f64], seed: u64| {
        if control.stopped() {
            return None;
        }
        let generator = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
        let drawn = match &objective {
            Objective::Frfs(own) => {
                let place = match &lines {
                    None => {
                        least_squares_within(&own.redrawn(generator), minimum, &[], END, control.stop()).place
                    }
                    Some((blocks, run)) => {
                        let sample = own.resampled(&draw_sample(Drawn::Lines, blocks, *run, generator));
                        least_squares_within(&sample, minimum, &[], END, control.stop()).place
                    }
                };
                let place = Place(place);
                PosteriorDraw { values: own.parameters(&place), nut_shifts_m: own.nuts_at(&place) }
            }
            Objective::Modes(own) => {
                let squares = own.objective.redrawn(variance.sqrt(), &own.whitened, generator);
                let place =
                    Place(least_squares_within(&squares, minimum, &[], MODES_END, control.stop()).place);
                own.draw(&place, &squares.tolerances_at(&own.objective, &place))
            }
        };
        step();
        Some(drawn)
    };
    let draws: Vec<Vec<PosteriorDraw>> = minima
        .iter()
        .zip(&seeds)
        .map(|(minimum, seeds)| {
            seeds.par_iter().filter_map(|seed| draw(&minimum[..dimension], *seed)).collect()
        })
        .collect();
    let machine = match &objective {
        Objective::Frfs(_) => fitted.clone(),
        Objective::Modes(own) => own.fitted.clone(),
    };
    Ok(PosteriorSample { best, draws, complete: !control.stopped(), machine })
}
