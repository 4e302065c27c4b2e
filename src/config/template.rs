//! Templates of machine configurations.

/// A commented `machine.toml`. Numbers that the user has to enter are `nan`, which the program rejects by
/// key.
pub const MACHINE_TEMPLATE: &str = include_str!("template/machine.toml");

/// A commented rigid linear axis for motion records.
pub const LINEAR_TEMPLATE: &str = include_str!("template/motion-linear.toml");
/// A commented rigid rotary axis for motion records.
pub const ROTARY_TEMPLATE: &str = include_str!("template/motion-rotary.toml");

/// Returns the template of a machine whose right bearing floats: without its joint and parameters.
pub fn floating_template() -> String {
    let sections = MACHINE_TEMPLATE.split_inclusive("\n\n");
    let is_of_bearing = |section: &str| {
        ["[[joint]]\nname = \"bearing-right\"", "[parameter.k_ar]", "[parameter.c_ar]"]
            .iter()
            .any(|begin| section.starts_with(begin))
    };
    let floating = "ground\n";
    let text: String = sections.filter(|section| !is_of_bearing(section)).collect();
    text.replacen(&format!("bearing-right ─ {floating}"), "right end (its bearing floats)\n", 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_machine_text;

    #[test]
    fn templates_of_motion_give_no_warning() {
        for (text, angle) in [(LINEAR_TEMPLATE, false), (ROTARY_TEMPLATE, true)] {
            let read = read_machine_text("machine.toml", text, &[], &[]).unwrap();
            assert_eq!(read.warnings, Vec::<String>::new());
            let drive = read.machine.drive.as_ref().unwrap();
            assert_eq!(drive.position.encoder.reads_angle(&read.machine), angle);
        }
    }

    /// With numbers filled in, and with the drive off as the guide says, both templates are read without a
    /// warning.
    #[test]
    fn templates_give_no_warning() {
        for (text, is_fixed) in [(MACHINE_TEMPLATE.to_string(), true), (floating_template(), false)] {
            let numbers = [
                ("mass_kg", "400.0"),
                ("inertia_kg_m2", "5e-3"),
                ("length_m", "1.2"),
                ("diameter_m", "0.036"),
                ("lead_m", "0.01"),
            ];
            let filled = numbers.iter().fold(text, |text, (key, number)| {
                text.replace(&format!("{key} = nan"), &format!("{key} = {number}"))
            });
            for effects in ["[\"rotor-hold\"]", "[]"] {
                let text = filled.replace("effects = [\"rotor-hold\"]", &format!("effects = {effects}"));
                let read = read_machine_text("machine.toml", &text, &[], &[]).unwrap();
                assert_eq!(read.warnings, Vec::<String>::new());
                let has_joint = read.machine.joints.iter().any(|joint| joint.name == "bearing-right");
                assert_eq!(has_joint, is_fixed);
            }
        }
    }
}
