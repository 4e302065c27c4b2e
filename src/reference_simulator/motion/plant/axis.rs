//! The axis in numbers.

use super::friction::Friction;
use super::gap::Contact;
use super::outside::Outside;
use super::wave::{Wave, along};

/// A spring with a dashpot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_m: f64,
}

/// A screw that gets warm and long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Strain when warm.
    pub strain: f64,
    /// Time constant, s.
    pub time_s: f64,
    /// Time for which the axis has been running at the start, s.
    pub begun_s: f64,
    /// Where the screw is held, m.
    pub fixed_m: f64,
}

/// Motor, screw and table in a row. The axis moves between 0 and its stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Masses of motor, screw and table as felt along the travel, kg.
    pub masses_kg: [f64; 3],
    /// Between motor and screw.
    pub coupling: Spring,
    /// Between screw and table.
    pub nut: Contact,
    /// Friction at the motor.
    pub bearing: Friction,
    /// Friction at the table.
    pub guide: Friction,
    /// A constant force that pulls the table back, N.
    pub pull_n: f64,
    /// Force of the motor over its position, N.
    pub cogging: Vec<Wave>,
    /// Relative change of the motor's force over its position.
    pub ripple: Vec<Wave>,
    /// Error of the screw's pitch, m.
    pub pitch: Vec<Wave>,
    /// Growth of the screw.
    pub growth: Growth,
    /// Time by which the scale's word comes late, s.
    pub scale_late_s: f64,
    /// What lies outside every list.
    pub outside: Vec<Outside>,
}

impl Axis {
    /// All masses together, kg.
    pub fn moving_mass_kg(&self) -> f64 {
        self.masses_kg.iter().sum()
    }

    /// The table's position by a scale that stands still: the pitch errs and the screw grows between motor and table.
    pub fn scale_m(&self, position_m: f64, time_s: f64) -> f64 {
        let warm = 1.0 - (-(time_s + self.growth.begun_s) / self.growth.time_s).exp();
        position_m + along(&self.pitch, position_m) + self.growth.strain * warm * (position_m - self.growth.fixed_m)
    }

    /// Error of an encoder's reading at a position, m.
    pub fn reading_error_m(&self, position_m: f64) -> f64 {
        let error = |outside: &Outside| match outside {
            Outside::ScaleCogging { amplitude_m, period_m } => {
                let turn = std::f64::consts::TAU * position_m / period_m;
                amplitude_m * (turn.sin() + 0.4 * (2.0 * turn + 1.0).cos())
            }
            _ => 0.0,
        };
        self.outside.iter().map(error).sum()
    }

    /// What the amplifier makes of a demand, N.
    pub fn amplified(&self, demand_n: f64) -> f64 {
        self.outside.iter().fold(demand_n, |demand, outside| match outside {
            Outside::DeadZone { force_n } => demand - demand.clamp(-force_n, *force_n),
            _ => demand,
        })
    }

    /// Excess of the sliding friction while the oil is cold, over that when it is warm.
    pub fn warmth(&self, time_s: f64) -> f64 {
        self.outside.iter().fold(1.0, |warmth, outside| match outside {
            Outside::RunningIn { rise, time_s: constant } => warmth * (1.0 + rise * (-time_s / constant).exp()),
            _ => warmth,
        })
    }
}
