//! Exact solutions of ẏ = A·y + f over a step, with f constant, linear and quadratic in time.

/// A square matrix stored by rows.
pub type Square = Vec<f64>;

/// The transition of a state over a step τ: y(τ) = Φ·y + P₁·f₀ + P₂·f₁ + P₃·f₂ for f(t) = f₀ + f₁·t +
/// f₂·t²/2.
///
/// ```text
/// Φ = e^{Aτ},     P_k = ∫₀^τ e^{A(τ−s)}·s^{k−1}/(k−1)! ds = τ^k·φ_k(Aτ)
/// ```
///
/// # Source  Hochbruck and Ostermann, Acta Numerica 19 (2010) 209–286, Eq. 2.10–2.12.
#[derive(Debug, Clone)]
pub struct StateTransition {
    /// Φ.
    pub phi: Square,
    /// P₁, P₂, P₃.
    pub forced: [Square; 3],
}

/// Largest ‖Aτ‖ at which the series is summed.
const SUMMED: f64 = 0.5;
/// Number of terms of the series: 0.5¹⁷/17! is 2e-20.
const TERMS: usize = 17;

/// Computes a·b.
fn product(a: &[f64], b: &[f64], n: usize) -> Square {
    let mut c = vec![0.0; n * n];
    for i in 0..n {
        for k in 0..n {
            let x = a[i * n + k];
            if x != 0.0 {
                for j in 0..n {
                    c[i * n + j] += x * b[k * n + j];
                }
            }
        }
    }
    c
}

/// Computes y += a·x.
pub fn add_product(a: &[f64], x: &[f64], y: &mut [f64]) {
    let n = x.len();
    for (row, y) in a.chunks_exact(n).zip(y.iter_mut()) {
        *y += row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    }
}

/// Computes y += a·x for a stored by columns: zeros of x are skipped, and the columns vectorise.
pub fn add_columns(a: &[f64], x: &[f64], y: &mut [f64]) {
    for (column, x) in a.chunks_exact(x.len()).zip(x).filter(|(_, x)| **x != 0.0) {
        y.iter_mut().zip(column).for_each(|(y, a)| *y += a * x);
    }
}

/// Stores a square matrix by columns.
pub fn columns(a: &[f64], n: usize) -> Square {
    (0..n * n).map(|at| a[at % n * n + at / n]).collect()
}

impl StateTransition {
    /// Computes the transition over τ for A of n rows: the series at τ/2^m, doubled m times.
    ///
    /// ```text
    /// P_k(2τ) = Φ·P_k(τ) + Σ_{j ≤ k} P_j(τ)·τ^{k−j}/(k−j)!
    /// ```
    pub fn new(a: &[f64], n: usize, tau_s: f64) -> Self {
        let norm =
            a.chunks_exact(n.max(1)).map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max)
                * tau_s;
        let doublings = if norm > SUMMED { (norm / SUMMED).log2().ceil() as i32 } else { 0 };
        let mut tau = tau_s * 0.5_f64.powi(doublings);
        let mut transition = StateTransition::summed(a, n, tau);
        for _ in 0..doublings {
            transition = transition.doubled(n, tau);
            tau *= 2.0;
        }
        transition
    }

    fn summed(a: &[f64], n: usize, tau: f64) -> Self {
        let mut identity = vec![0.0; n * n];
        (0..n).for_each(|i| identity[i * n + i] = 1.0);
        // Term j is (Aτ)^j/j!; its contribution to P_k has the factor τ^k·j!/(j+k)!.
        let mut term = identity.clone();
        let (mut phi, mut forced) = (identity, [vec![0.0; n * n], vec![0.0; n * n], vec![0.0; n * n]]);
        for j in 0..TERMS {
            if j > 0 {
                term = product(&term, a, n);
                term.iter_mut().for_each(|x| *x *= tau / j as f64);
                phi.iter_mut().zip(&term).for_each(|(p, t)| *p += t);
            }
            let mut factor = 1.0;
            for (k, p) in forced.iter_mut().enumerate() {
                factor *= tau / (j + k + 1) as f64;
                p.iter_mut().zip(&term).for_each(|(p, t)| *p += factor * t);
            }
        }
        StateTransition { phi, forced }
    }

    fn doubled(&self, n: usize, tau: f64) -> Self {
        let forced = std::array::from_fn(|k| {
            let mut p = product(&self.phi, &self.forced[k], n);
            let mut factor = 1.0;
            for (back, j) in (0..=k).rev().enumerate() {
                if back > 0 {
                    factor *= tau / back as f64;
                }
                p.iter_mut().zip(&self.forced[j]).for_each(|(p, x)| *p += factor * x);
            }
            p
        });
        StateTransition { phi: product(&self.phi, &self.phi, n), forced }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ẏ = −a·y + t²/2 for small and large a·τ.
    #[test]
    fn limit_one_state_under_a_parabola() {
        for a in [1e-6, 0.3, 40.0, 1e4] {
            let tau: f64 = 0.7;
            let transition = StateTransition::new(&[-a], 1, tau);
            let decay = (-a * tau).exp();
            let exact = if a < 1e-3 {
                // The first two terms of the series in a·τ.
                let term =
                    |n: i32, factorial: f64| tau.powi(n) / factorial * (1.0 - a * tau / f64::from(n + 1));
                [decay, term(1, 1.0), term(2, 2.0), term(3, 6.0)]
            } else {
                let p1 = (1.0 - decay) / a;
                let p2 = (tau - p1) / a;
                [decay, p1, p2, (tau * tau / 2.0 - p2) / a]
            };
            for (ours, exact) in
                [transition.phi[0], transition.forced[0][0], transition.forced[1][0], transition.forced[2][0]]
                    .iter()
                    .zip(exact)
            {
                assert!((ours - exact).abs() < 1e-12 * (1.0 + exact.abs()), "{a}: {ours} {exact}");
            }
        }
    }

    /// An oscillator over many periods: a rotation in phase space.
    #[test]
    fn limit_an_oscillator_rotates_in_phase_space() {
        let omega: f64 = 300.0;
        let tau: f64 = 0.1;
        let transition = StateTransition::new(&[0.0, 1.0, -omega * omega, 0.0], 2, tau);
        let (sin, cos) = (omega * tau).sin_cos();
        for (ours, exact) in transition.phi.iter().zip([cos, sin / omega, -omega * sin, cos]) {
            assert!((ours - exact).abs() < 1e-10 * omega, "{ours} {exact}");
        }
    }
}
