//! Targets and modifiers of patches: which numbers a patch changes, and how.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::{MachineError, fault, listing};
use super::schema::enum_without_descriptions;
use super::{Base, Machine, Modifier, Number, OperatingVariable, Parameter, TargetKind};

/// The number of a part that a patch changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// Kind of part and number.
    pub kind: TargetKind,
    /// Name of the point, joint or shaft; empty for other parts.
    pub name: String,
    /// Key of the number, where the kind has several.
    pub key: String,
}

impl TargetKind {
    /// Whether it has several numbers, which are named by their keys.
    pub fn has_keys(self) -> bool {
        matches!(self, TargetKind::JointFriction | TargetKind::JointLeadError | TargetKind::Drive)
    }

    /// Whether it is a modulus of a shaft.
    fn is_material(self) -> bool {
        matches!(
            self,
            TargetKind::ShaftModulus | TargetKind::ShaftYoungsModulus | TargetKind::ShaftShearModulus
        )
    }

    /// Returns what it is a number of, for messages.
    fn noun(self) -> &'static str {
        match self {
            TargetKind::PointInertia => "point",
            TargetKind::JointStiffness
            | TargetKind::JointDamping
            | TargetKind::JointLossFactor
            | TargetKind::JointIntegralRate
            | TargetKind::JointGap
            | TargetKind::JointFriction
            | TargetKind::JointLeadError => "joint",
            TargetKind::Drive => "drive",
            _ => "shaft",
        }
    }

    /// Whether a number is of this kind.
    fn includes(self, number: &Number) -> bool {
        let own = number.target;
        own == Some(self) || (self == TargetKind::ShaftModulus && own.is_some_and(TargetKind::is_material))
    }

    /// Returns the target of this kind of a point, joint or shaft; of other parts with an empty name.
    pub fn of(self, name: impl Into<String>) -> Target {
        Target { kind: self, name: name.into(), key: String::new() }
    }
}

impl Target {
    /// Returns the point, joint or shaft; for other numbers «drive», «losses» or «measurement».
    pub fn part(&self) -> &str {
        match self.kind {
            TargetKind::Drive => "drive",
            TargetKind::LossDispersion => "losses",
            TargetKind::ChainGain | TargetKind::ChainDelay | TargetKind::ChainPower => "measurement",
            _ => &self.name,
        }
    }

    /// Whether it changes a number of its part.
    pub(super) fn selects(&self, number: &Number) -> bool {
        self.kind.includes(number) && (!self.kind.has_keys() || number.key_in_section() == self.key)
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

impl Rescale {
    /// Returns the modifier by the parameter with this index; `None` where the parameter replaces the number.
    fn modifier(self, index: usize, stroke_m: Option<f64>) -> Result<Option<Modifier>, &'static str> {
        let stroke_m = stroke_m.ok_or("the machine has no shaft with a nut");
        Ok(Some(match self {
            Rescale::Replace => return Ok(None),
            Rescale::Less => Modifier::Less(index),
            Rescale::Relative => Modifier::Relative(index),
            Rescale::InSeries => Modifier::InSeries(index),
            Rescale::Added => Modifier::Added(index),
            Rescale::Times => Modifier::Times(index),
            Rescale::WithForceLevel => Modifier::With(index, OperatingVariable::ForceLevel),
            Rescale::WithSpeed => Modifier::With(index, OperatingVariable::Speed),
            Rescale::WithAcceleration => Modifier::With(index, OperatingVariable::Acceleration),
            Rescale::AlongStroke => Modifier::AlongStroke(index, stroke_m?),
            Rescale::MidStroke => Modifier::MidStroke(index, stroke_m?),
        }))
    }
}

impl Machine {
    pub(super) fn rescale(
        &mut self,
        target: &Target,
        rescale: Rescale,
        parameter: &str,
    ) -> Result<(), MachineError> {
        let name = target.part();
        let refused = |text: &str| fault(format!("rescale of {name} by {parameter}"), text);
        if target.kind == TargetKind::NutPosition
            && !matches!(rescale, Rescale::Relative | Rescale::Times | Rescale::Added)
        {
            return Err(refused("a nut position takes the modifier relative, times or added"));
        }
        let index = self
            .parameter(parameter)
            .ok_or_else(|| refused(&format!("no parameter is called «{parameter}»")))?;
        // A shaft and the journals at its ends are of one material.
        let journals =
            self.shafts.iter().filter(|s| target.kind.is_material() && s.journal_of.as_deref() == Some(name));
        let names: Vec<String> =
            std::iter::once(name.to_string()).chain(journals.map(|s| s.name.clone())).collect();
        let keys: Vec<&str> = self
            .numbers()
            .filter(|(number, part, _)| *part == name && target.kind.includes(number))
            .map(|(number, ..)| number.key_in_section())
            .collect();
        if keys.is_empty() {
            return Err(refused(&match target.kind.noun() {
                "drive" => "the machine has no drive".to_string(),
                noun => format!("no {noun} of the machine is called «{name}»"),
            }));
        }
        if target.kind.has_keys() && !keys.contains(&target.key.as_str()) {
            return Err(refused(&format!(
                "no number is called «{}»; {}",
                target.key,
                listing(keys.into_iter())
            )));
        }
        let modifier = rescale.modifier(index, self.stroke_m()).map_err(refused)?;
        let Parameter { start, lower, mut upper, .. } = self.parameters[index];
        self.change_numbers(&mut |number, part, value| {
            if !target.selects(number) || !names.iter().any(|own| own == part) {
                return;
            }
            let Some(modifier) = modifier else {
                value.base = Base::Parameter(index);
                return;
            };
            // At most 98 % can be subtracted. Where an effect starts above that, its range stays, and the
            // diagnosis reports no value it finds there.
            let most = value
                .described()
                .map(|number| 0.98 * number)
                .filter(|most| rescale == Rescale::Less && *most > start.max(lower));
            upper = most.map_or(upper, |most| upper.min(most));
            value.modifiers.push(modifier);
        });
        self.parameters[index].upper = upper;
        Ok(())
    }
}
