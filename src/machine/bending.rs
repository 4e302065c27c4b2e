//! Lateral bending of a shaft whose nut is loaded off the axis.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{NumberSource, Value};

/// Lateral bending of a shaft between two bearings at its ends, as the nut feels it: a force of the nut acts
/// with a misalignment a on the shaft's deflection y, and with an eccentricity e on its slope θ; the nut
/// moves by a·y + e·θ.
#[derive(Debug, Clone, PartialEq)]
pub struct Bending {
    /// Point (index) of that displacement.
    pub point: usize,
    /// Misalignment a (rad).
    pub misalignment: Value,
    /// Eccentricity e (m).
    pub eccentricity: Value,
    /// Lateral stiffness of the nut (N/m).
    pub lateral_stiffness: Value,
    /// Rotational stiffness of the left and of the right bearing over E·I/L: 0 is a hinge.
    pub clamping: [Value; 2],
    /// Loss factor of the bending stiffness, as that of a joint.
    pub loss_factor: Value,
}

/// Lateral bending of a shaft.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BendingFile {
    pub(super) shaft: String,
    /// Point that moves by the misalignment times the deflection and the eccentricity times the slope at the
    /// nut.
    pub(super) point: String,
    /// Misalignment of the nut's force (rad); 0 where it is absent.
    pub(super) misalignment: Option<NumberSource>,
    /// Eccentricity of the nut's force (m).
    pub(super) eccentricity_m: NumberSource,
    /// Lateral stiffness of the nut (N/m).
    pub(super) lateral_stiffness: NumberSource,
    /// Rotational stiffness of the bearings over E·I/L: 0 is a hinge.
    pub(super) clamping: [NumberSource; 2],
    /// As in a joint.
    pub(super) loss_factor: Option<NumberSource>,
}
