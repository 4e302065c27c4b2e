//! Kinds of numbers that a patch can change.

use schemars::JsonSchema;
use serde::Deserialize;

use super::schema::enum_without_descriptions;

/// Kinds of numbers that a patch can change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "PartFile", rename_all = "kebab-case")]
#[schemars(transform = enum_without_descriptions)]
pub enum TargetKind {
    /// Inertia of a point.
    PointInertia,
    /// Stiffness of a joint.
    JointStiffness,
    /// Damping of a joint.
    JointDamping,
    /// Loss factor of a joint.
    JointLossFactor,
    /// Integral action of a joint.
    JointIntegralRate,
    /// Backlash of a joint.
    JointGap,
    /// Friction of a joint; the target's key names the number.
    JointFriction,
    /// Lead error of a joint; the target's key names the number.
    JointLeadError,
    /// Diameter of a shaft.
    ShaftDiameter,
    /// Bore ratio of a shaft.
    ShaftBore,
    /// Loss factor of a shaft.
    ShaftLossFactor,
    /// Young's modulus alone of a shaft.
    ShaftYoungsModulus,
    /// Young's modulus of a shaft, and with it the shear modulus.
    ShaftModulus,
    /// Shear modulus alone of a shaft.
    ShaftShearModulus,
    /// Nut position on a shaft.
    NutPosition,
    /// The drive; the target's key names the number.
    Drive,
    /// Gain of the measuring chain.
    ChainGain,
    /// Delay of the measuring chain.
    ChainDelay,
    /// Power of iω by which the recorded quantity differs from the stated one.
    ChainPower,
    /// Share of dispersion of all loss factors; only tolerances change it.
    #[serde(skip)]
    LossDispersion,
}
