//! Uniform rods in axial or torsional vibration.

use num_complex::Complex64;

use super::simd::{Complexes, Reals, sin_cos};

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
///
/// A chain of n springs n·A/L with the mass lumped at their ends has the same form. Its inner masses follow a
/// recurrence with constant coefficients and are eliminated in closed form. The chain therefore costs no more
/// than the exact rod:
///
/// ```text
///                 ┌                  ┐
/// D  =  n·A/L·    │ cot nμ   −csc nμ │·sin μ      sin(μ/2) = φ/(2n)        poles: nμ = π, 2π, … (n − 1)·π
///                 │ −csc nμ   cot nμ │
///                 └                  ┘
/// ```
///
/// # Source     inverse of Tian et al., Eq. 1–2 and 10–12. Deviation: cot for the printed cos. The chain:
///   solution sin(jμ) of
///   u(j−1) − (2 − ω²·m/k)·u(j) + u(j+1) = 0, with halves of m at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rod {
    /// A/L (N/m or N·m/rad).
    pub stiffness: f64,
    /// φ/ω (s): the time a wave takes along the rod.
    pub transit_s: f64,
    /// Loss factor η of the material: A is multiplied by 1 + η·(i + s·2/π·ln(ω/ω₀)).
    pub loss_factor: f64,
    /// Share s of dispersion of the loss factor.
    pub dispersion: f64,
    /// Number n of springs of the chain that represents the rod; 0 for the exact rod.
    pub elements: usize,
    /// Decay rate σ of the exponential window of a record (1/s): ω − iσ stands for ω in the entries with
    /// loss, and they are complex. 0: no window.
    pub window_per_s: f64,
}

/// Frequency ω₀ (rad/s) at which a stiffness with a loss factor has its nominal value: 100 Hz.
const LOSS_REFERENCE_RAD_S: f64 = 200.0 * std::f64::consts::PI;
/// Frequency (rad/s) below which dispersion does not change the stiffness further: 1 Hz.
const LOWEST_RAD_S: f64 = 0.01 * LOSS_REFERENCE_RAD_S;

/// Computes the factor of η in the relative complex stiffness 1 + η·(i + s·2/π·ln(ω/ω₀)).
///
/// ```text
/// k(ω) = k·(1 + η·(i + s·2/π·ln(ω/ω₀))),      ω₀ = 2π·100 rad/s
/// ```
///
/// # Source  s = 1 is the causal hysteretic element, to first order in η: Makris, J. Eng. Mech. 123 (1997)
///   1209–1214. s = 0 is the constant
///   k·(1 + iη) of finite-element programs. Microslip in a joint follows it at one amplitude, although it is
///   not causal.
#[inline]
pub(super) fn loss(omega_rad_s: f64, dispersion: f64) -> Complex64 {
    // Below 1 Hz, where hammer tests have no force, the stiffness is held constant, since ln ω diverges.
    Complex64::new(
        dispersion
            * std::f64::consts::FRAC_2_PI
            * (omega_rad_s.max(LOWEST_RAD_S) / LOSS_REFERENCE_RAD_S).ln(),
        1.0,
    )
}

/// Computes the stiffness change of full dispersion over η, 2/π·ln(ω/ω₀), for each frequency.
#[inline]
pub(super) fn dispersion_each(omega_rad_s: Reals) -> Reals {
    let share = omega_rad_s.fast_max(Reals::splat(LOWEST_RAD_S)) * Reals::splat(1.0 / LOSS_REFERENCE_RAD_S);
    share.ln() * Reals::splat(std::f64::consts::FRAC_2_PI)
}

/// Computes [`loss`] for each frequency, and its slope with ω.
#[inline]
pub(super) fn loss_each(omega_rad_s: Reals, dispersion: f64) -> (Complexes, Reals) {
    let above = Reals::splat(std::f64::consts::FRAC_2_PI * dispersion) / omega_rad_s;
    let slope = omega_rad_s.simd_gt(Reals::splat(LOWEST_RAD_S)).select(above, Reals::ZERO);
    (Complexes::new(dispersion_each(omega_rad_s) * Reals::splat(dispersion), Reals::ONE), slope)
}

/// Computes the relative complex modulus 1 + η·(i + s·2/π·ln(ω/ω₀)) for each frequency.
#[inline]
pub(super) fn modulus_each(omega_rad_s: Reals, loss_factor: f64, dispersion: f64) -> Complexes {
    Complexes::real(Reals::ONE) + loss_each(omega_rad_s, dispersion).0 * loss_factor
}

/// Largest number of elements of a chain that the Chebyshev recurrence evaluates, and the largest φ/(2n) for
/// it (the chain's cut-off is at 1).
const SHORT_CHAIN: usize = 4;
const MAX_HALF_STEP: f64 = 1e3;

/// Returns (cos φ, sin φ), kept away from sin φ = 0, where the rod's dynamic stiffness has a pole.
fn cos_sin(phase: f64) -> (f64, f64) {
    let (sin, cos) = phase.sin_cos();
    if sin.abs() < 1e-13 { (cos, 1e-13_f64.copysign(if sin == 0.0 { cos } else { sin })) } else { (cos, sin) }
}

/// Whether any sin φ is too close to 0, where D has a pole.
fn near_pole(sin: Reals) -> bool {
    sin.abs().simd_lt(Reals::splat(1e-13)).any()
}

impl Rod {
    /// Whether its entries are real.
    pub(super) fn is_lossless(&self) -> bool {
        self.loss_factor == 0.0 && self.window_per_s == 0.0
    }

    /// Computes (ω − iσ)/ω.
    fn window(&self, omega_rad_s: f64) -> Complex64 {
        Complex64::new(1.0, -self.window_per_s / omega_rad_s)
    }

    /// Computes 1 + η·(i + s·2/π·ln(ω/ω₀)).
    pub(super) fn material(&self, omega_rad_s: f64) -> Complex64 {
        1.0 + loss(omega_rad_s, self.dispersion) * self.loss_factor
    }

    /// Computes [`Rod::material`] for each frequency.
    #[inline]
    fn material_each(&self, omega_rad_s: Reals) -> Material {
        let mut root = modulus_each(omega_rad_s, self.loss_factor, self.dispersion).sqrt();
        let mut slowness = root.inverse();
        let inverse = slowness * slowness;
        if self.window_per_s != 0.0 {
            let window = Complexes::new(Reals::ONE, Reals::splat(-self.window_per_s) / omega_rad_s);
            (root, slowness) = (root * window, slowness * window);
        }
        Material { loss_factor: self.loss_factor, root, slowness, inverse }
    }

    /// Computes the direct and the cross entry of D without loss.
    #[inline]
    pub fn undamped(&self, omega_rad_s: f64) -> (f64, f64) {
        if self.elements > 0 {
            return self.chain_undamped(omega_rad_s);
        }
        let phase = omega_rad_s * self.transit_s;
        let (cos, sin) = cos_sin(phase);
        let scale = self.stiffness * phase / sin;
        (scale * cos, -scale)
    }

    /// Computes the direct and the cross entry of D, and sin φ.
    #[inline]
    pub fn damped(&self, omega_rad_s: f64) -> RodEntries {
        if self.elements > 0 {
            return self.chain_damped(omega_rad_s);
        }
        if self.is_lossless() {
            let phase = omega_rad_s * self.transit_s;
            let (cos, sin) = cos_sin(phase);
            let scale = self.stiffness * phase / sin;
            return RodEntries {
                direct: (scale * cos).into(),
                cross: (-scale).into(),
                sin: sin.into(),
                lossless: true,
            };
        }
        let material = self.material(omega_rad_s);
        let phase = self.transit_s / material.sqrt() * omega_rad_s * self.window(omega_rad_s);
        let (sin, cos) = (phase.sin(), phase.cos());
        let scale = self.stiffness * material * phase / sin;
        RodEntries { direct: scale * cos, cross: -scale, sin, lossless: false }
    }

    /// Computes the direct and the cross entry of D without loss, and sin φ, for each frequency. Returns
    /// `None` next to a pole, and for a long chain above its cut-off.
    #[inline(always)]
    pub(super) fn lossless_each<const N: usize>(&self, omega_rad_s: [Reals; N]) -> Option<[[Reals; 3]; N]> {
        let mut each = [[Reals::ZERO; 3]; N];
        if self.elements == 0 {
            let phase = omega_rad_s.map(|omega| omega * Reals::splat(self.transit_s));
            for ((of, phase), [sin, cos]) in each.iter_mut().zip(phase).zip(sin_cos(phase)) {
                *of = [Reals::splat(self.stiffness) * phase, cos, sin];
            }
        } else {
            for (of, omega) in each.iter_mut().zip(omega_rad_s) {
                let [cos, sin] = self.chain_each(omega)?;
                *of = [Reals::splat(self.stiffness * self.elements as f64), cos, sin];
            }
        }
        if each.iter().any(|[_, _, sin]| near_pole(*sin)) {
            return None;
        }
        Some(each.map(|[scale, cos, sin]| {
            let scale = scale / sin;
            [scale * cos, -scale, sin]
        }))
    }

    /// Computes [`Rod::undamped`] for each frequency.
    #[inline]
    pub fn undamped_each(&self, omega_rad_s: Reals) -> (Reals, Reals) {
        if let Some([[direct, cross, _]]) = self.lossless_each([omega_rad_s]) {
            return (direct, cross);
        }
        let each = omega_rad_s.to_array().map(|omega| self.undamped(omega));
        (Reals::from(each.map(|e| e.0)), Reals::from(each.map(|e| e.1)))
    }

    /// Computes [`Rod::damped`] for each frequency.
    #[inline]
    pub fn damped_each(&self, omega_rad_s: Reals) -> RodLanes {
        self.damped_with_material(omega_rad_s, &mut None)
    }

    /// Computes as [`Rod::damped_each`], reusing the material of the previous rod at the same frequencies,
    /// which most rods share.
    #[inline]
    pub(super) fn damped_with_material(
        &self,
        omega_rad_s: Reals,
        material: &mut Option<Material>,
    ) -> RodLanes {
        if self.is_lossless()
            && let Some([[direct, cross, sin]]) = self.lossless_each([omega_rad_s])
        {
            return RodLanes::real(direct, cross, sin);
        }
        if material.as_ref().is_some_and(|known| known.loss_factor != self.loss_factor) {
            *material = None;
        }
        let material = material.get_or_insert_with(|| self.material_each(omega_rad_s));
        if !self.is_lossless() && self.elements == 0 {
            let phase = omega_rad_s * Reals::splat(self.transit_s);
            let (sin, cos) = (material.slowness * phase).sin_cos();
            let scale = material.root * sin.inverse() * (phase * Reals::splat(self.stiffness));
            return RodLanes {
                direct: scale * cos,
                cross: -scale,
                sin,
                material_inverse: material.inverse,
                lossless: false,
            };
        }
        let each = omega_rad_s.to_array().map(|omega| self.damped(omega));
        let of = |part: fn(&RodEntries) -> Complex64| Complexes::each(|lane| part(&each[lane]));
        let lossless = each.iter().all(|e| e.lossless);
        RodLanes {
            direct: of(|e| e.direct),
            cross: of(|e| e.cross),
            sin: of(|e| e.sin),
            material_inverse: material.inverse,
            lossless,
        }
    }

    /// Computes d(direct)/dω and d(cross)/dω for constant material; [`RodLanes::by_material`] gives the
    /// contribution of the material's change.
    ///
    /// # Source  sin² + cos² = 1 in the derivatives of the entries, with x = φ/(2n), and x = 0 for the exact
    ///   rod:
    ///
    /// ```text
    /// ω·d(direct)/dω = (2 − y)·direct − y·cross²/k        ω·d(cross)/dω = cross·(2 − y − y·direct/k)        y = 1/(1 − x²)
    /// ```
    #[inline]
    pub fn slopes_each(&self, omega_rad_s: Reals, entries: &RodLanes) -> (Complexes, Complexes) {
        let per_omega = Reals::ONE / omega_rad_s;
        let per_k = Reals::splat(1.0 / self.stiffness);
        if entries.lossless {
            let (direct, cross) = (entries.direct.re, entries.cross.re);
            let (alpha, beta) = if self.elements == 0 {
                (per_omega, per_omega * per_k)
            } else {
                let y = Reals::from(
                    omega_rad_s.to_array().map(|omega| 1.0 / (1.0 - self.half_step(omega).powi(2))),
                );
                ((Reals::splat(2.0) - y) * per_omega, y * per_omega * per_k)
            };
            return (
                Complexes::real(alpha * direct - beta * cross * cross),
                Complexes::real(cross * (alpha - beta * direct)),
            );
        }
        let y = match self.elements {
            0 => Complexes::real(Reals::ONE),
            _ => Complexes::each(|lane| {
                let omega = omega_rad_s.to_array()[lane];
                (1.0 - (self.half_step(omega) * self.window(omega)).powi(2) / self.material(omega)).inv()
            }),
        };
        let alpha = (Complexes::real(Reals::splat(2.0)) - y) * per_omega;
        let beta = y * entries.material_inverse * (per_omega * per_k);
        (
            alpha * entries.direct - beta * entries.cross * entries.cross,
            entries.cross * (alpha - beta * entries.direct),
        )
    }

    /// Computes cos nμ and sin nμ/sin μ of a lossless chain for each frequency: of a short chain at any
    /// frequency, of a long one below its cut-off.
    ///
    /// # Source  cos nμ and sin nμ/sin μ are Chebyshev polynomials in cos μ = 1 − 2x², x = φ/(2n), of the
    ///   first and of the second kind.
    #[inline]
    fn chain_each(&self, omega_rad_s: Reals) -> Option<[Reals; 2]> {
        let n = self.elements;
        let x = omega_rad_s * Reals::splat(0.5 * self.transit_s / n as f64);
        if (1..=SHORT_CHAIN).contains(&n) && x.simd_lt(Reals::splat(MAX_HALF_STEP)).all() {
            let twice = (x * x).mul_add(Reals::splat(-4.0), Reals::splat(2.0));
            let (mut before, mut here) = ([Reals::ONE, Reals::ZERO], [twice * Reals::splat(0.5), Reals::ONE]);
            for _ in 1..n {
                (before, here) = (here, [0, 1].map(|kind| twice.mul_add(here[kind], -before[kind])));
            }
            Some(here)
        } else if n > SHORT_CHAIN && x.simd_lt(Reals::splat(1.0 - 1e-9)).all() {
            let [[sin, cos]] = sin_cos([x.asin() * Reals::splat(2.0 * n as f64)]);
            Some([cos, sin / ((x + x) * (Reals::ONE - x * x).sqrt())])
        } else {
            None
        }
    }

    /// Counts the clamped–clamped natural frequencies of the rod below each ω: the poles of D.
    #[inline]
    pub fn clamped_modes_below_each(&self, omega_rad_s: Reals) -> Reals {
        if self.elements == 0 {
            return (omega_rad_s * Reals::splat(self.transit_s) / Reals::splat(std::f64::consts::PI))
                .floor()
                .fast_max(Reals::ZERO);
        }
        Reals::from(omega_rad_s.to_array().map(|omega| self.chain_modes_below(omega) as f64))
    }

    /// Computes φ/(2n) of a chain, kept away from the cut-off at 1, where neighbouring masses move in
    /// opposite phase.
    fn half_step(&self, omega_rad_s: f64) -> f64 {
        let x = 0.5 * omega_rad_s * self.transit_s / self.elements as f64;
        if (x - 1.0).abs() < 1e-12 { 1.0 - 1e-12 } else { x }
    }

    fn chain_undamped(&self, omega_rad_s: f64) -> (f64, f64) {
        let n = self.elements as f64;
        let x = self.half_step(omega_rad_s);
        if x < 1.0 {
            let (cos, sin) = cos_sin(2.0 * n * x.asin());
            let scale = self.stiffness * n * 2.0 * x * (1.0 - x * x).sqrt() / sin;
            return (scale * cos, -scale);
        }
        // Above the cut-off of the chain, μ = π + iy.
        let y = 2.0 * x.acosh();
        let scale = self.stiffness * n * 2.0 * x * (x * x - 1.0).sqrt();
        let sign = if self.elements.is_multiple_of(2) { 1.0 } else { -1.0 };
        (-scale / (n * y).tanh(), sign * scale / (n * y).sinh())
    }

    fn chain_damped(&self, omega_rad_s: f64) -> RodEntries {
        let n = self.elements as f64;
        let x = self.half_step(omega_rad_s);
        if self.is_lossless() && x < 1.0 {
            let (cos, sin) = cos_sin(2.0 * n * x.asin());
            let step = 2.0 * x * (1.0 - x * x).sqrt();
            let scale = self.stiffness * n * step / sin;
            return RodEntries {
                direct: (scale * cos).into(),
                cross: (-scale).into(),
                sin: (sin / step).into(),
                lossless: true,
            };
        }
        let material = self.material(omega_rad_s);
        let x = x * self.window(omega_rad_s) / material.sqrt();
        let sin_step = x * (1.0 - x * x).sqrt() * 2.0;
        let angle = x.asin() * (2.0 * n);
        // Far from the real axis sin and cos overflow; their quotient is ±i.
        let (csc, cot, sin) = if angle.im.abs() > 300.0 {
            let quotient = Complex64::new(0.0, -angle.im.signum());
            let sin = Complex64::new(0.0, -angle.re * angle.im.signum()).exp() * quotient;
            (Complex64::new(0.0, 0.0), quotient, sin.conj())
        } else {
            let (sin, cos) = (angle.sin(), angle.cos());
            (sin.inv(), cos / sin, sin)
        };
        let k = material * (self.stiffness * n);
        let lossless = self.is_lossless();
        let real = |z: Complex64| if lossless { Complex64::new(z.re, 0.0) } else { z };
        RodEntries {
            direct: real(k * sin_step * cot),
            cross: real(-k * sin_step * csc),
            sin: real(sin / sin_step),
            lossless,
        }
    }

    fn chain_modes_below(&self, omega_rad_s: f64) -> usize {
        let x = self.half_step(omega_rad_s);
        let passed = self.elements as f64 * 2.0 * x.min(1.0).asin() / std::f64::consts::PI;
        (passed.floor().max(0.0) as usize).min(self.elements - 1)
    }
}

/// Result of [`Rod::damped`].
#[derive(Debug, Clone, Copy)]
pub struct RodEntries {
    /// Direct entry (both ends).
    pub direct: Complex64,
    /// Cross entry.
    pub cross: Complex64,
    /// sin φ, or sin nμ/sin μ of a chain, which cancels the poles in the determinant.
    pub sin: Complex64,
    /// Whether all entries are real.
    pub lossless: bool,
}

/// [`RodEntries`] for each lane.
#[derive(Debug, Clone, Copy)]
pub struct RodLanes {
    /// Direct entry.
    pub direct: Complexes,
    /// Cross entry.
    pub cross: Complexes,
    /// As [`RodEntries::sin`].
    pub sin: Complexes,
    /// 1/(1 + η·(i + s·2/π·ln(ω/ω₀))) of the material.
    pub material_inverse: Complexes,
    /// Whether all entries are real.
    pub lossless: bool,
}

/// The relative complex modulus m of a material, for each frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct Material {
    loss_factor: f64,
    /// √m with m = 1 + η·(i + s·2/π·ln(ω/ω₀)), times (ω − iσ)/ω of a window.
    root: Complexes,
    /// 1/√m, times the same.
    slowness: Complexes,
    /// 1/m.
    inverse: Complexes,
}

impl RodLanes {
    #[inline]
    fn real(direct: Reals, cross: Reals, sin: Reals) -> Self {
        let [direct, cross, sin, material_inverse] = [direct, cross, sin, Reals::ONE].map(Complexes::real);
        RodLanes { direct, cross, sin, material_inverse, lossless: true }
    }

    /// Computes the change of the entries per d(material)/material: through the stiffness itself, and through
    /// φ = ω·t/√material.
    pub fn by_material(
        &self,
        omega_rad_s: Reals,
        (direct_slope, cross_slope): (Complexes, Complexes),
    ) -> (Complexes, Complexes) {
        let half = omega_rad_s * Reals::splat(0.5);
        (self.direct - direct_slope * half, self.cross - cross_slope * half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_rod_is_a_spring() {
        let rod = Rod {
            stiffness: 2e8,
            transit_s: 3e-4,
            loss_factor: 0.0,
            dispersion: 0.7,
            elements: 0,
            window_per_s: 0.0,
        };
        let (direct, cross) = rod.undamped(1e-3);
        assert!((direct / 2e8 - 1.0).abs() < 1e-12);
        assert!((cross / -2e8 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn slopes_equal_finite_differences_with_and_without_loss() {
        for (loss_factor, elements) in
            [(0.0, 0), (1e-12, 0), (0.02, 0), (0.0, 4), (0.02, 4), (0.0, 1), (1e-12, 4)]
        {
            let rod = Rod {
                stiffness: 2e8,
                transit_s: 3e-4,
                loss_factor,
                dispersion: 0.7,
                elements,
                window_per_s: 0.0,
            };
            for omega in [200.0, 3000.0, 9000.0, 20000.0] {
                let step = 1e-4 * omega;
                let (low, high) = (rod.damped(omega - step), rod.damped(omega + step));
                let direct = (high.direct - low.direct) / (2.0 * step);
                let cross = (high.cross - low.cross) / (2.0 * step);
                let drift = loss_each(Reals::splat(omega), rod.dispersion).1.to_array()[0] * loss_factor
                    / rod.material(omega);
                let (at, entries) = (Reals::splat(omega), rod.damped_each(Reals::splat(omega)));
                let slopes = rod.slopes_each(at, &entries);
                let changes = entries.by_material(at, slopes);
                let with = |slope: Complexes, by: Complexes| slope.lanes()[0] + by.lanes()[0] * drift;
                let (direct_slope, cross_slope) = (with(slopes.0, changes.0), with(slopes.1, changes.1));
                assert!((direct - direct_slope).norm() < 1e-4 * direct_slope.norm());
                // The cross entry of a single spring does not depend on ω.
                assert!(
                    (cross - cross_slope).norm() < 1e-4 * cross_slope.norm() + 1e-8 * direct_slope.norm()
                );
            }
        }
    }

    /// The closed form equals elimination mass by mass, below and above the cut-off.
    #[test]
    fn limit_closed_form_chain_equals_mass_by_mass_elimination() {
        for elements in [1, 2, 3, 7, 40] {
            for loss_factor in [0.0, 0.03] {
                let rod = Rod {
                    stiffness: 2e8,
                    transit_s: 3e-4,
                    loss_factor,
                    dispersion: 0.7,
                    elements,
                    window_per_s: 0.0,
                };
                let n = elements as f64;
                let mass = 2e8 * 3e-4 * 3e-4 / n;
                for omega in [10.0, 4000.0, 11_000.0, 30_000.0, 9e5, 3e7] {
                    let k = rod.material(omega) * (2e8 * n);
                    let end = k - 0.5 * mass * omega * omega;
                    // Two-port of a chain that is extended mass by mass: (a, b, c) = (left, cross, right).
                    let (mut a, mut b, mut c) = (end, -k, end);
                    for _ in 1..elements {
                        let middle = c + end;
                        (a, b, c) = (a - b * b / middle, b * k / middle, end - k * k / middle);
                    }
                    let ours = rod.damped(omega);
                    let scale = a.norm();
                    assert!(
                        (ours.direct - a).norm() < 1e-7 * scale,
                        "{elements} {loss_factor} {omega}: {} {a}",
                        ours.direct
                    );
                    assert!(
                        (ours.cross - b).norm() < 1e-7 * scale,
                        "{elements} {loss_factor} {omega}: {} {b}",
                        ours.cross
                    );
                    assert!((c - a).norm() < 1e-7 * scale);
                    if loss_factor == 0.0 {
                        let (direct, cross) = rod.undamped(omega);
                        assert!(
                            (ours.direct.re - direct).abs() < 1e-9 * scale
                                && (ours.cross.re - cross).abs() < 1e-9 * scale
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn limit_a_chain_has_as_many_clamped_modes_as_inner_masses() {
        let rod = Rod {
            stiffness: 2e8,
            transit_s: 3e-4,
            loss_factor: 0.0,
            dispersion: 0.7,
            elements: 5,
            window_per_s: 0.0,
        };
        assert_eq!(rod.chain_modes_below(1e9), 4);
        assert_eq!(Rod { elements: 1, ..rod }.chain_modes_below(1e9), 0);
        // The j-th lies at ω = 2n/t·sin(jπ/2n).
        for mode in 1..5 {
            let omega = 10.0 / 3e-4 * (f64::from(mode) * std::f64::consts::PI / 10.0).sin();
            assert_eq!(rod.chain_modes_below(omega * (1.0 - 1e-9)), mode as usize - 1);
            assert_eq!(rod.chain_modes_below(omega * (1.0 + 1e-9)), mode as usize);
        }
    }

    #[test]
    fn limit_vector_rod_equals_scalar_rod() {
        for (loss_factor, elements) in
            [(0.0, 0), (0.02, 0), (0.0, 1), (0.0, 2), (0.0, 4), (0.0, 7), (0.02, 4)]
        {
            let rod = Rod {
                stiffness: 2e8,
                transit_s: 3e-4,
                loss_factor,
                dispersion: 0.7,
                elements,
                window_per_s: 0.0,
            };
            // The third lies at a pole of the rod.
            let omegas = [12.0, 3000.0, std::f64::consts::PI / 3e-4, 2e5];
            let each = rod.damped_each(Reals::from(omegas));
            let (direct, cross) = rod.undamped_each(Reals::from(omegas));
            for (lane, omega) in omegas.into_iter().enumerate() {
                let one = rod.damped(omega);
                let near = |a: Complex64, b: Complex64| {
                    assert!((a - b).norm() <= 1e-11 * b.norm(), "{elements} {omega}: {a} {b}")
                };
                near(each.direct.lanes()[lane], one.direct);
                near(each.cross.lanes()[lane], one.cross);
                near(direct.to_array()[lane].into(), rod.undamped(omega).0.into());
                near(cross.to_array()[lane].into(), rod.undamped(omega).1.into());
            }
        }
    }

    #[test]
    fn limit_a_vanishing_loss_is_no_loss() {
        let with = Rod {
            stiffness: 2e8,
            transit_s: 3e-4,
            loss_factor: 1e-14,
            dispersion: 0.7,
            elements: 0,
            window_per_s: 0.0,
        };
        let without = Rod { loss_factor: 0.0, ..with };
        let at = Reals::splat(5000.0);
        let (a, b) = (with.damped_each(at), without.damped_each(at));
        let near = |a: Complexes, b: Complexes| (a - b).lanes()[0].norm() < 1e-10 * b.lanes()[0].norm();
        assert!(near(a.direct, b.direct) && near(with.slopes_each(at, &a).1, without.slopes_each(at, &b).1));
    }
}
