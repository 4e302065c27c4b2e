//! Weighted normal equations of the modal model, and their solution by Levenberg–Marquardt steps.
//!
//! Rows are the real and imaginary part of w (H − Ĥ) per line; the Jacobian is never stored as a whole.
//! Unknowns are scaled to unit column norm.
//!
//! # Source  Moré, Lecture Notes in Mathematics 630 (1978), 105–116, on the scaling.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::curve::CurveLines;
use super::model::{ModalModel, PER_MODE};

/// Number of lines processed at a time.
const BLOCK: usize = 128;

/// JᵀJ, Jᵀr and rᵀr of r = w (H − Ĥ).
pub(super) struct ModalNormalEquations {
    pub gram: DMatrix<f64>,
    pub right: DVector<f64>,
    pub chi2: f64,
}

impl ModalNormalEquations {
    /// Computes the sums at a model; `weight` is 1 over the standard deviation per component of H.
    pub fn of(model: &ModalModel, lines: &CurveLines, weight: &[f64]) -> Self {
        let n = model.unknowns();
        let mut sums = Self { gram: DMatrix::zeros(n, n), right: DVector::zeros(n), chi2: 0.0 };
        let mut columns = vec![Complex64::ZERO; n];
        let mut transposed = DMatrix::zeros(n, 2 * BLOCK);
        let mut residual = DVector::zeros(2 * BLOCK);
        for from in (0..lines.len()).step_by(BLOCK) {
            let to = (from + BLOCK).min(lines.len());
            if to - from < BLOCK {
                transposed.fill(0.0);
                residual.fill(0.0);
            }
            for (at, weight) in weight[from..to].iter().enumerate() {
                let (line, row) = (from + at, 2 * at);
                let difference =
                    (lines.h[line] - model.derivatives(lines.omega[line], &mut columns)) * *weight;
                residual[row] = difference.re;
                residual[row + 1] = difference.im;
                sums.chi2 += difference.norm_sqr();
                for (at, c) in columns.iter().enumerate() {
                    transposed[(at, row)] = c.re * weight;
                    transposed[(at, row + 1)] = c.im * weight;
                }
            }
            sums.gram.gemm(1.0, &transposed, &transposed.transpose(), 1.0);
            sums.right.gemv(1.0, &transposed, &residual, 1.0);
        }
        sums
    }

    /// Returns the equations restricted to some unknowns.
    pub fn restricted_to(&self, unknowns: &[usize]) -> Self {
        let n = unknowns.len();
        let gram = DMatrix::from_fn(n, n, |i, j| self.gram[(unknowns[i], unknowns[j])]);
        Self { gram, right: DVector::from_fn(n, |i, _| self.right[unknowns[i]]), chi2: self.chi2 }
    }

    /// Returns the step with damping λ, and Gram⁻¹ if requested; `None` where the matrix is not positive
    /// definite.
    pub fn solve(&self, lambda: f64, inverse: bool) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let n = self.right.len();
        let scale =
            DVector::from_fn(
                n,
                |i, _| if self.gram[(i, i)] > 0.0 { 1.0 / self.gram[(i, i)].sqrt() } else { 0.0 },
            );
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

/// Returns the indices of the linear unknowns (residues, background).
pub(super) fn linear_unknowns(model: &ModalModel) -> Vec<usize> {
    let modes = PER_MODE * model.terms.len();
    (0..model.unknowns()).filter(|i| *i >= modes || i % PER_MODE < 2).collect()
}

/// Computes the best residues and background at the model's poles and returns χ²; `None` where singular.
pub(super) fn solve_linear(model: &mut ModalModel, lines: &CurveLines, weight: &[f64]) -> Option<f64> {
    let unknowns = linear_unknowns(model);
    let mut chi2 = f64::INFINITY;
    // The second pass removes the rounding error of the first.
    for _ in 0..2 {
        let equations = ModalNormalEquations::of(model, lines, weight).restricted_to(&unknowns);
        let (step, _) = equations.solve(1e-13, false)?;
        let mut all = vec![0.0; model.unknowns()];
        for (at, s) in unknowns.iter().zip(step.iter()) {
            all[*at] = *s;
        }
        chi2 = equations.chi2 - step.dot(&equations.right);
        *model = model.stepped(&all);
    }
    Some(chi2)
}

/// Refines all unknowns and returns χ².
///
/// Stops when a step reduces χ² by less than the share `tolerance` twice in a row, or after `trials` trials.
pub(super) fn refine(
    model: &mut ModalModel,
    lines: &CurveLines,
    weight: &[f64],
    tolerance: f64,
    trials: usize,
) -> f64 {
    let mut current = ModalNormalEquations::of(model, lines, weight);
    let mut lambda = 1e-4;
    let mut slow = 0;
    for _ in 0..trials {
        let Some((step, _)) = current.solve(lambda, false) else {
            lambda = (lambda * 10.0).max(1e-10);
            continue;
        };
        let next = model.stepped(step.as_slice());
        let trial = ModalNormalEquations::of(&next, lines, weight);
        if trial.chi2 < current.chi2 {
            slow = if current.chi2 - trial.chi2 < tolerance * current.chi2 { slow + 1 } else { 0 };
            *model = next;
            current = trial;
            lambda = (lambda * 0.1).max(1e-13);
        } else {
            lambda *= 8.0;
            slow += usize::from(lambda > 1e4);
        }
        if slow >= 2 || lambda > 1e8 || current.chi2 == 0.0 {
            break;
        }
    }
    current.chi2
}
