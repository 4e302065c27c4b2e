//! The engineer's description of a machine before any measurement, and its machine file.

use std::fmt::Write;

use super::nuisance::Spread;
use super::number::{Hold, Joint, Journal, Machine, Nut, Screw};
use crate::parameter::Parameter;

/// A machine as its engineer describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Whether the drive holds the rotor.
    pub holds_rotor: bool,
    /// m_b
    pub table_mass_kg: f64,
    /// J_m
    pub rotor_inertia_kg_m2: f64,
    /// J_H
    pub hub_inertia_kg_m2: f64,
    /// m_s
    pub screw_mass_kg: f64,
    /// J_s
    pub screw_inertia_kg_m2: f64,
    /// L
    pub length_m: f64,
    /// d
    pub diameter_m: f64,
    /// E
    pub youngs_modulus_pa: f64,
    /// G
    pub shear_modulus_pa: f64,
    /// ρ
    pub density_kg_m3: f64,
    /// Lead, m per turn.
    pub lead_m: f64,
    /// Joint parameters.
    pub parameters: Vec<Parameter>,
    /// Tolerances of the description.
    pub spread: Spread,
    /// Whether machine file and manifest state the tolerances; else their reader assumes usual ones.
    pub states_tolerances: bool,
    /// Turns of the rotor for one turn of the screw.
    pub drive_ratio: f64,
}

impl Description {
    /// Returns a parameter by name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Returns the machine exactly as described, with the joints at their start values: uniform screw without
    /// loss, nut at one point.
    pub fn as_believed(&self) -> Machine {
        let joint = Joint::default();
        let mut machine = Machine {
            screw: Screw {
                length_m: self.length_m,
                diameter_m: self.diameter_m,
                bore_m: 0.0,
                youngs_modulus_pa: self.youngs_modulus_pa,
                shear_modulus_pa: self.shear_modulus_pa,
                density_kg_m3: self.density_kg_m3,
                loss: 0.0,
                left: Journal::NONE,
                right: Journal::NONE,
                elements: 200,
            },
            lead_m: self.lead_m,
            nut: Nut {
                joint,
                contacts: 1,
                length_m: 0.0,
                skew: 0.0,
                screw_mass_kg: self.screw_mass_kg,
                screw_inertia_kg_m2: self.screw_inertia_kg_m2,
            },
            bearing_left: joint,
            bearing_right: joint,
            coupling: joint,
            hold: self.holds_rotor.then(Hold::default),
            table_mass_kg: self.table_mass_kg,
            rotor_inertia_kg_m2: self.rotor_inertia_kg_m2,
            hub_inertia_kg_m2: self.hub_inertia_kg_m2,
            guide_damping_ns_per_m: 0.0,
            guide_stiffness_n_per_m: 0.0,
            drive_ratio: self.drive_ratio,
            loss_dispersion: 1.0,
        };
        for parameter in &self.parameters {
            if let Some(value) = machine.joint_mut(parameter.name) {
                *value = parameter.start;
            }
        }
        machine
    }

    /// Formats the description as a machine file.
    pub fn to_toml(&self) -> String {
        let mut out = String::new();
        let effects = if self.holds_rotor { "\"rotor-hold\"" } else { "" };
        let _ = writeln!(out, "title = \"ball-screw feed drive\"\neffects = [{effects}]\n");
        let mut point = |name: &str, motion: &str, inertia: Option<(&str, f64)>| {
            let _ = writeln!(out, "[[point]]\nname = \"{name}\"\nmotion = \"{motion}\"");
            if let Some((key, value)) = inertia {
                let _ = writeln!(out, "{key} = {value:e}");
            }
            out.push('\n');
        };
        point("table", "translation", Some(("mass_kg", self.table_mass_kg)));
        point("rotor", "rotation", Some(("inertia_kg_m2", self.rotor_inertia_kg_m2)));
        point("left", "translation", None);
        point("left-angle", "rotation", Some(("inertia_kg_m2", self.hub_inertia_kg_m2)));
        point("screw", "translation", Some(("mass_kg", self.screw_mass_kg)));
        point("screw-angle", "rotation", Some(("inertia_kg_m2", self.screw_inertia_kg_m2)));
        point("right", "translation", None);
        point("right-angle", "rotation", None);
        let _ = writeln!(
            out,
            "[[shaft]]\nname = \"screw\"\nlength_m = {:e}\ndiameter_m = {:e}\nyoungs_modulus_pa = {:e}\nshear_modulus_pa = {:e}\ndensity_kg_m3 = {:e}",
            self.length_m, self.diameter_m, self.youngs_modulus_pa, self.shear_modulus_pa, self.density_kg_m3
        );
        out.push_str(STATIONS);
        self.joints(&mut out);
        if self.states_tolerances {
            self.tolerances(&mut out);
        }
        self.parameters.iter().for_each(|parameter| parameter.write(&mut out));
        out
    }

    /// Writes the joints. A floating bearing carries no axial load and is none; a belt connects rotor and
    /// screw by the ratio of its pulleys.
    fn joints(&self, out: &mut String) {
        let mut joint = |name: &str, connects: &str, stiffness: Option<&str>, damping: &str| {
            let _ = writeln!(out, "[[joint]]\nname = \"{name}\"\n{connects}");
            if let Some(stiffness) = stiffness {
                let _ = writeln!(out, "stiffness = \"{stiffness}\"");
            }
            let _ = writeln!(out, "damping = \"{damping}\"\n");
        };
        let between = |first: &str, second: &str| format!("between = [\"{first}\", \"{second}\"]");
        joint("bearing-left", &between("left", "ground"), Some("k_al"), "c_al");
        if self.parameter("k_ar").is_some() {
            joint("bearing-right", &between("right", "ground"), Some("k_ar"), "c_ar");
        }
        let screw = format!(
            "{}\nscrew = {{ angle = \"screw-angle\", lead_m = {:e} }}",
            between("table", "screw"),
            self.lead_m
        );
        joint("nut", &screw, Some("k_n"), "c_n");
        let coupling = match self.drive_ratio {
            1.0 => between("rotor", "left-angle"),
            ratio => format!("on = {{ rotor = 1.0, left-angle = {:?} }}", -ratio),
        };
        joint("coupling", &coupling, Some("k_m"), "c_m");
        if self.parameter("c_g").is_some() {
            joint("guide", &between("table", "ground"), None, "c_g");
        }
    }

    fn tolerances(&self, out: &mut String) {
        // The table is weighed; inertias of rotating parts (journals, hub, nut) are less certain. G/E
        // combines two independent errors of equal size.
        let Spread { modulus, mass, .. } = self.spread;
        let shear = modulus * std::f64::consts::SQRT_2;
        let _ = writeln!(
            out,
            "[tolerance]\nyoungs_modulus = {modulus}\nshear_modulus = {shear:.4}\nmass = {mass}\n"
        );
    }
}

const STATIONS: &str = r#"station = [
    { at = "start", axial = "left", torsion = "left-angle" },
    { at = "nut", axial = "screw", torsion = "screw-angle" },
    { at = "end", axial = "right", torsion = "right-angle" },
]

"#;
