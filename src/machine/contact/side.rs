//! One nut or bearing under axial load.

use schemars::JsonSchema;
use serde::Deserialize;

use super::ContactError;
use super::error::{check_pressure, positive};

/// Which stiffness of a nonlinear load–deflection curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "StiffnessFile", rename_all = "lowercase")]
#[schemars(description = "Which stiffness of a contact counts.")]
pub enum Stiffness {
    /// Slope dP/dδ = 3/2·P/δ, which applies to small vibrations: vertical, Eq. 4, 13.
    #[schemars(description = "dP/dδ.")]
    Tangent,
    /// Load over deflection, P/δ: Duan, Eq. 9, 13, 16, 19.
    #[schemars(description = "P/δ.")]
    Secant,
}

impl Stiffness {
    /// Returns the factor on P/δ for δ ∝ P^(2/3).
    pub(super) fn factor(self) -> f64 {
        match self {
            Stiffness::Secant => 1.0,
            Stiffness::Tangent => 1.5,
        }
    }
}

/// One nut, one bearing, or several in tandem under the same axial load: δ = c·P^(2/3).
///
/// # Units      c in m/N^(2/3), P in N, δ in m
/// # Source     Duan, Eq. 9 (c = M₁·N^(−2/3)·(sin β·cos λ)^(−5/3)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// c (m/N^(2/3)).
    compliance: f64,
    /// Largest contact pressure over the cube root of the axial load (Pa/N^(1/3)); 0 where the contacts are
    /// unknown.
    pressure: f64,
    /// Largest pressure allowed (Pa).
    pressure_limit_pa: f64,
}

impl Side {
    /// Creates a side from contacts: c, the pressure at an axial load of 1 N, and the pressure limit.
    pub(super) fn of_contacts(compliance: f64, pressure: f64, pressure_limit_pa: f64) -> Side {
        Side { compliance, pressure, pressure_limit_pa }
    }

    /// Creates a side from one point of a catalogue or a measurement: the deflection under a load. Contact
    /// pressures are unknown and not checked.
    ///
    /// # Errors  a load or deflection that is not positive.
    pub fn from_point(load_n: f64, deflection_m: f64) -> Result<Side, ContactError> {
        positive("the load of the known point (N)", load_n)?;
        positive("the deflection of the known point (m)", deflection_m)?;
        Ok(Side {
            compliance: deflection_m / two_thirds(load_n),
            pressure: 0.0,
            pressure_limit_pa: f64::INFINITY,
        })
    }

    /// Combines several of these sides in tandem with equal loads: c·n^(−2/3).
    ///
    /// # Errors  a count of zero.
    pub fn tandem(&self, count: usize) -> Result<Side, ContactError> {
        let count = positive("the number of nuts or bearings in tandem", count as f64)?;
        Ok(Side {
            compliance: self.compliance / two_thirds(count),
            pressure: self.pressure / count.cbrt(),
            ..*self
        })
    }

    /// Replaces the limit of the contact pressure; infinity disables the check.
    pub fn with_pressure_limit_pa(self, pressure_limit_pa: f64) -> Side {
        Side { pressure_limit_pa, ..self }
    }

    /// Returns c (m/N^(2/3)).
    pub fn compliance_m_per_two_thirds_n(&self) -> f64 {
        self.compliance
    }

    /// Returns the axial load (N) at which the contact pressure reaches its limit; infinite where the
    /// contacts are unknown.
    pub fn load_limit_n(&self) -> f64 {
        if self.pressure > 0.0 { (self.pressure_limit_pa / self.pressure).powi(3) } else { f64::INFINITY }
    }

    /// Returns the load if the formula holds there.
    ///
    /// # Errors  a load that is not positive; [`ContactError::BeyondValidity`] above the pressure limit.
    pub fn check_load_n(&self, load_n: f64) -> Result<f64, ContactError> {
        positive("the axial load of a nut or bearing (N)", load_n)?;
        check_pressure(self.pressure * load_n.cbrt(), self.pressure_limit_pa)?;
        Ok(load_n)
    }

    /// Computes the axial deflection (m).
    ///
    /// # Errors  see [`Side::check_load_n`].
    pub fn deflection_m(&self, load_n: f64) -> Result<f64, ContactError> {
        Ok(self.deflection(self.check_load_n(load_n)?))
    }

    /// Computes the axial load (N) for a deflection.
    ///
    /// # Errors  a deflection that is not positive; a load that [`Side::check_load_n`] rejects.
    pub fn load_n(&self, deflection_m: f64) -> Result<f64, ContactError> {
        let ratio = positive("the axial deflection (m)", deflection_m)? / self.compliance;
        self.check_load_n(ratio * ratio.sqrt())
    }

    /// Computes the axial stiffness (N/m).
    ///
    /// # Errors  see [`Side::check_load_n`].
    pub fn stiffness_n_per_m(&self, load_n: f64, stiffness: Stiffness) -> Result<f64, ContactError> {
        Ok(self.stiffness(self.check_load_n(load_n)?, stiffness))
    }

    /// Computes the deflection under a load ≥ 0, unchecked.
    pub(super) fn deflection(&self, load_n: f64) -> f64 {
        self.compliance * two_thirds(load_n)
    }

    /// Computes the stiffness under a load ≥ 0, unchecked; 0 without load.
    pub(super) fn stiffness(&self, load_n: f64, stiffness: Stiffness) -> f64 {
        stiffness.factor() * load_n.cbrt() / self.compliance
    }
}

/// Computes x^(2/3).
pub(super) fn two_thirds(x: f64) -> f64 {
    x.cbrt().powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_tandem_is_parallel_springs() {
        let one = Side::from_point(1000.0, 1e-5).unwrap();
        let three = one.tandem(3).unwrap();
        assert!(
            (three.deflection_m(3000.0).unwrap() / one.deflection_m(1000.0).unwrap() - 1.0).abs() < 1e-14
        );
        for kind in [Stiffness::Secant, Stiffness::Tangent] {
            let (single, set) = (
                one.stiffness_n_per_m(1000.0, kind).unwrap(),
                three.stiffness_n_per_m(3000.0, kind).unwrap(),
            );
            assert!((set / (3.0 * single) - 1.0).abs() < 1e-14);
        }
        assert!(one.tandem(0).is_err());
    }

    #[test]
    fn limit_pressure_limit_is_the_load_limit() {
        let side = Side::of_contacts(1e-7, 2e8, 4.2e9);
        let limit = side.load_limit_n();
        assert!((limit - 21.0_f64.powi(3)).abs() < 1e-8);
        assert!(side.deflection_m(limit * (1.0 - 1e-9)).is_ok());
        assert!(matches!(side.deflection_m(limit * (1.0 + 1e-9)), Err(ContactError::BeyondValidity { .. })));
        assert!(side.with_pressure_limit_pa(f64::INFINITY).deflection_m(1e9).is_ok());
        assert!((side.tandem(2).unwrap().load_limit_n() / (2.0 * limit) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bad_points_are_named() {
        assert!(Side::from_point(0.0, 1e-5).is_err());
        assert!(Side::from_point(10.0, f64::NAN).is_err());
        let side = Side::from_point(10.0, 1e-6).unwrap();
        assert_eq!(side.load_limit_n(), f64::INFINITY);
        assert!(side.deflection_m(0.0).is_err());
        assert!(side.load_n(-1e-6).is_err());
        assert!((side.load_n(1e-6).unwrap() / 10.0 - 1.0).abs() < 1e-14);
    }
}
