//! The dynamic stiffness of one joint.

use num_complex::Complex64;

use super::rod::loss;
use super::simd::{Complexes, Reals};

/// Numbers of one joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct JointNumbers {
    pub stiffness: f64,
    pub damping: f64,
    pub loss_factor: f64,
    /// Share of its dispersion.
    pub dispersion: f64,
    pub integral_rate: f64,
    pub relaxation_stiffness: Option<f64>,
}

impl JointNumbers {
    /// Whether its dynamic stiffness is more than spring, viscous damper and loss, which are summed over all joints.
    pub(super) fn is_apart(&self) -> bool {
        self.relaxation_stiffness.is_some() || self.integral_rate != 0.0
    }

    /// 1/(1 + iωc/k) of a damper in line with a relaxation spring, at some frequencies.
    #[inline]
    fn share_each(&self, relaxation_stiffness: f64, omega_rad_s: Reals) -> Complexes {
        Complexes::new(Reals::ONE, omega_rad_s * Reals::splat(self.damping / relaxation_stiffness)).inverse()
    }

    /// iωc in line with a relaxation spring.
    #[inline]
    pub(super) fn damper_each(&self, relaxation_stiffness: f64, omega_rad_s: Reals) -> Complexes {
        (self.share_each(relaxation_stiffness, omega_rad_s) * (omega_rad_s * Reals::splat(self.damping))).turned()
    }

    /// A product times what the complex stiffness changes by a change of iωc, over i: less than all where the damper has its relaxation spring.
    #[inline]
    pub(super) fn by_damper_each(&self, product: Complexes, omega_rad_s: Reals) -> Complexes {
        match self.relaxation_stiffness {
            None => product.turned(),
            Some(k) => {
                let share = self.share_each(k, omega_rad_s);
                (product * share * share).turned()
            }
        }
    }

    /// −k·ω_i/ω: the integral action k·ω_i/(iω) over i.
    #[inline]
    pub(super) fn integral_each(&self, omega_rad_s: Reals) -> Reals {
        -Reals::splat(self.stiffness * self.integral_rate) / omega_rad_s
    }

    /// Complex stiffness: spring with its loss and integral action, k·(1 + η·(i + s·2/π·ln(ω/ω₀)) + ω_i/(iω)), and iωc, the damper through its relaxation
    /// spring where it has one.
    pub(super) fn dynamic(&self, omega_rad_s: f64) -> Complex64 {
        let integral = Complex64::new(0.0, -self.stiffness * self.integral_rate / omega_rad_s);
        let spring = self.stiffness + loss(omega_rad_s, self.dispersion) * (self.stiffness * self.loss_factor) + integral;
        let damper = Complex64::new(0.0, omega_rad_s * self.damping);
        match self.relaxation_stiffness {
            None => spring + damper,
            Some(series) => spring + damper * (1.0 + damper / series).inv(),
        }
    }
}
