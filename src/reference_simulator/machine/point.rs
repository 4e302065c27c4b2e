//! Points of excitation and response.

use serde::{Deserialize, Serialize};

/// A point of response or excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Point {
    /// Worktable, along the axis.
    Table,
    /// Rotor of the drive, angle.
    Rotor,
    /// Screw end at the left bearing, axial.
    Left,
    /// Screw at the nut, axial.
    Screw,
    /// Screw end at the right bearing, axial.
    Right,
    /// Body of the nut, axial.
    NutBody,
    /// Housing of the left bearing, axial.
    HousingLeft,
    /// Housing of the right bearing, axial.
    HousingRight,
}

impl Point {
    /// Returns the name in machine descriptions. The engineer's model has no point for the nut body and the housings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Table => "table",
            Self::Rotor => "rotor",
            Self::Left => "left",
            Self::Screw => "screw",
            Self::Right => "right",
            Self::NutBody => "nut-body",
            Self::HousingLeft => "housing-left",
            Self::HousingRight => "housing-right",
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
