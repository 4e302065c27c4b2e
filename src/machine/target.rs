//! Targets and modifiers of patches: which numbers a patch changes, and how.

use schemars::JsonSchema;
use serde::Deserialize;

use super::check::{MachineError, fault, listing};
use super::schema::enum_without_descriptions;
use super::{Base, Machine, Modifier, OperatingVariable, Shaft, Value};

/// The number of a part that a patch changes.
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
    /// Backlash of the joint of that name.
    Gap(String),
    /// Friction of the joint of that name, and the key of the number.
    Friction(String, String),
    /// Lead error of the joint of that name, and the key of the number.
    LeadError(String, String),
    /// Diameter of the shaft of that name.
    ShaftDiameter(String),
    /// Bore ratio of the shaft of that name.
    ShaftBore(String),
    /// Loss factor of the shaft of that name.
    ShaftLossFactor(String),
    /// Young's modulus alone of the shaft of that name.
    ShaftYoungsModulus(String),
    /// Young's modulus of the shaft of that name, and with it the shear modulus.
    ShaftModulus(String),
    /// Shear modulus alone of the shaft of that name.
    ShaftShearModulus(String),
    /// Nut position on the shaft of that name.
    NutPosition(String),
    /// Key of a number of the drive.
    Drive(String),
    /// Share of dispersion of all loss factors.
    LossDispersion,
    /// Gain of the measuring chain.
    ChainGain,
    /// Delay of the measuring chain.
    ChainDelay,
    /// Power of iω by which the recorded quantity differs from the stated one.
    ChainPower,
}

impl Target {
    /// Returns the point, joint or shaft; for other numbers «drive», «losses» or «measurement».
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
            | Target::ShaftYoungsModulus(name)
            | Target::ShaftModulus(name)
            | Target::ShaftShearModulus(name)
            | Target::NutPosition(name) => name,
            Target::Drive(_) => "drive",
            Target::LossDispersion => "losses",
            Target::ChainGain | Target::ChainDelay | Target::ChainPower => "measurement",
        }
    }
}

/// How a patch changes a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "LawFile", rename_all = "kebab-case")]
#[schemars(transform = enum_without_descriptions)]
pub enum Rescale {
    /// Multiplies by 1 + p.
    Relative,
    /// Multiplies by exp(p·(2·s − 1)), s = nut position / stroke.
    AlongStroke,
    /// Multiplies by exp(p·(1 − (2·s − 1)²)): a maximum or minimum at mid-stroke.
    MidStroke,
    /// Multiplies by exp(p·x), x the normalised force level.
    WithForceLevel,
    /// Multiplies by exp(p·x), x the normalised speed.
    WithSpeed,
    /// Multiplies by exp(p·x), x the normalised acceleration.
    WithAcceleration,
    /// Replaces the number by the parameter.
    Replace,
    /// Puts the parameter as a spring in series: x·p/(x + p).
    InSeries,
    /// Adds the parameter.
    Added,
    /// Subtracts the parameter, which the effect places elsewhere.
    Less,
    /// Multiplies by the parameter.
    Times,
}

/// Returns the number with a configuration key.
fn keyed<'v>(part: &str, key: &str, mut values: Vec<(&'static str, &'v mut Value)>) -> Result<&'v mut Value, MachineError> {
    match values.iter().position(|(k, _)| *k == key) {
        Some(at) => Ok(values.swap_remove(at).1),
        None => Err(fault(part, format!("no number is called «{key}»; {}", listing(values.iter().map(|(k, _)| *k))))),
    }
}

impl Machine {
    pub(super) fn rescale(&mut self, target: &Target, rescale: Rescale, parameter: &str) -> Result<(), MachineError> {
        let part = format!("rescale {target:?}");
        if matches!(target, Target::NutPosition(_)) && !matches!(rescale, Rescale::Relative | Rescale::Times | Rescale::Added) {
            return Err(fault(part, "a nut position takes the modifier relative, times or added"));
        }
        let index = self.parameter(parameter).ok_or_else(|| fault(&part, format!("no parameter is called «{parameter}»")))?;
        let stroke_m = self.stroke_m().ok_or_else(|| fault(&part, "the machine has no shaft with a nut"));
        let name = target.part();
        let missing = |kind: &str| fault(&part, format!("no {kind} of the machine is called «{name}»"));
        let point = self.points.iter_mut().find(|p| p.name == name).ok_or_else(|| missing("point"));
        let named = self.joints.iter_mut().filter(|j| j.name == name).collect::<Vec<_>>();
        let joints = if named.is_empty() { Err(missing("joint")) } else { Ok(named) };
        // A shaft and the journals at its ends are of one material.
        let is_own = |s: &&mut Shaft| s.name == name || s.journal_of.as_deref() == Some(name);
        let (shafts, journals): (Vec<_>, Vec<_>) = self.shafts.iter_mut().filter(is_own).partition(|s| !s.is_journal());
        let shaft = shafts.into_iter().next().ok_or_else(|| missing("shaft"));
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
                let parts = std::iter::once(shaft?).chain(journals);
                parts.flat_map(|s| [&mut s.youngs_modulus, &mut s.shear_modulus]).collect()
            }
            Target::ShaftYoungsModulus(_) => std::iter::once(shaft?).chain(journals).map(|s| &mut s.youngs_modulus).collect(),
            Target::ShaftShearModulus(_) => std::iter::once(shaft?).chain(journals).map(|s| &mut s.shear_modulus).collect(),
            Target::NutPosition(_) => vec![&mut shaft?.nut_position],
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
            let modifier = match rescale {
                Rescale::Replace => {
                    value.base = Base::Parameter(index);
                    continue;
                }
                Rescale::Less => {
                    // At most 98 % can be subtracted. Where an effect starts above that, its range stays, and the diagnosis reports no
                    // value it finds there.
                    let subtracted = &mut self.parameters[index];
                    if let Some(most) =
                        value.described().map(|number| 0.98 * number).filter(|most| *most > subtracted.start.max(subtracted.lower))
                    {
                        subtracted.upper = subtracted.upper.min(most);
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
            };
            value.modifiers.push(modifier);
        }
        Ok(())
    }
}
