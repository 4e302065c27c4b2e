//! Sensors of an axis: scale, encoder and torque channel.

use super::nominal::{check_values, with_names};
use crate::Result;

/// Sensors of an axis; each error is absent where its size is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// Steps of the motor encoder per revolution; 0 for a perfect one. It closes the loops.
    pub encoder_steps: f64,
    /// Standard deviation of the noise of the scale at the table, m.
    pub scale_noise_m: f64,
    /// Step of the scale, m.
    pub scale_step_m: f64,
    /// Delay of the scale's reading, s.
    pub scale_delay_s: f64,
    /// Standard deviation of the noise of the torque channel, N·m.
    pub torque_noise_nm: f64,
}

impl Default for Sensors {
    /// Returns usual sizes of the errors.
    fn default() -> Self {
        Self {
            encoder_steps: 1_048_576.0,
            scale_noise_m: 0.1e-6,
            scale_step_m: 50e-9,
            scale_delay_s: 10e-6,
            torque_noise_nm: 0.05,
        }
    }
}

impl Sensors {
    /// Returns sensors without errors.
    pub fn perfect() -> Self {
        Self {
            encoder_steps: 0.0,
            scale_noise_m: 0.0,
            scale_step_m: 0.0,
            scale_delay_s: 0.0,
            torque_noise_nm: 0.0,
        }
    }

    /// Checks that every parameter is admissible.
    ///
    /// # Errors     `SimulatorError::Refused` names the first inadmissible parameter.
    pub fn check(&self) -> Result<()> {
        let numbers = with_names! {
            self.encoder_steps, self.scale_noise_m, self.scale_step_m, self.scale_delay_s, self.torque_noise_nm
        };
        check_values(&numbers, "zero or a positive number", |value| value >= 0.0)
    }
}

/// A recorded run, one row for each millisecond.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Command, m.
    pub command_m: Vec<f64>,
    /// Motor encoder times lead/2π, m: the position that closes the loops.
    pub position_m: Vec<f64>,
    /// Scale at the table, m.
    pub table_m: Vec<f64>,
    /// Torque constant times the mean i_q of the millisecond before, N·m.
    pub torque_nm: Vec<f64>,
}
