//! Tests of effects that a file defines: numbers of physics, names and units.

use crate::{BENCH, embedded_config, read_machine_text};

/// Reads the bench with an effect of its own. Returns the refusal, if any.
fn refusal(id: &str, body: &str, contained: bool) -> Option<String> {
    let mut text = embedded_config(BENCH).unwrap().to_string();
    if contained {
        text = text.replace("effects = [\"rotor-hold\"]", &format!("effects = [\"rotor-hold\", \"{id}\"]"));
        assert!(text.contains(&format!("\"{id}\"]")));
    }
    text += &format!("\n[[effect]]\nid = \"{id}\"\ndescription = \"x\"\n{body}");
    read_machine_text("own.toml", &text, &[], &[]).err().map(|error| error.to_string())
}

/// A bed of a mass on a joint.
fn bed(mass: &str, joint: &str) -> String {
    let point = format!("[[effect.point]]\nname = \"bed\"\nmotion = \"translation\"\nmass_kg = {mass}\n");
    point + &format!("[[effect.joint]]\nname = \"feet\"\nbetween = [\"bed\", \"ground\"]\n{joint}\n")
}

fn change(part: &str, name: &str, modifier: &str, parameter: &str) -> String {
    let target = format!("part = \"{part}\"\nname = \"{name}\"\nmodifier = \"{modifier}\"\nby = \"q\"\n");
    format!("[[effect.rescale]]\n{target}{}", declared("q", parameter))
}

fn declared(id: &str, parameter: &str) -> String {
    let mut words = parameter.split(' ');
    let mut next = || words.next().unwrap();
    let (unit, start, lower, upper) = (next(), next(), next(), next());
    let range = format!("start = {start}\nlower = {lower}\nupper = {upper}\n");
    format!("[effect.parameter.{id}]\nunit = \"{unit}\"\n{range}")
}

const SPRING: &str = "stiffness = 1e8";

#[test]
fn own_effects_obey_physics() {
    for (body, key) in [
        (bed("0.0", SPRING), "point.bed.mass_kg"),
        (bed("-1.0", SPRING), "point.bed.mass_kg"),
        (bed("\"m\"", SPRING) + &declared("m", "kg 1 -2 2"), "point.bed.mass_kg"),
        (bed("9.0", "stiffness = -1.0"), "joint.feet.stiffness"),
        (bed("9.0", "stiffness = 1e8\nloss_factor = -1.0"), "joint.feet.loss_factor"),
        (bed("9.0", "stiffness = 1e8\nloss_factor = 1e6"), "joint.feet.loss_factor"),
        (
            bed("9.0", "stiffness = 1e8\nloss_factor = \"l\"") + &declared("l", "1 0.1 0.01 1e6"),
            "joint.feet.loss_factor",
        ),
        (change("joint-loss-factor", "nut", "replace", "1 1 0.1 1e6"), "joint.nut.loss_factor"),
        (change("shaft-loss-factor", "screw", "replace", "1 1 0.1 1e6"), "shaft.screw.loss_factor"),
        (change("shaft-diameter", "screw", "relative", "1 0 -2 2"), "shaft.screw.diameter_m"),
        (change("point-inertia", "table", "relative", "1 0 -2 2"), "point.table.mass_kg"),
        (change("joint-stiffness", "nut", "in-series", "kg 1 1 2"), "parameter.q.unit"),
        (change("point-inertia", "table", "added", "N/m 1 0 2"), "parameter.q.unit"),
        (bed("\"m\"", SPRING) + &declared("m", "N/m 1 1 2"), "parameter.m.unit"),
    ] {
        for contained in [false, true] {
            let fault = refusal("own", &body, contained).unwrap_or_else(|| panic!("accepted: {body}"));
            assert!(fault.contains(key) && fault.contains("own"), "{fault}");
        }
    }
    assert_eq!(refusal("own", &bed("9.0", SPRING), true), None);
}

#[test]
fn own_effects_have_names_of_their_own() {
    for id in ["", " ", "a b", "a+b", "a@l1", "a,b", "a:b"] {
        let fault = refusal(id, &bed("9.0", SPRING), false).unwrap();
        assert!(fault.contains(", id: ") && fault.contains("is no name"), "{fault}");
    }
    for id in ["none", "unknown", "measurement", "nominal"] {
        let fault = refusal(id, &bed("9.0", SPRING), false).unwrap();
        assert!(fault.contains(", id: ") && fault.contains("is a word of verdicts"), "{fault}");
    }
    // Parameters of the description, of another effect that it contains, and of the measurement.
    for (id, unit) in [("k_n", "N/m"), ("c_n", "N/m"), ("k_s", "N/m"), ("gain", "N/m"), ("\"a,b\"", "N/m")] {
        let joint = format!("stiffness = \"{}\"", id.trim_matches('"'));
        let body = bed("9.0", &joint) + &declared(id, &format!("{unit} 1e8 1e6 1e10"));
        let fault = refusal("own", &body, true).unwrap_or_else(|| panic!("accepted: {id}"));
        assert!(fault.contains("parameter") && fault.contains(id.trim_matches('"')), "{fault}");
    }
    assert_eq!(refusal("own", &bed("9.0", "stiffness = \"k_n\""), true), None);
}
