//! The contact of nut and screw: two flanks, each of which only pushes.

use super::nominal::Nominal;

/// Half the distance over which a flank comes into contact, m.
const EDGE_M: f64 = 0.2e-6;

/// Depth at which a flank has half of its damping, m.
const DEPTH_M: f64 = 0.1e-6;

/// Returns the depth of a flank, smooth from 0 to u: (u + ε)²/4ε within ±ε; and its integral.
fn depth(u_m: f64) -> (f64, f64) {
    if u_m <= -EDGE_M {
        (0.0, 0.0)
    } else if u_m < EDGE_M {
        let inside = u_m + EDGE_M;
        (inside * inside / (4.0 * EDGE_M), inside.powi(3) / (12.0 * EDGE_M))
    } else {
        (u_m, 0.5 * u_m * u_m + EDGE_M * EDGE_M / 6.0)
    }
}

/// Returns the force on the nut at a shift of the thread against it, and the elastic part of this force, N.
///
/// A flank pushes with k δ + d δ̇ δ/(δ + δ₀) ≥ 0; its damping grows with depth, as in the model of Hunt and
/// Crossley. Without backlash the force is the linear k s + d ṡ.
pub fn force_n(nominal: &Nominal, shift_m: f64, rate_m_s: f64) -> (f64, f64) {
    let (stiffness, damping) = (nominal.axial_n_m, nominal.axial_n_s_m);
    if nominal.backlash_m == 0.0 {
        let elastic = stiffness * shift_m;
        return (elastic + damping * rate_m_s, elastic);
    }
    // Force, and its elastic part, of the flank that pushes towards `side`.
    let flank = |side: f64| {
        let (deep, _) = depth(side * shift_m - 0.5 * nominal.backlash_m);
        let elastic = stiffness * deep;
        [(elastic + damping * deep / (deep + DEPTH_M) * side * rate_m_s).max(0.0), elastic]
    };
    let (ahead, back) = (flank(1.0), flank(-1.0));
    (ahead[0] - back[0], ahead[1] - back[1])
}

/// Returns the elastic energy of both flanks at a shift, J.
#[cfg(test)]
pub fn energy_j(nominal: &Nominal, shift_m: f64) -> f64 {
    if nominal.backlash_m == 0.0 {
        return 0.5 * nominal.axial_n_m * shift_m * shift_m;
    }
    let half = 0.5 * nominal.backlash_m;
    nominal.axial_n_m * (depth(shift_m - half).1 + depth(-shift_m - half).1)
}
