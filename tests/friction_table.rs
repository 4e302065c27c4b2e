//! Measured friction curves of a machine file: against formulas of which they are tables, and refused.

use config::read_machine_text;
use dynamics::motion::{SCurve, SimulationSettings, Trace, simulate};
use machine::Machine;

const AXIS: &str = r#"
title = "axis"
[[point]]
name = "table"
motion = "translation"
mass_kg = 100.0
[[joint]]
name = "guide"
between = ["table", "ground"]
friction = { FRICTION }
[drive]
on = "table"
constant = 100.0
[drive.position]
gain_per_s = 40.0
period_s = 1e-3
[drive.velocity]
gain = 100.0
integral_time_s = 0.05
period_s = 1e-3
"#;

fn machine(friction: &str) -> Machine {
    read_machine_text("axis.toml", &AXIS.replace("FRICTION", friction), &[], &[])
        .unwrap_or_else(|e| panic!("{e}"))
        .machine
}

fn run(machine: &Machine) -> Trace {
    let curve = SCurve { from: 0.0, to: 0.1, velocity: 0.1, acceleration: 1.0, jerk: 50.0 };
    let course = curve.course(1e-3, 0.3, true).unwrap();
    simulate(machine, &machine.start(), &course, &SimulationSettings::default(), &|| true).unwrap()
}

fn largest_difference(a: &Trace, b: &Trace) -> f64 {
    assert!(a.complete && b.complete && a.samples.len() == b.samples.len());
    a.samples.iter().zip(&b.samples).map(|(a, b)| (a.position - b.position).abs()).fold(0.0, f64::max)
}

/// A table with one level is Coulomb friction.
#[test]
fn limit_a_constant_table_is_coulomb_friction() {
    let table = run(&machine("table = [[0.0, 60.0], [0.2, 60.0]]"));
    assert!(largest_difference(&table, &run(&machine("coulomb = 60.0"))) < 1e-9);
    assert!(largest_difference(&table, &run(&machine("coulomb = 20.0"))) > 1e-6);
    assert!(table.energy.imbalance() < 1e-6, "{:e}", table.energy.imbalance());
}

/// A table of the Stribeck curve g = 40 + 30·exp(−(v/0.02)²), computed here, gives the motion of that curve.
/// Linear interpolation over Δ errs by at most Δ²·g''/8 = (5e-4)²·(2·30/0.02²)/8 = 5e-3 N of 70 N.
#[test]
fn limit_a_dense_table_is_its_curve() {
    let rows: Vec<String> = (0..=400)
        .map(|k| 5e-4 * f64::from(k))
        .map(|v| format!("[{v:e}, {:e}]", 40.0 + 30.0 * (-(v / 0.02_f64).powi(2)).exp()))
        .collect();
    let table = run(&machine(&format!("table = [{}]", rows.join(", "))));
    let formula = run(&machine("coulomb = 40.0, stribeck = 30.0, stribeck_velocity = 0.02"));
    let plain = run(&machine("coulomb = 40.0"));
    let (close, far) = (largest_difference(&table, &formula), largest_difference(&plain, &formula));
    assert!(close < 1e-3 * far, "{close:e} against {far:e}");
}

#[test]
fn refuse_tables_that_are_no_friction_law() {
    for (table, expected) in [
        ("[[0.0, 1.0]]", "at least two"),
        ("[[0.0, 1.0], [0.0, 2.0]]", "row 2: the speed 0 does not exceed 0; sort the rows by speed"),
        ("[[-0.1, 1.0], [0.1, 2.0]]", "row 1: the speed is -0.1"),
        ("[[0.0, 1.0], [0.1, -2.0]]", "row 2: the force is -2"),
        ("[[0.0, 1.0], [0.1, inf]]", "row 2: the force is inf"),
    ] {
        let text = AXIS.replace("FRICTION", &format!("table = {table}"));
        let error = read_machine_text("axis.toml", &text, &[], &[]).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("joint.guide.friction.table") && error.contains(expected), "{table}: {error}");
    }
}
