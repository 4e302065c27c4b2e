//! Parameters in words.

use super::{Machine, PointMotion, Value};

impl Machine {
    /// Describes a parameter: as its file states, else by the first number of the machine that depends on it, such as «damping of bearing-left». Empty
    /// where no number does.
    pub fn description_of(&self, parameter: usize) -> String {
        let stated = &self.parameters[parameter].description;
        if !stated.is_empty() {
            return stated.clone();
        }
        let depends = |value: &&Value| value.depends_on().any(|index| index == parameter);
        let structural = self.structural_numbers().into_iter().find(|(_, value)| depends(value));
        let motion = || self.motion_values().into_iter().find(|(_, value)| depends(value)).map(|(key, value)| (motion_words(&key), value));
        structural.or_else(motion).map(|(words, _)| words).unwrap_or_default()
    }

    /// The numbers of points, shafts, joints and measuring chain, each with its name.
    fn structural_numbers(&self) -> Vec<(String, &Value)> {
        let points = self.points.iter().map(|p| {
            let quantity = if p.motion == PointMotion::Translation { "mass" } else { "inertia" };
            (format!("{quantity} of {}", p.name), &p.inertia)
        });
        let shafts = self.shafts.iter().flat_map(|s| {
            let named = |quantity: &str| format!("{quantity} of {}", s.name);
            [
                (named("length"), &s.length),
                (named("diameter"), &s.diameter),
                (named("bore ratio"), &s.bore_ratio),
                (named("Young's modulus"), &s.youngs_modulus),
                (named("shear modulus"), &s.shear_modulus),
                (named("density"), &s.density),
                (named("loss factor"), &s.loss_factor),
                (format!("nut position on {}", s.name), &s.nut_position),
            ]
        });
        let bending = self.shafts.iter().flat_map(|s| {
            let values = s.bending.iter().flat_map(super::Bending::values);
            values.map(|(quantity, value)| (format!("{quantity} of {}", s.name), value))
        });
        let joints = self.joints.iter().flat_map(|j| {
            let named = |quantity: &str| format!("{quantity} of {}", j.name);
            let own = [
                (named("stiffness"), &j.stiffness),
                (named("damping"), &j.damping),
                (named("loss factor"), &j.loss_factor),
                (named("integral rate"), &j.integral_rate),
            ];
            own.into_iter().chain(j.relaxation_stiffness.as_ref().map(|value| (named("relaxation stiffness"), value)))
        });
        let levers = self.chain.levers.iter().flat_map(|l| {
            let name = &self.points[l.point].name;
            [(format!("arm of the sensor at {name}"), &l.sensor_arm), (format!("arm of the hammer at {name}"), &l.hammer_arm)]
        });
        let chain = [
            ("gain of the measuring chain", &self.chain.gain),
            ("delay of the measuring chain", &self.chain.delay),
            ("power of frequency of the measuring chain", &self.chain.power),
            ("dispersion of loss factors", &self.loss_dispersion),
        ];
        let chain = chain.map(|(name, value)| (name.to_string(), value));
        points.chain(shafts).chain(bending).chain(joints).chain(levers).chain(chain).collect()
    }
}

/// Words of a key of the motion numbers: `joint.guide.friction.coulomb` is «coulomb friction of guide».
fn motion_words(key: &str) -> String {
    let parts: Vec<String> = key.split('.').map(|part| part.replace('_', " ")).collect();
    match parts.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["joint", name, "gap"] => format!("backlash of {name}"),
        ["joint", name, "friction", number] => format!("{number} friction of {name}"),
        ["joint", name, ref number @ ..] => format!("{} of {name}", number.join(" ")),
        ["drive", ref number @ ..] => format!("{} of the drive", number.join(" ")),
        _ => parts.join(" "),
    }
}
