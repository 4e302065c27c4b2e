//! The quantity of an FRF: displacement, velocity or acceleration over force.

use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Response over force, by the derivative of the response (ISO 7626-1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// Displacement / force (m/N).
    Receptance,
    /// Velocity / force ((m/s)/N): iω times the receptance.
    Mobility,
    /// Acceleration / force ((m/s²)/N): −ω² times the receptance.
    Accelerance,
}

impl Quantity {
    /// Returns the power p of iω that converts a receptance to this quantity.
    pub fn power(self) -> i32 {
        match self {
            Quantity::Receptance => 0,
            Quantity::Mobility => 1,
            Quantity::Accelerance => 2,
        }
    }

    /// Returns the factor (iω)^p that converts a receptance to this quantity.
    pub fn from_receptance(self, omega_rad_s: f64) -> Complex64 {
        Complex64::new(0.0, omega_rad_s).powi(self.power())
    }

    /// Returns (iω + σ)^p/(iω)^p: its factor on a receptance under an exponential window of decay rate σ over
    /// that without one.
    pub fn windowed(self, window_per_s: f64, omega_rad_s: f64) -> Complex64 {
        Complex64::new(1.0, -window_per_s / omega_rad_s).powi(self.power())
    }

    /// Returns its name, as in manifests and on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::Receptance => "receptance",
            Quantity::Mobility => "mobility",
            Quantity::Accelerance => "accelerance",
        }
    }

    /// Returns its unit for a translational response to a force.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Receptance => "m/N",
            Quantity::Mobility => "(m/s)/N",
            Quantity::Accelerance => "(m/s²)/N",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_accelerance_is_minus_omega_squared_receptance() {
        let factor = Quantity::Accelerance.from_receptance(3.0);
        assert!((factor - Complex64::new(-9.0, 0.0)).norm() < 1e-14);
        assert!((Quantity::Mobility.from_receptance(3.0) - Complex64::new(0.0, 3.0)).norm() < 1e-14);
    }
}
