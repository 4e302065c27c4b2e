//! Measured channels and their quantity.

use num_complex::Complex64;

use crate::machine::nuisance::CHANNELS;
use crate::machine::point::Channel;

/// Channels of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
        let count = match self {
            Self::Table => 1,
            Self::Rotor => 2,
            Self::Cross => 3,
            Self::Axial => 6,
        };
        CHANNELS[..count].to_vec()
    }
}

named! {
    /// Quantity of a frequency response.
    pub enum Quantity {
        /// All of them.
        ALL {
            /// Displacement over force.
            Receptance = "receptance",
            /// Velocity over force.
            Mobility = "mobility",
            /// Acceleration over force.
            Accelerance = "accelerance",
        }
    }
}

impl Quantity {
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
