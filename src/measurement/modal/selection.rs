//! Which candidates are modes: backward elimination, refinement, and what the residual still asks for.
//!
//! A mode has four real unknowns; it stays when it lowers χ² by more than 4 ln N times the residual variance, N real data.
//!
//! # Source  Schwarz, Annals of Statistics 6 (1978), 461–464, on the price of an unknown.

use num_complex::Complex64;

use super::curve::{CurveLines, CurveOptions};
use super::least_squares::{ModalNormalEquations, linear_unknowns, refine, solve_linear};
use super::model::{ModalModel, PER_MODE, Term};
use super::stabilisation::{StablePole, same};

/// Share of the orders at which a pole must be stable to be tried from the start.
const LEAST_SHARE: f64 = 0.15;
/// A resonance narrower than this share of the distance of the lines is a single bad line.
const NARROW: f64 = 0.05;
/// Damping ratios of the poles tried on the residual.
const TRIED_DAMPING: [f64; 4] = [0.002, 0.01, 0.04, 0.15];
/// Frequencies of the poles tried on the residual, at most.
const TRIED_FREQUENCIES: usize = 250;

/// The lines with their weights, and the least χ² per degree of freedom that counts as noise.
pub(super) struct Task<'a> {
    pub lines: &'a CurveLines,
    pub weight: &'a [f64],
    pub floor: f64,
}

impl Task<'_> {
    /// χ² that a mode must gain.
    fn price(&self, chi2: f64, unknowns: usize) -> f64 {
        let data = 2.0 * self.lines.len() as f64;
        let variance = (chi2 / (data - unknowns as f64).max(1.0)).max(self.floor);
        PER_MODE as f64 * data.ln() * variance
    }
}

/// Most poles that the lines and the options allow.
fn most_modes(lines: &CurveLines, options: &CurveOptions) -> usize {
    options.max_modes.min(lines.len() / 6).max(1)
}

/// The modal model of the candidates and of the residual; `None` where the equations are singular.
pub(super) fn select(task: &Task, candidates: &[StablePole], options: &CurveOptions) -> Option<ModalModel> {
    let most = most_modes(task.lines, options);
    let mut poles: Vec<Complex64> = Vec::new();
    for candidate in candidates.iter().filter(|c| c.stability.share() >= LEAST_SHARE) {
        if poles.len() < most && !poles.iter().any(|p| same(*p, candidate.pole)) {
            poles.push(candidate.pole);
        }
    }
    let mut model = ModalModel::of(task.lines, &poles);
    solve_linear(&mut model, task.lines, task.weight)?;
    prune(&mut model, task);
    refine(&mut model, task.lines, task.weight, 1e-2, 8);
    prune(&mut model, task);
    let mut chi2 = refine(&mut model, task.lines, task.weight, 1e-3, 20);
    while model.terms.len() < most && chi2 > task.floor * 2.0 * task.lines.len() as f64 {
        let Some((next, reached)) = grown(&model, chi2, task) else { break };
        (model, chi2) = (next, reached);
    }
    prune(&mut model, task);
    merge(&mut model, task);
    Some(model)
}

/// Takes out one of two poles that ran into each other, where the other explains the curve as well without it.
fn merge(model: &mut ModalModel, task: &Task) {
    let mut chi2 = refine(model, task.lines, task.weight, 1e-3, 10);
    while let Some(at) = doubled(model) {
        let mut single = model.clone();
        single.terms.remove(at);
        if solve_linear(&mut single, task.lines, task.weight).is_none() {
            return;
        }
        let reached = refine(&mut single, task.lines, task.weight, 1e-3, 15);
        if reached - chi2 > task.price(chi2, model.unknowns()) {
            return;
        }
        (*model, chi2) = (single, reached);
    }
}

/// The weaker one of two poles closer than a third of their half-width.
fn doubled(model: &ModalModel) -> Option<usize> {
    let mut weakest: Option<(usize, f64)> = None;
    for (at, a) in model.terms.iter().enumerate() {
        let close =
            |b: &&Term| **b != *a && (a.pole - b.pole).norm() < 0.33 * (-a.pole.re).min(-b.pole.re) && b.residue.norm() >= a.residue.norm();
        if model.terms.iter().any(|b| close(&b)) && weakest.is_none_or(|(_, least)| a.residue.norm() < least) {
            weakest = Some((at, a.residue.norm()));
        }
    }
    weakest.map(|(at, _)| at)
}

/// The model with the mode that the residual asks for most, where it pays.
fn grown(model: &ModalModel, chi2: f64, task: &Task) -> Option<(ModalModel, f64)> {
    let mut poles: Vec<Complex64> = model.terms.iter().map(|t| t.pole).collect();
    poles.push(proposal(model, task)?);
    let mut next = ModalModel::of(task.lines, &poles);
    for (term, before) in next.terms.iter_mut().zip(&model.terms) {
        term.residue = before.residue;
    }
    next.background = model.background;
    solve_linear(&mut next, task.lines, task.weight)?;
    let reached = refine(&mut next, task.lines, task.weight, 1e-3, 15);
    (chi2 - reached > task.price(reached, next.unknowns())).then_some((next, reached))
}

/// The pole whose resonance explains most of the residual.
fn proposal(model: &ModalModel, task: &Task) -> Option<Complex64> {
    let lines = task.lines;
    let residual: Vec<Complex64> =
        lines.omega.iter().zip(&lines.h).zip(task.weight).map(|((omega, h), w)| (h - model.at(*omega)) * w).collect();
    let mut best: Option<(f64, Complex64)> = None;
    for at in (0..lines.len()).step_by(lines.len().div_ceil(TRIED_FREQUENCIES)) {
        let omega = lines.omega[at];
        let spacing = lines.spacing(omega);
        for damping in TRIED_DAMPING {
            let sigma = (damping * omega).max(0.5 * spacing);
            let pole = Complex64::new(-sigma, omega);
            // Lines further than 25 half-widths say little about the pole.
            let from = lines.omega.partition_point(|w| *w < omega - 25.0 * sigma);
            let to = lines.omega.partition_point(|w| *w < omega + 25.0 * sigma);
            let (mut along, mut length) = (Complex64::ZERO, 0.0);
            for ((omega, weight), residual) in lines.omega[from..to].iter().zip(&task.weight[from..to]).zip(&residual[from..to]) {
                let column = (Complex64::new(0.0, *omega) - pole).inv() * *weight;
                along += column.conj() * residual;
                length += column.norm_sqr();
            }
            let gain = along.norm_sqr() / length;
            if gain.is_finite() && best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, pole));
            }
        }
    }
    best.map(|(_, pole)| pole)
}

/// Removes, one after the other, the modes that do not pay and those narrower than the lines can show.
pub(super) fn prune(model: &mut ModalModel, task: &Task) {
    model.terms.retain(|t| -2.0 * t.pole.re > NARROW * task.lines.spacing(t.pole.im));
    if solve_linear(model, task.lines, task.weight).is_none() {
        return;
    }
    while let Some((chi2, gains)) = gains(model, task) {
        let Some((at, least)) = gains.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        if least > task.price(chi2, model.unknowns()) {
            return;
        }
        model.terms.remove(at);
        if solve_linear(model, task.lines, task.weight).is_none() {
            return;
        }
    }
}

/// χ², and how much it would grow without each mode, all other residues solved again.
pub(super) fn gains(model: &ModalModel, task: &Task) -> Option<(f64, Vec<f64>)> {
    let normal = ModalNormalEquations::of(model, task.lines, task.weight).part(&linear_unknowns(model));
    let (_, inverse) = normal.solve(1e-13, true)?;
    let gain = |(at, term): (usize, &Term)| {
        let block = inverse.fixed_view::<2, 2>(2 * at, 2 * at).into_owned();
        let residue = nalgebra::Vector2::new(term.residue.re, term.residue.im);
        block.try_inverse().map_or(0.0, |b| residue.dot(&(b * residue)))
    };
    Some((normal.chi2, model.terms.iter().enumerate().map(gain).collect()))
}
