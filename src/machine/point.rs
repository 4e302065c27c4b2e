//! One coordinate of a machine.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{Role, Value};

/// Name that stands for the ground where a joint names its points.
pub const GROUND: &str = "ground";

/// The kind of a coordinate: displacement (m) or angle (rad).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "MotionFile", rename_all = "lowercase")]
#[schemars(description = "`translation` or `rotation`.")]
pub enum PointMotion {
    /// Displacement along the axis (m); inertia is a mass (kg), stiffness N/m.
    #[schemars(description = "Displacement (m).")]
    Translation,
    /// Angle about the axis (rad); inertia is a moment of inertia (kg·m²), stiffness N·m/rad.
    #[schemars(description = "Angle (rad).")]
    Rotation,
}

/// A named coordinate with its lumped inertia.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Unique name.
    pub name: String,
    /// Displacement or angle.
    pub motion: PointMotion,
    /// Lumped mass (kg) or moment of inertia (kg·m²); zero where there is none.
    pub inertia: Value,
    /// Whether it is fixed to the ground: its coordinate is zero.
    pub fixed: bool,
    /// Origin.
    pub role: Role,
}

impl PointMotion {
    /// Returns the configuration key of the inertia of such a point.
    pub fn inertia_key(self) -> &'static str {
        match self {
            PointMotion::Translation => "mass_kg",
            PointMotion::Rotation => "inertia_kg_m2",
        }
    }

    /// Returns the noun for messages.
    pub fn noun(self) -> &'static str {
        match self {
            PointMotion::Translation => "translation",
            PointMotion::Rotation => "rotation",
        }
    }
}
