//! Selection of modes: backward elimination of candidates, refinement, and addition of modes found in the
//! residual.
//!
//! A mode has four real unknowns; it is kept if it reduces χ² by more than 4 ln N times the residual
//! variance, with N real data.
//!
//! # Source  Schwarz, Annals of Statistics 6 (1978), 461–464, on the penalty of an unknown.

use num_complex::Complex64;

use super::curve::CurveLines;
use super::least_squares::{ModalNormalEquations, linear_unknowns, refine, solve_linear};
use super::model::{ModalModel, PER_MODE, Term};
use super::stabilisation::{StablePole, coincide};

/// Smallest share of stable orders of a candidate in the initial model (1).
const LEAST_SHARE: f64 = 0.15;
/// Smallest width of a resonance, as a share of the line spacing (1); a narrower one is a single faulty line.
const NARROW: f64 = 0.05;
/// Damping ratios of the poles tried on the residual (1).
const TRIED_DAMPING: [f64; 4] = [0.002, 0.01, 0.04, 0.15];
/// Largest number of poles in the final model, including those outside the band.
const MAX_MODES: usize = 30;
/// Largest number of frequencies of the poles tried on the residual.
const TRIED_FREQUENCIES: usize = 250;

/// Lines with their weights, and the smallest χ² per degree of freedom that counts as noise.
pub(super) struct Task<'a> {
    pub lines: &'a CurveLines,
    pub weight: &'a [f64],
    pub floor: f64,
}

impl Task<'_> {
    /// Returns the reduction of χ² that a mode must exceed.
    fn penalty(&self, chi2: f64, unknowns: usize) -> f64 {
        let data = 2.0 * self.lines.len() as f64;
        let variance = (chi2 / (data - unknowns as f64).max(1.0)).max(self.floor);
        PER_MODE as f64 * data.ln() * variance
    }
}

/// Selects the modal model from candidates and residual; `None` where the equations are singular.
pub(super) fn select(task: &Task, candidates: &[StablePole]) -> Option<ModalModel> {
    let largest = MAX_MODES.min(task.lines.len() / 6).max(1);
    let mut poles: Vec<Complex64> = Vec::new();
    for candidate in candidates.iter().filter(|c| c.stability.share() >= LEAST_SHARE) {
        if poles.len() < largest && !poles.iter().any(|p| coincide(*p, candidate.pole)) {
            poles.push(candidate.pole);
        }
    }
    let mut model = ModalModel::of(task.lines, &poles);
    solve_linear(&mut model, task.lines, task.weight)?;
    prune(&mut model, task);
    refine(&mut model, task.lines, task.weight, 1e-2, 8);
    prune(&mut model, task);
    let mut chi2 = refine(&mut model, task.lines, task.weight, 1e-3, 20);
    while model.terms.len() < largest && chi2 > task.floor * 2.0 * task.lines.len() as f64 {
        let Some((next, reached)) = with_best_pole(&model, chi2, task) else { break };
        (model, chi2) = (next, reached);
    }
    prune(&mut model, task);
    merge(&mut model, task);
    Some(model)
}

/// Removes one of two coinciding poles where the other alone explains the curve as well.
fn merge(model: &mut ModalModel, task: &Task) {
    let mut chi2 = refine(model, task.lines, task.weight, 1e-3, 10);
    while let Some(at) = weaker_duplicate(model) {
        let mut single = model.clone();
        single.terms.remove(at);
        if solve_linear(&mut single, task.lines, task.weight).is_none() {
            return;
        }
        let reached = refine(&mut single, task.lines, task.weight, 1e-3, 15);
        if reached - chi2 > task.penalty(chi2, model.unknowns()) {
            return;
        }
        (*model, chi2) = (single, reached);
    }
}

/// Returns the weaker of two poles closer than a third of the smaller half-width.
fn weaker_duplicate(model: &ModalModel) -> Option<usize> {
    let mut weakest: Option<(usize, f64)> = None;
    for (at, a) in model.terms.iter().enumerate() {
        let close = |b: &&Term| {
            **b != *a
                && (a.pole - b.pole).norm() < 0.33 * (-a.pole.re).min(-b.pole.re)
                && b.residue.norm() >= a.residue.norm()
        };
        if model.terms.iter().any(|b| close(&b)) && weakest.is_none_or(|(_, least)| a.residue.norm() < least)
        {
            weakest = Some((at, a.residue.norm()));
        }
    }
    weakest.map(|(at, _)| at)
}

/// Returns the model with the mode that explains most of the residual, if it exceeds the penalty.
fn with_best_pole(model: &ModalModel, chi2: f64, task: &Task) -> Option<(ModalModel, f64)> {
    let mut poles: Vec<Complex64> = model.terms.iter().map(|t| t.pole).collect();
    poles.push(best_pole(model, task)?);
    let mut next = ModalModel::of(task.lines, &poles);
    for (term, previous) in next.terms.iter_mut().zip(&model.terms) {
        term.residue = previous.residue;
    }
    next.background = model.background;
    solve_linear(&mut next, task.lines, task.weight)?;
    let reached = refine(&mut next, task.lines, task.weight, 1e-3, 15);
    (chi2 - reached > task.penalty(reached, next.unknowns())).then_some((next, reached))
}

/// Returns the pole whose resonance explains most of the residual.
fn best_pole(model: &ModalModel, task: &Task) -> Option<Complex64> {
    let lines = task.lines;
    let residual: Vec<Complex64> = lines
        .omega
        .iter()
        .zip(&lines.h)
        .zip(task.weight)
        .map(|((omega, h), w)| (h - model.at(*omega)) * w)
        .collect();
    let mut best: Option<(f64, Complex64)> = None;
    for at in (0..lines.len()).step_by(lines.len().div_ceil(TRIED_FREQUENCIES)) {
        let omega = lines.omega[at];
        let spacing = lines.spacing(omega);
        for damping in TRIED_DAMPING {
            let sigma = (damping * omega).max(0.5 * spacing);
            let pole = Complex64::new(-sigma, omega);
            // Lines further than 25 half-widths carry little information on the pole.
            let from = lines.omega.partition_point(|w| *w < omega - 25.0 * sigma);
            let to = lines.omega.partition_point(|w| *w < omega + 25.0 * sigma);
            let (mut projection, mut length) = (Complex64::ZERO, 0.0);
            for ((omega, weight), residual) in
                lines.omega[from..to].iter().zip(&task.weight[from..to]).zip(&residual[from..to])
            {
                let column = (Complex64::new(0.0, *omega) - pole).inv() * *weight;
                projection += column.conj() * residual;
                length += column.norm_sqr();
            }
            let gain = projection.norm_sqr() / length;
            if gain.is_finite() && best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, pole));
            }
        }
    }
    best.map(|(_, pole)| pole)
}

/// Removes, one by one, the modes below the penalty and those too narrow for the line spacing.
pub(super) fn prune(model: &mut ModalModel, task: &Task) {
    model.terms.retain(|t| -2.0 * t.pole.re > NARROW * task.lines.spacing(t.pole.im));
    if solve_linear(model, task.lines, task.weight).is_none() {
        return;
    }
    while let Some((chi2, gains)) = gains(model, task) {
        let Some((at, least)) = gains.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return;
        };
        if least > task.penalty(chi2, model.unknowns()) {
            return;
        }
        model.terms.remove(at);
        if solve_linear(model, task.lines, task.weight).is_none() {
            return;
        }
    }
}

/// Returns χ² and its increase without each mode, with all other residues solved again.
pub(super) fn gains(model: &ModalModel, task: &Task) -> Option<(f64, Vec<f64>)> {
    let normal =
        ModalNormalEquations::of(model, task.lines, task.weight).restricted_to(&linear_unknowns(model));
    let (_, inverse) = normal.solve(1e-13, true)?;
    let gain = |(at, term): (usize, &Term)| {
        let block = inverse.fixed_view::<2, 2>(2 * at, 2 * at).into_owned();
        let residue = nalgebra::Vector2::new(term.residue.re, term.residue.im);
        block.try_inverse().map_or(0.0, |b| residue.dot(&(b * residue)))
    };
    Some((normal.chi2, model.terms.iter().enumerate().map(gain).collect()))
}
