//! Configuration sections of the changes that an effect makes to numbers.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::{MachineError, Rescale, Target};

/// A number that an effect changes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RescaleFile {
    part: PartFile,
    /// Name of the point, joint or shaft.
    #[serde(default)]
    name: String,
    /// Key of the number of friction, lead error or drive.
    #[serde(default)]
    key: String,
    #[serde(alias = "law")]
    modifier: Rescale,
    by: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum PartFile {
    PointInertia,
    JointStiffness,
    JointDamping,
    JointLossFactor,
    JointIntegralRate,
    JointGap,
    JointFriction,
    JointLeadError,
    ShaftDiameter,
    ShaftBore,
    ShaftLossFactor,
    ShaftYoungsModulus,
    ShaftModulus,
    ShaftShearModulus,
    NutPosition,
    Drive,
    ChainGain,
    ChainDelay,
    ChainPower,
}

impl RescaleFile {
    /// Returns the number, the modifier and the parameter.
    pub fn rescale(self) -> Result<(Target, Rescale, String), MachineError> {
        let has_keys = [PartFile::JointFriction, PartFile::JointLeadError, PartFile::Drive].contains(&self.part);
        if has_keys == self.key.is_empty() {
            let remedy = if has_keys { "name the number with key = \"…\"" } else { "this part is one number; leave key out" };
            return Err(fault(format!("rescale by {}", self.by), remedy));
        }
        let target = match self.part {
            PartFile::PointInertia => Target::PointInertia(self.name),
            PartFile::JointStiffness => Target::JointStiffness(self.name),
            PartFile::JointDamping => Target::JointDamping(self.name),
            PartFile::JointLossFactor => Target::JointLossFactor(self.name),
            PartFile::JointIntegralRate => Target::JointIntegralRate(self.name),
            PartFile::JointGap => Target::Gap(self.name),
            PartFile::JointFriction => Target::Friction(self.name, self.key),
            PartFile::JointLeadError => Target::LeadError(self.name, self.key),
            PartFile::ShaftDiameter => Target::ShaftDiameter(self.name),
            PartFile::ShaftBore => Target::ShaftBore(self.name),
            PartFile::ShaftLossFactor => Target::ShaftLossFactor(self.name),
            PartFile::ShaftYoungsModulus => Target::ShaftYoungsModulus(self.name),
            PartFile::ShaftModulus => Target::ShaftModulus(self.name),
            PartFile::ShaftShearModulus => Target::ShaftShearModulus(self.name),
            PartFile::NutPosition => Target::NutPosition(self.name),
            PartFile::Drive => Target::Drive(self.key),
            PartFile::ChainGain => Target::ChainGain,
            PartFile::ChainDelay => Target::ChainDelay,
            PartFile::ChainPower => Target::ChainPower,
        };
        Ok((target, self.modifier, self.by))
    }
}
