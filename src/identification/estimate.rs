//! Computes estimates from any data: repeated searches, minima, intervals and identifiability.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::bootstrap::bootstraps;
use super::combination::{Combination, combinations};
use super::contained::contained_starts;
use super::doubt::Doubt;
use super::place::Place;
use super::problem::{Basin, POLISH, Problem, Surroundings};
use super::profile::{CHI_SQUARE_95, ProfileStart, Profiler, Profiles, Region, joined};
use super::result::Identification;
use super::search::{SearchEffort, searched};
use super::settings::IdentificationSettings;
use super::tolerance::check_priors;
use super::uncertainty::{Certainty, Estimate, certainty, narrow_logarithmic_width, narrow_width};
use crate::objective::{AmplitudeFit, GAIN_RANGE, ObjectiveError};
use long_work::Control;
use machine::{Machine, Parameter, ParameterValues};
use optimizer::{LeastSquares, Polished, least_squares, least_squares_within};

/// Least-squares steps from each of many starts, before the best are selected.
const FIRST_STEPS: u64 = 10;
/// Largest number of starts, those with the least χ², that are continued.
const CONTINUED: usize = 12;
/// Largest distance from an end of the unit interval at which a parameter counts as lying at its bound.
const AT_BOUND: f64 = 1e-3;

/// A problem with more free parameters and uncertainties, on which the intervals are computed, and its
/// starts.
pub(super) type Wider<P> = Option<(P, Vec<Place>)>;

/// Fits a problem and computes intervals and identifiability: for FRFs on the problem itself, for modes on a
/// wider one about the minimum.
///
/// Without a free parameter it evaluates the objective at the start values. Predictions, derived quantities
/// and estimates of tolerances are left to the caller.
///
/// # Errors  those of `wider`.
pub(super) fn estimate<P: Problem>(
    problem: &P,
    wider: impl Fn(&Place) -> Result<Wider<P>, ObjectiveError>,
    machine: &Machine,
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<Identification, ObjectiveError> {
    let free = problem.free().to_vec();
    if free.is_empty() {
        return Ok(at_start(problem, machine));
    }
    let starts = contained_starts(machine, problem.varied(), &plan.contained);
    let found = searched(problem, (plan, &starts), control);
    let (best, least) = finite(problem, found.minima.first())?;
    let freedom = problem.observations().saturating_sub(best.len());
    let misfit_at = |place: &Place| {
        let chi_square = problem.squares(None, |squares| squares.chi_square(place));
        let misfit = if freedom > 0 { (chi_square / freedom as f64).max(1.0) } else { 1.0 };
        (chi_square, misfit, problem.correlation_factor(place).max(1.0))
    };
    let first @ (_, misfit, correlation_factor) = misfit_at(&best);
    let inflated = problem.with_inflated_variance(misfit * correlation_factor);
    let mut basins = found.minima;
    basins.retain(|basin| basin.cost - least <= CHI_SQUARE_95 * misfit * correlation_factor);
    if let Some(inflated) = &inflated {
        basins = control.cached("weakened", || refined_basins(inflated, basins, CHI_SQUARE_95, control));
    }
    let mut place = basins[0].place.clone();
    let has_intervals = problem.is_likelihood();
    let profiled = has_intervals && plan.profile;
    let inflation = if inflated.is_some() { 1.0 } else { misfit * correlation_factor };
    let wider = if profiled { wider(&place)? } else { None };
    let wide = match &wider {
        Some((wider, from)) => {
            let start = |place: &Place| Basin { place: place.clone(), cost: 0.0, starts: 1 };
            let starts = from.iter().map(start).collect();
            basins =
                control.cached("wider", || refined_basins(wider, starts, CHI_SQUARE_95 * inflation, control));
            wider
        }
        None => inflated.as_ref().unwrap_or(problem),
    };
    let columns: Vec<usize> = (0..free.len()).chain(wide.gain_column()).collect();
    let intervals = intervals(wide, basins, (&columns, inflation, profiled), control);
    let Intervals { basins, mut regions, whole } = intervals;
    if inflated.is_some() || wider.is_none() {
        // A profile may have met a deeper minimum.
        place = basins[0].place.clone();
    }
    let (chi_square, misfit, correlation_factor) = if inflated.is_some() { misfit_at(&place) } else { first };
    let mut combinations = Vec::new();
    if profiled {
        let here = (&basins[0], &whole, &regions[..free.len()]);
        combinations = combined(wide, machine, here, inflation, control);
    }
    if wider.is_some() {
        // The estimate is that of the fit with the parameters that modes hardly determine held fixed.
        let own = (0..free.len()).chain(problem.gain_column()).map(|at| place[at]);
        regions.iter_mut().zip(own).for_each(|(region, u)| *region = joined(std::mem::take(region), (u, u)));
    }
    let bootstraps = bootstraps(problem, &place, (plan.bootstrap, plan.seed), control);
    let (estimates, at_bounds, ends) =
        parameter_estimates(machine, &free, &place, &problem.values(&place), &regions, has_intervals);
    let mut warnings = [shortage(problem.observations(), best.len()), at_bounds].concat();
    let gain_column = problem.gain_column();
    let gain_interval = |at: usize| gain_interval(&regions[free.len()], place[at]);
    let (gain_interval95, gain_identifiable) =
        gain_column.filter(|_| has_intervals).map(gain_interval).unzip();
    if has_intervals {
        warnings.extend(widened(chi_square, freedom, misfit, correlation_factor));
    }
    warnings.extend(gain_column.and_then(|at| gain_at_end(place[at])));
    let complete = !control.stopped() && found.rounds.iter().all(|r| r.found.complete);
    let agree =
        (complete && plan.near.is_none() && found.effort.required > 1).then(|| found.effort.is_enough());
    warnings.extend((agree == Some(false)).then(|| seldom_found(found.effort)));
    let found = Identification {
        estimates,
        gain_interval95,
        gain_identifiable,
        // A profile may have met a deeper minimum.
        cost: if has_intervals { least.min(chi_square) } else { least },
        evaluations: found.rounds.iter().map(|r| r.found.evaluations).sum(),
        repeats: found.rounds,
        effort: found.effort,
        agree,
        chi_square,
        degrees_of_freedom: freedom,
        correlation_factor,
        certainty: whole.of(&columns),
        sd: whole.sd,
        combinations,
        bootstraps,
        basins,
        complete,
        warnings,
        ..without_fit(problem, machine, place)
    };
    Ok(judged(found, ends, has_intervals))
}

/// Returns the result with the doubts that misfit, search, priors and ends of ranges cast on it.
fn judged(mut found: Identification, ends: Vec<Doubt>, is_likelihood: bool) -> Identification {
    let (of_priors, notes) = check_priors(&found.machine, (&found.free, &found.sd), &found.values);
    found.warnings.extend(notes);
    let excess = found.misfit().max(1.0) * found.correlation_factor;
    let misfit = (is_likelihood && excess > EXCESS).then_some(Doubt::Misfit(excess));
    let SearchEffort { found: times, starts, .. } = found.effort;
    let search = (found.agree == Some(false)).then_some(Doubt::Search(times, starts));
    let doubts = ends.into_iter().chain(of_priors).chain(misfit).chain(search).collect();
    found.doubted(doubts)
}

/// Returns the interval of an estimated gain for the region of its coordinate, and whether the gain is
/// identifiable.
fn gain_interval(region: &Region, place: f64) -> ((f64, f64), bool) {
    let end = |u: f64| GAIN_RANGE.0 * (u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).exp();
    let (low, high) = hull(region);
    let is_identifiable =
        is_narrow(region, narrow_logarithmic_width(GAIN_RANGE)) && gain_at_end(place).is_none();
    ((end(low), end(high)), is_identifiable)
}

/// Minima, the regions of some coordinates, and the first-order uncertainty about the best minimum.
struct Intervals {
    basins: Vec<Basin>,
    regions: Vec<Region>,
    whole: Certainty,
}

/// Computes the regions of some coordinates: by profiles, or to first order.
fn intervals<P: Problem>(
    problem: &P,
    basins: Vec<Basin>,
    (columns, inflation, profiled): (&[usize], f64, bool),
    control: &Control,
) -> Intervals {
    if profiled {
        control.begin("intervals");
    }
    let (basins, regions) = match profiled {
        true => {
            control.cached("profiles", || confidence_regions(problem, basins, columns, inflation, control))
        }
        false => (basins, None),
    };
    let information = problem.squares(None, |squares| squares.normal(&basins[0].place).information);
    let whole = certainty(&information, inflation);
    let first_order = |at: &usize| {
        let (here, half) = (basins[0].place[*at], 1.96 * whole.sd[*at]);
        vec![(here - half, here + half)]
    };
    let regions = regions.unwrap_or_else(|| columns.iter().map(first_order).collect());
    Intervals { basins, regions, whole }
}

/// Refines minima and returns the distinct ones within a rise of χ² above the least, in rising order.
///
/// The data variance of the problem covers the model error, so that priors keep their weight against the
/// data.
fn refined_basins<P: Problem>(problem: &P, basins: Vec<Basin>, rise: f64, control: &Control) -> Vec<Basin> {
    let settle = |basin: Basin, end: (u64, f64)| {
        let polished = problem
            .squares(None, |squares| least_squares_within(squares, &basin.place, &[], end, control.stop()));
        Basin { place: Place(polished.place), cost: polished.normal.chi_square, ..basin }
    };
    let all = |basins: Vec<Basin>, end: (u64, f64)| {
        let mut ends: Vec<Basin> = basins.into_par_iter().map(|basin| settle(basin, end)).collect();
        ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        ends
    };
    // A few steps from many starts select those to continue.
    let mut near = if basins.len() > CONTINUED { all(basins, (FIRST_STEPS, 1e-3)) } else { basins };
    near.truncate(CONTINUED);
    let ends = all(near, (POLISH, 1e-7));
    let least = ends[0].cost;
    let mut distinct: Vec<(Basin, Surroundings)> = Vec::new();
    for end in ends.into_iter().filter(|end| end.cost - least <= rise) {
        if !distinct.iter().any(|(_, around)| around.hold(&end.place, rise)) {
            let around =
                Surroundings { place: end.place.clone(), information: problem.information(&end.place) };
            distinct.push((end, around));
        }
    }
    distinct.into_iter().map(|(basin, _)| basin).collect()
}

/// Returns place and cost of the best minimum.
///
/// # Errors  its misfit is not finite.
fn finite<P: Problem>(problem: &P, best: Option<&Basin>) -> Result<(Place, f64), ObjectiveError> {
    let is_finite = |best: &&Basin| {
        let chi_square = problem.squares(None, |squares| squares.chi_square(&best.place));
        (best.cost * chi_square * problem.correlation_factor(&best.place)).is_finite()
    };
    let fault = "the misfit is not finite at any values of the parameters";
    let remedy = "correct the stated noise, or the number that is far too large or too small";
    let found = best.filter(is_finite).map(|best| (best.place.clone(), best.cost));
    found.ok_or_else(|| ObjectiveError::Data(format!("{fault}; {remedy}")))
}

/// Finds the combinations of parameters that the data determine about a minimum. `regions` are those of the
/// first parameters.
fn combined<P: Problem>(
    problem: &P,
    machine: &Machine,
    (here, certainty, regions): (&Basin, &Certainty, &[Region]),
    inflation: f64,
    control: &Control,
) -> Vec<Combination> {
    let free = problem.free();
    let described: Vec<&Parameter> = free.iter().map(|i| &machine.parameters[*i]).collect();
    let of = |place: &Place| -> Vec<f64> {
        let all = problem.values(place);
        free.iter().map(|i| all[*i]).collect()
    };
    let valley = |column: usize, by: f64| {
        let mut moved = here.place.clone();
        moved[column] = (moved[column] + by).clamp(0.0, 1.0);
        // Outside the region of the profile χ² rises too much, whatever the others do.
        if regions
            .get(column)
            .is_some_and(|region| region.iter().all(|(low, high)| !(*low..=*high).contains(&moved[column])))
        {
            return None;
        }
        let held: Vec<bool> = (0..moved.len()).map(|i| i == column).collect();
        let polished =
            problem.squares(None, |squares| least_squares(squares, &moved, &held, POLISH, control.stop()));
        (polished.normal.chi_square - here.cost < CHI_SQUARE_95 * inflation)
            .then(|| of(&Place(polished.place)))
    };
    let values = problem.values(&here.place);
    let is_known = |(column, at): (usize, &usize)| {
        2.0 * 1.96 * certainty.sd[column] <= narrow_width(&machine.parameters, &values, *at)
    };
    let known: Vec<bool> = free.iter().enumerate().map(is_known).collect();
    let mut found = combinations(&described, &of(&here.place), (certainty, &known), valley);
    found.iter_mut().for_each(|c| c.parameters = (free[c.parameters.0], free[c.parameters.1]));
    found
}

/// Number of times that the profiles start again from a deeper minimum.
const DEEPER: usize = 4;

/// Computes the confidence regions of some coordinates by profiles from all basins; `None` if stopped.
/// Returns also the basins, with deeper ones that the profiles have met.
fn confidence_regions<P: Problem>(
    problem: &P,
    mut basins: Vec<Basin>,
    columns: &[usize],
    inflation: f64,
    control: &Control,
) -> (Vec<Basin>, Option<Vec<Region>>) {
    for _ in 0..DEEPER {
        let found = problem.squares(None, |squares| profiles(squares, &basins, columns, inflation, control));
        match found {
            Profiles::Regions(regions) => return (basins, Some(regions)),
            Profiles::Stopped => return (basins, None),
            Profiles::Deeper(place) => {
                basins.insert(0, Basin { place: Place(place), cost: 0.0, starts: 0 });
                basins = refined_basins(problem, basins, CHI_SQUARE_95 * inflation, control);
            }
        }
    }
    (basins, None)
}

fn profiles(
    squares: &dyn LeastSquares,
    basins: &[Basin],
    columns: &[usize],
    inflation: f64,
    control: &Control,
) -> Profiles {
    let start = |basin: &Basin| {
        let minimum = Polished {
            place: basin.place.0.clone(),
            normal: squares.normal(&basin.place),
            evaluations: 0,
            converged: true,
        };
        ProfileStart { certainty: certainty(&minimum.normal.information, inflation), minimum }
    };
    let minima: Vec<ProfileStart> = basins.iter().map(start).collect();
    Profiler { squares, minima: &minima, rise: CHI_SQUARE_95 * inflation, control }.regions(columns)
}

/// Whether a region is no wider than a share of the unit interval.
fn is_narrow(region: &Region, widest: f64) -> bool {
    let (low, high) = hull(region);
    high - low <= widest
}

/// Returns the hull of a region.
fn hull(region: &Region) -> (f64, f64) {
    region
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |hull, part| (hull.0.min(part.0), hull.1.max(part.1)))
}

/// Variance by misfit over that by the stated uncertainty (1) above which values depend on what the model
/// lacks: intervals are more than twice as wide as those by noise and tolerances, so that they consist of
/// misfit for the larger part. Model error is no noise, so that its part is no probability.
const EXCESS: f64 = 4.0;

/// Evaluates the objective at the start values, without a fit.
fn at_start<P: Problem>(problem: &P, machine: &Machine) -> Identification {
    let place = problem.start_near(&Place(Vec::new()));
    Identification {
        estimates: parameter_estimates(machine, &[], &place, &problem.values(&place), &[], false).0,
        cost: problem.cost(&place),
        chi_square: problem.squares(None, |squares| squares.chi_square(&place)),
        correlation_factor: problem.correlation_factor(&place),
        warnings: vec![
            "no parameter is free: the objective and all errors are those of the start values".into(),
        ],
        ..without_fit(problem, machine, place)
    }
}

/// Returns the values and the gain at coordinates, without what a fit finds.
fn without_fit<P: Problem>(problem: &P, machine: &Machine, place: Place) -> Identification {
    let values = problem.values(&place);
    let free = problem.free().to_vec();
    Identification {
        machine: machine.clone(),
        estimates: Vec::new(),
        doubts: Vec::new(),
        tolerances: Vec::new(),
        channels: Vec::new(),
        basins: Vec::new(),
        gain: AmplitudeFit { gain: problem.gain_at(&place), count: 0 },
        cost: 0.0,
        evaluations: 0,
        repeats: Vec::new(),
        effort: SearchEffort { starts: 0, found: 0, required: 0 },
        agree: None,
        chi_square: 0.0,
        degrees_of_freedom: problem.observations(),
        gain_interval95: None,
        gain_identifiable: None,
        certainty: certainty(&DMatrix::zeros(0, 0), 1.0),
        derived: Vec::new(),
        combinations: Vec::new(),
        bootstraps: Vec::new(),
        correlation_factor: 1.0,
        posterior: None,
        varied_parameters: problem.varied().to_vec(),
        free,
        fitted: Vec::new(),
        held_out: Vec::new(),
        fitted_frfs: Vec::new(),
        held_out_frfs: Vec::new(),
        observations: problem.observations(),
        sd: Vec::new(),
        complete: true,
        warnings: Vec::new(),
        values,
        place,
    }
}

/// Warns of widened intervals: a misfit above the stated weights, or correlated residuals.
fn widened(chi_square: f64, freedom: usize, misfit: f64, correlation_factor: f64) -> Vec<String> {
    let misfit_warning = || {
        format!(
            "χ² is {chi_square:.1} for {freedom} degrees of freedom: model and data differ by more than the stated uncertainty; intervals are widened by √{misfit:.2}; check the lines or modes with the largest errors, or run diagnose to find the missing effect"
        )
    };
    let correlation_warning = || {
        format!(
            "residuals of neighbouring lines are correlated, so they are not noise: the model lacks an effect; intervals are widened by √{correlation_factor:.1}; run diagnose to find it"
        )
    };
    (misfit > 2.0)
        .then(misfit_warning)
        .into_iter()
        .chain((correlation_factor > 2.0).then(correlation_warning))
        .collect()
}

/// Warns of an estimated gain at an end of its range.
fn gain_at_end(place: f64) -> Option<String> {
    let end = if place < 0.5 { GAIN_RANGE.0 } else { GAIN_RANGE.1 };
    let at_end = !(AT_BOUND..=1.0 - AT_BOUND).contains(&place);
    at_end.then(|| format!("the estimated gain lies at an end of its range, {end:e}: check the units of the set, or state the gain"))
}

/// Warns of a best minimum that was not found again as often as required.
fn seldom_found(effort: SearchEffort) -> String {
    let SearchEffort { starts, found, required } = effort;
    format!(
        "the best minimum was found from {found} of {starts} starts, not from {required} as required: a better one may exist; narrow the ranges of the parameters, or raise the number of times it has to be found (repeats)"
    )
}

fn shortage(observations: usize, unknowns: usize) -> Vec<String> {
    let short = observations < unknowns;
    short
        .then(|| {
            format!(
                "{observations} observations cannot determine {unknowns} unknowns: those that the data do not determine are marked not identifiable; fit more positions, or freeze parameters"
            )
        })
        .into_iter()
        .collect()
}

/// Returns the estimates of all parameters, with warnings and doubts for those at an end of their range.
fn parameter_estimates(
    machine: &Machine,
    free: &[usize],
    place: &Place,
    values: &ParameterValues,
    regions: &[Region],
    has_intervals: bool,
) -> (Vec<Estimate>, Vec<String>, Vec<Doubt>) {
    let (mut warnings, mut doubts) = (Vec::new(), Vec::new());
    let mut estimates: Vec<Estimate> = (0..machine.parameters.len())
        .map(|parameter| Estimate::without_interval(parameter, values[parameter], None))
        .collect();
    for (column, &parameter) in free.iter().enumerate() {
        let (u, (low, high)) = (place[column], hull(&regions[column]));
        let description = &machine.parameters[parameter];
        let end = |x: f64| description.from_unit(x.clamp(0.0, 1.0));
        let at_bound = !(AT_BOUND..=1.0 - AT_BOUND).contains(&u);
        let widest = narrow_width(&machine.parameters, values, parameter);
        let narrow = is_narrow(&regions[column], widest);
        let estimate = Estimate {
            parameter,
            value: values[parameter],
            interval95: has_intervals.then(|| (end(low), end(high))),
            intervals95: regions[column]
                .iter()
                .filter(|_| has_intervals)
                .map(|(low, high)| (end(*low), end(*high)))
                .collect(),
            identifiable: has_intervals.then_some(narrow && !at_bound),
            depends: false,
            at_bound,
        };
        estimates[parameter] = estimate;
        if at_bound {
            let which = if u < 0.5 { ("lower", description.lower) } else { ("upper", description.upper) };
            let remedy = if narrow {
                doubts.push(Doubt::End(description.id.clone(), which.0));
                "the data drive it there; check its range and the model"
            } else {
                "the data do not determine it; run plan to find a measurement that does"
            };
            warnings.push(format!(
                "{} lies at the {} end of its range, {:e} {}: {remedy}",
                description.id, which.0, which.1, description.unit
            ));
        }
    }
    (estimates, warnings, doubts)
}
