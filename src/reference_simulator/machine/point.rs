//! Points of excitation and response.

use serde::{Deserialize, Serialize};

named! {
    /// A point of response or excitation.
    pub enum Point {
        /// All of them.
        ALL {
            /// Worktable, along the axis.
            Table = "table",
            /// Rotor of the drive, angle.
            Rotor = "rotor",
            /// Screw end at the left bearing, axial.
            Left = "left",
            /// Screw at the nut, axial.
            Screw = "screw",
            /// Screw end at the right bearing, axial.
            Right = "right",
            /// Body of the nut, axial.
            NutBody = "nut-body",
            /// Housing of the left bearing, axial.
            HousingLeft = "housing-left",
            /// Housing of the right bearing, axial.
            HousingRight = "housing-right",
        }
    }
}

/// One response under one excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Channel {
    /// Measured point.
    pub response: Point,
    /// Excited point.
    pub excitation: Point,
}

impl Channel {
    /// Creates a channel.
    pub fn new(response: Point, excitation: Point) -> Self {
        Self { response, excitation }
    }

    /// Creates a channel with response and excitation at one point.
    pub fn direct(point: Point) -> Self {
        Self::new(point, point)
    }
}
