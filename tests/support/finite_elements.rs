//! The bench as linear finite elements with consistent mass: a model independent of the one under test.
//!
//! It has an axial chain, a torsional chain, table and rotor. Complex tridiagonal solves eliminate the two
//! chains.

use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;

use super::bench_equations::{D, E, G, Joints, L, LEAD, RHO};

type C = Complex64;

/// A mesh of the bench for one nut position; `hold` is the stiffness and damping of the rotor to ground.
pub struct Bench {
    elements: usize,
    nut: f64,
    joints: Joints,
    hold: (f64, f64),
}

/// A peak of the mobility |ω·H|.
#[derive(Debug, Clone, Copy)]
pub struct Peak {
    pub frequency_hz: f64,
    pub amplitude: f64,
}

impl Bench {
    /// Meshes each rod, left and right of the nut, with `elements` elements.
    pub fn new(elements: usize, nut: f64, joints: Joints, hold: (f64, f64)) -> Self {
        Bench { elements, nut, joints, hold }
    }

    /// Returns stiffness and mass of one chain as tridiagonals: (diagonal, off-diagonal) of each;
    /// 2·elements + 1 nodes.
    fn chain(&self, a: f64, inertia_per_m: f64) -> [Vec<f64>; 4] {
        let n = self.elements;
        let nodes = 2 * n + 1;
        let (mut kd, mut ko, mut md, mut mo) =
            (vec![0.0; nodes], vec![0.0; nodes - 1], vec![0.0; nodes], vec![0.0; nodes - 1]);
        for e in 0..2 * n {
            let h = if e < n { self.nut } else { L - self.nut } / n as f64;
            let (k, m) = (a / h, inertia_per_m * h / 6.0);
            kd[e] += k;
            kd[e + 1] += k;
            ko[e] -= k;
            md[e] += 2.0 * m;
            md[e + 1] += 2.0 * m;
            mo[e] += m;
        }
        [kd, ko, md, mo]
    }

    fn axial(&self) -> [Vec<f64>; 4] {
        let area = std::f64::consts::PI * D * D / 4.0;
        self.chain(E * area, RHO * area)
    }

    fn torsional(&self) -> [Vec<f64>; 4] {
        let polar = std::f64::consts::PI * D.powi(4) / 32.0;
        self.chain(G * polar, RHO * polar)
    }

    /// Returns the receptance table/table (m/N).
    pub fn receptance(&self, omega: f64) -> C {
        let iw = C::new(0.0, omega);
        let w2 = omega * omega;
        let j = &self.joints;
        let n = self.elements;
        let [kd, ko, md, mo] = self.axial();
        let mut diagonal: Vec<C> = kd.iter().zip(&md).map(|(k, m)| C::from(k - w2 * m)).collect();
        let off: Vec<C> = ko.iter().zip(&mo).map(|(k, m)| C::from(k - w2 * m)).collect();
        let last = diagonal.len() - 1;
        diagonal[0] += j.k_al + iw * j.c_al;
        diagonal[last] += j.k_ar + iw * j.c_ar;
        diagonal[n] -= w2 * 0.25;
        let axial = at_middle(&diagonal, &off, n);
        let [kd, ko, md, mo] = self.torsional();
        let mut diagonal: Vec<C> = kd.iter().zip(&md).map(|(k, m)| C::from(k - w2 * m)).collect();
        let off: Vec<C> = ko.iter().zip(&mo).map(|(k, m)| C::from(k - w2 * m)).collect();
        let coupling = j.k_m + iw * j.c_m;
        let hold = self.hold.0 + iw * self.hold.1;
        let rotor = coupling + hold - w2 * 1e-3;
        diagonal[0] += coupling - w2 * 1e-4 - coupling * coupling / rotor;
        diagonal[n] -= w2 * 1e-4;
        let torsional = at_middle(&diagonal, &off, n);
        // The nut joint acts on x_b − x_s − i_b·θ_s: its compliance in series with those of the screw at the
        // nut.
        let i_b = LEAD / std::f64::consts::TAU;
        let series = (j.k_n + iw * j.c_n).inv() + axial + torsional * (i_b * i_b);
        (series.inv() - w2 * 272.0).inv()
    }

    /// Returns the undamped natural frequencies (Hz), by a dense symmetric eigenproblem.
    pub fn undamped_hz(&self) -> Vec<f64> {
        let n = self.elements;
        let nodes = 2 * n + 1;
        let size = 2 * nodes + 2; // axial, torsional, rotor, table
        let (mut k, mut m) = (DMatrix::<f64>::zeros(size, size), DMatrix::<f64>::zeros(size, size));
        for (offset, [kd, ko, md, mo]) in [(0, self.axial()), (nodes, self.torsional())] {
            for i in 0..nodes {
                k[(offset + i, offset + i)] += kd[i];
                m[(offset + i, offset + i)] += md[i];
                if i + 1 < nodes {
                    for (a, b) in [(i, i + 1), (i + 1, i)] {
                        k[(offset + a, offset + b)] += ko[i];
                        m[(offset + a, offset + b)] += mo[i];
                    }
                }
            }
        }
        let j = &self.joints;
        let (rotor, table) = (2 * nodes, 2 * nodes + 1);
        k[(0, 0)] += j.k_al;
        k[(nodes - 1, nodes - 1)] += j.k_ar;
        m[(n, n)] += 0.25;
        m[(nodes + n, nodes + n)] += 1e-4;
        m[(nodes, nodes)] += 1e-4;
        m[(rotor, rotor)] += 1e-3;
        m[(table, table)] += 272.0;
        k[(rotor, rotor)] += self.hold.0 + j.k_m;
        k[(nodes, nodes)] += j.k_m;
        k[(rotor, nodes)] -= j.k_m;
        k[(nodes, rotor)] -= j.k_m;
        let on = [(table, 1.0), (n, -1.0), (nodes + n, -LEAD / std::f64::consts::TAU)];
        for (a, x) in on {
            for (b, y) in on {
                k[(a, b)] += j.k_n * x * y;
            }
        }
        let lower = m.cholesky().unwrap().l();
        let inverse = lower.try_inverse().unwrap();
        let reduced = &inverse * k * inverse.transpose();
        let mut hz: Vec<f64> = SymmetricEigen::new(reduced)
            .eigenvalues
            .iter()
            .map(|l| l.max(0.0).sqrt() / std::f64::consts::TAU)
            .collect();
        hz.sort_by(f64::total_cmp);
        hz
    }

    /// Returns the peaks of the mobility in a band, found by a fine scan and golden-section search.
    pub fn peaks(&self, from_hz: f64, to_hz: f64) -> Vec<Peak> {
        let size = |f: f64| {
            let omega = std::f64::consts::TAU * f;
            self.receptance(omega).norm() * omega
        };
        let step = 0.5;
        let count = ((to_hz - from_hz) / step) as usize;
        let scan: Vec<f64> = (0..=count).map(|i| size(from_hz + step * i as f64)).collect();
        let mut found = Vec::new();
        for i in 1..count {
            if scan[i] > scan[i - 1] && scan[i] >= scan[i + 1] {
                let (mut a, mut b) = (from_hz + step * (i as f64 - 1.0), from_hz + step * (i as f64 + 1.0));
                let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
                let (mut x, mut y) = (b - ratio * (b - a), a + ratio * (b - a));
                let (mut fx, mut fy) = (size(x), size(y));
                while b - a > 1e-6 {
                    if fx > fy {
                        b = y;
                        (y, fy) = (x, fx);
                        x = b - ratio * (b - a);
                        fx = size(x);
                    } else {
                        a = x;
                        (x, fx) = (y, fy);
                        y = a + ratio * (b - a);
                        fy = size(y);
                    }
                }
                let f = 0.5 * (a + b);
                found.push(Peak { frequency_hz: f, amplitude: size(f) });
            }
        }
        found
    }
}

/// Returns the entry (n, n) of the inverse of a symmetric tridiagonal matrix, by elimination from both ends.
fn at_middle(diagonal: &[C], off: &[C], n: usize) -> C {
    let mut left = diagonal[0];
    for i in 1..n {
        left = diagonal[i] - off[i - 1] * off[i - 1] / left;
    }
    let last = diagonal.len() - 1;
    let mut right = diagonal[last];
    for i in (n + 1..last).rev() {
        right = diagonal[i] - off[i] * off[i] / right;
    }
    (diagonal[n] - off[n - 1] * off[n - 1] / left - off[n] * off[n] / right).inv()
}
