//! The measuring chain between what happens and what is recorded.

use num_complex::Complex64;

use super::{Operating, Value};

/// What a measuring chain makes of an FRF: H_recorded = g·e^{−iωτ}·(iω)^p·H, with H between the places where sensor and hammer sit.
///
/// Its values are those of a perfect chain unless an effect says otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Gain g; 1 for a perfect chain.
    pub gain: Value,
    /// Delay τ of the response against the excitation (s); 0 for a perfect chain.
    pub delay: Value,
    /// Power p by which the recorded quantity differs from the one stated; 0 where it is the one stated.
    pub power: Value,
    /// Arms on which sensor and hammer sit; none where they sit at the points themselves.
    pub levers: Vec<Lever>,
}

/// Arms on which sensor and hammer sit: what is read at a point is x_point + r·x_on, and a blow there, with an arm of its own, acts on both motions.
///
/// # Source  rigid-body kinematics of small rotations: a sensor at the height h over the centre of a body that turns by φ moves by x + h·φ; the
/// blow's generalised forces follow from virtual work.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever {
    /// The point (by index) at which the data are said to be taken.
    pub point: usize,
    /// The point (by index) whose motion is felt there, too.
    pub on: usize,
    /// r of the sensor; for two translations without unit.
    pub read: Value,
    /// The same of the hammer.
    pub struck: Value,
}

impl Default for Chain {
    fn default() -> Self {
        Chain { gain: Value::number(1.0), delay: Value::number(0.0), power: Value::number(0.0), levers: Vec::new() }
    }
}

impl Chain {
    /// Its numbers (g, τ, p) for the given parameters.
    pub fn at(&self, parameters: &[f64], operating: &Operating) -> (f64, f64, f64) {
        (self.gain.at(parameters, operating), self.delay.at(parameters, operating), self.power.at(parameters, operating))
    }

    /// ln(H_recorded/H) of its numbers at a frequency.
    pub fn log_factor((gain, delay_s, power): (f64, f64, f64), omega_rad_s: f64) -> Complex64 {
        // A plain chain costs no logarithm: this is asked line by line.
        let log_gain = if gain == 1.0 { 0.0 } else { gain.ln() };
        let log_power = if power == 0.0 { 0.0 } else { power * omega_rad_s.ln() };
        Complex64::new(log_gain + log_power, -omega_rad_s * delay_s + power * std::f64::consts::FRAC_PI_2)
    }
}
