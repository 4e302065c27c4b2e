//! Points, shafts, joints and lever arms that a patch adds.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::{MachineError, fault};
use super::{FrictionForceFile, LeadErrorFile, NumberSource, PointMotion, Role, StationPlace};

/// A point that a patch adds.
#[derive(Debug, Clone, PartialEq)]
pub struct PointPatch {
    /// Unique name.
    pub name: String,
    /// Displacement or angle.
    pub motion: PointMotion,
    /// Mass (kg) or moment of inertia (kg·m²).
    pub inertia: NumberSource,
    /// Whether it is fixed to the ground.
    pub fixed: bool,
    /// Origin.
    pub role: Role,
}

/// A shaft.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShaftFile {
    pub(super) name: String,
    pub(super) length_m: NumberSource,
    pub(super) diameter_m: NumberSource,
    /// Bore diameter divided by outer diameter of a hollow shaft; solid where it is absent.
    pub(super) bore_ratio: Option<NumberSource>,
    pub(super) youngs_modulus_pa: NumberSource,
    pub(super) shear_modulus_pa: NumberSource,
    pub(super) density_kg_m3: NumberSource,
    /// η of the material: the moduli are multiplied by 1 + η·(i + s·2/π·ln(ω/ω₀)), as in a joint.
    pub(super) loss_factor: Option<NumberSource>,
    pub(super) station: Vec<StationFile>,
}

#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StationFile {
    at: Option<PlaceName>,
    at_m: Option<f64>,
    pub(super) axial: Option<String>,
    pub(super) torsion: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "PlaceFile", rename_all = "lowercase")]
enum PlaceName {
    Start,
    Nut,
    End,
}

impl ShaftFile {
    /// Returns the places of its stations.
    ///
    /// # Errors  a station gives neither or both of name and distance.
    pub fn locations(&self) -> Result<Vec<StationPlace>, MachineError> {
        let place = |station: &StationFile| match (station.at, station.at_m) {
            (Some(PlaceName::Start), None) => Ok(StationPlace::At(0.0)),
            (Some(PlaceName::Nut), None) => Ok(StationPlace::Nut),
            (Some(PlaceName::End), None) => Ok(StationPlace::End),
            (None, Some(distance_m)) => Ok(StationPlace::At(distance_m)),
            _ => {
                let remedy = "write either at = \"start\", \"nut\" or \"end\", or at_m = a distance";
                Err(fault(format!("shaft.{}.station", self.name), remedy))
            }
        };
        self.station.iter().map(place).collect()
    }
}

/// A joint that a patch adds; fields as in [`Joint`](super::Joint).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointPatch {
    /// Unique name.
    pub name: String,
    /// Point names and coefficients.
    pub on: Vec<(String, f64)>,
    /// Points of the same kind: all translations, or all rotations.
    pub alike: Vec<String>,
    /// Points that must be rotations.
    pub angles: Vec<String>,
    /// k.
    pub stiffness: NumberSource,
    /// c.
    pub damping: NumberSource,
    /// η.
    pub loss_factor: NumberSource,
    /// ω_i.
    pub integral_rate: NumberSource,
    /// Relaxation stiffness in series with the damper.
    pub relaxation_stiffness: Option<NumberSource>,
    /// Friction.
    pub friction: FrictionForceFile,
    /// Backlash.
    pub gap: NumberSource,
    /// Lead error.
    pub lead_error: LeadErrorFile,
}

/// A lever arm of sensor and hammer.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeverFile {
    /// The point at which the data are stated to be taken.
    pub(super) at: String,
    /// The point whose motion adds to it.
    pub(super) with: String,
    /// Share of that motion in the sensor's reading.
    pub(super) read: NumberSource,
    /// Share of the hammer's force that acts on that motion.
    pub(super) struck: NumberSource,
}
