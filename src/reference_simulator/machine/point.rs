//! Where a machine can be struck and measured.

use serde::{Deserialize, Serialize};

/// A place of response or excitation.
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
    /// Name as in machine descriptions; those of nut body and housings are not points of the engineer's model.
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
    /// What is measured.
    pub response: Point,
    /// What is struck.
    pub excitation: Point,
}

impl Channel {
    /// A channel.
    pub fn new(response: Point, excitation: Point) -> Self {
        Self { response, excitation }
    }

    /// Both ends at one point.
    pub fn direct(point: Point) -> Self {
        Self::new(point, point)
    }
}
