//! The survey: every candidate fitted jointly with the machine, ranked by how it foretells parts of the motion that were left out.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::data::{MotionData, Nuisance, beside};
use super::design::{Design, Solved};
use super::free::free_shapes;
use super::noise::Noise;
use crate::diagnosis::{Hypothesis, Kind, Status};
use crate::inverse_dynamics::{Columns, Fit, Projected, Rigid, inverse, prediction};
use crate::machine::{Machine, Motion, Parameter, Scale};
use crate::numeric::random::normal;
use crate::numeric::statistics::quantile;
use crate::optimizer::Control;

/// A candidate and its lattice of designs.
pub struct MotionCandidate {
    /// Id.
    pub id: String,
    /// What became of it.
    pub status: Status,
    /// The machine with it; `None` for a free shape.
    pub hypothesis: Option<Hypothesis>,
    /// For a free shape: what the force may depend on, and the shape it resembles.
    pub free: Option<(&'static str, &'static str)>,
    /// For a free shape of a further point: its column.
    pub column: Option<String>,
    lattice: Vec<Place>,
}

/// A place of the lattice: values of what is not linear, and the design there.
struct Place {
    /// Indices of parameters and their values.
    values: Vec<(usize, f64)>,
    /// What stands in the added columns.
    linear: Vec<Linear>,
    design: Arc<Design>,
}

/// A parameter (index) that is linear, or whose inverse is.
#[derive(Clone, Copy)]
struct Linear {
    index: usize,
    inverse: bool,
}

impl Linear {
    /// What is linear of a value, and the value of what is linear.
    fn of(self, x: f64) -> f64 {
        if self.inverse { 1.0 / x } else { x }
    }

    /// Its ends.
    fn ends(self, parameter: &Parameter) -> (f64, f64) {
        let (a, b) = (self.of(parameter.lower), self.of(parameter.upper));
        (a.min(b), a.max(b))
    }

    /// The value at which it does nothing, or next to it.
    fn nothing(self, parameter: &Parameter) -> f64 {
        if self.inverse { parameter.upper } else { 0.0_f64.clamp(parameter.lower, parameter.upper) }
    }
}

/// A candidate's figures on one force.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// Index of the candidate.
    pub candidate: usize,
    /// Share of what the machine fails to foretell that it takes away.
    pub gain: f64,
    /// What each part left out leaves.
    pub left_out: Vec<f64>,
    /// Index in its lattice.
    place: usize,
    /// Values of the parameters it adds there.
    pub added: Vec<(usize, f64)>,
}

/// The machine, what is ordinarily wrong of it, and all candidates.
pub struct Survey {
    base: Arc<Design>,
    base_columns: usize,
    /// Candidates.
    pub candidates: Vec<MotionCandidate>,
    /// Names of nuisances.
    pub nuisances: Vec<Nuisance>,
}

/// What nulls show. Some candidates gain much by accident (a wave of any period), others little: −ln(1 − gain) is told in units of what each
/// gains in one null of ten, and the largest of a draw stands for the whole library.
#[derive(Debug, Clone, PartialEq)]
pub struct Null {
    /// −ln(1 − gain) of each candidate that nine nulls of ten stay below.
    pub scales: Vec<f64>,
    /// Largest −ln(1 − gain) of each candidate in any null.
    pub most: Vec<f64>,
    /// Largest −ln(1 − gain) of any effect over its scale, of each draw, rising.
    pub effects: Vec<f64>,
    /// The same of free shapes.
    pub free: Vec<f64>,
}

/// Least scale of a candidate.
const LEAST_SCALE: f64 = 0.01;
/// What a candidate must gain over the most that it gained in any null, to be no accident whatever others gained.
const BEYOND: f64 = 1.25;

impl Null {
    /// Share of draws in which some effect gains as much; that of none where it gains clearly more than itself in any.
    pub fn p_value(&self, ranked: &Ranked) -> f64 {
        self.p_among(&self.effects, ranked)
    }

    /// The same of free shapes.
    pub fn p_value_free(&self, ranked: &Ranked) -> f64 {
        self.p_among(&self.free, ranked)
    }

    fn p_among(&self, all: &[f64], ranked: &Ranked) -> f64 {
        let own = strength(ranked.gain);
        if own > BEYOND * self.most[ranked.candidate].max(LEAST_SCALE) {
            return 1.0 / (all.len() + 1) as f64;
        }
        share_above(all, own / self.scales[ranked.candidate])
    }
}

/// ln of what the machine fails to foretell over what a candidate does.
fn strength(gain: f64) -> f64 {
    -(1.0 - gain.clamp(0.0, 1.0)).max(1e-12).ln()
}

fn share_above(sorted: &[f64], gain: f64) -> f64 {
    let above = sorted.len() - sorted.partition_point(|x| *x < gain);
    (above + 1) as f64 / (sorted.len() + 1) as f64
}

/// Places of a lattice over one number that is not linear, over a period, and over several.
const PLACES: (usize, usize, usize) = (24, 60, 48);
/// Share of the force by which it must change to count as moved.
const MOVES: f64 = 1e-3;
/// A column that the machine's own parameters can stand for to this share is not seen.
const SEEN: f64 = 0.05;

/// Everything a survey is made of.
pub(super) struct Ground<'g> {
    pub data: &'g MotionData<'g>,
    pub rigid: &'g Rigid,
    /// The machine, perhaps with effects that were chosen before.
    pub nominal: &'g Hypothesis,
    pub fit: &'g Fit,
    pub frozen: &'g [String],
}

impl Survey {
    /// Works out all designs.
    ///
    /// # Errors  none: a candidate whose columns fail is told among the candidates.
    pub(super) fn new(ground: &Ground<'_>, hypotheses: Vec<Hypothesis>, others: Vec<(String, Status)>, control: &Control) -> Option<Self> {
        let Ground { data, rigid, nominal, fit, frozen } = ground;
        let machine = &nominal.machine;
        // What stands at an end of its range is held there: no candidate is to gain by taking it farther, or to lose to one that does.
        let inside = |i: &usize| machine.parameters[*i].holds_inside(fit.values[*i]);
        let free: Vec<usize> = data.free(machine, frozen).ok()?.into_iter().filter(inside).collect();
        let columns = Columns::new(rigid, machine, &fit.values, &free, &data.motions);
        let nuisances = data.nuisances(rigid, machine, fit);
        let nuisances: Vec<Nuisance> = nuisances.into_iter().filter(|n| n.column.norm() > 0.0).collect();
        let wrong = DMatrix::from_columns(&nuisances.iter().map(|n| n.column.clone()).collect::<Vec<_>>());
        // What smooth functions leave of the residual is noise, whatever is missing; coloured, it counts for fewer samples.
        let shapes = free_shapes(data);
        let mut left = fit.residual.clone();
        for part in std::iter::once(&columns.derivatives).chain([&wrong]).chain(shapes.iter().map(|s| &s.columns)) {
            let apart = part.select_columns(&(0..part.ncols().saturating_sub(usize::from(part.ncols() > 4))).collect::<Vec<_>>());
            left = Projected::new(&apart, &left).map_or(left, |p| p.residual);
        }
        let noise = Noise::new(&left, &data.records());
        let variance = left.norm_squared() / data.samples() as f64 * noise.block() as f64;
        let mut penalty = vec![0.0; free.len()];
        penalty.resize(free.len() + nuisances.len(), variance);
        let design = |columns: &Columns, values: &[f64], free: &[usize], extra: Option<&DMatrix<f64>>, bounds: Vec<(usize, f64, f64)>| {
            let at = DVector::from_iterator(free.len(), free.iter().map(|i| values[*i]));
            let shift = &columns.prediction - &columns.derivatives * at;
            let all = match extra {
                None => beside(&[&columns.derivatives, &wrong]),
                Some(extra) => beside(&[&columns.derivatives, &wrong, extra]),
            };
            let mut penalty = penalty.clone();
            penalty.resize(all.ncols(), 0.0);
            Design::new(data, shift, all, &penalty, bounds)
        };
        let base = Arc::new(design(&columns, &fit.values, &free, None, Vec::new())?);
        let made: Vec<MotionCandidate> = hypotheses
            .into_par_iter()
            .map(|hypothesis| {
                if control.stopped() {
                    return without(hypothesis.id, Status::Failed("stopped before its turn".into()));
                }
                let of = &hypothesis.machine;
                let start = start_of(of, &fit.values);
                let added = &hypothesis.added;
                // What moves at a place amid the ranges decides what is linear; where nothing moves, the force of a rigid drive does not know it.
                let amid = amid(of, &start, added);
                let around = prediction(rigid, of, &amid, &data.motions);
                let moved = |index: usize, unit: f64| {
                    let mut values = amid.clone();
                    values[index] = of.parameters[index].from_unit(unit);
                    (values[index], prediction(rigid, of, &values, &data.motions))
                };
                let (mut linear, mut curved) = (Vec::new(), Vec::new());
                for (&index, inverse) in added.iter().zip(inverse(of, added)) {
                    let coordinate = Linear { index, inverse };
                    let unit = of.parameters[index].to_unit(amid[index]);
                    let ((a, fa), (b, fb)) = (moved(index, 0.5 * unit), moved(index, 0.25 * unit));
                    let (a, b, here) = (coordinate.of(a), coordinate.of(b), coordinate.of(amid[index]));
                    let (da, db) = ((&fa - &around) / (a - here), (&fb - &around) / (b - here));
                    let size = da.norm().max(db.norm());
                    if size * (a - here).abs() <= 1e-9 * around.norm() {
                        continue;
                    }
                    if (da - db).norm() <= 1e-6 * size { linear.push(coordinate) } else { curved.push(index) }
                }
                if linear.is_empty() && curved.is_empty() {
                    let why = "the force of a rigid drive with the effects it has does not depend on it";
                    return without(hypothesis.id, Status::NotApplicable(why.into()));
                }
                let mut places: Vec<Vec<(usize, f64)>> = lattice(of, &curved, data, rigid);
                // Over decades: as many places again over those of them at which anything moves.
                if let [one] = curved[..]
                    && of.parameters[one].scale == Scale::Logarithmic
                    && !of.parameters[one].id.ends_with("period")
                {
                    let moves = |place: &&Vec<(usize, f64)>| {
                        let mut values = start.clone();
                        values[one] = place[0].1;
                        (prediction(rigid, of, &values, &data.motions) - &columns.prediction).norm() > MOVES * columns.prediction.norm()
                    };
                    let moved: Vec<f64> = places.par_iter().filter(moves).map(|place| place[0].1).collect();
                    if let (Some(from), Some(to)) = (moved.iter().copied().reduce(f64::min), moved.iter().copied().reduce(f64::max)) {
                        let last = (places.len() - 1) as f64;
                        (0..places.len()).for_each(|k| places[k][0].1 = from * (to / from).powf(k as f64 / last));
                    }
                }
                // Each place stands for itself and, of one number other than a wave's period, for what lies between it and its neighbours: there the force
                // is taken to be straight.
                let straight = matches!(curved[..], [one] if !of.parameters[one].id.ends_with("period"));
                let near = |at: usize| {
                    let value = |at: usize| places.get(at).map(|p| p[0].1);
                    let here = places[at][0].1;
                    (at.checked_sub(1).and_then(value).unwrap_or(here), value(at + 1).unwrap_or(here))
                };
                let lattice: Vec<(Place, f64)> = places
                    .par_iter()
                    .enumerate()
                    .flat_map_iter(|(at, values)| [(at, values, false), (at, values, true)])
                    .filter(|(_, _, slopes)| straight || !slopes)
                    .filter_map(|(at_place, values, slopes)| {
                        let values = values.clone();
                        let mut seen: f64 = 0.0;
                        let mut at = start.clone();
                        linear.iter().for_each(|l| at[l.index] = l.nothing(&of.parameters[l.index]));
                        let (mut linear, mut toward) = (linear.clone(), amid.clone());
                        let mut ends: Vec<(f64, f64)> = linear.iter().map(|l| l.ends(&of.parameters[l.index])).collect();
                        if slopes {
                            let slope = Linear { index: curved[0], inverse: of.parameters[curved[0]].scale == Scale::Logarithmic };
                            let (a, b) = near(at_place);
                            linear.push(slope);
                            ends.push((slope.of(a).min(slope.of(b)), slope.of(a).max(slope.of(b))));
                            toward[curved[0]] = if b == values[0].1 { a } else { b };
                        }
                        values.iter().for_each(|(i, x)| at[*i] = *x);
                        let more = added_columns(rigid, of, (&at, &toward), &linear, data);
                        let change = &more.prediction - &columns.prediction;
                        // With nothing of what is linear the force is mostly the machine's own.
                        let own = if change.norm() > 1e-9 * columns.prediction.norm() {
                            seen = seen.max(base.visible(&change));
                            Columns::new(rigid, of, &at, &free, &data.motions)
                        } else {
                            columns.clone()
                        };
                        more.derivatives.column_iter().for_each(|c| seen = seen.max(base.visible(&c.clone_owned())));
                        let from = free.len() + nuisances.len();
                        let bounds = ends.iter().enumerate().map(|(k, (a, b))| (from + k, *a, *b)).collect();
                        // The shift of the added columns: their coefficients count from nothing.
                        let zero: DVector<f64> = DVector::from_iterator(linear.len(), linear.iter().map(|l| l.of(at[l.index])));
                        let mut own = own;
                        own.prediction -= &more.derivatives * zero;
                        let extra = (!linear.is_empty()).then_some(&more.derivatives);
                        let design = design(&own, &at, &free, extra, bounds)?;
                        Some((Place { values, linear, design: Arc::new(design) }, seen))
                    })
                    .collect();
                let seen = lattice.iter().map(|(_, seen)| *seen).fold(0.0, f64::max);
                let lattice: Vec<Place> = lattice.into_iter().map(|(place, _)| place).collect();
                if seen < SEEN || lattice.is_empty() {
                    let why = "these records cannot show it: the machine's own parameters stand for what it does";
                    return without(hypothesis.id, Status::NotApplicable(why.into()));
                }
                MotionCandidate {
                    id: hypothesis.id.clone(),
                    status: Status::Tried,
                    hypothesis: Some(hypothesis),
                    free: None,
                    column: None,
                    lattice,
                }
            })
            .collect();
        let mut candidates = made;
        for shape in shapes {
            // Knots add up to what the machine has already (a constant, a direction): a little ridge keeps them apart.
            let ridge = 1e-3 * shape.columns.norm_squared() / shape.columns.ncols() as f64;
            let at = DVector::from_iterator(free.len(), free.iter().map(|i| fit.values[*i]));
            let shift = &columns.prediction - &columns.derivatives * at;
            let all = beside(&[&columns.derivatives, &wrong, &shape.columns]);
            let mut penalty = penalty.clone();
            penalty.resize(all.ncols(), ridge);
            if let Some(design) = Design::new(data, shift, all, &penalty, Vec::new()) {
                let place = Place { values: Vec::new(), linear: Vec::new(), design: Arc::new(design) };
                let free = Some((shape.over, shape.shape));
                candidates.push(MotionCandidate {
                    id: shape.column.as_ref().map_or(shape.over.into(), |column| format!("{} of {column}", shape.over)),
                    column: shape.column,
                    status: Status::Tried,
                    hypothesis: None,
                    free,
                    lattice: vec![place],
                });
            }
        }
        candidates.extend(others.into_iter().map(|(id, status)| without(id, status)));
        Some(Survey { base, base_columns: free.len() + nuisances.len(), candidates, nuisances })
    }

    /// What the machine alone leaves of parts foretold without them.
    pub fn base_loss(&self, data: &MotionData<'_>, y: &DVector<f64>) -> f64 {
        self.base.solve(data, y).map_or(f64::INFINITY, |s| s.loss())
    }

    /// Figures of every candidate on a force, the largest gain first.
    pub fn rank(&self, data: &MotionData<'_>, y: &DVector<f64>) -> Vec<Ranked> {
        let before = self.base_loss(data, y);
        let mut ranked: Vec<Ranked> = self
            .candidates
            .iter()
            .enumerate()
            .filter_map(|(candidate, c)| {
                let solved = c.lattice.iter().enumerate().filter_map(|(at, p)| Some((at, p.design.solve(data, y)?)));
                let (place, best): (usize, Solved) = solved.min_by(|a, b| a.1.loss().total_cmp(&b.1.loss()))?;
                let at = &c.lattice[place];
                let mut added = at.values.clone();
                added.extend(at.linear.iter().enumerate().map(|(k, l)| (l.index, l.of(best.coefficients[self.base_columns + k]))));
                Some(Ranked { candidate, gain: 1.0 - best.loss() / before, left_out: best.left_out, place, added })
            })
            .collect();
        ranked.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        ranked
    }

    /// What the machine, or a candidate, leaves of a force.
    pub fn residual(&self, data: &MotionData<'_>, y: &DVector<f64>, of: Option<&Ranked>) -> DVector<f64> {
        let design = of.map_or(&self.base, |r| &self.candidates[r.candidate].lattice[r.place].design);
        design.solve(data, y).map_or_else(|| y.clone(), |solved| design.residual(y, &solved))
    }

    /// Nulls: the machine with nuisances drawn from what is known of them and noise of the colour of `left`, half of the draws moved in time, half
    /// in place with drawn signs.
    pub fn null(&self, data: &MotionData<'_>, left: &DVector<f64>, draws: usize, seed: u64, control: &Control) -> Null {
        let noise = Noise::new(left, &data.records());
        let gains: Vec<Vec<f64>> = (0..draws)
            .into_par_iter()
            .filter(|_| !control.stopped())
            .map(|draw| {
                control.kept(&format!("null {draw} {seed}"), || {
                    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9E37_79B9).wrapping_add(draw as u64));
                    let mut y = &self.base.shift + noise.draw(draw % 2 == 1, &mut random);
                    for nuisance in &self.nuisances {
                        y += normal(&mut random) * &nuisance.column;
                    }
                    let mut gains = vec![0.0; self.candidates.len()];
                    self.rank(data, &y).iter().for_each(|r| gains[r.candidate] = strength(r.gain));
                    gains
                })
            })
            .collect();
        let of = |at: usize| gains.iter().map(move |g| g[at]);
        let scales: Vec<f64> = (0..self.candidates.len()).map(|at| quantile(of(at), 0.9).unwrap_or(0.0).max(LEAST_SCALE)).collect();
        let most: Vec<f64> = (0..self.candidates.len()).map(|at| of(at).fold(0.0, f64::max)).collect();
        let largest = |free: bool| {
            let own = |g: &Vec<f64>| {
                let over = g.iter().zip(&scales).zip(&self.candidates).filter(|(_, c)| c.free.is_some() == free).map(|((g, s), _)| g / s);
                over.fold(0.0, f64::max)
            };
            let mut all: Vec<f64> = gains.iter().map(own).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let (effects, free) = (largest(false), largest(true));
        Null { scales, most, effects, free }
    }
}

fn without(id: String, status: Status) -> MotionCandidate {
    MotionCandidate { id, status, hypothesis: None, free: None, column: None, lattice: Vec::new() }
}

/// Prediction at a place, and its derivatives with what is linear; those of inverses between that place and one amid the ranges.
fn added_columns(rigid: &Rigid, machine: &Machine, (at, amid): (&[f64], &[f64]), linear: &[Linear], data: &MotionData<'_>) -> Columns {
    let indices: Vec<usize> = linear.iter().map(|l| l.index).collect();
    let mut columns = Columns::new(rigid, machine, at, &indices, &data.motions);
    for (k, l) in linear.iter().enumerate().filter(|(_, l)| l.inverse) {
        let mut there = at.to_vec();
        there[l.index] = amid[l.index];
        let change = prediction(rigid, machine, &there, &data.motions) - &columns.prediction;
        columns.derivatives.set_column(k, &(change / (l.of(there[l.index]) - l.of(at[l.index]))));
    }
    columns
}

/// Values of a machine with effects, from those of the machine without.
pub(super) fn start_of(machine: &Machine, values: &[f64]) -> Vec<f64> {
    values.iter().copied().chain(machine.parameters.iter().skip(values.len()).map(|p| p.start)).collect()
}

/// Added parameters at places amid their ranges, each at another.
fn amid(machine: &Machine, start: &[f64], added: &[usize]) -> Vec<f64> {
    let mut values = start.to_vec();
    for (k, &index) in added.iter().enumerate() {
        values[index] = machine.parameters[index].from_unit(0.55 + 0.07 * (k % 5) as f64);
    }
    values
}

/// Places over the ranges of parameters that are not linear. A period is looked for from a sixtieth
/// of the travel to the travel: longer waves are what ordinarily varies along it. Of a drive that turns, waves of its turn are likely, many
/// to the travel: places half a wave apart over it.
fn lattice(machine: &Machine, curved: &[usize], data: &MotionData<'_>, rigid: &Rigid) -> Vec<Vec<(usize, f64)>> {
    let turning = machine.drive.as_ref().map(|d| d.on).filter(|p| machine.points[*p].motion == Motion::Rotation);
    let range = |index: usize| {
        let p = &machine.parameters[index];
        let period = p.id.ends_with("period");
        let (low, high) =
            data.motions.iter().flat_map(|m| &m.position_m).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let travel = turning.filter(|_| p.unit.contains("rad")).map_or(1.0, |point| rigid.point_ratio(point).abs());
        let (low, high) = (travel * low, travel * high);
        if period && p.unit.contains('m') {
            (p.lower.max((high - low) / 60.0), p.upper.min(high - low), true)
        } else {
            (p.lower, p.upper, p.scale == Scale::Logarithmic)
        }
    };
    let value = |index: usize, unit: f64| {
        let (low, high, logarithmic) = range(index);
        if logarithmic && low > 0.0 { low * (high / low).powf(unit) } else { low + unit * (high - low) }
    };
    match curved {
        [] => vec![Vec::new()],
        [one] => {
            let period = machine.parameters[*one].id.ends_with("period");
            if period && turning.is_some() {
                let (low, high, _) = range(*one);
                let count = (2.0 * high / low).clamp(1.0, 2.0 * PLACES.1 as f64) as usize;
                let waves = |k: usize| 1.0 / high + (k as f64 + 0.5) / count as f64 * (1.0 / low - 1.0 / high);
                return (0..count).map(|k| vec![(*one, 1.0 / waves(k))]).collect();
            }
            let count = if period { PLACES.1 } else { PLACES.0 };
            // From the end where it does next to nothing outward; that end itself says nothing.
            // A size that begins at nothing is told by its share: closer together where it is small.
            let (low, _, logarithmic) = range(*one);
            let unit = |k: usize| ((k as f64 - 0.5) / count as f64).powi(if low == 0.0 && !logarithmic { 2 } else { 1 });
            (1..=count).map(|k| vec![(*one, value(*one, unit(k)))]).collect()
        }
        several => {
            let halton = |mut i: usize, base: usize| {
                let (mut f, mut x) = (1.0, 0.0);
                while i > 0 {
                    f /= base as f64;
                    x += f * (i % base) as f64;
                    i /= base;
                }
                x
            };
            let primes = [2, 3, 5, 7];
            (1..=PLACES.2).map(|k| several.iter().enumerate().map(|(d, i)| (*i, value(*i, halton(k, primes[d % 4])))).collect()).collect()
        }
    }
}

/// Whether a candidate releases a frozen parameter.
pub(super) fn releases(candidate: &MotionCandidate) -> bool {
    candidate.hypothesis.as_ref().is_some_and(|h| h.kind == Kind::Release)
}
