//! The measuring chain between the actual and the recorded FRF.

use num_complex::Complex64;

use super::{Operating, Value};

/// The measuring chain of an FRF: H_recorded = g·e^{−iωτ}·(iω)^p·H, with H between the locations of sensor
/// and hammer.
///
/// Its values are those of a perfect chain unless an effect changes them.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Gain g; 1 for a perfect chain.
    pub gain: Value,
    /// Delay τ of the response relative to the excitation (s); 0 for a perfect chain.
    pub delay: Value,
    /// Power p of iω by which the recorded quantity differs from the stated one; 0 where they agree.
    pub power: Value,
    /// Lever arms of sensor and hammer; none where they are mounted at the points themselves.
    pub levers: Vec<Lever>,
}

/// Lever arms of sensor and hammer.
///
/// The sensor at a point reads x_point + r·x_on. A blow there acts on both motions, with an arm of its own.
///
/// # Source  rigid-body kinematics of small rotations: a sensor at the height h above the centre of a body
///   that rotates by φ moves by x +
/// h·φ; the generalised forces of the blow follow from virtual work.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever {
    /// The point (by index) at which the data are stated to be taken.
    pub point: usize,
    /// The point (by index) whose motion adds to it.
    pub on: usize,
    /// r of the sensor; dimensionless between two translations.
    pub sensor_arm: Value,
    /// r of the hammer.
    pub hammer_arm: Value,
}

impl Default for Chain {
    fn default() -> Self {
        Chain {
            gain: Value::number(1.0),
            delay: Value::number(0.0),
            power: Value::number(0.0),
            levers: Vec::new(),
        }
    }
}

impl Chain {
    /// Returns its numbers (g, τ, p) for the given parameters.
    pub fn at(&self, parameters: &[f64], operating: &Operating) -> (f64, f64, f64) {
        (
            self.gain.at(parameters, operating),
            self.delay.at(parameters, operating),
            self.power.at(parameters, operating),
        )
    }

    /// Returns ln(H_recorded/H) at a frequency, from the numbers of [`Chain::at`].
    pub fn log_factor((gain, delay_s, power): (f64, f64, f64), omega_rad_s: f64) -> Complex64 {
        // A perfect chain skips the logarithms: this runs for every frequency line.
        let log_gain = if gain == 1.0 { 0.0 } else { gain.ln() };
        let log_power = if power == 0.0 { 0.0 } else { power * omega_rad_s.ln() };
        Complex64::new(log_gain + log_power, -omega_rad_s * delay_s + power * std::f64::consts::FRAC_PI_2)
    }
}
