//! Computes estimates from any data: repeated searches, minima, intervals and identifiability.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::bootstrap::{Bootstrap, Drawn, bootstrap};
use super::combination::{Combination, combinations};
use super::place::Place;
use super::problem::{Problem, SearchEnd, distance};
use super::profile::{CHI_SQUARE_95, profiles};
use super::settings::{IdentificationSettings, Repeat};
use super::uncertainty::{Certainty, NARROWING, RANGE_SD, certainty, counted};
use crate::objective::{GAIN_RANGE, ObjectiveError};
use machine::{Machine, Parameter, ParameterValues};
use optimizer::{Control, Polished, SearchResult, SearchSettings, least_squares, least_squares_within, search};

/// An identified parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Index in the machine.
    pub parameter: usize,
    /// Value in its unit.
    pub value: f64,
    /// 95 % interval; `None` for a parameter that was not fitted.
    pub interval95: Option<(f64, f64)>,
    /// Whether it is identifiable from the data; `None` for a parameter that was not fitted.
    pub identifiable: Option<bool>,
    /// Whether it lies at an end of its plausible range.
    pub at_bound: bool,
}

/// Parameters after a fit: values, intervals, identifiability, warnings.
pub(super) struct Estimation {
    pub place: Place,
    pub values: ParameterValues,
    pub gain: f64,
    pub estimates: Vec<Estimate>,
    pub gain_interval95: Option<(f64, f64)>,
    pub gain_identifiable: Option<bool>,
    pub repeats: Vec<Repeat>,
    pub agree: Option<bool>,
    pub chi_square: f64,
    pub freedom: usize,
    pub correlation_factor: f64,
    pub certainty: Certainty,
    /// Standard deviation of every unit-cube coordinate, nuisance parameters included.
    pub sd: Vec<f64>,
    pub combinations: Vec<Combination>,
    pub bootstraps: Vec<Bootstrap>,
    pub basins: Vec<Basin>,
    pub complete: bool,
    pub warnings: Vec<String>,
}

/// A minimum of χ² that the data cannot distinguish from the least one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basin {
    /// Its coordinates.
    pub place: Place,
    /// χ².
    pub cost: f64,
    /// Number of searches that found it.
    pub searches: usize,
}

/// Largest number of least-squares steps from a nearby start.
const POLISH: u64 = 100;
/// Least-squares steps from each of many starts, before the best are selected.
const FIRST_STEPS: u64 = 10;
/// Largest number of starts, those with the least χ², that are continued.
const CONTINUED: usize = 6;
/// Largest distance from an end of the unit interval at which a parameter counts as lying at its bound.
const AT_BOUND: f64 = 1e-3;

/// Runs least squares from a nearby start. Returns the result, and its coordinates with the nuisance parameters.
fn polished_from_nearby<P: Problem>(problem: &P, near: &Place, control: &Control) -> (SearchResult, Place) {
    let polished = problem.squares(None, |squares| least_squares(squares, &problem.start_near(near), &[], POLISH, control.stop()));
    let (place, cost) = (polished.place[..problem.dimension()].to_vec(), polished.normal.chi_square);
    let (trace, population) = (Vec::new(), Vec::new());
    let found =
        SearchResult { place, cost, evaluations: polished.evaluations, generations: 0, trace, population, complete: !control.stopped() };
    (found, Place(polished.place))
}

/// Runs the searches of the plan, each with its own seed: differential evolution, then the refinement of the problem.
fn searches<P: Problem>(problem: &P, plan: &IdentificationSettings, control: &Control) -> Vec<(Repeat, Vec<SearchEnd>)> {
    let (repeats, threads) = (plan.repeats.max(1), rayon::current_num_threads());
    let seed = |repeat: usize| plan.seed.wrapping_add(1_000_003 * repeat as u64);
    let explored = |repeat: usize| {
        let usual = SearchSettings { strategy: plan.strategy, ..SearchSettings::for_dimension(problem.dimension(), seed(repeat)) };
        control.cached(&format!("search {}", seed(repeat)), || search(problem, problem.settings(usual), control))
    };
    let polished = |repeat: usize, mut found: SearchResult| {
        let (ends, spent) = control.cached(&format!("polish {}", seed(repeat)), || problem.polish(&found, control));
        if let Some(end) = ends.first() {
            (found.place, found.cost) = (end.place[..found.place.len()].to_vec(), end.cost);
        }
        found.evaluations += spent;
        found.population.clear();
        found.complete &= !control.stopped();
        (Repeat { seed: seed(repeat), found }, ends)
    };
    // A population is evaluated on all threads, a simplex on one. The last searches defer their refinement until all populations are done,
    // so that there is one for each thread. The refinements of the earlier searches run in parallel with later populations.
    let explored_or_polished: Vec<Result<(Repeat, Vec<SearchEnd>), SearchResult>> = (0..repeats)
        .into_par_iter()
        .map(|repeat| {
            let found = explored(repeat);
            if repeat + threads < repeats { Ok(polished(repeat, found)) } else { Err(found) }
        })
        .collect();
    explored_or_polished
        .into_par_iter()
        .enumerate()
        .map(|(repeat, result)| result.unwrap_or_else(|found| polished(repeat, found)))
        .collect()
}

/// Runs the searches, or least squares from the nearby solution of the plan. Returns each with its ends, in the order of rising cost.
fn runs<P: Problem>(problem: &P, plan: &IdentificationSettings, control: &Control) -> (Vec<Repeat>, Vec<Vec<SearchEnd>>) {
    let mut runs = match &plan.near {
        Some(near) => {
            let (found, place) = control.cached("polish", || polished_from_nearby(problem, near, control));
            let end = SearchEnd { cost: found.cost, place };
            vec![(Repeat { seed: plan.seed, found }, vec![end])]
        }
        None => searches(problem, plan, control),
    };
    runs.sort_by(|a, b| a.0.found.cost.total_cmp(&b.0.found.cost));
    runs.into_iter().unzip()
}

/// A problem with more free parameters and uncertainties, on which the intervals are computed, and its starts.
pub(super) type Wider<P> = Option<(P, Vec<Place>)>;

/// Fits a problem and computes intervals and identifiability: for FRFs on the problem itself, for modes on a wider one about the minimum.
///
/// # Errors  no parameter is free; those of `wider`.
pub(super) fn estimate<P: Problem>(
    problem: &P,
    wider: impl Fn(&Place) -> Result<Wider<P>, ObjectiveError>,
    machine: &Machine,
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<Estimation, ObjectiveError> {
    let free = problem.free().to_vec();
    if free.is_empty() {
        return Err(ObjectiveError::Data("no parameter is free to be identified; freeze fewer, or set fit = \"always\" for one".into()));
    }
    let (repeats, ends) = runs(problem, plan, control);
    let unknowns = ends[0][0].place.len();
    let freedom = problem.observations().saturating_sub(unknowns);
    let misfit_at = |place: &Place| {
        let chi_square = problem.squares(None, |squares| squares.chi_square(place));
        let misfit = if freedom > 0 { (chi_square / freedom as f64).max(1.0) } else { 1.0 };
        (chi_square, misfit, problem.correlation_factor(place).max(1.0))
    };
    let first = misfit_at(&ends[0][0].place);
    let (_, misfit, correlation_factor) = first;
    let inflated = problem.with_inflated_variance(misfit * correlation_factor);
    let mut basins = basins(&ends, free.len(), CHI_SQUARE_95 * misfit * correlation_factor);
    if let Some(inflated) = &inflated {
        basins = control.cached("weakened", || refined_basins(inflated, basins, (free.len(), CHI_SQUARE_95), control));
    }
    let place = basins[0].place.clone();
    let values = problem.values(&place);
    let gain = problem.gain_at(&place);
    let (chi_square, misfit, correlation_factor) = if inflated.is_some() { misfit_at(&place) } else { first };
    // Eq. 26 is no likelihood: its minimum has no intervals.
    let has_intervals = problem.is_likelihood();
    let inflation = if inflated.is_some() { 1.0 } else { misfit * correlation_factor };
    let wider = if has_intervals && plan.profile { wider(&place)? } else { None };
    let wide = match &wider {
        Some((wider, from)) => {
            let starts = from.iter().map(|place| Basin { place: place.clone(), cost: 0.0, searches: 1 }).collect();
            basins = control.cached("wider", || refined_basins(wider, starts, (wider.free().len(), CHI_SQUARE_95 * inflation), control));
            wider
        }
        None => inflated.as_ref().unwrap_or(problem),
    };
    let shares: Vec<f64> = wide.free().iter().map(|i| counted(&machine.parameters[*i])).collect();
    let information = wide.squares(None, |squares| squares.normal(&basins[0].place).information);
    let whole = certainty(&information, inflation, &shares);
    let columns: Vec<usize> = (0..free.len()).chain(wide.gain_column()).collect();
    let first_order = |at: &usize| {
        let (here, half) = (basins[0].place[*at], 1.96 * whole.sd[*at]);
        (here - half, here + half)
    };
    let profiled = (has_intervals && plan.profile)
        .then(|| control.cached("profiles", || joined_profiles(wide, &basins, (&columns, &shares), inflation, control)))
        .flatten();
    let mut intervals = profiled.unwrap_or_else(|| columns.iter().map(first_order).collect());
    if wider.is_some() {
        // The estimate is that of the fit with the parameters that modes hardly determine held fixed.
        let own = (0..free.len()).chain(problem.gain_column()).map(|at| place[at]);
        intervals.iter_mut().zip(own).for_each(|(interval, u)| *interval = (interval.0.min(u), interval.1.max(u)));
    }
    let certainty = whole.of(&columns);
    let bootstraps = [Drawn::Lines, Drawn::Positions]
        .into_iter()
        .filter_map(|drawn| bootstrap(problem, &place, drawn, plan.bootstrap, plan.seed, control))
        .collect();
    let mut warnings = shortage(problem.observations(), unknowns);
    let (estimates, at_bounds) = parameter_estimates(machine, &free, &place, &values, &intervals, &certainty, has_intervals);
    warnings.extend(at_bounds);
    let gain_column = problem.gain_column();
    let gain_interval95 = gain_column.filter(|_| has_intervals).map(|_| {
        let end = |u: f64| GAIN_RANGE.0 * (u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).exp();
        (end(intervals[free.len()].0), end(intervals[free.len()].1))
    });
    warnings.extend(has_intervals.then(|| widened(chi_square, freedom, misfit, correlation_factor)).into_iter().flatten());
    let combinations =
        if has_intervals && plan.profile { combined(wide, machine, (&basins[0], &whole), inflation, control) } else { Vec::new() };
    warnings.extend(gain_column.and_then(|at| gain_at_end(place[at])));
    let complete = !control.stopped() && repeats.len() == plan.repeats.max(1) && repeats.iter().all(|r| r.found.complete);
    let agree = (complete && repeats.len() > 1).then(|| agreement(&repeats, &certainty, free.len()));
    warnings.extend((agree == Some(false)).then(|| disagreement(&repeats)));
    Ok(Estimation {
        gain_identifiable: gain_column.filter(|_| has_intervals).and(certainty.identifiable.get(free.len()).copied()),
        place,
        values,
        gain,
        estimates,
        gain_interval95,
        repeats,
        agree,
        chi_square,
        freedom,
        correlation_factor,
        certainty,
        sd: whole.sd,
        combinations,
        bootstraps,
        basins,
        complete,
        warnings,
    })
}

/// Refines minima and returns the distinct ones within a rise of χ² above the least, in rising order.
///
/// The data variance of the problem covers the model error, so that priors keep their weight against the data.
fn refined_basins<P: Problem>(problem: &P, basins: Vec<Basin>, (free, rise): (usize, f64), control: &Control) -> Vec<Basin> {
    let settle = |basin: Basin, end: (u64, f64)| {
        let polished = problem.squares(None, |squares| least_squares_within(squares, &basin.place, &[], end, control.stop()));
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
    let mut distinct: Vec<Basin> = Vec::new();
    for end in ends.into_iter().filter(|end| end.cost - least <= rise) {
        if distinct.iter().all(|other| !same(&other.place, &end.place, free)) {
            distinct.push(end);
        }
    }
    distinct
}

/// Whether two points of the unit cube belong to the same minimum.
fn same(a: &[f64], b: &[f64], free: usize) -> bool {
    distance(&a[..free], b) < MIN_DISTANCE
}

/// Finds the combinations of parameters that the data determine about a minimum.
fn combined<P: Problem>(
    problem: &P,
    machine: &Machine,
    (here, certainty): (&Basin, &Certainty),
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
        let held: Vec<bool> = (0..moved.len()).map(|i| i == column).collect();
        let polished = problem.squares(None, |squares| least_squares(squares, &moved, &held, POLISH, control.stop()));
        (polished.normal.chi_square - here.cost < CHI_SQUARE_95 * inflation).then(|| of(&Place(polished.place)))
    };
    let mut found = combinations(&described, &of(&here.place), certainty, valley);
    found.iter_mut().for_each(|c| c.parameters = (free[c.parameters.0], free[c.parameters.1]));
    found
}

/// Smallest coordinate difference in the unit cube at which two ends are different minima.
const MIN_DISTANCE: f64 = 0.02;

/// Returns the distinct minima among the ends of searches, within a rise of χ² above the least, in rising order.
fn basins(searches: &[Vec<SearchEnd>], free: usize, rise: f64) -> Vec<Basin> {
    let mut ends: Vec<(usize, &SearchEnd)> =
        searches.iter().enumerate().flat_map(|(search, ends)| ends.iter().map(move |end| (search, end))).collect();
    ends.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let least = ends.first().map_or(0.0, |(_, end)| end.cost);
    let mut basins: Vec<(Basin, Vec<usize>)> = Vec::new();
    for (search, end) in ends.into_iter().filter(|(_, end)| end.cost - least <= rise) {
        match basins.iter_mut().find(|(basin, _)| same(&basin.place, &end.place, free)) {
            Some((_, by)) if by.contains(&search) => {}
            Some((_, by)) => by.push(search),
            None => basins.push((Basin { place: end.place.clone(), cost: end.cost, searches: 1 }, vec![search])),
        }
    }
    basins.into_iter().map(|(basin, by)| Basin { searches: by.len(), ..basin }).collect()
}

/// Computes intervals of some coordinates: the hull of the profile intervals of all basins. `None` if stopped.
fn joined_profiles<P: Problem>(
    problem: &P,
    basins: &[Basin],
    (columns, shares): (&[usize], &[f64]),
    inflation: f64,
    control: &Control,
) -> Option<Vec<(f64, f64)>> {
    let least = basins.first()?.cost;
    let mut joined: Option<Vec<(f64, f64)>> = None;
    for basin in basins {
        // A profile has already passed a basin that lies within the intervals so far.
        let inside = |all: &Vec<(f64, f64)>| columns.iter().zip(all).all(|(c, (low, high))| (*low..=*high).contains(&basin.place[*c]));
        if joined.as_ref().is_some_and(inside) {
            continue;
        }
        let own = problem.squares(None, |squares| {
            let best = Polished { place: basin.place.0.clone(), normal: squares.normal(&basin.place), evaluations: 0, converged: true };
            let certainty = certainty(&best.normal.information, inflation, shares);
            let rise = CHI_SQUARE_95 * inflation - (basin.cost - least);
            profiles(squares, &best, &certainty, (columns, rise), control)
        })?;
        joined = Some(match joined {
            None => own,
            Some(all) => all.iter().zip(&own).map(|(a, b)| (a.0.min(b.0), a.1.max(b.1))).collect(),
        });
    }
    joined
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
    (misfit > 2.0).then(misfit_warning).into_iter().chain((correlation_factor > 2.0).then(correlation_warning)).collect()
}

/// Warns of an estimated gain at an end of its range.
fn gain_at_end(place: f64) -> Option<String> {
    let end = if place < 0.5 { GAIN_RANGE.0 } else { GAIN_RANGE.1 };
    let at_end = !(AT_BOUND..=1.0 - AT_BOUND).contains(&place);
    at_end.then(|| format!("the estimated gain lies at an end of its range, {end:e}: check the units of the set, or state the gain"))
}

/// Warns of searches that do not agree.
fn disagreement(repeats: &[Repeat]) -> String {
    let worst = repeats.last().map_or(0.0, |r| r.found.cost);
    format!(
        "the {} searches do not agree (cost {:.6} to {worst:.6}): raise the number of searches (repeats)",
        repeats.len(),
        repeats[0].found.cost
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

/// Returns the estimates of all parameters, and warnings for those at an end of their range.
fn parameter_estimates(
    machine: &Machine,
    free: &[usize],
    place: &Place,
    values: &ParameterValues,
    intervals: &[(f64, f64)],
    certainty: &Certainty,
    has_intervals: bool,
) -> (Vec<Estimate>, Vec<String>) {
    let mut warnings = Vec::new();
    let mut estimates: Vec<Estimate> = (0..machine.parameters.len())
        .map(|parameter| Estimate { parameter, value: values[parameter], interval95: None, identifiable: None, at_bound: false })
        .collect();
    for (column, &parameter) in free.iter().enumerate() {
        let (u, (low, high)) = (place[column], intervals[column]);
        let description = &machine.parameters[parameter];
        let end = |x: f64| description.from_unit(x.clamp(0.0, 1.0));
        let at_bound = !(AT_BOUND..=1.0 - AT_BOUND).contains(&u);
        let narrow = high - low <= 2.0 * 1.96 * counted(description) * RANGE_SD / NARROWING;
        estimates[parameter] = Estimate {
            parameter,
            value: values[parameter],
            interval95: has_intervals.then(|| (end(low), end(high))),
            identifiable: has_intervals.then_some(narrow && !at_bound),
            at_bound,
        };
        if at_bound {
            let which = if u < 0.5 { ("lower", description.lower) } else { ("upper", description.upper) };
            let identifiable = narrow && certainty.identifiable[column];
            let remedy = if identifiable {
                "the data drive it there; check its range and the model"
            } else {
                "the data do not determine it; run plan to find a measurement that does"
            };
            warnings
                .push(format!("{} lies at the {} end of its range, {:e} {}: {remedy}", description.id, which.0, which.1, description.unit));
        }
    }
    (estimates, warnings)
}

/// Whether the searches agree on the cost and on the identifiable parameters.
///
/// Parameters agree within a tenth of their standard deviation or a thousandth of the range.
fn agreement(repeats: &[Repeat], certainty: &Certainty, free: usize) -> bool {
    let best = &repeats[0].found;
    let worst = repeats.last().map_or(best.cost, |r| r.found.cost);
    let costs = worst - best.cost <= 1e-3 * best.cost.abs().max(1e-12);
    // Where costs agree to a thousandth of the χ² rise of a 95 % interval, the intervals cover the differences.
    let flat = worst - best.cost <= 1e-3 * CHI_SQUARE_95;
    let mut identifiable = (0..free).filter(|i| certainty.identifiable[*i]);
    costs
        && (flat
            || identifiable.all(|i| repeats.iter().all(|r| (r.found.place[i] - best.place[i]).abs() <= (0.1 * certainty.sd[i]).max(1e-3))))
}
