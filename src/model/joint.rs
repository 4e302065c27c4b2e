//! The dynamic stiffness of one joint.

use num_complex::Complex64;

use super::lanes::{Complexes, Reals};
use super::rod::loss;

/// Numbers of one joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct JointNumbers {
    pub stiffness: f64,
    pub damping: f64,
    pub loss_factor: f64,
    pub relaxation_stiffness: Option<f64>,
}

impl JointNumbers {
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

    /// Stiffness with its loss, k·(1 + η·(i + 2/π·ln(ω/ω₀))), and its slope with ω.
    fn spring(&self, omega_rad_s: f64) -> (Complex64, f64) {
        let (added, slope) = loss(omega_rad_s);
        let h = self.stiffness * self.loss_factor;
        (self.stiffness + added * h, slope * h)
    }

    /// Complex stiffness: spring with its loss, and iωc, the damper through its relaxation spring where it has one; and its slope with ω.
    pub(super) fn dynamic(&self, omega_rad_s: f64) -> (Complex64, Complex64) {
        let (spring, spring_slope) = self.spring(omega_rad_s);
        match self.relaxation_stiffness {
            None => (spring + Complex64::new(0.0, omega_rad_s * self.damping), Complex64::new(spring_slope, self.damping)),
            Some(series) => {
                let damper = Complex64::new(0.0, omega_rad_s * self.damping);
                let share = (1.0 + damper / series).inv();
                (spring + damper * share, spring_slope + Complex64::new(0.0, self.damping) * share * share)
            }
        }
    }
}
