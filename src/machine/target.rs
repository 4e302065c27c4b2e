//! Numbers that a patch scales: which they are, and what becomes of them.

use schemars::JsonSchema;
use serde::Deserialize;

use super::check::{MachineError, fault, listing};
use super::schema::words_alone;
use super::{Base, Machine, Modifier, OperatingVariable, Value};

/// Which number of which part a patch scales.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// Inertia of the point of that name.
    PointInertia(String),
    /// Stiffness of the joint of that name.
    JointStiffness(String),
    /// Damping of the joint of that name.
    JointDamping(String),
    /// Loss factor of the joint of that name.
    JointLossFactor(String),
    /// Integral action of the joint of that name.
    JointIntegralRate(String),
    /// Play of the joint of that name.
    Gap(String),
    /// Friction of the joint of that name, and the key of the number.
    Friction(String, String),
    /// Lead error of the joint of that name, and the key of the number.
    LeadError(String, String),
    /// Diameter of the shaft of that name.
    ShaftDiameter(String),
    /// Bore over diameter of the shaft of that name.
    ShaftBore(String),
    /// Loss factor of the shaft of that name.
    ShaftLossFactor(String),
    /// Young's modulus, and with it the shear modulus, of the shaft of that name.
    ShaftModulus(String),
    /// Shear modulus alone of the shaft of that name.
    ShaftShearModulus(String),
    /// Key of a number of the drive.
    Drive(String),
    /// Share of dispersion of all loss factors.
    LossDispersion,
    /// Gain of the measuring chain.
    ChainGain,
    /// Delay of the measuring chain.
    ChainDelay,
    /// Power by which the recorded quantity differs from the one stated.
    ChainPower,
}

impl Target {
    /// The point, joint or shaft; «drive» and «measurement» for what is none.
    pub fn part(&self) -> &str {
        match self {
            Target::PointInertia(name)
            | Target::JointStiffness(name)
            | Target::JointDamping(name)
            | Target::JointLossFactor(name)
            | Target::JointIntegralRate(name)
            | Target::Gap(name)
            | Target::Friction(name, _)
            | Target::LeadError(name, _)
            | Target::ShaftDiameter(name)
            | Target::ShaftBore(name)
            | Target::ShaftLossFactor(name)
            | Target::ShaftModulus(name)
            | Target::ShaftShearModulus(name) => name,
            Target::Drive(_) => "drive",
            Target::LossDispersion => "losses",
            Target::ChainGain | Target::ChainDelay | Target::ChainPower => "measurement",
        }
    }
}

/// How a patch scales a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "LawFile", rename_all = "kebab-case")]
#[schemars(transform = words_alone)]
pub enum Rescale {
    /// Times 1 + p.
    Relative,
    /// Times exp(p·(2·s − 1)), s = nut position / stroke.
    AlongStroke,
    /// Times exp(p·(1 − (2·s − 1)²)): a hump at mid-stroke.
    MidStroke,
    /// An inertia becomes the stiffness of a beam of that inertia over the shaft's free length left of the nut.
    LeftSpan,
    /// The same right of the nut.
    RightSpan,
    /// Times exp(p·x) with the size x of the force level.
    WithForceLevel,
    /// The same with that of the speed.
    WithSpeed,
    /// The same with that of the acceleration.
    WithAcceleration,
    /// Becomes the parameter itself.
    Replace,
    /// With the parameter as a spring in series: x·p/(x + p).
    InSeries,
    /// Plus the parameter.
    Added,
    /// Less the parameter, which is elsewhere.
    Less,
    /// Times the parameter.
    Times,
}

/// The number of that key.
fn keyed<'v>(part: &str, key: &str, mut values: Vec<(&'static str, &'v mut Value)>) -> Result<&'v mut Value, MachineError> {
    match values.iter().position(|(k, _)| *k == key) {
        Some(at) => Ok(values.swap_remove(at).1),
        None => Err(fault(part, format!("no number is called «{key}»; {}", listing(values.iter().map(|(k, _)| *k))))),
    }
}

impl Machine {
    pub(super) fn rescale(&mut self, target: &Target, rescale: Rescale, parameter: &str) -> Result<(), MachineError> {
        let part = format!("rescale {target:?}");
        let index = self.parameter(parameter).ok_or_else(|| fault(&part, format!("no parameter is called «{parameter}»")))?;
        let stroke_m = self.stroke_m().ok_or_else(|| fault(&part, "the machine has no shaft with a nut"));
        let name = target.part();
        let missing = || fault(&part, format!("the machine has no «{name}»"));
        let point = self.points.iter_mut().find(|p| p.name == name).ok_or_else(missing);
        let own = self.joints.iter_mut().filter(|j| j.name == name).collect::<Vec<_>>();
        let joints = if own.is_empty() { Err(missing()) } else { Ok(own) };
        let shaft = self.shafts.iter_mut().find(|s| s.name == name).ok_or_else(missing);
        let values: Vec<&mut Value> = match target {
            Target::PointInertia(_) => vec![&mut point?.inertia],
            Target::JointStiffness(_) => joints?.into_iter().map(|j| &mut j.stiffness).collect(),
            Target::JointDamping(_) => joints?.into_iter().map(|j| &mut j.damping).collect(),
            Target::JointLossFactor(_) => joints?.into_iter().map(|j| &mut j.loss_factor).collect(),
            Target::JointIntegralRate(_) => joints?.into_iter().map(|j| &mut j.integral_rate).collect(),
            Target::ShaftDiameter(_) => vec![&mut shaft?.diameter],
            Target::ShaftBore(_) => vec![&mut shaft?.bore_ratio],
            Target::ShaftLossFactor(_) => vec![&mut shaft?.loss_factor],
            Target::ShaftModulus(_) => {
                let shaft = shaft?;
                vec![&mut shaft.youngs_modulus, &mut shaft.shear_modulus]
            }
            Target::ShaftShearModulus(_) => vec![&mut shaft?.shear_modulus],
            Target::Gap(_) => joints?.into_iter().map(|j| &mut j.gap).collect(),
            Target::Friction(_, key) => {
                joints?.into_iter().map(|j| keyed(&part, key, j.friction.values_mut())).collect::<Result<_, _>>()?
            }
            Target::LeadError(_, key) => {
                joints?.into_iter().map(|j| keyed(&part, key, j.lead_error.values_mut())).collect::<Result<_, _>>()?
            }
            Target::Drive(key) => {
                let drive = self.drive.as_mut().ok_or_else(|| fault(&part, "the machine has no drive"))?;
                vec![keyed(&part, key, drive.values_mut())?]
            }
            Target::LossDispersion => vec![&mut self.loss_dispersion],
            Target::ChainGain => vec![&mut self.chain.gain],
            Target::ChainDelay => vec![&mut self.chain.delay],
            Target::ChainPower => vec![&mut self.chain.power],
        };
        for value in values {
            let law = match rescale {
                Rescale::Replace => {
                    value.base = Base::Parameter(index);
                    continue;
                }
                Rescale::Less => {
                    // No more can be taken away than there is. Where an effect starts beyond that its range stays, and nothing it finds there is told.
                    let taken = &mut self.parameters[index];
                    if let Some(most) = value.described().map(|number| 0.98 * number).filter(|most| *most > taken.start.max(taken.lower)) {
                        taken.upper = taken.upper.min(most);
                    }
                    Modifier::Less(index)
                }
                Rescale::Relative => Modifier::Relative(index),
                Rescale::InSeries => Modifier::InSeries(index),
                Rescale::Added => Modifier::Added(index),
                Rescale::Times => Modifier::Times(index),
                Rescale::WithForceLevel => Modifier::With(index, OperatingVariable::ForceLevel),
                Rescale::WithSpeed => Modifier::With(index, OperatingVariable::Speed),
                Rescale::WithAcceleration => Modifier::With(index, OperatingVariable::Acceleration),
                Rescale::AlongStroke => Modifier::AlongStroke(index, stroke_m.clone()?),
                Rescale::MidStroke => Modifier::MidStroke(index, stroke_m.clone()?),
                Rescale::LeftSpan => Modifier::LeftSpan(index, stroke_m.clone()?),
                Rescale::RightSpan => Modifier::RightSpan(index, stroke_m.clone()?),
            };
            value.laws.push(law);
        }
        Ok(())
    }
}
