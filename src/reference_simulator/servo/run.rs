//! A run of an axis along a command.

use std::f64::consts::TAU;

use super::drive::{CURRENT_S, Drive, POSITION_TICKS};
use super::nominal::Axis;
use super::plant::Plant;
use super::sensor::{Record, Sensors};
use crate::draw::Draw;
use crate::motion::drive::quantised;
use crate::{Result, SimulatorError};

/// Sampling period of the records, s: that of the position loop.
pub const RECORD_S: f64 = 1e-3;

/// Integration steps in a current period: 7.8 µs each.
pub(super) const STEPS: usize = 4;

/// An axis with its active drive and its encoder.
pub(super) struct Machine<'a> {
    pub axis: &'a Axis,
    pub plant: Plant,
    pub drive: Drive,
    pub voltage_v: [f64; 2],
    encoder_rad: f64,
}

impl<'a> Machine<'a> {
    /// Creates a machine at rest at zero.
    pub fn at_rest(axis: &'a Axis, sensors: &Sensors) -> Self {
        let encoder_rad = if sensors.encoder_steps > 0.0 { TAU / sensors.encoder_steps } else { 0.0 };
        let drive = Drive::at_rest(&axis.nominal.loops);
        Self { axis, plant: Plant::at_rest(axis), drive, voltage_v: [0.0; 2], encoder_rad }
    }

    /// Returns the motor angle by its encoder, rad.
    pub fn reading_rad(&self) -> f64 {
        quantised(self.plant.motor_rad(), self.encoder_rad)
    }

    /// Advances by one current period.
    pub fn advance(&mut self, command_m: f64, steps: usize) {
        self.voltage_v = self.drive.sample(
            &self.axis.nominal,
            self.axis.missing.lag_s,
            command_m,
            self.reading_rad(),
            self.plant.current_a(),
        );
        for _ in 0..steps {
            self.plant.step(self.axis, CURRENT_S / steps as f64, self.voltage_v);
        }
    }
}

/// Drives an axis along commands, one for each millisecond, from rest at zero, and records it. The seed
/// determines the sensor noise.
///
/// # Errors     `SimulatorError::Refused` for inadmissible parameters of axis or sensors,
///   `SimulatorError::Diverged` for unstable loops.
pub fn run(axis: &Axis, sensors: &Sensors, command_m: &[f64], seed: u64) -> Result<Record> {
    run_in(axis, sensors, command_m, &mut Draw::new(seed), STEPS)
}

/// Runs as [`run`] with a given random source and number of steps in a current period.
pub(super) fn run_in(
    axis: &Axis,
    sensors: &Sensors,
    command_m: &[f64],
    draw: &mut Draw,
    steps: usize,
) -> Result<Record> {
    axis.check()?;
    sensors.check()?;
    let mut machine = Machine::at_rest(axis, sensors);
    let mut record = Record::default();
    // A drive records the mean current of a cycle. At the samples of the position loop, where its demand
    // steps, the current is least.
    let mut mean_a = 0.0;
    for (k, &command) in command_m.iter().enumerate() {
        let (time_s, plant) = (k as f64 * RECORD_S, &machine.plant);
        let table_m = plant.table_m() - plant.table_m_s() * sensors.scale_delay_s;
        // A deviation of one metre from the command means that the loops are unstable.
        if !((table_m - command).abs() < 1.0) {
            return Err(SimulatorError::Diverged { time_s });
        }
        record.time_s.push(time_s);
        record.command_m.push(command);
        record.position_m.push(axis.nominal.ratio_m() * machine.reading_rad());
        record.table_m.push(quantised(table_m + sensors.scale_noise_m * draw.normal(), sensors.scale_step_m));
        record
            .torque_nm
            .push(axis.nominal.torque_constant_nm_a * mean_a + sensors.torque_noise_nm * draw.normal());
        mean_a = 0.0;
        for _ in 0..POSITION_TICKS {
            machine.advance(command, steps);
            mean_a += machine.plant.current_a()[1] / POSITION_TICKS as f64;
        }
    }
    Ok(record)
}
