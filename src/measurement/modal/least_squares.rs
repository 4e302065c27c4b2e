//! Weighted normal equations of the modal model, and their solution by Levenberg–Marquardt steps.
//!
//! Rows are the real and imaginary part of (H − Ĥ)/w⁻¹ per line; the Jacobian is never stored as a whole. Unknowns are scaled to
//! columns of length 1.
//!
//! # Source  Moré, Lecture Notes in Mathematics 630 (1978), 105–116, on the scaling.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::curve::CurveLines;
use super::model::{ModalModel, PER_MODE};

/// Lines worked on at a time.
const BLOCK: usize = 128;

/// JᵀJ, Jᵀr and rᵀr of r = w (H − Ĥ).
pub(super) struct ModalNormalEquations {
    pub gram: DMatrix<f64>,
    pub right: DVector<f64>,
    pub chi2: f64,
}

impl ModalNormalEquations {
    /// At a model; `weight` is 1 over the standard deviation per component of H.
    pub fn of(model: &ModalModel, lines: &CurveLines, weight: &[f64]) -> Self {
        let n = model.unknowns();
        let mut sums = Self { gram: DMatrix::zeros(n, n), right: DVector::zeros(n), chi2: 0.0 };
        let mut columns = vec![Complex64::ZERO; n];
        let mut turned = DMatrix::zeros(n, 2 * BLOCK);
        let mut residual = DVector::zeros(2 * BLOCK);
        for from in (0..lines.len()).step_by(BLOCK) {
            let to = (from + BLOCK).min(lines.len());
            if to - from < BLOCK {
                turned.fill(0.0);
                residual.fill(0.0);
            }
            for (at, weight) in weight[from..to].iter().enumerate() {
                let (line, row) = (from + at, 2 * at);
                let difference = (lines.h[line] - model.derivatives(lines.omega[line], &mut columns)) * *weight;
                residual[row] = difference.re;
                residual[row + 1] = difference.im;
                sums.chi2 += difference.norm_sqr();
                for (at, c) in columns.iter().enumerate() {
                    turned[(at, row)] = c.re * weight;
                    turned[(at, row + 1)] = c.im * weight;
                }
            }
            sums.gram.gemm(1.0, &turned, &turned.transpose(), 1.0);
            sums.right.gemv(1.0, &turned, &residual, 1.0);
        }
        sums
    }

    /// The same with some of the unknowns only.
    pub fn part(&self, of: &[usize]) -> Self {
        let gram = DMatrix::from_fn(of.len(), of.len(), |i, j| self.gram[(of[i], of[j])]);
        Self { gram, right: DVector::from_fn(of.len(), |i, _| self.right[of[i]]), chi2: self.chi2 }
    }

    /// Step with damping λ, and Gram⁻¹ where asked; `None` where the matrix is not positive definite.
    pub fn solve(&self, lambda: f64, inverse: bool) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let n = self.right.len();
        let scale = DVector::from_fn(n, |i, _| if self.gram[(i, i)] > 0.0 { 1.0 / self.gram[(i, i)].sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(n, n, |i, j| {
            let diagonal = if i != j {
                0.0
            } else if scale[i] > 0.0 {
                lambda
            } else {
                1.0
            };
            self.gram[(i, j)] * scale[i] * scale[j] + diagonal
        });
        let cholesky = scaled.cholesky()?;
        let mut step = cholesky.solve(&self.right.component_mul(&scale));
        step.component_mul_assign(&scale);
        let inverse = if inverse {
            let inner = cholesky.inverse();
            DMatrix::from_fn(n, n, |i, j| inner[(i, j)] * scale[i] * scale[j])
        } else {
            DMatrix::zeros(0, 0)
        };
        step.iter().all(|s| s.is_finite()).then_some((step, inverse))
    }
}

/// Indices of the linear unknowns (residues, background).
pub(super) fn linear_unknowns(model: &ModalModel) -> Vec<usize> {
    let modes = PER_MODE * model.terms.len();
    (0..model.unknowns()).filter(|i| *i >= modes || i % PER_MODE < 2).collect()
}

/// Best residues and background at the model's poles; the χ² reached. `None` where singular.
pub(super) fn solve_linear(model: &mut ModalModel, lines: &CurveLines, weight: &[f64]) -> Option<f64> {
    let of = linear_unknowns(model);
    let mut chi2 = f64::INFINITY;
    // The second pass removes the rounding of the first.
    for _ in 0..2 {
        let part = ModalNormalEquations::of(model, lines, weight).part(&of);
        let (step, _) = part.solve(1e-13, false)?;
        let mut all = vec![0.0; model.unknowns()];
        for (at, s) in of.iter().zip(step.iter()) {
            all[*at] = *s;
        }
        chi2 = part.chi2 - step.dot(&part.right);
        *model = model.stepped(&all);
    }
    Some(chi2)
}

/// Refines all unknowns; the χ² reached.
///
/// Ends when a step gains less than `gain` of χ² twice in a row, or after `most` trials.
pub(super) fn refine(model: &mut ModalModel, lines: &CurveLines, weight: &[f64], gain: f64, most: usize) -> f64 {
    let mut here = ModalNormalEquations::of(model, lines, weight);
    let mut lambda = 1e-4;
    let mut slow = 0;
    for _ in 0..most {
        let Some((step, _)) = here.solve(lambda, false) else {
            lambda = (lambda * 10.0).max(1e-10);
            continue;
        };
        let next = model.stepped(step.as_slice());
        let there = ModalNormalEquations::of(&next, lines, weight);
        if there.chi2 < here.chi2 {
            slow = if here.chi2 - there.chi2 < gain * here.chi2 { slow + 1 } else { 0 };
            *model = next;
            here = there;
            lambda = (lambda * 0.1).max(1e-13);
        } else {
            lambda *= 8.0;
            slow += usize::from(lambda > 1e4);
        }
        if slow >= 2 || lambda > 1e8 || here.chi2 == 0.0 {
            break;
        }
    }
    here.chi2
}
