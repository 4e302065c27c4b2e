//! The dynamic stiffness of one joint.

use num_complex::Complex64;

use super::rod::{loss, loss_each};
use super::simd::{Complexes, Reals};

/// The numbers of one joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct JointNumbers {
    pub stiffness: f64,
    pub damping: f64,
    pub loss_factor: f64,
    /// Share of dispersion of the loss factor.
    pub dispersion: f64,
    pub integral_rate: f64,
    pub relaxation_stiffness: Option<f64>,
    /// Relative deviation γ of the lead.
    pub lead_growth: f64,
}

/// Computes x/s for each frequency, with one division where s = iω.
#[inline]
pub(super) fn over_each(x: f64, s: Complexes) -> Complexes {
    if s.re.simd_eq(Reals::ZERO).all() {
        Complexes::new(Reals::ZERO, -Reals::splat(x) / s.im)
    } else {
        s.inverse() * x
    }
}

impl JointNumbers {
    /// Whether the joint has dynamics in addition to spring, viscous damper and loss, which are summed over
    /// all joints.
    pub(super) fn has_extra_dynamics(&self) -> bool {
        self.relaxation_stiffness.is_some() || self.integral_rate != 0.0
    }

    /// Computes 1/(1 + s·c/k) of a damper in series with a relaxation spring, for each s = iω or iω + σ.
    #[inline]
    fn relaxation_share_each(&self, relaxation_stiffness: f64, s: Complexes) -> Complexes {
        (Complexes::real(Reals::ONE) + s * (self.damping / relaxation_stiffness)).inverse()
    }

    /// Computes the complex stiffness of a damper s·c in series with its relaxation spring.
    #[inline]
    pub(super) fn damper_each(&self, relaxation_stiffness: f64, s: Complexes) -> Complexes {
        self.relaxation_share_each(relaxation_stiffness, s) * (s * self.damping)
    }

    /// Multiplies a product by the derivative of the complex stiffness with s·c. The derivative is 1 for a
    /// plain damper, smaller in series with a relaxation spring.
    #[inline]
    pub(super) fn damper_derivative_each(&self, product: Complexes, s: Complexes) -> Complexes {
        match self.relaxation_stiffness {
            None => product,
            Some(k) => {
                let share = self.relaxation_share_each(k, s);
                product * share * share
            }
        }
    }

    /// Computes the integral action k·ω_i/s.
    #[inline]
    pub(super) fn integral_each(&self, s: Complexes) -> Complexes {
        over_each(self.stiffness * self.integral_rate, s)
    }

    /// Computes [`JointNumbers::dynamic`] for each frequency, with s = iω or iω + σ.
    pub(super) fn dynamic_each(&self, omega_rad_s: Reals, s: Complexes) -> Complexes {
        let mut sum = Complexes::real(Reals::splat(self.stiffness));
        if self.loss_factor != 0.0 {
            sum += loss_each(omega_rad_s, self.dispersion).0 * (self.stiffness * self.loss_factor);
        }
        if self.integral_rate != 0.0 {
            sum += self.integral_each(s);
        }
        sum +=
            self.relaxation_stiffness.map_or_else(|| s * self.damping, |series| self.damper_each(series, s));
        sum
    }

    /// Computes the complex stiffness: spring with loss and integral action, k·(1 + η·(i + s·2/π·ln(ω/ω₀)) +
    /// ω_i/(iω)), and damper iωc, in series with its relaxation spring if it has one.
    pub(super) fn dynamic(&self, omega_rad_s: f64) -> Complex64 {
        let integral = Complex64::new(0.0, -self.stiffness * self.integral_rate / omega_rad_s);
        let spring = self.stiffness
            + loss(omega_rad_s, self.dispersion) * (self.stiffness * self.loss_factor)
            + integral;
        let damper = Complex64::new(0.0, omega_rad_s * self.damping);
        match self.relaxation_stiffness {
            None => spring + damper,
            Some(series) => spring + damper * (1.0 + damper / series).inv(),
        }
    }
}
