//! Measured channels and their quantity.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::machine::point::{Channel, Point};

/// Channels of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChannelSet {
    /// The table is excited and measured.
    Table,
    /// In addition, the rotor is excited and measured.
    Rotor,
    /// In addition, the rotor's response to excitation of the table.
    Cross,
    /// In addition, the screw at nut and bearings, axial, with excitation of the table.
    Axial,
}

impl ChannelSet {
    /// All sets, in the order of their number of channels.
    pub const ALL: [Self; 4] = [Self::Table, Self::Rotor, Self::Cross, Self::Axial];

    /// Returns the channels, the table first.
    pub fn channels(self) -> Vec<Channel> {
        let all = [
            Channel::direct(Point::Table),
            Channel::direct(Point::Rotor),
            Channel::new(Point::Rotor, Point::Table),
            Channel::new(Point::Screw, Point::Table),
            Channel::new(Point::Left, Point::Table),
            Channel::new(Point::Right, Point::Table),
        ];
        let count = match self {
            Self::Table => 1,
            Self::Rotor => 2,
            Self::Cross => 3,
            Self::Axial => 6,
        };
        all[..count].to_vec()
    }
}

/// Quantity of a frequency response.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Displacement over force.
    Receptance,
    /// Velocity over force.
    Mobility,
    /// Acceleration over force.
    Accelerance,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 3] = [Self::Receptance, Self::Mobility, Self::Accelerance];

    /// Returns the name in a manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Receptance => "receptance",
            Self::Mobility => "mobility",
            Self::Accelerance => "accelerance",
        }
    }

    /// Returns the factor from receptance at a frequency.
    pub fn factor(self, frequency_hz: f64) -> Complex64 {
        let s = Complex64::new(0.0, 2.0 * std::f64::consts::PI * frequency_hz);
        match self {
            Self::Receptance => Complex64::ONE,
            Self::Mobility => s,
            Self::Accelerance => s * s,
        }
    }
}
