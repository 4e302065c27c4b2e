//! Numbers that a patch scales: which they are, and what becomes of them.

use super::check::{MachineError, fault, listing};
use super::{Base, Law, Machine, Rescale, Value};

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
            Target::ChainGain | Target::ChainDelay | Target::ChainPower => "measurement",
        }
    }
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
        let joint = |name: &String| self.joints.iter().position(|j| j.name == *name);
        let shaft = |name: &String| self.shafts.iter().position(|s| s.name == *name);
        let missing = |name: &String| fault(&part, format!("the machine has no «{name}»"));
        let mut values: Vec<&mut Value> = match target {
            Target::PointInertia(name) => {
                let at = self.point(name).ok_or_else(|| missing(name))?;
                vec![&mut self.points[at].inertia]
            }
            Target::JointStiffness(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].stiffness]
            }
            Target::JointDamping(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].damping]
            }
            Target::JointLossFactor(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].loss_factor]
            }
            Target::JointIntegralRate(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].integral_rate]
            }
            Target::ShaftDiameter(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                vec![&mut self.shafts[at].diameter]
            }
            Target::ShaftBore(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                vec![&mut self.shafts[at].bore_ratio]
            }
            Target::ShaftLossFactor(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                vec![&mut self.shafts[at].loss_factor]
            }
            Target::ShaftModulus(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                let shaft = &mut self.shafts[at];
                vec![&mut shaft.youngs_modulus, &mut shaft.shear_modulus]
            }
            Target::ShaftShearModulus(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                vec![&mut self.shafts[at].shear_modulus]
            }
            Target::Gap(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].gap]
            }
            Target::Friction(name, key) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![keyed(&part, key, self.joints[at].friction.values_mut())?]
            }
            Target::LeadError(name, key) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![keyed(&part, key, self.joints[at].lead_error.values_mut())?]
            }
            Target::Drive(key) => {
                let drive = self.drive.as_mut().ok_or_else(|| fault(&part, "the machine has no drive"))?;
                vec![keyed(&part, key, drive.values_mut())?]
            }
            Target::ChainGain => vec![&mut self.chain.gain],
            Target::ChainDelay => vec![&mut self.chain.delay],
            Target::ChainPower => vec![&mut self.chain.power],
        };
        for value in &mut values {
            match rescale {
                Rescale::Relative => value.laws.push(Law::Relative(index)),
                Rescale::InSeries => value.laws.push(Law::InSeries(index)),
                Rescale::Added => value.laws.push(Law::Added(index)),
                Rescale::Less => {
                    // No more can be taken away than there is. Where an effect starts beyond that its range stays, and nothing it finds there is told.
                    let taken = &mut self.parameters[index];
                    if let Some(most) = value.described().map(|number| 0.98 * number).filter(|most| *most > taken.start.max(taken.lower)) {
                        taken.upper = taken.upper.min(most);
                    }
                    value.laws.push(Law::Less(index));
                }
                Rescale::Times => value.laws.push(Law::Times(index)),
                Rescale::With(circumstance) => value.laws.push(Law::With(index, circumstance)),
                Rescale::AlongStroke => value.laws.push(Law::AlongStroke(index, stroke_m.clone()?)),
                Rescale::MidStroke => value.laws.push(Law::MidStroke(index, stroke_m.clone()?)),
                Rescale::LeftSpan => value.laws.push(Law::LeftSpan(index, stroke_m.clone()?)),
                Rescale::RightSpan => value.laws.push(Law::RightSpan(index, stroke_m.clone()?)),
                Rescale::Replace => value.base = Base::Parameter(index),
            }
        }
        Ok(())
    }
}
