//! Friction as a function of velocity, and its conversion from torque.

use std::f64::consts::TAU;

use super::ContactError;
use super::error::{positive, within};
use numeric::root::bracketed_root;

/// The Stribeck curve of one axis.
///
/// ```text
/// f(v) = [ F_c + (F_s − F_c)·exp(−(v/v_s)²) ]·sgn(v) + d·v          f(0) = 0
/// ```
///
/// f is odd: at reversal it jumps from −F_s to +F_s. At rest the friction balances the applied force, up to
/// F_s; the curve gives 0 there, like sgn.
///
/// # Units      f, F_c, F_s in N, v, v_s in m/s, d in N·s/m
/// # Limits     |v| ≫ v_s gives F_c + d·|v|; v → 0+ gives F_s
/// # Source     Duan, Eq. 11 and Tab. 2 (there v_s in mm/s and d, called d_elt, in N per mm/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StribeckCurve {
    /// Coulomb friction F_c (N).
    pub coulomb_n: f64,
    /// Static friction F_s (N).
    pub static_n: f64,
    /// Viscous coefficient d (N·s/m).
    pub viscous_n_s_per_m: f64,
    /// Stribeck velocity v_s (m/s).
    pub stribeck_velocity_m_per_s: f64,
}

impl StribeckCurve {
    /// Returns the curve after a check of its parameters: F_c, F_s, d ≥ 0 and v_s > 0.
    ///
    /// # Errors  a parameter outside its range.
    pub fn check(self) -> Result<StribeckCurve, ContactError> {
        within("the Coulomb friction (N)", self.coulomb_n, 0.0, f64::MAX)?;
        within("the static friction (N)", self.static_n, 0.0, f64::MAX)?;
        within("the viscous coefficient (N·s/m)", self.viscous_n_s_per_m, 0.0, f64::MAX)?;
        positive("the Stribeck velocity (m/s)", self.stribeck_velocity_m_per_s)?;
        Ok(self)
    }

    /// Computes the friction (N) at a velocity, with the velocity's sign.
    pub fn force_n(&self, velocity_m_per_s: f64) -> f64 {
        if velocity_m_per_s == 0.0 {
            return 0.0;
        }
        let decay = (-(velocity_m_per_s / self.stribeck_velocity_m_per_s).powi(2)).exp();
        (self.coulomb_n + (self.static_n - self.coulomb_n) * decay).copysign(velocity_m_per_s)
            + self.viscous_n_s_per_m * velocity_m_per_s
    }

    /// Computes the speed (m/s) of least friction, where the rising branch begins; 0 for a curve that only
    /// rises or has no viscous part.
    pub fn least_friction_speed_m_per_s(&self) -> f64 {
        // f' = 0 where u·exp(−u²) = d·v_s/(2·(F_s − F_c)), on the branch u > 1/√2.
        let level = self.viscous_n_s_per_m * self.stribeck_velocity_m_per_s
            / (2.0 * (self.static_n - self.coulomb_n));
        let top = std::f64::consts::FRAC_1_SQRT_2;
        if !(level > 0.0 && level < top * (-0.5_f64).exp()) {
            return 0.0;
        }
        let slope = |u: f64| u.ln() - u * u - level.ln();
        // −u²/2 outweighs ln u, so that the slope is negative at the upper end.
        let upper = 2.0 + (-2.0 * level.ln()).max(0.0).sqrt();
        bracketed_root(top, upper, slope).unwrap_or(top) * self.stribeck_velocity_m_per_s
    }

    /// Computes the speed (m/s) of least friction from rest up to a speed, which it is itself where the friction
    /// falls throughout.
    pub fn least_friction_speed_up_to(&self, highest_m_per_s: f64) -> f64 {
        let inner = self.least_friction_speed_m_per_s();
        let least = if inner > 0.0 && inner < highest_m_per_s { inner } else { highest_m_per_s };
        if self.force_n(least) < self.static_n { least } else { 0.0 }
    }

    /// Computes the speed (m/s) on the rising branch at which the friction reaches a force, for example the
    /// unloading force of a nut.
    ///
    /// # Errors  [`ContactError::NoRisingBranch`] without viscous friction or for a force below the branch;
    ///   invalid parameters.
    pub fn rising_branch_velocity_m_per_s(&self, force_n: f64) -> Result<f64, ContactError> {
        self.check()?;
        positive("the friction force (N)", force_n)?;
        if self.viscous_n_s_per_m == 0.0 {
            return Err(ContactError::NoRisingBranch { force_n, reason: ": it has no viscous part" });
        }
        let lower = self.least_friction_speed_m_per_s();
        let start = if lower == 0.0 { self.static_n } else { self.force_n(lower) };
        if force_n <= start {
            return Err(ContactError::NoRisingBranch { force_n, reason: ", which begins above it" });
        }
        let upper = (force_n - self.coulomb_n.min(self.static_n)) / self.viscous_n_s_per_m * 1.001;
        let excess =
            |velocity: f64| if velocity == 0.0 { start - force_n } else { self.force_n(velocity) - force_n };
        bracketed_root(lower, upper, excess)
            .ok_or(ContactError::NoRoot { what: "the speed on the rising branch" })
    }
}

/// Conversion between motor torque and axial force.
///
/// ```text
///         2π
/// F = T·η·──
///          p
/// ```
///
/// # Units      T in N·m, p in m per turn, F in N
/// # Source     Duan, Eq. 11, second line; there η = P_T = 0.90 is the efficiency of the motor. It holds
///   while the motor drives: torque,
/// velocity and friction have the same sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScrewDrive {
    lead_m: f64,
    efficiency: f64,
}

impl ScrewDrive {
    /// Creates a screw drive from the lead and the motor's efficiency in (0, 1].
    ///
    /// # Errors  a lead that is not positive, an efficiency outside (0, 1].
    pub fn new(lead_m: f64, efficiency: f64) -> Result<ScrewDrive, ContactError> {
        positive("the lead (m)", lead_m)?;
        positive("the efficiency", efficiency)?;
        Ok(ScrewDrive { lead_m, efficiency: within("the efficiency", efficiency, 0.0, 1.0)? })
    }

    /// Computes the axial force (N) of a torque at constant velocity.
    pub fn force_n(&self, torque_nm: f64) -> f64 {
        torque_nm * self.efficiency * TAU / self.lead_m
    }

    /// Computes the torque (N·m) that balances an axial force at constant velocity.
    pub fn torque_nm(&self, force_n: f64) -> f64 {
        force_n * self.lead_m / (TAU * self.efficiency)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::published::{LEAD_M, MOTOR_EFFICIENCY, friction_axis_1, friction_axis_2};

    #[test]
    fn published_eq_11_values() {
        let curve = friction_axis_1();
        assert!((curve.force_n(0.42e-3) - (280.9 + 144.9 * (-1.0_f64).exp() + 3.49 * 0.42)).abs() < 1e-9);
        assert!((curve.force_n(50e-3) - (280.9 + 174.5)).abs() < 1e-9);
        let curve = friction_axis_2();
        assert!((curve.force_n(-50e-3) + (431.4 + 255.0)).abs() < 1e-9);
    }

    #[test]
    fn limit_reversal_is_odd_with_a_jump_of_twice_the_static_friction() {
        for curve in [friction_axis_1(), friction_axis_2()] {
            for velocity in [1e-9, 1e-4, 0.01, 1.0] {
                assert_eq!(curve.force_n(velocity), -curve.force_n(-velocity));
            }
            assert_eq!(curve.force_n(0.0), 0.0);
            assert_eq!(curve.force_n(-0.0), 0.0);
            assert!((curve.force_n(1e-12) - curve.force_n(-1e-12) - 2.0 * curve.static_n).abs() < 1e-6);
        }
    }

    #[test]
    fn limit_least_friction_and_rising_branch() {
        for curve in [
            friction_axis_1(),
            friction_axis_2(),
            StribeckCurve { viscous_n_s_per_m: 1.0, ..friction_axis_1() },
        ] {
            let least = curve.least_friction_speed_m_per_s();
            let force = curve.force_n(least);
            for factor in [0.7, 0.95, 1.05, 1.5] {
                assert!(curve.force_n(least * factor) > force);
            }
            for velocity in [1.001 * least, 0.003, 0.1, 5.0] {
                let found = curve.rising_branch_velocity_m_per_s(curve.force_n(velocity)).unwrap();
                assert!((found / velocity - 1.0).abs() < 1e-9, "{velocity} {found}");
            }
            assert!(matches!(
                curve.rising_branch_velocity_m_per_s(0.99 * force),
                Err(ContactError::NoRisingBranch { .. })
            ));
        }
        let rising = StribeckCurve {
            coulomb_n: 100.0,
            static_n: 90.0,
            viscous_n_s_per_m: 1000.0,
            stribeck_velocity_m_per_s: 1e-3,
        };
        assert_eq!(rising.least_friction_speed_m_per_s(), 0.0);
        assert!((rising.rising_branch_velocity_m_per_s(rising.force_n(0.02)).unwrap() - 0.02).abs() < 1e-12);
        assert_eq!(rising.least_friction_speed_up_to(0.3), 0.0);
        let axis = friction_axis_1();
        let least = axis.least_friction_speed_m_per_s();
        assert_eq!(axis.least_friction_speed_up_to(0.3), least);
        assert_eq!(axis.least_friction_speed_up_to(0.5 * least), 0.5 * least);
        let flat = StribeckCurve { viscous_n_s_per_m: 0.0, ..friction_axis_1() };
        assert_eq!(flat.least_friction_speed_up_to(0.3), 0.3);
        assert!(matches!(
            flat.rising_branch_velocity_m_per_s(500.0),
            Err(ContactError::NoRisingBranch { .. })
        ));
    }

    #[test]
    fn published_torque_is_the_friction() {
        let drive = ScrewDrive::new(LEAD_M, MOTOR_EFFICIENCY).unwrap();
        let torque = drive.torque_nm(280.9);
        assert!((torque - 280.9 * 5e-3 / (TAU * 0.9)).abs() < 1e-15);
        assert!((drive.force_n(-torque) + 280.9).abs() < 1e-10);
        assert!(
            ScrewDrive::new(0.0, 0.9).is_err()
                && ScrewDrive::new(5e-3, 1.2).is_err()
                && ScrewDrive::new(5e-3, 0.0).is_err()
        );
    }

    #[test]
    fn bad_curves_are_refused() {
        let curve = friction_axis_1();
        assert!(StribeckCurve { stribeck_velocity_m_per_s: 0.0, ..curve }.check().is_err());
        assert!(StribeckCurve { coulomb_n: -1.0, ..curve }.check().is_err());
    }
}
