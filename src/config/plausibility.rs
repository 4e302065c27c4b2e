//! Plausible magnitudes of the numbers of a description: warnings with the likely unit, and refusals beyond physics.

use file_access::{is_physical, unfilled};
use machine::{Machine, MachineError};
use toml::{Table, Value};

use super::error::fault;

/// Magnitudes of a kind of quantity in its SI unit.
struct Kind {
    /// Keys of the quantity, or units of a parameter.
    keys: &'static [&'static str],
    /// Unit as it is printed.
    unit: &'static str,
    /// Range outside which the number is refused.
    possible: [f64; 2],
    /// Range outside which the number is warned about.
    plausible: [f64; 2],
    /// Range in which a number has to be in another unit, to name that unit as the likely one.
    usual: [f64; 2],
    /// Other units by likelihood, with their factors to the SI unit.
    others: &'static [(&'static str, f64)],
}

const fn kind(
    keys: &'static [&'static str],
    unit: &'static str,
    possible: [f64; 2],
    plausible: [f64; 2],
    usual: [f64; 2],
    others: &'static [(&'static str, f64)],
) -> Kind {
    Kind { keys, unit, possible, plausible, usual, others }
}

const PASCAL: &[(&str, f64)] = &[("GPa", 1e9), ("MPa (N/mm²)", 1e6), ("kPa", 1e3)];
const METRE: &[(&str, f64)] = &[("mm", 1e-3), ("µm", 1e-6)];
const STIFFNESS: &[(&str, f64)] = &[("N/µm", 1e6), ("N/mm", 1e3)];

/// Kinds by the key of a number.
///
/// # Source  materials from polymers to ceramics; screws of 2 mm to 0.5 m, tables of 10 g to 50 t; catalogues of motors and couplings.
const BY_KEY: [Kind; 30] = [
    kind(&["youngs_modulus_pa"], "Pa", [1.0, 1e15], [1e8, 1.5e12], [4e10, 5e11], PASCAL),
    kind(&["shear_modulus_pa"], "Pa", [1.0, 1e15], [3e7, 7e11], [1.5e10, 2.5e11], PASCAL),
    kind(&["pressure_limit_pa"], "Pa", [1.0, 1e15], [1e7, 1e11], [5e8, 1e10], PASCAL),
    kind(&["density_kg_m3"], "kg/m³", [1e-12, 1e9], [100.0, 3e4], [800.0, 2.3e4], &[("g/cm³", 1e3), ("kg/mm³", 1e9), ("t/mm³", 1e12)]),
    kind(&["length_m"], "m", [1e-9, 1e6], [2e-3, 60.0], [0.02, 30.0], METRE),
    kind(&["diameter_m", "pitch_diameter_m"], "m", [1e-9, 1e5], [2e-4, 2.0], [2e-3, 0.6], METRE),
    kind(&["ball_diameter_m"], "m", [1e-9, 1e5], [1e-4, 0.2], [3e-4, 0.06], METRE),
    kind(&["lead_m"], "m", [1e-9, 1e5], [5e-5, 0.6], [2e-4, 0.3], METRE),
    kind(&["mass_kg", "moved_mass_kg"], "kg", [1e-15, 1e12], [1e-4, 1e5], [0.01, 5e4], &[("g", 1e-3), ("t", 1e3)]),
    kind(&["inertia_kg_m2"], "kg·m²", [1e-20, 1e12], [1e-9, 20.0], [1e-8, 10.0], &[("kg·cm²", 1e-4), ("kg·mm²", 1e-6), ("g·cm²", 1e-7)]),
    kind(&["period_s"], "s", [1e-12, 1e6], [1e-7, 1.0], [1e-6, 0.02], &[("ms", 1e-3), ("µs", 1e-6)]),
    kind(&["preload_n", "coulomb_n", "static_n"], "N", [1e-15, 1e15], [1e-4, 1e6], [0.1, 1e5], &[("kN", 1e3), ("mN", 1e-3)]),
    kind(&["loss_factor"], "", [1e-15, 100.0], [1e-7, 3.0], [1e-4, 1.0], &[("%", 0.01)]),
    kind(&["stiffness_proportional_damping_s"], "s", [1e-15, 1e3], [1e-9, 1.0], [1e-7, 0.1], &[("ms", 1e-3), ("µs", 1e-6)]),
    kind(&["coulomb", "stribeck", "offset"], "N or N·m", [1e-15, 1e15], [1e-6, 1e6], [1e-3, 1e5], &[("kN", 1e3), ("mN", 1e-3)]),
    kind(&["stribeck_velocity"], "m/s or rad/s", [1e-12, 1e6], [1e-7, 100.0], [1e-5, 10.0], &[("mm/s", 1e-3)]),
    kind(&["stribeck_exponent"], "", [1e-3, 1e3], [0.1, 10.0], [0.1, 10.0], &[]),
    kind(&["presliding_stiffness"], "N/m or N·m/rad", [1e-9, 1e18], [0.1, 1e12], [1.0, 1e11], STIFFNESS),
    kind(&["presliding_damping"], "N·s/m or N·m·s/rad", [1e-15, 1e15], [1e-9, 1e10], [1e-6, 1e7], &[]),
    kind(&["load_share", "feed_forward"], "", [1e-12, 1e6], [1e-6, 5.0], [1e-3, 2.0], &[("%", 0.01)]),
    kind(&["gap"], "m or rad", [1e-15, 1e3], [1e-8, 0.1], [1e-7, 5e-3], METRE),
    kind(&["growth"], "", [1e-15, 1.0], [1e-9, 0.02], [1e-6, 5e-3], &[("µm/m", 1e-6)]),
    kind(&["delay_s", "integral_time_s", "over_s"], "s", [1e-15, 1e12], [1e-9, 1e4], [1e-6, 10.0], &[("ms", 1e-3), ("µs", 1e-6)]),
    kind(&["encoder_step"], "m or rad", [1e-15, 10.0], [1e-12, 0.01], [1e-10, 1e-3], METRE),
    kind(&["limits_m"], "m or rad", [1e-9, 1e9], [1e-6, 1e4], [1e-3, 60.0], METRE),
    kind(&["resistance_ohm"], "Ω", [1e-9, 1e9], [1e-4, 1e4], [0.01, 1e3], &[("mΩ", 1e-3)]),
    kind(&["inductance_h", "inductance_d_h"], "H", [1e-12, 1e6], [1e-7, 10.0], [1e-6, 1.0], &[("mH", 1e-3), ("µH", 1e-6)]),
    kind(&["dc_link_v", "saturation"], "", [1e-12, 1e12], [1e-6, 1e6], [0.1, 1e4], &[]),
    kind(&["gain", "gain_per_s", "constant", "position_gain_per_s", "velocity_gain"], "", [1e-15, 1e15], [1e-12, 1e12], [1e-12, 1e12], &[]),
    kind(&["gravity_m_s2"], "m/s²", [1e-6, 1e3], [1.0, 30.0], [9.0, 10.0], &[("mm/s²", 1e-3)]),
];

/// Kinds of stiffness and damping by their unit: of literal numbers of joints, and of parameters.
const BY_UNIT: [Kind; 8] = [
    kind(&["N/m"], "N/m", [1e-12, 1e20], [1e3, 1e12], [1e6, 1e11], STIFFNESS),
    kind(&["N*m/rad"], "N·m/rad", [1e-15, 1e20], [1e-3, 1e10], [1.0, 1e8], &[("kN·m/rad", 1e3), ("MN·m/rad", 1e6), ("N·mm/rad", 1e-3)]),
    kind(&["N*s/m"], "N·s/m", [1e-15, 1e15], [1e-4, 1e10], [1.0, 1e7], &[("N·s/mm", 1e3), ("N·s/µm", 1e6)]),
    kind(&["N*m*s/rad"], "N·m·s/rad", [1e-20, 1e15], [1e-10, 1e8], [1e-5, 1e3], &[("N·mm·s/rad", 1e-3)]),
    kind(&["kg"], "kg", [1e-15, 1e12], [1e-4, 1e5], [0.01, 5e4], &[("g", 1e-3), ("t", 1e3)]),
    kind(&["kg*m^2"], "kg·m²", [1e-20, 1e12], [1e-10, 20.0], [1e-8, 10.0], &[("kg·cm²", 1e-4), ("kg·mm²", 1e-6)]),
    kind(&["Pa"], "Pa", [1.0, 1e15], [1e7, 1.5e12], [1e10, 5e11], PASCAL),
    kind(&["m"], "m", [1e-15, 1e6], [1e-12, 60.0], [1e-6, 30.0], METRE),
];

/// Checks the magnitudes of all numbers of a description, as the file states them. Returns one warning per implausible number.
///
/// # Errors  numbers are still open; a number is beyond physics.
pub(super) fn check_numbers(table: &Table) -> Result<Vec<String>, MachineError> {
    let open = unfilled(table);
    match open.as_slice() {
        [] => {}
        [only] => return Err(fault(only.clone(), "is NaN, still to be filled in; write a number, from a drawing or catalogue")),
        several => {
            let text =
                format!("these {} are NaN, still to be filled in; write a number for each, from drawings and catalogues", several.len());
            return Err(fault(several.join(", "), text));
        }
    }
    let mut found = Vec::new();
    walk_table(table, "", &mut |path, key, x| {
        if !is_physical(x) {
            return Err(fault(path, format!("is {x:e}; no quantity in SI units has this magnitude")));
        }
        found.extend(judge(BY_KEY.iter().find(|kind| kind.keys.contains(&key)), path, x)?);
        Ok(())
    })?;
    for joint in table.get("joint").and_then(Value::as_array).into_iter().flatten() {
        let Some(units) = joint_units(table, joint) else { continue };
        for (key, unit) in ["stiffness", "damping"].into_iter().zip(units) {
            let name = joint.get("name").and_then(Value::as_str).unwrap_or("?");
            if let Some(x) = joint.get(key).and_then(number) {
                found.extend(judge(by_unit(unit), &format!("joint.{name}.{key}"), x)?);
            }
        }
    }
    Ok(found)
}

/// Checks the magnitudes of the parameters that the file describes, at their start. Returns one warning per implausible parameter.
///
/// # Errors  a number is beyond physics.
pub(super) fn check_parameters(machine: &Machine, stated: impl Fn(&str) -> bool) -> Result<Vec<String>, MachineError> {
    let parameters = machine.parameters.iter().filter(|p| stated(&p.id));
    let found = parameters.map(|p| judge(by_unit(&p.unit), &format!("parameter.{}.start", p.id), p.start));
    Ok(found.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

fn by_unit(unit: &str) -> Option<&'static Kind> {
    BY_UNIT.iter().find(|kind| kind.keys.contains(&unit))
}

/// Returns a warning about an implausible number; `None` for a plausible one, for 0 and for a negative one, which is checked elsewhere.
fn judge(kind: Option<&Kind>, path: &str, x: f64) -> Result<Option<String>, MachineError> {
    let Some(kind) = kind.filter(|_| x != 0.0) else { return Ok(None) };
    let within = |[low, high]: [f64; 2], x: f64| (low..=high).contains(&x.abs());
    if within(kind.plausible, x) {
        return Ok(None);
    }
    let unit = if kind.unit.is_empty() { String::new() } else { format!(" {}", kind.unit) };
    let likely = kind.others.iter().find(|(_, factor)| within(kind.usual, x * factor));
    let remedy = likely.map_or_else(
        || "check the number".to_string(),
        |(other, factor)| format!("{} looks like {other}; write {}", written(x), converted(x, *factor)),
    );
    let [low, high] = if within(kind.possible, x) { kind.plausible } else { kind.possible };
    let range = format!("{}{unit} is outside {} … {}{unit}", written(x), written(low), written(high));
    if within(kind.possible, x) { Ok(Some(format!("{path}: {range}; {remedy}"))) } else { Err(fault(path, format!("{range}; {remedy}"))) }
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

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// Returns the units of stiffness and damping of a joint; `None` where its points move differently.
fn joint_units(table: &Table, joint: &Value) -> Option<[&'static str; 2]> {
    let motion = |name: &str| {
        let points = table.get("point")?.as_array()?;
        points.iter().find(|point| point.get("name").and_then(Value::as_str) == Some(name))?.get("motion")?.as_str()
    };
    let ends = joint.get("between")?.as_array()?.iter().filter_map(Value::as_str).filter(|name| *name != "ground");
    let motions: Vec<&str> = ends.map(motion).collect::<Option<_>>()?;
    if motions.iter().all(|motion| *motion == "translation") {
        Some(["N/m", "N*s/m"])
    } else if motions.iter().all(|motion| *motion == "rotation") {
        Some(["N*m/rad", "N*m*s/rad"])
    } else {
        None
    }
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
                walk(value, &format!("{path}.{}", name.map_or_else(|| at.to_string(), str::to_string)), key, visit)?;
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
        read_machine(BENCH, &[set.to_string()], &[]).map(|_| "accepted".to_string()).unwrap_or_else(|e| e.to_string())
    }

    #[test]
    fn likely_units_are_named() {
        for (set, key, remedy) in [
            ("shaft.screw.youngs_modulus_pa=206", "shaft.screw.youngs_modulus_pa", "206 looks like GPa; write 206e9"),
            ("shaft.screw.youngs_modulus_pa=200", "shaft.screw.youngs_modulus_pa", "200 looks like GPa; write 200e9"),
            ("shaft.screw.youngs_modulus_pa=2e5", "shaft.screw.youngs_modulus_pa", "200000 looks like MPa (N/mm²); write 200000e6"),
            ("shaft.screw.shear_modulus_pa=79.0", "shaft.screw.shear_modulus_pa", "79 looks like GPa; write 79e9"),
            ("shaft.screw.density_kg_m3=7.85", "shaft.screw.density_kg_m3", "7.85 looks like g/cm³; write 7850"),
            ("shaft.screw.density_kg_m3=7.85e-9", "shaft.screw.density_kg_m3", "7.85e-9 looks like t/mm³; write 7850"),
            ("shaft.screw.diameter_m=40", "shaft.screw.diameter_m", "40 looks like mm; write 0.04"),
            ("joint.nut.screw.lead_m=10", "joint.nut.screw.lead_m", "10 looks like mm; write 0.01"),
            ("point.rotor.inertia_kg_m2=42", "point.rotor.inertia_kg_m2", "42 looks like kg·cm²; write 0.0042"),
            ("point.table.mass_kg=272000", "point.table.mass_kg", "272000 looks like g; write 272"),
        ] {
            let found = warnings(set);
            assert!(found.len() == 1 && found[0].contains(key) && found[0].contains(remedy), "{set}: {found:?}");
        }
        let long = warnings("shaft.screw.length_m=1120");
        assert!(long.len() == 1 && long[0].contains("1120 looks like mm; write 1.12"), "{long:?}");
    }

    #[test]
    fn parameters_are_judged_by_their_units() {
        let sets = ["start=180", "lower=1", "upper=1e10"].map(|set| format!("parameter.k_n.{set}"));
        let found = read_machine(BENCH, &sets, &[]).unwrap().warnings;
        assert!(
            found.len() == 1 && found[0].contains("parameter.k_n.start: 180 N/m") && found[0].contains("N/µm; write 180e6"),
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
        for set in ["drive.position.feed_forward=1e18", "drive.motor.resistance_ohm=1e18", "joint.guide.friction.stribeck_exponent=1e-18"] {
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
        for key in
            ["point.table.mass_kg", "point.rotor.inertia_kg_m2", "shaft.screw.length_m", "shaft.screw.diameter_m", "joint.nut.screw.lead_m"]
        {
            assert!(message.contains(key), "{message}");
        }
    }
}
