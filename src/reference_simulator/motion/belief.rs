//! The engineer's description of an axis before any motion, and its machine file.

use std::fmt::Write;

use super::catalogue::DrawnAxis;
use super::drive::Settings;
use super::run::Side;
use crate::machine::catalogue::round_to;
use crate::parameter::Parameter;

/// Parameter ids in the order of the columns of the inverse dynamics.
pub const IDS: [&str; 4] = ["moving_mass", "viscous_friction", "coulomb_friction", "friction_offset"];

/// An axis as its engineer describes it: one mass, or motor and table with the nut between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    /// Location of the position sensor of the records.
    pub side: Side,
    /// Mass of the motor, reduced to the travel, kg; only if the description has it apart from the table.
    pub motor_kg: Option<f64>,
    /// Stiffness (N/m) and damping (N·s/m) between motor and table.
    pub nut: [f64; 2],
    /// Whether the moving mass is weighed.
    pub is_weighed: bool,
    /// Force constant of the drive, N/V.
    pub constant_n_v: f64,
    /// Settings of the drive.
    pub set: Settings,
    /// Parameters of the description, without those of omitted frictions.
    pub parameters: Vec<Parameter>,
}

impl Belief {
    /// Describes an axis without effects; `without` names the frictions that the description omits.
    pub fn new(drawn: &DrawnAxis, side: Side, is_rigid: bool, is_weighed: bool, without: &[&str]) -> Self {
        let (axis, drive) = (&drawn.machine.axis, &drawn.machine.drive);
        let motor_kg = (!is_rigid).then(|| round_to(axis.masses_kg[0], 3));
        let series = |a: f64, b: f64| a * b / (a + b);
        let stiffness = round_to(series(axis.coupling.stiffness_n_m, axis.nut.stiffness_n_m), 2);
        let damping = round_to(series(axis.coupling.damping_n_s_m, axis.nut.damping_n_s_m), 1);
        let mass = axis.moving_mass_kg() - motor_kg.unwrap_or(0.0);
        let push = axis.moving_mass_kg() * drawn.limits.acceleration_m_s2;
        let (weighed, round) = (round_to(mass, 3), round_to(mass, 1));
        let (range, source) = if is_weighed {
            ([weighed, 0.97 * weighed, 1.03 * weighed], "weighed, with an allowance of three per cent")
        } else {
            ([round, 0.1 * round, 10.0 * round], "table and attached masses, within a decade")
        };
        let scale = round_to(push, 1);
        let linear = |id, unit, range, source| Parameter {
            further: Some(("scale", "linear")),
            ..Parameter::new(id, unit, range, source)
        };
        let film = scale / round_to(drawn.limits.speed_m_s, 1);
        let parameters = [
            Parameter::new(IDS[0], "kg", range, source),
            linear(
                IDS[1],
                "N*s/m",
                [round_to(0.2 * film, 1), 0.0, round_to(5.0 * film, 1)],
                "zero to five times the accelerating force at rapid speed",
            ),
            linear(
                IDS[2],
                "N",
                [round_to(0.1 * scale, 1), 0.0, 2.0 * scale],
                "zero to twice the accelerating force",
            ),
            linear(IDS[3], "N", [0.0, -scale, scale], "a slope of the guide, an offset of the amplifier"),
        ];
        Self {
            side,
            motor_kg,
            nut: [stiffness, damping],
            is_weighed,
            constant_n_v: round_to(drive.set.limit_n / 10.0, 2),
            set: drive.set,
            parameters: parameters
                .into_iter()
                .filter(|parameter| !without.contains(&parameter.name))
                .collect(),
        }
    }

    /// Whether the drive's force follows from command and encoder alone, so that the reading of an encoder
    /// that was not recorded follows from the force.
    pub fn gives_encoder(&self) -> bool {
        !self.set.is_direct && self.set.integral_time_s.is_infinite()
    }

    /// Whether the description has the parameter, one of [`IDS`].
    pub fn has(&self, id: &str) -> bool {
        self.parameters.iter().any(|parameter| parameter.name == id)
    }

    /// Returns a mutable parameter by id.
    pub fn parameter_mut(&mut self, id: &str) -> Option<&mut Parameter> {
        self.parameters.iter_mut().find(|parameter| parameter.name == id)
    }

    /// Formats the description as a machine file.
    pub fn to_toml(&self) -> String {
        let mut out = String::new();
        let contained = [("coulomb_friction", "coulomb-friction"), ("viscous_friction", "viscous-friction")];
        let effects: Vec<String> = contained
            .iter()
            .filter(|(id, _)| self.has(id))
            .map(|(_, effect)| format!("\"{effect}\""))
            .collect();
        let _ = writeln!(out, "title = \"ball-screw axis\"\neffects = [{}]\n", effects.join(", "));
        if let Some(motor_kg) = self.motor_kg {
            let _ = writeln!(
                out,
                "[[point]]\nname = \"motor\"\nmotion = \"translation\"\nmass_kg = {motor_kg:e}\n"
            );
        }
        out.push_str("[[point]]\nname = \"table\"\nmotion = \"translation\"\nmass_kg = \"moving_mass\"\n\n");
        if self.motor_kg.is_some() {
            let _ = writeln!(
                out,
                "[[joint]]\nname = \"nut\"\nbetween = [\"motor\", \"table\"]\nstiffness = {:e}\ndamping = {:e}\n",
                self.nut[0], self.nut[1]
            );
        }
        out.push_str("[[joint]]\nname = \"guide\"\nbetween = [\"table\", \"ground\"]\nfriction = { offset = \"friction_offset\" }\n\n");
        let _ = writeln!(
            out,
            "[drive]\non = \"{}\"\nconstant = {:e}\nsaturation = {:e}\n",
            if self.motor_kg.is_some() { "motor" } else { "table" },
            self.constant_n_v,
            self.set.limit_n / self.constant_n_v
        );
        let _ = writeln!(
            out,
            "[drive.position]\nencoder_step = {:e}\ngain_per_s = {:e}\nperiod_s = {:e}",
            self.set.quantum_m, self.set.position_gain_1_s, self.set.period_s
        );
        let has_two_encoders = self.set.is_direct && self.motor_kg.is_some();
        if has_two_encoders {
            out.push_str("at = \"table\"\n");
        }
        if self.set.feed_forward != 0.0 {
            let _ = writeln!(out, "feed_forward = {:e}", self.set.feed_forward);
        }
        let _ = writeln!(
            out,
            "\n[drive.velocity]\ngain = {:e}\nperiod_s = {:e}",
            self.set.velocity_gain_n_s_m / self.constant_n_v,
            self.set.period_s
        );
        if has_two_encoders {
            let _ = writeln!(out, "at = \"motor\"\nencoder_step = {:e}", self.set.quantum_m);
        }
        if self.set.integral_time_s.is_finite() {
            let _ = writeln!(out, "integral_time_s = {:e}", self.set.integral_time_s);
        }
        out.push('\n');
        self.parameters.iter().for_each(|parameter| parameter.write(&mut out));
        out
    }
}
