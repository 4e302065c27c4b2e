//! The modal model and its derivatives.
//!
//! ```text
//!          n  ⎛   r_k         r̄_k   ⎞
//!   H(ω) = Σ  ⎜ ───────  +  ─────── ⎟ + b(ω),     p_k = −σ_k + i ω_k,   σ_k = ζ_k |p_k|
//!         k=1 ⎝ iω − p_k    iω − p̄_k ⎠
//!   b = L (ω₀/ω)² + U   whole curve: rigid body below, modes above
//!   b = U + V x         local fit, x from −1 to 1 over the band
//! ```
//!
//! Residues and background are complex, so that a delay or phase error of the measuring chain does not bias
//! the poles. The nonlinear unknowns are ln σ and ln ω_k, which keep both positive.

use num_complex::Complex64;

use super::curve::CurveLines;

/// Number of real unknowns of a mode: Re r, Im r, ln σ, ln ω.
pub(super) const PER_MODE: usize = 4;
/// Number of real unknowns of the background.
pub(super) const BACKGROUND: usize = 4;

/// A pole with its residue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Term {
    /// Pole (rad/s), Re < 0 < Im.
    pub pole: Complex64,
    /// Residue (unit of H times rad/s).
    pub residue: Complex64,
}

impl Term {
    /// Returns the contribution of the mode to H.
    pub fn at(&self, omega: f64) -> Complex64 {
        let iw = Complex64::new(0.0, omega);
        self.residue / (iw - self.pole) + self.residue.conj() / (iw - self.pole.conj())
    }
}

/// Background: two complex coefficients and their basis functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Background {
    /// Coefficients of the two basis functions.
    pub coefficients: [Complex64; 2],
    /// Ends of the band (rad/s).
    pub band: (f64, f64),
    /// Whether the basis is constant and linear instead of 1/ω² and constant.
    pub local: bool,
}

impl Background {
    /// Returns the two basis functions.
    fn basis(&self, omega: f64) -> [f64; 2] {
        let (low, high) = self.band;
        if self.local {
            [1.0, (2.0 * omega - low - high) / (high - low)]
        } else {
            [low * low / (omega * omega), 1.0]
        }
    }
}

/// Modes and background.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ModalModel {
    /// Modes.
    pub terms: Vec<Term>,
    /// Background.
    pub background: Background,
}

impl ModalModel {
    /// Creates a model with residue 0 at the poles.
    pub fn of(lines: &CurveLines, poles: &[Complex64]) -> Self {
        let terms = poles.iter().map(|pole| Term { pole: *pole, residue: Complex64::ZERO }).collect();
        Self {
            terms,
            background: Background {
                coefficients: [Complex64::ZERO; 2],
                band: lines.band(),
                local: lines.local,
            },
        }
    }

    /// Returns the number of real unknowns.
    pub fn unknowns(&self) -> usize {
        PER_MODE * self.terms.len() + BACKGROUND
    }

    /// Returns H.
    pub fn at(&self, omega: f64) -> Complex64 {
        let basis = self.background.basis(omega);
        let [first, second] = self.background.coefficients;
        self.terms.iter().map(|t| t.at(omega)).sum::<Complex64>() + first * basis[0] + second * basis[1]
    }

    /// Returns H; writes its derivatives with respect to all unknowns to `columns` (modes first, in order).
    pub fn derivatives(&self, omega: f64, columns: &mut [Complex64]) -> Complex64 {
        let iw = Complex64::new(0.0, omega);
        let mut value = Complex64::ZERO;
        for (term, column) in self.terms.iter().zip(columns.chunks_exact_mut(PER_MODE)) {
            let (u, v) = ((iw - term.pole).inv(), (iw - term.pole.conj()).inv());
            let (a, b) = (term.residue * u, term.residue.conj() * v);
            value += a + b;
            let (slope_p, slope_q) = (a * u, b * v);
            column[0] = u + v;
            column[1] = times_i(u - v);
            column[2] = (slope_p + slope_q) * term.pole.re;
            column[3] = times_i(slope_p - slope_q) * term.pole.im;
        }
        let basis = self.background.basis(omega);
        for (at, b) in basis.iter().enumerate() {
            let column = &mut columns[PER_MODE * self.terms.len() + 2 * at..];
            column[0] = Complex64::new(*b, 0.0);
            column[1] = Complex64::new(0.0, *b);
            value += self.background.coefficients[at] * b;
        }
        value
    }

    /// Returns the model after a step in all unknowns; logarithms change by at most 0.3.
    pub fn stepped(&self, step: &[f64]) -> Self {
        let mut next = self.clone();
        let bounded = |x: f64| x.clamp(-0.3, 0.3).exp();
        for (term, step) in next.terms.iter_mut().zip(step.chunks_exact(PER_MODE)) {
            term.residue += Complex64::new(step[0], step[1]);
            term.pole = Complex64::new(term.pole.re * bounded(step[2]), term.pole.im * bounded(step[3]));
        }
        for (at, coefficient) in next.background.coefficients.iter_mut().enumerate() {
            let step = &step[PER_MODE * self.terms.len() + 2 * at..];
            *coefficient += Complex64::new(step[0], step[1]);
        }
        next
    }
}

fn times_i(z: Complex64) -> Complex64 {
    Complex64::new(-z.im, z.re)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_derivatives_match_differences() {
        let lines =
            CurveLines { omega: vec![10.0, 90.0], h: vec![Complex64::ONE; 2], sd: None, local: false };
        let mut model = ModalModel::of(&lines, &[Complex64::new(-1.0, 40.0), Complex64::new(-9.0, 60.0)]);
        model.terms[0].residue = Complex64::new(0.3, -2.0);
        model.terms[1].residue = Complex64::new(-0.5, 1.0);
        let mut columns = vec![Complex64::ZERO; model.unknowns()];
        for omega in [15.0, 41.0, 70.0] {
            model.derivatives(omega, &mut columns);
            for at in 0..model.unknowns() {
                let mut step = vec![0.0; model.unknowns()];
                step[at] = 1e-6;
                let up = model.stepped(&step).at(omega);
                step[at] = -1e-6;
                let slope = (up - model.stepped(&step).at(omega)) / 2e-6;
                assert!(
                    (slope - columns[at]).norm() < 1e-7 * (1.0 + slope.norm()),
                    "{at} at {omega}: {slope} {}",
                    columns[at]
                );
            }
        }
    }
}
