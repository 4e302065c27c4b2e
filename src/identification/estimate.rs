//! From data to estimates, whatever the data: search, repeats, certainty.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::bootstrap::{Bootstrap, Drawn, bootstrap};
use super::combination::{Combination, combinations};
use super::problem::{BoundSide, Problem, distance};
use super::profile::{CHI_SQUARE_95, profiles};
use super::settings::{IdentificationSettings, Repeat};
use super::uncertainty::{Certainty, NARROWING, RANGE_SD, certainty, counted};
use crate::objective::{GAIN_RANGE, ObjectiveError};
use machine::{Machine, Parameter};
use optimizer::{Control, Found, Polished, SearchSettings, least_squares, least_squares_within, search};

/// An identified parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Index in the machine.
    pub parameter: usize,
    /// Value in its unit.
    pub value: f64,
    /// 95 % interval; `None` for a parameter that was not fitted.
    pub interval95: Option<(f64, f64)>,
    /// Whether the data determine it; `None` for one that was not fitted.
    pub identifiable: Option<bool>,
    /// Lies at an end of its plausible range.
    pub at_bound: bool,
}

/// What is known of the parameters after a fit.
pub(super) struct Estimation {
    pub place: Vec<f64>,
    pub values: Vec<f64>,
    pub gain: f64,
    pub estimates: Vec<Estimate>,
    pub gain_interval95: Option<(f64, f64)>,
    pub gain_identifiable: Option<bool>,
    pub repeats: Vec<Repeat>,
    pub agree: Option<bool>,
    pub chi_square: f64,
    pub freedom: usize,
    pub colour: f64,
    pub certainty: Certainty,
    /// Standard deviation of every coordinate of a place, of what is fitted along, too.
    pub sd: Vec<f64>,
    pub combinations: Vec<Combination>,
    pub bootstraps: Vec<Bootstrap>,
    pub basins: Vec<Basin>,
    pub complete: bool,
    pub warnings: Vec<String>,
}

/// A minimum of χ² that the data do not tell from the least one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basin {
    /// Place of the free parameters, and of what is fitted along.
    pub place: Vec<f64>,
    /// Its χ².
    pub cost: f64,
    /// Searches that found it.
    pub searches: usize,
}

/// Most steps of a polish from a place nearby.
const POLISH: u64 = 100;
/// First steps from many places, after which so many are followed.
const FIRST_STEPS: u64 = 10;
const FOLLOWED: usize = 6;
/// Distance from an end of the unit interval that counts as being there.
const AT_BOUND: f64 = 1e-3;

/// Least squares from a place nearby, the gain its last coordinate.
fn polished_near<P: Problem>(problem: &P, near: &[f64], control: &Control) -> (Found, Vec<f64>) {
    let polished = problem.squares(None, |squares| least_squares(squares, &problem.restarted(near), &[], POLISH, control.stop()));
    let (place, cost) = (polished.place[..problem.dimension()].to_vec(), polished.normal.chi_square);
    let (trace, population) = (Vec::new(), Vec::new());
    let found = Found { place, cost, evaluations: polished.evaluations, generations: 0, trace, population, complete: !control.stopped() };
    (found, polished.place)
}

/// Searches from as many seeds as the plan asks for, each a differential evolution and then the polish of the problem.
fn searches<P: Problem>(problem: &P, plan: &IdentificationSettings, control: &Control) -> Vec<(Repeat, Vec<BoundSide>)> {
    let (repeats, threads) = (plan.repeats.max(1), rayon::current_num_threads());
    let seed = |repeat: usize| plan.seed.wrapping_add(1_000_003 * repeat as u64);
    let explored = |repeat: usize| {
        let usual = SearchSettings { strategy: plan.strategy, ..SearchSettings::for_dimension(problem.dimension(), seed(repeat)) };
        control.kept(&format!("search {}", seed(repeat)), || search(problem, problem.settings(usual), control))
    };
    let polished = |repeat: usize, mut found: Found| {
        let (ends, spent) = control.kept(&format!("polish {}", seed(repeat)), || problem.polish(&found, control));
        if let Some(end) = ends.first() {
            (found.place, found.cost) = (end.place[..found.place.len()].to_vec(), end.cost);
        }
        found.evaluations += spent;
        found.population.clear();
        found.complete &= !control.stopped();
        (Repeat { seed: seed(repeat), found }, ends)
    };
    // All threads share a population, but a simplex goes step by step on one. Those of the last searches wait for the last population, so that in
    // the end there is one for each thread; the others go on beside populations.
    let begun: Vec<Result<(Repeat, Vec<BoundSide>), Found>> = (0..repeats)
        .into_par_iter()
        .map(|repeat| {
            let found = explored(repeat);
            if repeat + threads < repeats { Ok(polished(repeat, found)) } else { Err(found) }
        })
        .collect();
    begun.into_par_iter().enumerate().map(|(repeat, begun)| begun.unwrap_or_else(|found| polished(repeat, found))).collect()
}

/// Searches, or one from nearby where the plan says so, with the ends of each; the deepest first.
fn runs<P: Problem>(problem: &P, plan: &IdentificationSettings, control: &Control) -> (Vec<Repeat>, Vec<Vec<BoundSide>>) {
    let mut runs = match &plan.near {
        Some(near) => {
            let (found, place) = control.kept("polish", || polished_near(problem, near, control));
            let end = BoundSide { cost: found.cost, place };
            vec![(Repeat { seed: plan.seed, found }, vec![end])]
        }
        None => searches(problem, plan, control),
    };
    runs.sort_by(|a, b| a.0.found.cost.total_cmp(&b.0.found.cost));
    runs.into_iter().unzip()
}

/// A problem with more that is free and more that is uncertain, and places to begin from in it: intervals are told there.
pub(super) type Wider<P> = Option<(P, Vec<Vec<f64>>)>;

/// Fits a problem and tells how sure the result is, of FRFs by the problem itself, of modes by a wider one about the best place.
///
/// # Errors  nothing is free; those of `wider`.
pub(super) fn estimate<P: Problem>(
    problem: &P,
    wider: impl Fn(&[f64]) -> Result<Wider<P>, ObjectiveError>,
    machine: &Machine,
    plan: &IdentificationSettings,
    control: &Control,
) -> Result<Estimation, ObjectiveError> {
    let free = problem.free().to_vec();
    if free.is_empty() {
        return Err(ObjectiveError::Data("no parameter is left to identify; freeze fewer, or give one fit = \"always\"".into()));
    }
    let (repeats, ends) = runs(problem, plan, control);
    let unknowns = ends[0][0].place.len();
    let freedom = problem.observations().saturating_sub(unknowns);
    let widening = |place: &[f64]| {
        let chi_square = problem.squares(None, |squares| squares.chi_square(place));
        let misfit = if freedom > 0 { (chi_square / freedom as f64).max(1.0) } else { 1.0 };
        (chi_square, misfit, problem.colour(place).max(1.0))
    };
    let first = widening(&ends[0][0].place);
    let (_, misfit, colour) = first;
    let weak = problem.weakened(misfit * colour);
    let mut basins = basins(&ends, free.len(), CHI_SQUARE_95 * misfit * colour);
    if let Some(weak) = &weak {
        basins = control.kept("weakened", || settled(weak, basins, (free.len(), CHI_SQUARE_95), control));
    }
    let place = basins[0].place.clone();
    let values = problem.values(&place);
    let gain = problem.gain_at(&place);
    let (chi_square, misfit, colour) = if weak.is_some() { widening(&place) } else { first };
    // Eq. 26 is no likelihood: its minimum tells no intervals.
    let tells = problem.is_likelihood();
    let inflation = if weak.is_some() { 1.0 } else { misfit * colour };
    let wider = if tells && plan.profile { wider(&place)? } else { None };
    let told = match &wider {
        Some((wider, from)) => {
            let begun = from.iter().map(|place| Basin { place: place.clone(), cost: 0.0, searches: 1 }).collect();
            basins = control.kept("wider", || settled(wider, begun, (wider.free().len(), CHI_SQUARE_95 * inflation), control));
            wider
        }
        None => weak.as_ref().unwrap_or(problem),
    };
    let shares: Vec<f64> = told.free().iter().map(|i| counted(&machine.parameters[*i])).collect();
    let information = told.squares(None, |squares| squares.normal(&basins[0].place).information);
    let whole = certainty(&information, inflation, &shares);
    let columns: Vec<usize> = (0..free.len()).chain(told.gain_column()).collect();
    let first_order = |at: &usize| {
        let (here, half) = (basins[0].place[*at], 1.96 * whole.sd[*at]);
        (here - half, here + half)
    };
    let profiled = (tells && plan.profile)
        .then(|| control.kept("profiles", || joined_profiles(told, &basins, (&columns, &shares), inflation, control)))
        .flatten();
    let mut intervals = profiled.unwrap_or_else(|| columns.iter().map(first_order).collect());
    if wider.is_some() {
        // The estimate is that of the fit with what modes say little of held.
        let own = (0..free.len()).chain(problem.gain_column()).map(|at| place[at]);
        intervals.iter_mut().zip(own).for_each(|(interval, u)| *interval = (interval.0.min(u), interval.1.max(u)));
    }
    let certainty = whole.of(&columns);
    let bootstraps = [Drawn::Lines, Drawn::Positions]
        .into_iter()
        .filter_map(|drawn| bootstrap(problem, &place, drawn, plan.bootstrap, plan.seed, control))
        .collect();
    let mut warnings = shortage(problem.observations(), unknowns);
    let (estimates, at_bounds) = report_progress(machine, &free, &place, &values, &intervals, &certainty, tells);
    warnings.extend(at_bounds);
    let gain_column = problem.gain_column();
    let gain_interval95 = gain_column.filter(|_| tells).map(|_| {
        let end = |u: f64| GAIN_RANGE.0 * (u * (GAIN_RANGE.1 / GAIN_RANGE.0).ln()).exp();
        (end(intervals[free.len()].0), end(intervals[free.len()].1))
    });
    warnings.extend(tells.then(|| widened(chi_square, freedom, misfit, colour)).into_iter().flatten());
    let combinations = if tells && plan.profile { combined(told, machine, (&basins[0], &whole), inflation, control) } else { Vec::new() };
    warnings.extend(gain_column.and_then(|at| gain_at_end(place[at])));
    let complete = !control.stopped() && repeats.len() == plan.repeats.max(1) && repeats.iter().all(|r| r.found.complete);
    let agree = (complete && repeats.len() > 1).then(|| agreement(&repeats, &certainty, free.len()));
    warnings.extend((agree == Some(false)).then(|| disagreement(&repeats)));
    Ok(Estimation {
        gain_identifiable: gain_column.filter(|_| tells).and(certainty.identifiable.get(free.len()).copied()),
        place,
        values,
        gain,
        estimates,
        gain_interval95,
        repeats,
        agree,
        chi_square,
        freedom,
        colour,
        certainty,
        sd: whole.sd,
        combinations,
        bootstraps,
        basins,
        complete,
        warnings,
    })
}

/// Minima once the data count as little as the model's error asks for: priors must hold against that, too. The deepest first.
fn settled<P: Problem>(weak: &P, basins: Vec<Basin>, (free, rise): (usize, f64), control: &Control) -> Vec<Basin> {
    let settle = |basin: Basin, end: (u64, f64)| {
        let polished = weak.squares(None, |squares| least_squares_within(squares, &basin.place, &[], end, control.stop()));
        Basin { place: polished.place, cost: polished.normal.chi_square, ..basin }
    };
    let all = |basins: Vec<Basin>, end: (u64, f64)| {
        let mut ends: Vec<Basin> = basins.into_par_iter().map(|basin| settle(basin, end)).collect();
        ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        ends
    };
    // Of many a few steps tell which to follow.
    let mut near = if basins.len() > FOLLOWED { all(basins, (FIRST_STEPS, 1e-3)) } else { basins };
    near.truncate(FOLLOWED);
    let ends = all(near, (POLISH, 1e-7));
    let least = ends[0].cost;
    let mut apart: Vec<Basin> = Vec::new();
    for end in ends.into_iter().filter(|end| end.cost - least <= rise) {
        if apart.iter().all(|other| !same(&other.place, &end.place, free)) {
            apart.push(end);
        }
    }
    apart
}

/// Whether two places are of one minimum.
fn same(a: &[f64], b: &[f64], free: usize) -> bool {
    distance(&a[..free], b) < ASUNDER
}

/// Combinations that the data see about a minimum.
fn combined<P: Problem>(
    problem: &P,
    machine: &Machine,
    (here, certainty): (&Basin, &Certainty),
    inflation: f64,
    control: &Control,
) -> Vec<Combination> {
    let free = problem.free();
    let described: Vec<&Parameter> = free.iter().map(|i| &machine.parameters[*i]).collect();
    let of = |place: &[f64]| -> Vec<f64> {
        let all = problem.values(place);
        free.iter().map(|i| all[*i]).collect()
    };
    let valley = |column: usize, by: f64| {
        let mut moved = here.place.clone();
        moved[column] = (moved[column] + by).clamp(0.0, 1.0);
        let held: Vec<bool> = (0..moved.len()).map(|i| i == column).collect();
        let polished = problem.squares(None, |squares| least_squares(squares, &moved, &held, POLISH, control.stop()));
        (polished.normal.chi_square - here.cost < CHI_SQUARE_95 * inflation).then(|| of(&polished.place))
    };
    let mut found = combinations(&described, &of(&here.place), certainty, valley);
    found.iter_mut().for_each(|c| c.parameters = (free[c.parameters.0], free[c.parameters.1]));
    found
}

/// How far apart in some coordinate two ends are two minima.
const ASUNDER: f64 = 0.02;

/// The minima among ends of searches that lie within a rise of χ² above the least one, the best first.
fn basins(searches: &[Vec<BoundSide>], free: usize, rise: f64) -> Vec<Basin> {
    let mut ends: Vec<(usize, &BoundSide)> =
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

/// Intervals of some coordinates, each the hull of those of all basins. `None` where it was stopped.
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
        // What lies within the intervals so far is on the way of a profile there.
        let inside = |all: &Vec<(f64, f64)>| columns.iter().zip(all).all(|(c, (low, high))| (*low..=*high).contains(&basin.place[*c]));
        if joined.as_ref().is_some_and(inside) {
            continue;
        }
        let own = problem.squares(None, |squares| {
            let best = Polished { place: basin.place.clone(), normal: squares.normal(&basin.place), evaluations: 0, converged: true };
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

/// What widens intervals beyond what the weights say.
fn widened(chi_square: f64, freedom: usize, misfit: f64, colour: f64) -> Vec<String> {
    let differ = || {
        format!(
            "χ² is {chi_square:.1} for {freedom} degrees of freedom: model and data differ by more than the weights allow; intervals are widened by √{misfit:.2}; look where the errors are largest, or let diagnose look for what is missing"
        )
    };
    let follows = || {
        format!(
            "what is left is not noise but follows the frequency (neighbouring lines agree): the model lacks something; intervals are widened by √{colour:.1}; diagnose looks for what it lacks"
        )
    };
    (misfit > 2.0).then(differ).into_iter().chain((colour > 2.0).then(follows)).collect()
}

/// What to say of an unknown gain at an end of its range.
fn gain_at_end(place: f64) -> Option<String> {
    let end = if place < 0.5 { GAIN_RANGE.0 } else { GAIN_RANGE.1 };
    let at_end = !(AT_BOUND..=1.0 - AT_BOUND).contains(&place);
    at_end.then(|| format!("the gain lies at an end of its range, {end:e}: check the units of the set, or state the gain"))
}

/// What to say of searches that do not agree.
fn disagreement(repeats: &[Repeat]) -> String {
    let worst = repeats.last().map_or(0.0, |r| r.found.cost);
    format!("the {} searches do not agree (cost {:.6} to {worst:.6}): raise --repeats", repeats.len(), repeats[0].found.cost)
}

fn shortage(observations: usize, unknowns: usize) -> Vec<String> {
    let short = observations < unknowns;
    short
        .then(|| {
            format!(
                "{observations} observations cannot determine {unknowns} unknowns: those the data do not see are marked not identifiable; fit more positions, or --freeze parameters"
            )
        })
        .into_iter()
        .collect()
}

/// Estimates of all parameters, and what to say of those at an end of their range.
fn report_progress(
    machine: &Machine,
    free: &[usize],
    place: &[f64],
    values: &[f64],
    intervals: &[(f64, f64)],
    certainty: &Certainty,
    tells: bool,
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
            interval95: tells.then(|| (end(low), end(high))),
            identifiable: tells.then_some(narrow && !at_bound),
            at_bound,
        };
        if at_bound {
            let which = if u < 0.5 { ("lower", description.lower) } else { ("upper", description.upper) };
            let seen = narrow && certainty.identifiable[column];
            let remedy = if seen {
                "the data push it there: check range and model"
            } else {
                "the data do not determine it; plan tells what measurement would"
            };
            warnings
                .push(format!("{} lies at the {} end of its range, {:e} {}: {remedy}", description.id, which.0, which.1, description.unit));
        }
    }
    (estimates, warnings)
}

/// Whether the searches agree on the cost, and on what the data see: within a tenth of its standard deviation or a thousandth of the range.
fn agreement(repeats: &[Repeat], certainty: &Certainty, free: usize) -> bool {
    let best = &repeats[0].found;
    let worst = repeats.last().map_or(best.cost, |r| r.found.cost);
    let costs = worst - best.cost <= 1e-3 * best.cost.abs().max(1e-12);
    // Where costs are the same to a thousandth of what a 95 % interval allows, differences are for the intervals to tell.
    let flat = worst - best.cost <= 1e-3 * CHI_SQUARE_95;
    let mut seen = (0..free).filter(|i| certainty.identifiable[*i]);
    costs && (flat || seen.all(|i| repeats.iter().all(|r| (r.found.place[i] - best.place[i]).abs() <= (0.1 * certainty.sd[i]).max(1e-3))))
}
