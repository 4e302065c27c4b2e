//! Parameters of the axis.

use super::friction::Friction;
use super::gap::Contact;
use super::outside::UnlistedEffect;
use super::wave::{Wave, wave_sum};

/// A spring with a dashpot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_m: f64,
}

/// Thermal expansion of the screw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalExpansion {
    /// Strain of the warm screw.
    pub strain: f64,
    /// Time constant, s.
    pub time_s: f64,
    /// Time of operation before the start of the record, s.
    pub elapsed_s: f64,
    /// Position of the fixed bearing, m.
    pub fixed_m: f64,
}

/// Motor, screw and table in series. The axis moves between 0 and its stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Masses of motor, screw and table, reduced to the travel, kg.
    pub masses_kg: [f64; 3],
    /// Between motor and screw.
    pub coupling: Spring,
    /// Between screw and table.
    pub nut: Contact,
    /// Friction at the motor.
    pub bearing: Friction,
    /// Friction at the table.
    pub guide: Friction,
    /// Constant force that pulls the table back, N.
    pub pull_n: f64,
    /// Cogging force of the motor over its position, N.
    pub cogging: Vec<Wave>,
    /// Relative ripple of the motor force over its position.
    pub ripple: Vec<Wave>,
    /// Error of the screw's lead along the travel, m.
    pub pitch: Vec<Wave>,
    /// Thermal expansion of the screw.
    pub thermal_expansion: ThermalExpansion,
    /// Delay of the scale's reading, s.
    pub scale_delay_s: f64,
    /// Unlisted effects.
    pub unlisted: Vec<UnlistedEffect>,
}

impl Axis {
    /// Returns the sum of all masses, kg.
    pub fn moving_mass_kg(&self) -> f64 {
        self.masses_kg.iter().sum()
    }

    /// Returns the table position by a stationary scale: lead error and thermal expansion act between motor
    /// and table.
    pub fn scale_m(&self, position_m: f64, time_s: f64) -> f64 {
        let warm = 1.0 - (-(time_s + self.thermal_expansion.elapsed_s) / self.thermal_expansion.time_s).exp();
        position_m
            + wave_sum(&self.pitch, position_m)
            + self.thermal_expansion.strain * warm * (position_m - self.thermal_expansion.fixed_m)
    }

    /// Returns the error of an encoder's reading at a position, m.
    pub fn reading_error_m(&self, position_m: f64) -> f64 {
        let error = |unlisted: &UnlistedEffect| match unlisted {
            UnlistedEffect::ScaleCogging { amplitude_m, period_m } => {
                let turn = std::f64::consts::TAU * position_m / period_m;
                amplitude_m * (turn.sin() + 0.4 * (2.0 * turn + 1.0).cos())
            }
            _ => 0.0,
        };
        self.unlisted.iter().map(error).sum()
    }

    /// Returns the force of the amplifier for a demand, N.
    pub fn amplified(&self, demand_n: f64) -> f64 {
        self.unlisted.iter().fold(demand_n, |demand, unlisted| match unlisted {
            UnlistedEffect::DeadZone { force_n } => demand - demand.clamp(-force_n, *force_n),
            _ => demand,
        })
    }

    /// Returns the factor on the sliding friction while the oil is cold; 1 when it is warm.
    pub fn oil_factor(&self, time_s: f64) -> f64 {
        self.unlisted.iter().fold(1.0, |oil_factor, unlisted| match unlisted {
            UnlistedEffect::RunningIn { excess, time_s: constant } => {
                oil_factor * (1.0 + excess * (-time_s / constant).exp())
            }
            _ => oil_factor,
        })
    }
}
