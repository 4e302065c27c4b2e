//! Plausible magnitudes of the numbers of a description: warnings with the likely unit, and refusals beyond
//! physics.

use file_access::{is_physical, unfilled};
use machine::{GROUND, Machine, MachineError, Magnitude, Mechanism, Number, PointMotion};
use toml::{Table, Value};

use super::error::fault;

/// Ratio of angles above which a joint is a gear (1).
const GEARED: f64 = 1.5;
/// Largest plausible inertia behind a gear (kg·m²). Source: rotary tables of 10 m and 100 t.
const LARGEST_GEARED_KG_M2: f64 = 2e6;

/// Checks the magnitudes of all numbers of a description, as the file states them. Returns one warning per
/// implausible number.
///
/// # Errors  numbers are still open; a number is beyond physics.
pub(super) fn check_numbers(table: &Table) -> Result<Vec<String>, MachineError> {
    let open = unfilled(table);
    match open.as_slice() {
        [] => {}
        [only] => {
            return Err(fault(
                only.clone(),
                "is NaN, still to be filled in; write a number, from a drawing or catalogue",
            ));
        }
        several => {
            let text = format!(
                "these {} are NaN, still to be filled in; write a number for each, from drawings and catalogues",
                several.len()
            );
            return Err(fault(several.join(", "), text));
        }
    }
    let mut found = Vec::new();
    let is_geared = is_geared(table);
    let judge = |known, path: &str, x| judge(behind_gears(known, is_geared), path, x);
    walk_table(table, "", &mut |path, key, x| {
        if !is_physical(x) {
            return Err(fault(path, format!("is {x:e}; no quantity in SI units has this magnitude")));
        }
        found.extend(judge(Number::quantity_of(key).and_then(|quantity| quantity.magnitude), path, x)?);
        Ok(())
    })?;
    for joint in table.get("joint").and_then(Value::as_array).into_iter().flatten() {
        let Some(units) = joint_units(table, joint) else { continue };
        for (key, unit) in ["stiffness", "damping"].into_iter().zip(units) {
            let name = joint.get("name").and_then(Value::as_str).unwrap_or("?");
            if let Some(x) = joint.get(key).and_then(number) {
                found.extend(judge(Magnitude::of_unit(unit), &format!("joint.{name}.{key}"), x)?);
            }
        }
    }
    Ok(found)
}

/// Checks the magnitudes of the parameters that the file describes, at their start. Returns one warning per
/// implausible parameter.
///
/// # Errors  a number is beyond physics.
pub(super) fn check_parameters(
    (machine, table): (&Machine, &Table),
    stated: impl Fn(&str) -> bool,
) -> Result<Vec<String>, MachineError> {
    let parameters = machine.parameters.iter().filter(|p| stated(&p.id));
    let is_geared = is_geared(table);
    let found = parameters.map(|p| {
        let known = behind_gears(Magnitude::of_unit(&p.unit), is_geared);
        judge(known, &format!("parameter.{}.start", p.id), p.start)
    });
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Returns a warning about an implausible number; `None` for a plausible one, for 0 and for a negative one,
/// which is checked elsewhere.
fn judge(known: Option<Magnitude>, path: &str, x: f64) -> Result<Option<String>, MachineError> {
    let Some(known) = known.filter(|_| x != 0.0) else { return Ok(None) };
    let within = |[low, high]: [f64; 2], x: f64| (low..=high).contains(&x.abs());
    if within(known.plausible, x) {
        return Ok(None);
    }
    let unit = if known.unit.is_empty() { String::new() } else { format!(" {}", known.unit) };
    let likely = known.others.iter().find(|(_, factor)| within(known.usual, x * factor));
    let remedy = likely.map_or_else(
        || "check the number".to_string(),
        |(other, factor)| format!("{} looks like {other}; write {}", written(x), converted(x, *factor)),
    );
    let [low, high] = if within(known.possible, x) { known.plausible } else { known.possible };
    let range = format!("{}{unit} is outside {} … {}{unit}", written(x), written(low), written(high));
    if within(known.possible, x) {
        Ok(Some(format!("{path}: {range}; {remedy}")))
    } else {
        Err(fault(path, format!("{range}; {remedy}")))
    }
}

/// Whether a joint of a description gears rotations: they move by unlike angles.
fn is_geared(table: &Table) -> bool {
    let joints = table.get("joint").and_then(Value::as_array).into_iter().flatten();
    let is_rotation = |name: &str| {
        let points = table.get("point").and_then(Value::as_array).into_iter().flatten();
        points
            .filter(|point| point.get("name").and_then(Value::as_str) == Some(name))
            .any(|point| point.get("motion").and_then(Value::as_str) == Some("rotation"))
    };
    joints.filter_map(|joint| joint.get("on").and_then(Value::as_table)).any(|on| {
        let angles = on.iter().filter(|(name, _)| is_rotation(name));
        let sizes: Vec<f64> = angles.filter_map(|(_, share)| number(share)).map(f64::abs).collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        sizes.iter().any(|size| GEARED * size < largest)
    })
}

/// Returns magnitudes of inertias up to those of tables and arms behind gears.
fn behind_gears(known: Option<Magnitude>, is_geared: bool) -> Option<Magnitude> {
    known.map(|known| match known.unit {
        "kg·m²" if is_geared => {
            let up_to = |[low, _]: [f64; 2]| [low, LARGEST_GEARED_KG_M2];
            Magnitude { plausible: up_to(known.plausible), usual: up_to(known.usual), ..known }
        }
        _ => known,
    })
}

/// Writes a number briefly: in powers of ten beyond 10⁻³ … 10⁶.
fn written(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

/// Writes a number times a factor as it is to be entered: `206e9`.
fn converted(x: f64, factor: f64) -> String {
    let power = factor.log10().round();
    if power >= 6.0 && x.abs() >= 1.0 {
        return format!("{x}e{power}");
    }
    // Rounded: 1120 · 0.001 is 1.12.
    written(format!("{:.12e}", x * factor).parse().unwrap_or(x * factor))
}

/// Returns a whole or decimal number of a configuration.
pub(super) fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// Returns the units of stiffness and damping of a joint; `None` where its points move differently.
fn joint_units(table: &Table, joint: &Value) -> Option<[&'static str; 2]> {
    let motion = |name: &str| {
        let points = table.get("point")?.as_array()?;
        let point = points.iter().find(|point| point.get("name").and_then(Value::as_str) == Some(name))?;
        point.get("motion")?.clone().try_into::<PointMotion>().ok()
    };
    let ends =
        joint.get("between")?.as_array()?.iter().filter_map(Value::as_str).filter(|name| *name != GROUND);
    let motions: Vec<PointMotion> = ends.map(motion).collect::<Option<_>>()?;
    let [stiffness, damping] = [Mechanism::Stiffness, Mechanism::Damping].map(Mechanism::units);
    [PointMotion::Translation, PointMotion::Rotation]
        .into_iter()
        .position(|alike| motions.iter().all(|motion| *motion == alike))
        .map(|at| [stiffness[at], damping[at]])
}

/// A visitor of numbers: path, key and value.
type Visit<'v> = &'v mut dyn FnMut(&str, &str, f64) -> Result<(), MachineError>;

fn walk_table(table: &Table, path: &str, visit: Visit<'_>) -> Result<(), MachineError> {
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        walk(value, &path, key, visit)?;
    }
    Ok(())
}

fn walk(value: &Value, path: &str, key: &str, visit: Visit<'_>) -> Result<(), MachineError> {
    match value {
        Value::Table(table) => walk_table(table, path, visit),
        Value::Array(list) => {
            for (at, value) in list.iter().enumerate() {
                let name = ["name", "id"].iter().find_map(|key| value.get(key)?.as_str());
                walk(
                    value,
                    &format!("{path}.{}", name.map_or_else(|| at.to_string(), str::to_string)),
                    key,
                    visit,
                )?;
            }
            Ok(())
        }
        // A literal `inf` is refused at its key, where the remedy is known.
        value => number(value).filter(|x| x.is_finite()).map_or(Ok(()), |x| visit(path, key, x)),
    }
}

#[cfg(test)]
mod tests {
    use crate::{BENCH, MACHINE_TEMPLATE, embedded_config, read_machine, read_machine_text};

    fn warnings(set: &str) -> Vec<String> {
        read_machine(BENCH, &[set.to_string()], &[]).unwrap().warnings
    }

    fn refusal(set: &str) -> String {
        read_machine(BENCH, &[set.to_string()], &[])
            .map(|_| "accepted".to_string())
            .unwrap_or_else(|e| e.to_string())
    }

    #[test]
    fn likely_units_are_named() {
        for (set, key, remedy) in [
            (
                "shaft.screw.youngs_modulus_pa=206",
                "shaft.screw.youngs_modulus_pa",
                "206 looks like GPa; write 206e9",
            ),
            (
                "shaft.screw.youngs_modulus_pa=200",
                "shaft.screw.youngs_modulus_pa",
                "200 looks like GPa; write 200e9",
            ),
            (
                "shaft.screw.youngs_modulus_pa=2e5",
                "shaft.screw.youngs_modulus_pa",
                "200000 looks like MPa (N/mm²); write 200000e6",
            ),
            (
                "shaft.screw.shear_modulus_pa=79.0",
                "shaft.screw.shear_modulus_pa",
                "79 looks like GPa; write 79e9",
            ),
            (
                "shaft.screw.density_kg_m3=7.85",
                "shaft.screw.density_kg_m3",
                "7.85 looks like g/cm³; write 7850",
            ),
            (
                "shaft.screw.density_kg_m3=7.85e-9",
                "shaft.screw.density_kg_m3",
                "7.85e-9 looks like t/mm³; write 7850",
            ),
            ("shaft.screw.diameter_m=40", "shaft.screw.diameter_m", "40 looks like mm; write 0.04"),
            ("joint.nut.screw.lead_m=10", "joint.nut.screw.lead_m", "10 looks like mm; write 0.01"),
            (
                "point.rotor.inertia_kg_m2=42",
                "point.rotor.inertia_kg_m2",
                "42 looks like kg·cm²; write 0.0042",
            ),
            ("point.table.mass_kg=272000", "point.table.mass_kg", "272000 looks like g; write 272"),
        ] {
            let found = warnings(set);
            assert!(
                found.len() == 1 && found[0].contains(key) && found[0].contains(remedy),
                "{set}: {found:?}"
            );
        }
        let long = warnings("shaft.screw.length_m=1120");
        assert!(long.len() == 1 && long[0].contains("1120 looks like mm; write 1.12"), "{long:?}");
    }

    #[test]
    fn parameters_are_judged_by_their_units() {
        let sets = ["start=180", "lower=1", "upper=1e10"].map(|set| format!("parameter.k_n.{set}"));
        let found = read_machine(BENCH, &sets, &[]).unwrap().warnings;
        assert!(
            found.len() == 1
                && found[0].contains("parameter.k_n.start: 180 N/m")
                && found[0].contains("N/µm; write 180e6"),
            "{found:?}"
        );
    }

    #[test]
    fn numbers_beyond_physics_are_refused() {
        for set in [
            "shaft.screw.length_m=1e308",
            "shaft.screw.length_m=1e18",
            "shaft.screw.length_m=5e-324",
            "point.table.mass_kg=1e308",
            "point.table.mass_kg=5e-324",
            "joint.nut.screw.lead_m=1e300",
            "shaft.screw.youngs_modulus_pa=1e-9",
            "parameter.k_n.upper=1e300",
            "parameter.k_n.lower=5e-324",
        ] {
            let message = refusal(set);
            assert!(message.contains("magnitude") || message.contains("is outside"), "{set}: {message}");
        }
    }

    /// Numbers on which only motion depends, of an axis with a drive.
    #[test]
    fn numbers_of_motion_are_judged() {
        let read = |set: &str| {
            let path = "configs/hybrid-axis.toml";
            read_machine_text(path, embedded_config(path).unwrap(), &[set.to_string()], &[])
        };
        for (set, remedy) in [
            ("joint.shaft.gap=17", "17 looks like"),
            ("drive.motor.inductance_h=23", "23 looks like mH; write 0.023"),
            ("drive.delay_s=1e-10", "drive.delay_s: 1e-10 s is outside"),
            ("drive.position.feed_forward=90", "90 looks like %; write 0.9"),
            ("joint.guide.friction.presliding_stiffness=1e-3", "presliding_stiffness"),
        ] {
            let found = read(set).unwrap().warnings;
            assert!(found.len() == 1 && found[0].contains(remedy), "{set}: {found:?}");
        }
        for set in [
            "drive.position.feed_forward=1e18",
            "drive.motor.resistance_ohm=1e18",
            "joint.guide.friction.stribeck_exponent=1e-18",
        ] {
            let message = read(set).map(|_| "accepted".to_string()).unwrap_or_else(|e| e.to_string());
            assert!(message.contains("is outside"), "{set}: {message}");
        }
    }

    #[test]
    fn described_machines_are_plausible() {
        let names = [
            "tian",
            "tian-as-published",
            "tian-as-computed",
            "two-inertia",
            "emps",
            "twin-ball-screw",
            "twin-ball-screw-as-computed",
            "servo-axis",
            "hybrid-axis",
            "vertical-axis",
        ];
        for name in names {
            let path = format!("configs/{name}.toml");
            let read = read_machine_text(&path, embedded_config(&path).unwrap(), &[], &[]).unwrap();
            assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        }
    }

    #[test]
    fn all_open_numbers_of_a_template_are_in_one_message() {
        let message = read_machine_text("machine.toml", MACHINE_TEMPLATE, &[], &[]).unwrap_err().to_string();
        for key in [
            "point.table.mass_kg",
            "point.rotor.inertia_kg_m2",
            "shaft.screw.length_m",
            "shaft.screw.diameter_m",
            "joint.nut.screw.lead_m",
        ] {
            assert!(message.contains(key), "{message}");
        }
    }

    /// The arm of a robot, or a rotary table, behind a gear has an inertia that is no unit mistake.
    #[test]
    fn inertias_behind_gears_may_be_large() {
        let text = |share: &str| {
            format!(
                r#"
title = "table behind a gear"
[[point]]
name = "motor"
motion = "rotation"
inertia_kg_m2 = 1e-3
[[point]]
name = "table"
motion = "rotation"
inertia_kg_m2 = 1500.0
[[joint]]
name = "gear"
on = {{ motor = 1.0, table = {share} }}
stiffness = 1e4
"#
            )
        };
        let found = |share: &str| read_machine_text("m.toml", &text(share), &[], &[]).unwrap().implausible;
        assert_eq!(found("-160.0"), Vec::<String>::new());
        assert!(found("-1.0")[0].contains("1500 looks like kg·cm²"), "{:?}", found("-1.0"));
    }
}
