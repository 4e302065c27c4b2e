//! The survey: every candidate fitted jointly with the machine, ranked by how it foretells parts of the motion that were left out.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::data::{MotionData, beside};
use super::design::{CandidateDesign, Forces, INDEPENDENT, SharedDesign, Solved};
use super::free_function::free_functions;
use super::grid::{grid, small};
use super::nuisance::{Nuisance, nuisances};
use super::null_distribution::{MotionNullDistribution, strength};
use super::residual_bootstrap::ResidualBootstrap;
use crate::{Hypothesis, HypothesisKind, Status};
use dynamics::inverse_dynamics::{LinearForce, Rigid, free_parameters, inverse, prediction};
use identification::motion::ForceFit;
use machine::{Machine, Parameter, Scale};
use numeric::linear_fit::LinearFit;
use numeric::random::normal;
use optimizer::Control;
use optimizer::live_columns;

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
    /// It applies, but the machine's own parameters stand for what it does to these records.
    pub unseen: bool,
    lattice: Vec<GridNode>,
}

/// A place of the lattice: values of what is not linear, and the design there.
struct GridNode {
    /// Indices of parameters and their values.
    values: Vec<(usize, f64)>,
    /// What stands in the added columns.
    linear: Vec<LinearParameter>,
    design: CandidateDesign,
}

/// A parameter (index) that is linear, or whose inverse is.
#[derive(Clone, Copy)]
struct LinearParameter {
    index: usize,
    inverse: bool,
    /// What it does is taken between two places, not at one.
    chord: bool,
}

impl LinearParameter {
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
pub struct MotionScreening {
    /// What is ordinarily wrong with the machine's own columns, and without.
    bases: [Arc<SharedDesign>; 2],
    nominal: CandidateDesign,
    base_columns: usize,
    /// Candidates.
    pub candidates: Vec<MotionCandidate>,
    /// What is ordinarily wrong.
    pub nuisances: Vec<Nuisance>,
    /// Parameters of the machine that are free beside it.
    free: Vec<usize>,
    /// Variance of the noise, as a mean of its samples varies.
    variance: f64,
}

/// Share of the force by which it must change to count as moved.
const MOVES: f64 = 1e-3;
/// A column that the machine's own parameters can stand for to this share is not seen.
const SEEN: f64 = 0.05;

/// Standard deviations within which what is ordinarily wrong is taken to be in nulls.
const ORDINARY: f64 = 2.0;
/// Nulls that are solved together.
const TOGETHER: usize = 50;

/// Everything a survey is made of.
pub(super) struct SharedColumns<'g> {
    pub data: &'g MotionData<'g>,
    pub rigid: &'g Rigid,
    /// The machine, perhaps with effects that were chosen before.
    pub nominal: &'g Hypothesis,
    pub fit: &'g ForceFit,
    pub frozen: &'g [String],
}

impl MotionScreening {
    /// Works out all designs.
    ///
    /// # Errors  none: a candidate whose columns fail is told among the candidates.
    pub(super) fn new(
        ground: &SharedColumns<'_>,
        hypotheses: Vec<Hypothesis>,
        others: Vec<(String, Status)>,
        control: &Control,
    ) -> Option<Self> {
        let SharedColumns { data, rigid, nominal, fit, frozen } = ground;
        let machine = &nominal.machine;
        let mut asked = free_parameters(machine, frozen).ok()?;
        let mut all = LinearForce::new(rigid, machine, &fit.values, &asked, &data.motions);
        // What does nothing where the fit ended stays there.
        let live = live_columns(&all.derivatives);
        if live.len() < asked.len() {
            all.derivatives = all.derivatives.select_columns(&live);
            asked = live.into_iter().map(|at| asked[at]).collect();
        }
        let nuisances = nuisances(data, rigid, machine, &fit.values);
        if nuisances.is_empty() {
            return None;
        }
        let wrong = columns_of(&nuisances);
        // What smooth functions leave of the residual is noise, whatever is missing; coloured, it counts for fewer samples.
        let shapes = free_functions(data);
        let mut left = fit.residual.clone();
        for part in std::iter::once(&all.derivatives).chain([&wrong]).chain(shapes.iter().map(|s| &s.columns)) {
            let apart = part.select_columns(&(0..part.ncols().saturating_sub(usize::from(part.ncols() > 4))).collect::<Vec<_>>());
            left = LinearFit::new(&apart, &left).map_or(left, |p| p.residual);
        }
        let noise = ResidualBootstrap::new(&left, &data.records());
        let variance = left.norm_squared() / data.samples() as f64 * noise.inflation();
        let penalties = |free: usize| [vec![0.0; free], vec![variance; nuisances.len()]].concat();
        // What would leave its range beside what is ordinarily wrong is held at its end: no candidate is to gain by taking it farther, or to lose to one
        // that does.
        let beside_wrong = beside(&[&all.derivatives, &wrong]);
        let step = LinearFit::penalised(&beside_wrong, &penalties(asked.len()), &fit.residual, INDEPENDENT)?.coefficients;
        let inside = |at: &usize| {
            let (p, x) = (&machine.parameters[asked[*at]], fit.values[asked[*at]]);
            p.holds_inside(x) || (p.lower..=p.upper).contains(&(x + step[*at]))
        };
        let free: Vec<usize> = (0..asked.len()).filter(inside).map(|at| asked[at]).collect();
        let columns = if free.len() == asked.len() { all } else { LinearForce::new(rigid, machine, &fit.values, &free, &data.motions) };
        // What is ordinarily wrong, with the machine's own columns, which many candidates leave as they are, and without.
        let known = vec![variance; nuisances.len()];
        let whole = SharedDesign::new(data, &beside(&[&wrong, &columns.derivatives]), [known.clone(), vec![0.0; free.len()]].concat())?;
        let bases = [Arc::new(whole), Arc::new(SharedDesign::new(data, &wrong, known)?)];
        let shift = |columns: &LinearForce, values: &[f64]| {
            &columns.prediction - &columns.derivatives * DVector::from_iterator(free.len(), free.iter().map(|i| values[*i]))
        };
        let here = shift(&columns, &fit.values);
        let nominal_design = CandidateDesign::new(data, &bases[0], &here, &DMatrix::zeros(data.samples(), 0), 0.0, Vec::new())?;
        // Share of a change that the machine's own parameters cannot stand for.
        let shows = |change: &DVector<f64>| {
            let left = LinearFit::new(&columns.derivatives, change);
            left.map_or(1.0, |left| left.residual.norm() / change.norm())
        };
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
                    let coordinate = LinearParameter { index, inverse, chord: inverse };
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
                // Amplitudes that are not linear all over their ranges, for a play beyond which others count, are next to it where they are small: a lattice over
                // several would miss that.
                let mut toward = amid.clone();
                if curved.len() > 1 {
                    curved.retain(|&index| {
                        let small = small(rigid, of, &start, index, data);
                        linear.extend(small.map(|_| LinearParameter { index, inverse: false, chord: true }));
                        toward[index] = small.unwrap_or(toward[index]);
                        small.is_none()
                    });
                }
                let mut places: Vec<Vec<(usize, f64)>> = grid(of, &curved, data, rigid);
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
                let lattice: Vec<(GridNode, f64)> = places
                    .par_iter()
                    .enumerate()
                    .flat_map_iter(|(at, values)| [(at, values, false), (at, values, true)])
                    .filter(|(_, _, slopes)| straight || !slopes)
                    .filter_map(|(at_place, values, slopes)| {
                        let values = values.clone();
                        let mut seen: f64 = 0.0;
                        let mut at = start.clone();
                        linear.iter().for_each(|l| at[l.index] = l.nothing(&of.parameters[l.index]));
                        let (mut linear, mut toward) = (linear.clone(), toward.clone());
                        let mut ends: Vec<(f64, f64)> = linear.iter().map(|l| l.ends(&of.parameters[l.index])).collect();
                        if slopes {
                            let inverse = of.parameters[curved[0]].scale == Scale::Logarithmic;
                            let slope = LinearParameter { index: curved[0], inverse, chord: inverse };
                            let (a, b) = near(at_place);
                            linear.push(slope);
                            ends.push((slope.of(a).min(slope.of(b)), slope.of(a).max(slope.of(b))));
                            toward[curved[0]] = if b == values[0].1 { a } else { b };
                        }
                        values.iter().for_each(|(i, x)| at[*i] = *x);
                        let more = added_columns(rigid, of, (&at, &toward), &linear, data);
                        let change = &more.prediction - &columns.prediction;
                        // With nothing of what is linear the force is mostly the machine's own.
                        let changed = (change.norm() > 1e-9 * columns.prediction.norm()).then(|| {
                            seen = seen.max(shows(&change));
                            LinearForce::new(rigid, of, &at, &free, &data.motions)
                        });
                        let differs =
                            |own: &LinearForce| (&own.derivatives - &columns.derivatives).norm() > 1e-9 * columns.derivatives.norm();
                        let same = !changed.as_ref().is_some_and(differs);
                        let mut own = changed.unwrap_or_else(|| columns.clone());
                        more.derivatives.column_iter().for_each(|c| seen = seen.max(shows(&c.clone_owned())));
                        let from = free.len() + nuisances.len();
                        let bounds = ends.iter().enumerate().map(|(k, (a, b))| (from + k, *a, *b)).collect();
                        // The shift of the added columns: their coefficients count from nothing.
                        let zero: DVector<f64> = DVector::from_iterator(linear.len(), linear.iter().map(|l| l.of(at[l.index])));
                        own.prediction -= &more.derivatives * zero;
                        let (base, extra) = match same {
                            true => (&bases[0], more.derivatives),
                            false => (&bases[1], beside(&[&own.derivatives, &more.derivatives])),
                        };
                        let design = CandidateDesign::new(data, base, &shift(&own, &at), &extra, 0.0, bounds)?;
                        Some((GridNode { values, linear, design }, seen))
                    })
                    .collect();
                let seen = lattice.iter().map(|(_, seen)| *seen).fold(0.0, f64::max);
                let lattice: Vec<GridNode> = lattice.into_iter().map(|(place, _)| place).collect();
                if seen < SEEN || lattice.is_empty() {
                    let why = "these records cannot show it: the machine's own parameters stand for what it does";
                    return MotionCandidate { unseen: true, ..without(hypothesis.id, Status::NotApplicable(why.into())) };
                }
                MotionCandidate {
                    id: hypothesis.id.clone(),
                    status: Status::Tried,
                    hypothesis: Some(hypothesis),
                    free: None,
                    column: None,
                    unseen: false,
                    lattice,
                }
            })
            .collect();
        let mut candidates = made;
        for shape in shapes {
            // Knots add up to what the machine has already (a constant, a direction): a little ridge keeps them apart.
            let ridge = 1e-3 * shape.columns.norm_squared() / shape.columns.ncols() as f64;
            if let Some(design) = CandidateDesign::new(data, &bases[0], &here, &shape.columns, ridge, Vec::new()) {
                let place = GridNode { values: Vec::new(), linear: Vec::new(), design };
                let free = Some((shape.over, shape.shape));
                candidates.push(MotionCandidate {
                    id: shape.column.as_ref().map_or(shape.over.into(), |column| format!("{} of {column}", shape.over)),
                    column: shape.column,
                    unseen: false,
                    status: Status::Tried,
                    hypothesis: None,
                    free,
                    lattice: vec![place],
                });
            }
        }
        candidates.extend(others.into_iter().map(|(id, status)| without(id, status)));
        Some(MotionScreening {
            bases,
            nominal: nominal_design,
            base_columns: free.len() + nuisances.len(),
            candidates,
            nuisances,
            free,
            variance,
        })
    }

    /// What a machine leaves beside what is ordinarily wrong, with what the latter costs; what an effect adds stays at these values.
    pub fn squares(&self, data: &MotionData<'_>, rigid: &Rigid, machine: &Machine, values: &[f64]) -> Option<f64> {
        let own = LinearForce::new(rigid, machine, values, &self.free, &data.motions);
        let columns = beside(&[&own.derivatives, &columns_of(&self.nuisances)]);
        let penalty = [vec![0.0; self.free.len()], vec![self.variance; self.nuisances.len()]].concat();
        let left = &data.y - own.prediction;
        let fit = LinearFit::penalised(&columns, &penalty, &left, INDEPENDENT)?;
        let prior: f64 = fit.coefficients.iter().zip(&penalty).map(|(size, p)| p * size * size).sum();
        Some(fit.residual.norm_squared() + prior)
    }

    /// Figures of every candidate on a force, the largest gain first.
    pub fn rank(&self, data: &MotionData<'_>, y: &DVector<f64>) -> Vec<Ranked> {
        let forces = Forces::new(data, std::slice::from_ref(y), &self.bases);
        let before = self.base_loss(data, &forces)[0];
        let best = |candidate: usize| {
            let c = &self.candidates[candidate];
            let (place, best) = self.best(candidate, data, &forces).swap_remove(0)?;
            let at = &c.lattice[place];
            let mut added = at.values.clone();
            added.extend(at.linear.iter().enumerate().map(|(k, l)| (l.index, l.of(best.coefficients[self.base_columns + k]))));
            Some(Ranked { candidate, gain: 1.0 - best.loss() / before, left_out: best.left_out, place, added })
        };
        let mut ranked: Vec<Ranked> = (0..self.candidates.len()).into_par_iter().filter_map(best).collect();
        ranked.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        ranked
    }

    /// What is ordinarily wrong that the machine as described needs most of, and how many standard deviations of it.
    pub fn stretched(&self, data: &MotionData<'_>) -> Option<(&str, f64)> {
        let (_, coefficients, _) = self.fitted(data, &data.y, None)?;
        let sizes = self.nuisances.iter().zip(coefficients.iter()).map(|(nuisance, size)| (nuisance.name.as_str(), size.abs()));
        sizes.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// What the machine alone leaves of parts of each force foretold without them.
    fn base_loss(&self, data: &MotionData<'_>, forces: &Forces) -> Vec<f64> {
        self.nominal.solve(data, forces).into_iter().map(|s| s.map_or(f64::INFINITY, |s| s.loss())).collect()
    }

    /// The place of a candidate's lattice that leaves least of each force.
    fn best(&self, candidate: usize, data: &MotionData<'_>, forces: &Forces) -> Vec<Option<(usize, Solved)>> {
        let places = self.candidates[candidate].lattice.iter().enumerate();
        let all = places.map(|(at, place)| place.design.solve(data, forces).into_iter().map(|s| s.map(|s| (at, s))).collect::<Vec<_>>());
        let better = |a: Option<(usize, Solved)>, b: Option<(usize, Solved)>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.1.loss() < a.1.loss() { b } else { a }),
            (a, b) => a.or(b),
        };
        all.reduce(|a, b| a.into_iter().zip(b).map(|(a, b)| better(a, b)).collect()).unwrap_or_else(|| vec![None; forces.count()])
    }

    /// The machine, or a candidate, fitted to a force: its coefficients, and what it leaves.
    fn fitted(
        &self,
        data: &MotionData<'_>,
        y: &DVector<f64>,
        of: Option<&Ranked>,
    ) -> Option<(&CandidateDesign, DVector<f64>, DVector<f64>)> {
        let design = of.map_or(&self.nominal, |r| &self.candidates[r.candidate].lattice[r.place].design);
        let solved = design.solve(data, &Forces::new(data, std::slice::from_ref(y), &self.bases)).swap_remove(0)?;
        let left = y - design.force(data, &solved.coefficients);
        Some((design, solved.coefficients, left))
    }

    /// By how much less squared misfit a candidate leaves than the machine, beside what is ordinarily wrong, sample by sample.
    pub fn taken(&self, data: &MotionData<'_>, of: &Ranked) -> Option<DVector<f64>> {
        let (_, _, before) = self.fitted(data, &data.y, None)?;
        let (_, _, after) = self.fitted(data, &data.y, Some(of))?;
        Some(before.zip_map(&after, |before, after| before * before - after * after))
    }

    /// Nulls: the machine with what is ordinarily wrong drawn from what these records tell of it beside the candidate that explains most, and noise of
    /// the colour of what that leaves, half of the draws moved in time, half in place with drawn signs.
    pub fn null(
        &self,
        data: &MotionData<'_>,
        y: &DVector<f64>,
        best: Option<&Ranked>,
        draws: usize,
        seed: u64,
        control: &Control,
    ) -> MotionNullDistribution {
        let gains = self.fitted(data, y, best).map_or_else(Vec::new, |fitted| self.gains_of_nulls(data, fitted, draws, seed, control));
        MotionNullDistribution::new(&gains, &self.candidates.iter().map(|c| c.free.is_some()).collect::<Vec<bool>>())
    }

    /// −ln(1 − gain) of every candidate in each draw.
    fn gains_of_nulls(
        &self,
        data: &MotionData<'_>,
        (design, coefficients, left): (&CandidateDesign, DVector<f64>, DVector<f64>),
        draws: usize,
        seed: u64,
        control: &Control,
    ) -> Vec<Vec<f64>> {
        let noise = ResidualBootstrap::new(&left, &data.records());
        let count = self.nuisances.len();
        let known = coefficients.rows(0, count).map(|size| size.clamp(-ORDINARY, ORDINARY));
        let scatter = design.covariance(count) * self.variance;
        let scatter = Cholesky::new(scatter).map_or_else(|| DMatrix::zeros(count, count), |c| c.unpack());
        let machine = self.nominal.force(data, &DVector::zeros(self.base_columns));
        let drawn = |draw: usize| {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9E37_79B9).wrapping_add(draw as u64));
            let mut y = &machine + noise.draw(draw % 2 == 1, &mut random);
            let wrong = &known + &scatter * DVector::from_fn(count, |_, _| normal(&mut random));
            self.nuisances.iter().zip(wrong.iter()).for_each(|(nuisance, size)| y.axpy(*size, &nuisance.column, 1.0));
            y
        };
        let together = |from: usize| {
            let forces = Forces::new(data, &(from..draws.min(from + TOGETHER)).map(drawn).collect::<Vec<_>>(), &self.bases);
            let before = self.base_loss(data, &forces);
            let mut gains = vec![Vec::with_capacity(self.candidates.len()); before.len()];
            for candidate in 0..self.candidates.len() {
                for ((own, before), best) in gains.iter_mut().zip(&before).zip(self.best(candidate, data, &forces)) {
                    own.push(best.map_or(0.0, |(_, solved)| strength(1.0 - solved.loss() / before)));
                }
            }
            gains
        };
        let chunks: Vec<usize> = (0..draws).step_by(TOGETHER).collect();
        let of = |from: usize| control.kept(&format!("nulls from {from} {seed}"), || together(from));
        chunks.into_par_iter().filter(|_| !control.stopped()).flat_map_iter(of).collect()
    }
}

fn columns_of(nuisances: &[Nuisance]) -> DMatrix<f64> {
    DMatrix::from_columns(&nuisances.iter().map(|n| n.column.clone()).collect::<Vec<_>>())
}

fn without(id: String, status: Status) -> MotionCandidate {
    MotionCandidate { id, status, hypothesis: None, free: None, column: None, unseen: false, lattice: Vec::new() }
}

/// Prediction at a place, and its derivatives with what is linear; those of inverses and small amplitudes between that place and another.
fn added_columns(
    rigid: &Rigid,
    machine: &Machine,
    (at, toward): (&[f64], &[f64]),
    linear: &[LinearParameter],
    data: &MotionData<'_>,
) -> LinearForce {
    let indices: Vec<usize> = linear.iter().map(|l| l.index).collect();
    let mut columns = LinearForce::new(rigid, machine, at, &indices, &data.motions);
    for (k, l) in linear.iter().enumerate().filter(|(_, l)| l.chord) {
        let mut there = at.to_vec();
        there[l.index] = toward[l.index];
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

/// Whether a candidate releases a frozen parameter.
pub(super) fn releases(candidate: &MotionCandidate) -> bool {
    candidate.hypothesis.as_ref().is_some_and(|h| h.kind == HypothesisKind::Release)
}
