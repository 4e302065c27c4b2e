//! The words of a configuration file for what an effect does to a number.

use schemars::JsonSchema;
use serde::Deserialize;

use machine::{Rescale, Target};

/// A number that an effect scales.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RescaleFile {
    part: PartFile,
    /// Of point, joint or shaft.
    #[serde(default)]
    name: String,
    /// Which number of friction, lead error or drive.
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
    ShaftModulus,
    ShaftShearModulus,
    Drive,
    ChainGain,
    ChainDelay,
    ChainPower,
}

impl RescaleFile {
    /// Which number, how, by which parameter.
    pub fn rescale(self) -> Result<(Target, Rescale, String), String> {
        let has_keys = [PartFile::JointFriction, PartFile::JointLeadError, PartFile::Drive].contains(&self.part);
        if has_keys == self.key.is_empty() {
            let mend = if has_keys { "write which number with key = \"…\"" } else { "this part is one number; leave key out" };
            return Err(format!("rescale by {}: {mend}", self.by));
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
            PartFile::ShaftModulus => Target::ShaftModulus(self.name),
            PartFile::ShaftShearModulus => Target::ShaftShearModulus(self.name),
            PartFile::Drive => Target::Drive(self.key),
            PartFile::ChainGain => Target::ChainGain,
            PartFile::ChainDelay => Target::ChainDelay,
            PartFile::ChainPower => Target::ChainPower,
        };
        Ok((target, self.modifier, self.by))
    }
}
