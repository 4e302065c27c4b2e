//! Screening: every candidate is fitted jointly with the machine and compared with it, on the
//! record and on null simulations.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::candidate::{GridNode, MotionCandidate, ScreenedFit, start_of, without};
use super::data::{MotionData, side_by_side};
use super::design::{CandidateDesign, Forces, INDEPENDENT, SharedDesign, Solved};
use super::free_function::free_functions;
use super::grid::{LinearParameter, grid, small};
use super::nuisance::{Nuisance, columns_of, nuisances};
use super::residual_bootstrap::ResidualBootstrap;
use crate::null_directions::generator;
use crate::{Hypothesis, Status};
use dynamics::inverse_dynamics::{LinearForce, Rigid, free_parameters, is_linear_in_inverse, prediction};
use identification::motion::{ForceFit, Tolerances};
use long_work::Control;
use machine::{Machine, ParameterValues, Scale};
use numeric::linear_fit::LinearFit;
use numeric::random::normal;
use optimizer::nonzero_columns;

/// Figures of one null simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct NullDraw {
    /// Squared misfit of the machine as described, with the penalty of the nuisance parameters.
    pub squares: f64,
    /// Reduction of it by every candidate.
    pub gains: Vec<f64>,
}

/// The machine, its nuisance parameters and all candidates.
pub struct MotionScreening {
    /// Columns of the nuisance parameters with the machine's own columns, and alone.
    bases: [Arc<SharedDesign>; 2],
    nominal: CandidateDesign,
    base_columns: usize,
    /// Candidates.
    pub candidates: Vec<MotionCandidate>,
    /// Nuisance parameters.
    pub nuisances: Vec<Nuisance>,
    /// What smooth functions leave of the residual: noise, whatever effect is missing.
    noise: ResidualBootstrap,
    /// Variance of the noise, corrected for its autocorrelation.
    variance: f64,
}

/// Least relative change of the force by an effective parameter value.
const LEAST_CHANGE: f64 = 1e-3;
/// Least share of a column, orthogonal to the machine's own parameters, with which a candidate is
/// identifiable.
const LEAST_INDEPENDENT: f64 = 0.05;

/// Least noise over the recorded force (1). Drives do not know their current to better than a thousandth, and
/// simulated records without noise show how they were integrated.
const LEAST_NOISE: f64 = 1e-3;
/// Largest size (standard deviations) of nuisance parameters in null simulations.
const NUISANCE_RANGE: f64 = 2.0;
/// Number of null simulations that are solved together.
const BATCH: usize = 50;

/// Inputs of a screening.
pub(super) struct SharedColumns<'g> {
    pub data: &'g MotionData<'g>,
    pub rigid: &'g Rigid,
    /// The machine, possibly with effects chosen so far.
    pub nominal: &'g Hypothesis,
    pub fit: &'g ForceFit,
    pub frozen: &'g [String],
}

impl MotionScreening {
    /// Computes all designs.
    ///
    /// # Errors  none: a candidate whose columns fail is reported among the candidates.
    pub(super) fn new(
        shared: &SharedColumns<'_>,
        hypotheses: Vec<Hypothesis>,
        others: Vec<(String, Status)>,
        control: &Control,
    ) -> Option<Self> {
        let SharedColumns { data, rigid, nominal, fit, frozen } = shared;
        let machine = &nominal.machine;
        let mut free_all = free_parameters(machine, frozen).ok()?;
        let mut all = LinearForce::new(rigid, machine, &fit.values, &free_all, &data.motions);
        // Parameters without influence at the end of the fit keep their values.
        let live = nonzero_columns(&all.derivatives);
        if live.len() < free_all.len() {
            all.derivatives = all.derivatives.select_columns(&live);
            free_all = live.into_iter().map(|at| free_all[at]).collect();
        }
        let nuisances = nuisances(data, rigid, machine, &fit.values);
        if nuisances.is_empty() {
            return None;
        }
        let tolerances = columns_of(&nuisances);
        // Noise: the residual beyond smooth functions, whatever effect is missing. Its autocorrelation
        // reduces the effective number of samples.
        let functions = free_functions(data);
        let smooth: Vec<&DMatrix<f64>> =
            [&all.derivatives, &tolerances].into_iter().chain(functions.iter().map(|f| &f.columns)).collect();
        let mut smooth = side_by_side(&smooth);
        smooth.column_iter_mut().for_each(|mut column| column.unscale_mut(column.norm()));
        let mut left = fit.residual.clone();
        Tolerances::new(&smooth, 0.0)?.apply(&mut left);
        left *= (LEAST_NOISE * data.y.norm() / left.norm()).max(1.0);
        let noise = ResidualBootstrap::new(&left, &data.records());
        let freedom = data.samples().saturating_sub(smooth.ncols()).max(data.samples() / 2);
        let variance = left.norm_squared() / freedom as f64 * noise.inflation();
        let penalties = |free: usize| [vec![0.0; free], vec![variance; nuisances.len()]].concat();
        // Fix parameters that would leave their range next to the nuisance parameters: no candidate gains or
        // loses by moving them farther.
        let with_nuisances = side_by_side(&[&all.derivatives, &tolerances]);
        let step =
            LinearFit::penalised(&with_nuisances, &penalties(free_all.len()), &fit.residual, INDEPENDENT)?
                .coefficients;
        let inside = |at: &usize| {
            let (p, x) = (&machine.parameters[free_all[*at]], fit.values[free_all[*at]]);
            p.holds_inside(x) || (p.lower..=p.upper).contains(&(x + step[*at]))
        };
        let free: Vec<usize> = (0..free_all.len()).filter(inside).map(|at| free_all[at]).collect();
        let columns = if free.len() == free_all.len() {
            all
        } else {
            LinearForce::new(rigid, machine, &fit.values, &free, &data.motions)
        };
        // Nuisance parameters with the machine's own columns, which many candidates do not change, and alone.
        let known = vec![variance; nuisances.len()];
        let whole = SharedDesign::new(
            data,
            &side_by_side(&[&tolerances, &columns.derivatives]),
            [known.clone(), vec![0.0; free.len()]].concat(),
        )?;
        let bases = [Arc::new(whole), Arc::new(SharedDesign::new(data, &tolerances, known)?)];
        let shift = |columns: &LinearForce, values: &[f64]| {
            &columns.prediction
                - &columns.derivatives * DVector::from_iterator(free.len(), free.iter().map(|i| values[*i]))
        };
        let here = shift(&columns, &fit.values);
        let nominal_design = CandidateDesign::new(
            data,
            &bases[0],
            &here,
            &DMatrix::zeros(data.samples(), 0),
            0.0,
            Vec::new(),
        )?;
        // Share of a change that the machine's own parameters cannot reproduce.
        let independent_share = |change: &DVector<f64>| {
            let left = LinearFit::new(&columns.derivatives, change);
            left.map_or(1.0, |left| left.residual.norm() / change.norm())
        };
        let made: Vec<MotionCandidate> = hypotheses
            .into_par_iter()
            .map(|hypothesis| {
                if control.stopped() {
                    return without(hypothesis.id(), Status::Failed("stopped before this candidate was fitted".into()));
                }
                let of = &hypothesis.machine;
                let start = start_of(of, &fit.values);
                let added = &hypothesis.added;
                // Linearity is tested at interior values. Without any change there, the force of a rigid
                // drive does not depend on the effect.
                let interior = interior(of, &start, added);
                let base_force = prediction(rigid, of, &interior, &data.motions);
                let changed_force = |index: usize, unit: f64| {
                    let mut values = interior.clone();
                    values[index] = of.parameters[index].from_unit(unit);
                    (values[index], prediction(rigid, of, &values, &data.motions))
                };
                let (mut linear, mut curved) = (Vec::new(), Vec::new());
                for (&index, inverse) in added.iter().zip(is_linear_in_inverse(of, added)) {
                    let coordinate = LinearParameter { index, inverse, chord: inverse };
                    let unit = of.parameters[index].to_unit(interior[index]);
                    let ((a, fa), (b, fb)) = (changed_force(index, 0.5 * unit), changed_force(index, 0.25 * unit));
                    let (a, b, here) = (coordinate.of(a), coordinate.of(b), coordinate.of(interior[index]));
                    let (da, db) = ((&fa - &base_force) / (a - here), (&fb - &base_force) / (b - here));
                    let size = da.norm().max(db.norm());
                    if size * (a - here).abs() <= 1e-9 * base_force.norm() {
                        continue;
                    }
                    if (da - db).norm() <= 1e-6 * size { linear.push(coordinate) } else { curved.push(index) }
                }
                if linear.is_empty() && curved.is_empty() {
                    let why = "the force of the rigid drive with its present effects does not depend on it";
                    return without(hypothesis.id(), Status::NotApplicable(why.into()));
                }
                // Nonlinear amplitudes with both signs are linearised near zero, as a grid over several would
                // miss it.
                let mut toward = interior.clone();
                if curved.len() > 1 {
                    curved.retain(|&index| {
                        let small = small(rigid, of, &start, index, data);
                        linear.extend(small.map(|_| LinearParameter { index, inverse: false, chord: true }));
                        toward[index] = small.unwrap_or(toward[index]);
                        small.is_none()
                    });
                }
                let mut grid_points: Vec<Vec<(usize, f64)>> = grid(of, &curved, data, rigid);
                // Over decades: place the nodes within the range in which the force changes.
                if let [one] = curved[..]
                    && of.parameters[one].scale == Scale::Logarithmic
                    && !of.parameters[one].mechanism.is_period()
                {
                    let moves = |node: &&Vec<(usize, f64)>| {
                        let mut values = start.clone();
                        values[one] = node[0].1;
                        (prediction(rigid, of, &values, &data.motions) - &columns.prediction).norm()
                            > LEAST_CHANGE * columns.prediction.norm()
                    };
                    let effective: Vec<f64> = grid_points.par_iter().filter(moves).map(|node| node[0].1).collect();
                    if let (Some(from), Some(to)) = (effective.iter().copied().reduce(f64::min), effective.iter().copied().reduce(f64::max))
                    {
                        let last = (grid_points.len() - 1) as f64;
                        (0..grid_points.len()).for_each(|k| grid_points[k][0].1 = from * (to / from).powf(k as f64 / last));
                    }
                }
                // A node covers itself and, for one nonlinear parameter other than a period, the linearised
                // interval to its neighbours.
                let straight = matches!(curved[..], [one] if !of.parameters[one].mechanism.is_period());
                let near = |at: usize| {
                    let value = |at: usize| grid_points.get(at).map(|p| p[0].1);
                    let here = grid_points[at][0].1;
                    (at.checked_sub(1).and_then(value).unwrap_or(here), value(at + 1).unwrap_or(here))
                };
                let nodes: Vec<(GridNode, f64)> = grid_points
                    .par_iter()
                    .enumerate()
                    .filter(|_| !control.stopped())
                    .flat_map_iter(|(at, values)| [(at, values, false), (at, values, true)])
                    .filter(|(_, _, slopes)| straight || !slopes)
                    .filter_map(|(at_place, values, slopes)| {
                        let values = values.clone();
                        let mut visible: f64 = 0.0;
                        let mut at = start.clone();
                        linear.iter().for_each(|l| at[l.index] = l.without_influence(&of.parameters[l.index]));
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
                        // With all linear parameters at zero the force is mostly that of the machine.
                        let changed = (change.norm() > 1e-9 * columns.prediction.norm()).then(|| {
                            visible = visible.max(independent_share(&change));
                            LinearForce::new(rigid, of, &at, &free, &data.motions)
                        });
                        let differs =
                            |own: &LinearForce| (&own.derivatives - &columns.derivatives).norm() > 1e-9 * columns.derivatives.norm();
                        let same = !changed.as_ref().is_some_and(differs);
                        let mut own = changed.unwrap_or_else(|| columns.clone());
                        more.derivatives.column_iter().for_each(|c| visible = visible.max(independent_share(&c.clone_owned())));
                        let from = free.len() + nuisances.len();
                        let bounds = ends.iter().enumerate().map(|(k, (a, b))| (from + k, *a, *b)).collect();
                        // Coefficients of added columns count from zero: shift the prediction.
                        let zero: DVector<f64> = DVector::from_iterator(linear.len(), linear.iter().map(|l| l.of(at[l.index])));
                        own.prediction -= &more.derivatives * zero;
                        let (base, extra) = match same {
                            true => (&bases[0], more.derivatives),
                            false => (&bases[1], side_by_side(&[&own.derivatives, &more.derivatives])),
                        };
                        let design = CandidateDesign::new(data, base, &shift(&own, &at), &extra, 0.0, bounds)?;
                        Some((GridNode { values, linear, design }, visible))
                    })
                    .collect();
                if control.stopped() {
                    return without(hypothesis.id(), Status::Failed("stopped before this candidate was fitted".into()));
                }
                let visible = nodes.iter().map(|(_, visible)| *visible).fold(0.0, f64::max);
                let nodes: Vec<GridNode> = nodes.into_iter().map(|(node, _)| node).collect();
                if visible < LEAST_INDEPENDENT || nodes.is_empty() {
                    let why = "these records do not identify it: the machine's own parameters have the same influence";
                    return MotionCandidate { unidentifiable: true, ..without(hypothesis.id(), Status::NotApplicable(why.into())) };
                }
                let id = hypothesis.id();
                MotionCandidate { hypothesis: Some(hypothesis), nodes, ..without(id, Status::Tried) }
            })
            .collect();
        let mut candidates = made;
        for shape in functions {
            if let Some(design) =
                CandidateDesign::new(data, &bases[0], &here, &shape.columns, shape.ridge(), Vec::new())
            {
                let node = GridNode { values: Vec::new(), linear: Vec::new(), design };
                let word = shape.variable.word();
                candidates.push(MotionCandidate {
                    id: shape.column.as_ref().map_or(word.into(), |column| format!("{word} of {column}")),
                    column: shape.column,
                    free: Some(shape.variable),
                    nodes: vec![node],
                    ..without(String::new(), Status::Tried)
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
            noise,
            variance,
        })
    }

    /// Returns what the nuisance parameters leave of a force; `None` where they are no numbers.
    pub fn tolerances(&self) -> Option<Tolerances> {
        Tolerances::new(&columns_of(&self.nuisances), self.variance)
    }

    /// Returns the variance of the noise, corrected for its autocorrelation (N² or N²·m²).
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// Returns the number of samples without autocorrelation.
    pub fn count(&self, data: &MotionData<'_>) -> f64 {
        data.samples() as f64 / self.noise.inflation()
    }

    /// Fits the machine alone to the recorded force: its least squared misfit, and its squared prediction
    /// error of left-out parts, both with the penalty.
    pub fn alone(&self, data: &MotionData<'_>) -> (f64, f64) {
        let forces = Forces::new(data, std::slice::from_ref(&data.y), &self.bases);
        let Some(solved) = self.nominal.solve(data, &forces).swap_remove(0) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let left_out: f64 = self.nominal.left_out(data, &forces).iter().sum();
        (solved.squares, left_out + self.nominal.prior(&solved.coefficients))
    }

    /// Fits every candidate to the recorded force.
    pub fn fits(&self, data: &MotionData<'_>) -> Vec<ScreenedFit> {
        let forces = Forces::new(data, std::slice::from_ref(&data.y), &self.bases);
        let best = |candidate: usize| {
            let c = &self.candidates[candidate];
            let (node, best) = self.best(candidate, data, &forces).swap_remove(0)?;
            let at = &c.nodes[node];
            let mut added = at.values.clone();
            added.extend(
                at.linear
                    .iter()
                    .enumerate()
                    .map(|(k, l)| (l.index, l.of(best.coefficients[self.base_columns + k]))),
            );
            let left_out: f64 = at.design.left_out(data, &forces).iter().sum();
            let left_out = left_out + at.design.prior(&best.coefficients);
            Some(ScreenedFit { candidate, squares: best.squares, left_out, node, added })
        };
        (0..self.candidates.len()).into_par_iter().filter_map(best).collect()
    }

    /// Returns the grid node of a candidate that fits each force best.
    fn best(&self, candidate: usize, data: &MotionData<'_>, forces: &Forces) -> Vec<Option<(usize, Solved)>> {
        let grid_points = self.candidates[candidate].nodes.iter().enumerate();
        let all = grid_points.map(|(at, node)| {
            node.design.solve(data, forces).into_iter().map(|s| s.map(|s| (at, s))).collect::<Vec<_>>()
        });
        let better = |a: Option<(usize, Solved)>, b: Option<(usize, Solved)>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.1.squares < a.1.squares { b } else { a }),
            (a, b) => a.or(b),
        };
        all.reduce(|a, b| a.into_iter().zip(b).map(|(a, b)| better(a, b)).collect())
            .unwrap_or_else(|| vec![None; forces.count()])
    }

    /// Fits the machine, or a candidate, to the recorded force; returns design, coefficients and residual.
    fn fitted(
        &self,
        data: &MotionData<'_>,
        of: Option<&ScreenedFit>,
    ) -> Option<(&CandidateDesign, DVector<f64>, DVector<f64>)> {
        let design = of.map_or(&self.nominal, |r| &self.candidates[r.candidate].nodes[r.node].design);
        let solved = design
            .solve(data, &Forces::new(data, std::slice::from_ref(&data.y), &self.bases))
            .swap_remove(0)?;
        let left = &data.y - design.force(data, &solved.coefficients);
        Some((design, solved.coefficients, left))
    }

    /// Returns by how much a candidate reduces the squared misfit, sample by sample.
    pub fn squared_reduction(&self, data: &MotionData<'_>, of: &ScreenedFit) -> Option<DVector<f64>> {
        let (_, _, before) = self.fitted(data, None)?;
        let (_, _, after) = self.fitted(data, Some(of))?;
        Some(before.zip_map(&after, |before, after| before * before - after * after))
    }

    /// Simulates the machine without a missing effect. Nuisance parameters are drawn from their estimates
    /// next to the best candidate, noise by bootstrap of what smooth functions leave of the residual.
    pub(super) fn null_simulations(
        &self,
        data: &MotionData<'_>,
        best: Option<&ScreenedFit>,
        draws: usize,
        seed: u64,
        control: &Control,
    ) -> Vec<NullDraw> {
        let Some((design, coefficients, _)) = self.fitted(data, best) else { return Vec::new() };
        let noise = &self.noise;
        let count = self.nuisances.len();
        let known = coefficients.rows(0, count).map(|size| size.clamp(-NUISANCE_RANGE, NUISANCE_RANGE));
        let scatter = design.covariance(count) * self.variance;
        let scatter = Cholesky::new(scatter).map_or_else(|| DMatrix::zeros(count, count), |c| c.unpack());
        let machine = self.nominal.force(data, &DVector::zeros(self.base_columns));
        let drawn = |draw: usize| {
            let mut random = generator(seed, draw);
            let mut y = &machine + noise.draw(draw % 2 == 1, &mut random);
            let sizes = &known + &scatter * DVector::from_fn(count, |_, _| normal(&mut random));
            self.nuisances
                .iter()
                .zip(sizes.iter())
                .for_each(|(nuisance, size)| y.axpy(*size, &nuisance.column, 1.0));
            y
        };
        let solve_batch = |from: usize| {
            let forces = Forces::new(
                data,
                &(from..draws.min(from + BATCH)).map(drawn).collect::<Vec<_>>(),
                &self.bases,
            );
            let alone = self.nominal.solve(data, &forces);
            let begin = |alone: Option<Solved>| NullDraw {
                squares: alone.map_or(f64::INFINITY, |solved| solved.squares),
                gains: Vec::with_capacity(self.candidates.len()),
            };
            let mut draws: Vec<NullDraw> = alone.into_iter().map(begin).collect();
            for candidate in 0..self.candidates.len() {
                for (draw, best) in draws.iter_mut().zip(self.best(candidate, data, &forces)) {
                    draw.gains.push(best.map_or(0.0, |(_, solved)| (draw.squares - solved.squares).max(0.0)));
                }
            }
            draws
        };
        let chunks: Vec<usize> = (0..draws).step_by(BATCH).collect();
        let of = |from: usize| {
            control.cached(&format!("null simulations from {from} {seed}"), || solve_batch(from))
        };
        chunks.into_par_iter().filter(|_| !control.stopped()).flat_map_iter(of).collect()
    }
}

/// Returns prediction and derivatives by linear parameters. Those marked as `chord` are difference quotients
/// to another point.
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

/// Returns values with the added parameters inside their ranges, each at a different coordinate.
fn interior(machine: &Machine, start: &ParameterValues, added: &[usize]) -> ParameterValues {
    let mut values = start.clone();
    for (k, &index) in added.iter().enumerate() {
        values[index] = machine.parameters[index].from_unit(0.55 + 0.07 * (k % 5) as f64);
    }
    values
}
