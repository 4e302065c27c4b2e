//! Tian et al., Eq. 1–24, written out for the bench, equation by equation, with the corrections of the
//! paper's misprints: cot for cos in Eq. 1–2, h_J = 1/(k + iωc) in Eq. 6 and 8, v = (1, −1, −i_b) in Eq.
//! 19–20.

use nalgebra::{Matrix2, Matrix3, Vector3};
use num_complex::Complex64;

type C = Complex64;

/// Joint values.
#[derive(Clone, Copy)]
pub struct Joints {
    pub k_al: f64,
    pub k_ar: f64,
    pub k_n: f64,
    pub k_m: f64,
    pub c_al: f64,
    pub c_ar: f64,
    pub c_n: f64,
    pub c_m: f64,
}

/// Published joint values (Tab. 3).
pub const TAB_3: Joints = Joints {
    k_al: 4.28e7,
    k_ar: 2.94e7,
    k_n: 7.09e8,
    k_m: 5.53e3,
    c_al: 2.02e3,
    c_ar: 2.73e3,
    c_n: 2.25e5,
    c_m: 3.50,
};

// Tab. A, in SI units, with the paper's symbols.
pub const E: f64 = 2e11;
pub const G: f64 = 7.75e10;
pub const RHO: f64 = 7850.0;
pub const D: f64 = 0.040;
pub const LEAD: f64 = 0.040;
pub const L: f64 = 2.6;
pub const M_S: f64 = 0.25;
pub const J_S: f64 = 1e-4;
pub const J_H: f64 = 1e-4;
pub const M_B: f64 = 272.0;
pub const J_M: f64 = 1e-3;

fn real(x: f64) -> C {
    C::new(x, 0.0)
}

/// H_A or H_B (Eq. 1–2, 10–11).
fn rod(a: f64, lambda: f64, length: f64) -> Matrix2<C> {
    let phi = lambda * length;
    let direct = real(-1.0 / (a * lambda * phi.tan()));
    let cross = real(-1.0 / (a * lambda * phi.sin()));
    Matrix2::new(direct, cross, cross, direct)
}

/// H_AB over points 1, 2, 4 (Eq. 4, 13).
fn join(a: Matrix2<C>, b: Matrix2<C>) -> Matrix3<C> {
    let zero = real(0.0);
    let free = Matrix3::new(a[(0, 0)], a[(0, 1)], zero, a[(1, 0)], a[(1, 1)], zero, zero, zero, b[(1, 1)]);
    let column = Vector3::new(-a[(0, 1)], -a[(1, 1)], b[(1, 0)]);
    let row = Vector3::new(a[(1, 0)], a[(1, 1)], -b[(0, 1)]);
    free + column * row.transpose() / (a[(1, 1)] + b[(0, 0)])
}

/// Couples at point p: H − column(p)·(h_pp + rest)⁻¹·row(p) (Eq. 7, 9, 17, 23, 24).
fn couple(h: Matrix3<C>, p: usize, rest: C) -> Matrix3<C> {
    let column = h.column(p).into_owned();
    let row = h.row(p).into_owned();
    h - column * row / (h[(p, p)] + rest)
}

/// H_all over (6a, 5a, 5t) = (table, screw at the nut, its angle) at ω for a nut at l, rotor free (Eq. 24).
pub fn h_all(joints: &Joints, l: f64, omega: f64) -> Matrix3<C> {
    let iw = C::new(0.0, omega);
    let area = std::f64::consts::PI * D * D / 4.0;
    let polar = std::f64::consts::PI * D.powi(4) / 32.0; // Eq. 12
    // Axial substructure.
    let lambda = omega * (RHO / E).sqrt(); // Eq. 3
    let h_ab = join(rod(E * area, lambda, l), rod(E * area, lambda, L - l));
    let h_ac = couple(h_ab, 0, (joints.k_al + iw * joints.c_al).inv()); // Eq. 5–7
    let h_ad = couple(h_ac, 2, (joints.k_ar + iw * joints.c_ar).inv()); // Eq. 8–9
    // Torsional substructure.
    let lambda = omega * (RHO / G).sqrt();
    let h_abt = join(rod(G * polar, lambda, l), rod(G * polar, lambda, L - l));
    let k = joints.k_m + iw * joints.c_m;
    let d_h = Matrix2::new(k - omega * omega * J_M, -k, -k, k - omega * omega * J_H); // Eq. 14–16
    let h_h = d_h.try_inverse().unwrap()[(1, 1)];
    let h_ah = couple(h_abt, 0, h_h); // Eq. 17
    // Worktable substructure (Eq. 18–22).
    let i_b = LEAD / std::f64::consts::TAU; // Eq. 21
    let v = Vector3::new(real(1.0), real(-1.0), real(-i_b));
    let w2 = omega * omega;
    // H_W = (K_W + iωC_W − ω²M_W)⁻¹ by the Sherman–Morrison formula: direct inversion loses ten digits at 1
    // Hz.
    let free = Matrix3::from_diagonal(&Vector3::new(
        real(-1.0 / (M_B * w2)),
        real(-1.0 / (M_S * w2)),
        real(-1.0 / (J_S * w2)),
    ));
    let u = free * v;
    let h_w = free - u * u.transpose() / ((joints.k_n + iw * joints.c_n).inv() + v.dot(&u));
    let h_aw = couple(h_w, 1, h_ad[(1, 1)]); // Eq. 23
    couple(h_aw, 2, h_ah[(1, 1)]) // Eq. 24
}
