//! What scale, encoder and torque channel make of an axis.

use super::nominal::refuse;
use crate::TruthError;

/// Sensors of an axis; each nuisance is off where its size is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// Steps of the motor's encoder per turn; 0 for a perfect one. It closes the loops.
    pub encoder_steps: f64,
    /// Standard deviation of the scale at the table, m.
    pub scale_noise_m: f64,
    /// Step of the scale, m.
    pub scale_step_m: f64,
    /// How late the scale is read, s.
    pub scale_late_s: f64,
    /// Standard deviation of the torque channel, N·m.
    pub torque_noise_nm: f64,
}

impl Default for Sensors {
    /// The usual sizes.
    fn default() -> Self {
        Self { encoder_steps: 1_048_576.0, scale_noise_m: 0.1e-6, scale_step_m: 50e-9, scale_late_s: 10e-6, torque_noise_nm: 0.05 }
    }
}

impl Sensors {
    /// Sensors without errors.
    pub fn perfect() -> Self {
        Self { encoder_steps: 0.0, scale_noise_m: 0.0, scale_step_m: 0.0, scale_late_s: 0.0, torque_noise_nm: 0.0 }
    }

    /// Refuses numbers that no sensor has.
    ///
    /// # Errors     `TruthError::Refused` names the first one.
    pub fn check(&self) -> Result<(), TruthError> {
        let numbers = [
            ("encoder_steps", self.encoder_steps),
            ("scale_noise_m", self.scale_noise_m),
            ("scale_step_m", self.scale_step_m),
            ("scale_late_s", self.scale_late_s),
            ("torque_noise_nm", self.torque_noise_nm),
        ];
        refuse(&numbers, "zero or a positive number", |value| value >= 0.0)
    }
}

/// A value on a grid; as it is for a grid of none.
pub(super) fn stepped(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

/// A run, one row for each millisecond.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Command, m.
    pub command_m: Vec<f64>,
    /// Motor's encoder times lead/2π, m: what closes the loops.
    pub position_m: Vec<f64>,
    /// Scale at the table, m.
    pub table_m: Vec<f64>,
    /// Torque constant times i_q, N·m.
    pub torque_nm: Vec<f64>,
}
