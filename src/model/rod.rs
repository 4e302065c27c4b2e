//! Uniform rods in axial or torsional vibration.

use num_complex::Complex64;

/// The dynamic stiffness of a uniform free–free rod at its two ends.
///
/// ```text
///          φ   ┌                ┐
/// D  =  A ───  │  cot φ  −csc φ │      φ = ω·L·√(ρ/E)   axial,    A = E·S
///          L   │ −csc φ   cot φ │      φ = ω·L·√(ρ/G)   torsion,  A = G·J,  S = π·d²/4, J = π·d⁴/32
///              └                ┘
/// ```
///
/// # Units      A/L in N/m (N·m/rad), φ in rad
/// # Limits     ω → 0 gives the spring A/L (test `limit_rod_is_a_spring`)
/// # Source     inverse of Tian et al., Eq. 1–2 and 10–12. Deviation: cot for the printed cos.
#[derive(Debug, Clone, Copy)]
pub struct Rod {
    /// A/L (N/m or N·m/rad).
    pub stiffness: f64,
    /// φ/ω (s): the time a wave takes along the rod.
    pub transit_s: f64,
    /// Loss factor η of the material: A times 1 + iη.
    pub loss_factor: f64,
}

/// (cos φ, sin φ) kept away from the poles at sin φ = 0, where the rod's dynamic stiffness is infinite.
fn cos_sin(phase: f64) -> (f64, f64) {
    let (sin, cos) = phase.sin_cos();
    if sin.abs() < 1e-13 { (cos, 1e-13_f64.copysign(if sin == 0.0 { cos } else { sin })) } else { (cos, sin) }
}

impl Rod {
    /// Direct and cross entry of D without loss.
    #[inline]
    pub fn undamped(&self, omega_rad_s: f64) -> (f64, f64) {
        let phase = omega_rad_s * self.transit_s;
        let (cos, sin) = cos_sin(phase);
        let scale = self.stiffness * phase / sin;
        (scale * cos, -scale)
    }

    /// Direct and cross entry of D, their slopes with ω, and sin φ.
    #[inline]
    pub fn damped(&self, omega_rad_s: f64) -> RodEntries {
        if self.loss_factor == 0.0 {
            let phase = omega_rad_s * self.transit_s;
            let (cos, sin) = cos_sin(phase);
            let csc = 1.0 / sin;
            let cot = cos * csc;
            let k = self.stiffness;
            return RodEntries {
                direct: (k * phase * cot).into(),
                cross: (-k * phase * csc).into(),
                direct_slope: (k * self.transit_s * (cot - phase * csc * csc)).into(),
                cross_slope: (-k * self.transit_s * csc * (1.0 - phase * cot)).into(),
                sin: sin.into(),
                lossless: true,
            };
        }
        let material = Complex64::new(1.0, self.loss_factor);
        let transit_s = self.transit_s / material.sqrt();
        let k = self.stiffness * material;
        let phase = transit_s * omega_rad_s;
        let (sin, cos) = (phase.sin(), phase.cos());
        let csc = sin.inv();
        let cot = cos * csc;
        RodEntries {
            direct: k * phase * cot,
            cross: -k * phase * csc,
            direct_slope: k * transit_s * (cot - phase * csc * csc),
            cross_slope: -k * transit_s * csc * (1.0 - phase * cot),
            sin,
            lossless: false,
        }
    }

    /// Number of clamped–clamped natural frequencies of the rod below ω: the poles of D.
    pub fn clamped_modes_below(&self, omega_rad_s: f64) -> usize {
        (omega_rad_s * self.transit_s / std::f64::consts::PI).floor().max(0.0) as usize
    }
}

/// What [`Rod::damped`] gives.
#[derive(Debug, Clone, Copy)]
pub struct RodEntries {
    /// Direct entry (both ends).
    pub direct: Complex64,
    /// Cross entry.
    pub cross: Complex64,
    /// d(direct)/dω.
    pub direct_slope: Complex64,
    /// d(cross)/dω.
    pub cross_slope: Complex64,
    /// sin φ, which cancels the poles in the determinant.
    pub sin: Complex64,
    /// All of it is real.
    pub lossless: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_rod_is_a_spring() {
        let rod = Rod { stiffness: 2e8, transit_s: 3e-4, loss_factor: 0.0 };
        let (direct, cross) = rod.undamped(1e-3);
        assert!((direct / 2e8 - 1.0).abs() < 1e-12);
        assert!((cross / -2e8 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn slopes_are_those_of_finite_differences_with_and_without_loss() {
        for loss_factor in [0.0, 1e-12, 0.02] {
            let rod = Rod { stiffness: 2e8, transit_s: 3e-4, loss_factor };
            for omega in [200.0, 3000.0, 9000.0, 20000.0] {
                let step = 1e-4 * omega;
                let (low, here, high) = (rod.damped(omega - step), rod.damped(omega), rod.damped(omega + step));
                let direct = (high.direct - low.direct) / (2.0 * step);
                let cross = (high.cross - low.cross) / (2.0 * step);
                assert!((direct - here.direct_slope).norm() < 1e-4 * here.direct_slope.norm());
                assert!((cross - here.cross_slope).norm() < 1e-4 * here.cross_slope.norm());
            }
        }
    }

    #[test]
    fn limit_a_vanishing_loss_is_no_loss() {
        let with = Rod { stiffness: 2e8, transit_s: 3e-4, loss_factor: 1e-14 };
        let without = Rod { loss_factor: 0.0, ..with };
        let (a, b) = (with.damped(5000.0), without.damped(5000.0));
        assert!((a.direct - b.direct).norm() < 1e-10 * b.direct.norm());
        assert!((a.cross_slope - b.cross_slope).norm() < 1e-10 * b.cross_slope.norm());
    }
}
