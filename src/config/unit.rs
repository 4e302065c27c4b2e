//! Units of parameters: conversion to SI, and the check that a unit fits the place of its parameter.

use super::error::fault;
use machine::{MachineError, Mechanism, NumberSource, Patch, PointMotion};
use numeric::unit::{Unit, parse_for};

/// SI units of parameters, in the spelling of results.
const SI: [&str; 18] = [
    "1",
    "N/m",
    "N*m/rad",
    "N*s/m",
    "N*m*s/rad",
    "kg",
    "kg*m^2",
    "N",
    "N*m",
    "Hz",
    "m",
    "rad",
    "m/s",
    "rad/s",
    "s",
    "1/s",
    "Pa",
    "kg/m^3",
];

/// Returns the unit of a parameter in SI and the factor to it.
///
/// # Errors  the unit is unknown, or of another dimension than the place where the parameter is used.
pub(super) fn to_si(id: &str, label: &str, uses: &Patch) -> Result<(String, f64), MachineError> {
    let refused = |text: String| fault(format!("parameter.{id}.unit"), text);
    let label = label.trim();
    if label.is_empty() {
        return Ok((String::new(), 1.0));
    }
    // Effects serve translations and rotations: «N or N*m».
    if label.contains(" or ") {
        for part in label.split(" or ") {
            let unit = parse_for(part, |_| true).map_err(|e| refused(format!("{e}; write SI units")))?;
            if (unit.to_si() - 1.0).abs() > 1e-12 && !SI.contains(&part.trim()) {
                return Err(refused(format!(
                    "«{part}» is one of two units, which must both be SI; write SI units"
                )));
            }
        }
        return Ok((label.into(), 1.0));
    }
    let mechanism = uses.mechanism_of(id, label);
    let fits: Vec<&str> = match (mechanism.units(), is_rotation(id, mechanism, uses)) {
        ([translation, rotation], Some(is_rotation)) => {
            vec![if is_rotation { rotation } else { translation }]
        }
        (list, _) => list.to_vec(),
    };
    let of_fitting = |unit: Unit| fits.iter().any(|si| is_like(unit, si));
    let unit =
        parse_for(label, of_fitting).map_err(|e| refused(format!("{e}; write {}", suggestion(&fits))))?;
    if !fits.is_empty() && !of_fitting(unit) {
        let text = format!(
            "«{label}» is the unit of {}, but the parameter is used where {} is expected",
            unit.dimension.name(),
            fits.join(" or ")
        );
        return Err(refused(format!("{text}; write {}", suggestion(&fits))));
    }
    if SI.contains(&label) && !(fits == ["1/s"] && label == "Hz") {
        return Ok((label.into(), 1.0));
    }
    if fits == ["1/s"] {
        // A rate counts neither turns nor radians: 60/min is 1/s, and no frequency is a rate.
        let is_frequency = unit.angle != 0 || (unit.turns != 0 && !label.contains("min"));
        if is_frequency || label.contains("rpm") || label.contains("r/min") {
            return Err(refused(format!(
                "«{label}» is the unit of a frequency, but the parameter is used where a rate is expected; write 1/s or 1/min"
            )));
        }
        return Ok(("1/s".into(), unit.factor));
    }
    let known = fits.iter().chain(SI.iter()).find(|si| is_like(unit, si));
    Ok(match known.and_then(|si| Some((*si, unit.to(parse_for(si, |_| true).ok()?)?))) {
        Some((si, factor)) => (si.to_string(), factor),
        None => (unit.dimension.to_string(), unit.to_si()),
    })
}

fn suggestion(fits: &[&str]) -> String {
    if fits.is_empty() { "one like N/m, N/mm, kg or Hz".into() } else { fits.join(" or ") }
}

/// Whether a unit has the dimension of an SI unit. Torque per angle is told from energy by its place alone.
fn is_like(unit: Unit, si: &str) -> bool {
    parse_for(si, |_| true).is_ok_and(|si| si.dimension == unit.dimension)
}

/// Whether a parameter is used by a rotation; `None` where its places do not state it.
fn is_rotation(id: &str, mechanism: Mechanism, uses: &Patch) -> Option<bool> {
    let names = |source: &NumberSource| matches!(source, NumberSource::Parameter(own) if own == id);
    if mechanism == Mechanism::Inertia {
        return uses.points.iter().find(|p| names(&p.inertia)).map(|p| p.motion == PointMotion::Rotation);
    }
    let joint = uses.joints.iter().find(|j| names(&j.stiffness) || names(&j.damping))?;
    let are_rotations = |points: &mut dyn Iterator<Item = &String>| -> Option<Vec<bool>> {
        points
            .map(|name| {
                uses.points.iter().find(|p| p.name == *name).map(|p| p.motion == PointMotion::Rotation)
            })
            .collect()
    };
    // Points of different kinds that must be of one are a fault of the joint, not of the unit.
    let alike = are_rotations(&mut joint.alike.iter())?;
    if alike.windows(2).any(|pair| pair[0] != pair[1]) {
        return None;
    }
    // A screw joins an angle to translations and acts along these.
    let on = are_rotations(&mut joint.on.iter().map(|(name, _)| name))?;
    (!on.is_empty()).then(|| on.iter().all(|is_rotation| *is_rotation))
}

#[cfg(test)]
mod tests {
    use crate::{BENCH, read_machine, read_machine_text};

    /// Reads the bench with another unit of `k_al`, a stiffness between translations.
    fn with_unit(unit: &str) -> Result<(String, [f64; 3]), String> {
        let set = [format!("parameter.k_al.unit=\"{unit}\"")];
        let config = read_machine(BENCH, &set, &[]).map_err(|error| error.to_string())?;
        let k = config.machine.parameters.iter().find(|p| p.id == "k_al").unwrap();
        Ok((k.unit.clone(), [k.start, k.lower, k.upper]))
    }

    #[test]
    fn parameters_convert_to_si() {
        let (_, si) = with_unit("N/m").unwrap();
        for (unit, factor) in [
            ("N/mm", 1e3),
            ("N/um", 1e6),
            ("N/µm", 1e6),
            ("kN/m", 1e3),
            ("lbf/in", 4.448_221_615_260_5 / 0.0254),
        ] {
            let (converted, values) = with_unit(unit).unwrap();
            assert_eq!(converted, "N/m");
            for (value, si) in values.iter().zip(si) {
                assert!((value / (factor * si) - 1.0).abs() < 1e-12, "{unit}: {value} {si}");
            }
        }
    }

    #[test]
    fn every_place_of_a_parameter_refuses_units_of_other_dimensions() {
        // Keys, a unit that fits with the factor to SI, and one that does not.
        for (config, set, unit, factor, other) in [
            ("hybrid-axis", "drive.position.gain_per_s=\"p\"", "1/min", 1.0 / 60.0, "kg"),
            ("hybrid-axis", "drive.constant=\"p\"", "N*cm/A", 0.01, "N/m"),
            ("hybrid-axis", "drive.velocity.gain=\"p\"", "A/(mm/s)", 1e3, "1/s"),
            ("hybrid-axis", "drive.velocity.integral_time_s=\"p\"", "ms", 1e-3, "Hz"),
            ("hybrid-axis", "drive.current.gain=\"p\"", "V/mA", 1e3, "V"),
            ("hybrid-axis", "drive.motor.resistance_ohm=\"p\"", "mOhm", 1e-3, "A"),
            ("hybrid-axis", "drive.motor.inductance_h=\"p\"", "mH", 1e-3, "mOhm"),
            ("hybrid-axis", "drive.saturation=\"p\"", "mA", 1e-3, "N"),
            ("tian", "shaft.screw.youngs_modulus_pa=\"p\"", "GPa", 1e9, "N/m"),
            ("tian", "shaft.screw.density_kg_m3=\"p\"", "g/cm^3", 1e3, "kg"),
        ] {
            let read = |unit: &str| {
                let start = 1.5 / factor;
                let numbers =
                    format!("start = {start:e}\nlower = {:e}\nupper = {:e}\n", 0.5 * start, 2.0 * start);
                let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs/");
                let text = std::fs::read_to_string(format!("{path}{config}.toml")).unwrap();
                let text = format!("{text}\n[parameter.p]\nunit = \"{unit}\"\nsource = \"\"\n{numbers}");
                read_machine_text(config, &text, &[set.to_string()], &[]).map_err(|error| error.to_string())
            };
            if set.contains("position.gain_per_s") {
                for frequency in ["Hz", "rpm"] {
                    assert!(read(frequency).unwrap_err().contains("a rate is expected"), "{frequency}");
                }
            }
            let refused = read(other).map(|_| "accepted".to_string()).unwrap_or_else(|text| text);
            assert!(
                refused.contains("parameter.p.unit") && refused.contains("is expected"),
                "{set} in {other}: {refused}"
            );
            let fitting = read(unit);
            let value = match fitting {
                Ok(config) => config.machine.parameters.iter().find(|p| p.id == "p").unwrap().start,
                // The number may lie outside the range of its place; the unit is accepted.
                Err(text) => {
                    assert!(!text.contains("parameter.p.unit"), "{set} in {unit}: {text}");
                    continue;
                }
            };
            assert!((value / 1.5 - 1.0).abs() < 1e-9, "{set} in {unit}: {value}");
        }
    }

    #[test]
    fn refuse_unknown_and_unfitting_units() {
        for (unit, words) in [
            ("bananas", ["parameter.k_al.unit", "«bananas» is unknown"]),
            ("kg", ["a mass", "write N/m"]),
            ("N*m", ["a torque", "N/m"]),
            ("N*s/m", ["a damping", "N/m"]),
            ("n/m", ["«n»", "N/m"]),
        ] {
            let text = with_unit(unit).unwrap_err();
            assert!(words.iter().all(|word| text.contains(word)), "{unit}: {text}");
        }
    }
}
