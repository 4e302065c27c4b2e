//! Operating states in which a machine can be measured.

use super::error::fault;
use super::{Joint, Machine, MachineError, Modifier, OperatingVariable, PointMotion, Value};

/// A state in which a measurement can be made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    /// As described.
    Described,
    /// The drive is off: nothing holds the rotor.
    ServoOff,
    /// A known mass (kg) is added to the largest mass.
    AddedMass(f64),
    /// The excitation has this force level (N).
    Level(f64),
}

impl State {
    /// Reads a state: `as-is`, `servo-off`, `mass=KG` or `level=N`. `None` for any other text.
    pub fn named(text: &str) -> Option<State> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| *x > 0.0 && x.is_finite());
        match text.split_once('=') {
            None if text == "as-is" => Some(State::Described),
            None if text == "servo-off" => Some(State::ServoOff),
            Some(("mass", kg)) => number(kg).map(State::AddedMass),
            Some(("level", n)) => number(n).map(State::Level),
            _ => None,
        }
    }

    /// Returns its name, which [`State::named`] reads.
    pub fn name(self) -> String {
        match self {
            State::Described => "as-is".into(),
            State::ServoOff => "servo-off".into(),
            State::AddedMass(kg) => format!("mass={kg}"),
            State::Level(n) => format!("level={n}"),
        }
    }

    /// Returns the force level (N) of the excitation; `None` where the state does not concern it.
    pub fn level_n(self) -> Option<f64> {
        if let State::Level(n) = self { Some(n) } else { None }
    }
}

impl Machine {
    /// Whether a joint is a holding servo: it acts between a rotation and the ground.
    pub(super) fn is_servo(&self, joint: &Joint) -> bool {
        matches!(joint.on[..], [(point, _)] if self.points[point].motion == PointMotion::Rotation)
    }

    /// Whether the coefficient of a point (index) in a joint contains a lead: it rotates, and the joint
    /// couples it with a translation.
    pub fn has_lead(&self, joint: &Joint, point: usize) -> bool {
        let motion = |point: usize| self.points[point].motion;
        motion(point) == PointMotion::Rotation
            && joint.on.iter().any(|(other, _)| motion(*other) == PointMotion::Translation)
    }

    /// Returns the machine in a state, with the same parameters.
    ///
    /// # Errors  the machine has no such state.
    pub fn in_state(&self, state: State) -> Result<Machine, MachineError> {
        let missing = |text: &str| Err(fault(format!("state {}", state.name()), text));
        let mut machine = self.clone();
        match state {
            State::Described => {}
            State::ServoOff => {
                let servos: Vec<usize> =
                    (0..self.joints.len()).filter(|at| self.is_servo(&self.joints[*at])).collect();
                if servos.is_empty() {
                    return missing(
                        "the machine has no servo: no joint holds a rotation against the ground; leave the state out",
                    );
                }
                for at in servos {
                    let joint = &mut machine.joints[at];
                    let parts = [
                        &mut joint.stiffness,
                        &mut joint.damping,
                        &mut joint.loss_factor,
                        &mut joint.integral_rate,
                    ];
                    parts.into_iter().for_each(|value| *value = Value::number(0.0));
                    joint.relaxation_stiffness = None;
                }
            }
            State::AddedMass(kg) => {
                let Some(point) = self.largest(PointMotion::Translation) else {
                    return missing("the machine has no mass to add one to; leave the state out");
                };
                machine.points[point].inertia.modifiers.push(Modifier::Shifted(kg));
            }
            State::Level(_) => {
                if !self.depends_on_level() {
                    return missing(
                        "no number of the machine depends on the force level; add the effect contact-level, or leave the state out",
                    );
                }
            }
        }
        Ok(machine)
    }

    /// Whether a number of the machine depends on the level of the exciting force.
    pub fn depends_on_level(&self) -> bool {
        let is_level = |m: &Modifier| matches!(m, Modifier::With(_, OperatingVariable::ForceLevel));
        self.numbers().any(|(.., value)| value.modifiers.iter().any(is_level))
    }
}

#[cfg(test)]
mod tests {
    use super::State;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for state in [State::Described, State::ServoOff, State::AddedMass(20.5), State::Level(300.0)] {
            assert_eq!(State::named(&state.name()), Some(state));
        }
        for text in ["", "off", "mass", "mass=-2", "mass=nan", "level=0", "level=x", "mass=1=2"] {
            assert_eq!(State::named(text), None, "{text}");
        }
    }
}
