//! Motion records as they are: two clocks, strokes in one direction with a rebound, short moves, and a record in which
//! something else acts.

use jointid::document::VerdictKind;
use jointid::measurement::{DriveEffort, MeasurementSet, MotionArrays, SetArrays};
use jointid::{Settings, Study, read_machine};

use crate::motion_certainty::{CONFIG, pure_sines, record};
use crate::support::Draws;
use crate::support::axis::{Axis, course};

fn study(records: Vec<MotionArrays>) -> Study {
    let set = SetArrays { title: "drawn".into(), motions: records, ..SetArrays::default() };
    Study::new(read_machine(CONFIG).unwrap(), MeasurementSet::from_arrays(&set).unwrap())
}

/// Changes the forces of a record, sample by sample: of their time and all of them.
fn with_force(mut of: MotionArrays, change: impl Fn(usize, &[f64]) -> f64) -> MotionArrays {
    let DriveEffort::Force(force) = &of.load else { unreachable!() };
    of.load = DriveEffort::Force((0..force.len()).map(|i| change(i, force)).collect());
    of
}

/// Two records of an axis without a missing effect; `second` is held out.
fn two_records() -> [MotionArrays; 2] {
    [("first", 1), ("second", 2)]
        .map(|(name, number)| record(name, &Axis::nominal(), &course(number), &mut Draws(number), 0.3))
}

/// A force recorded before the motion that it causes comes from a drive that lags, or from another clock; one recorded
/// after it comes from no drive. The mass is not biased by either.
#[test]
fn recover_two_clocks() {
    for (samples, by_drive) in [(4, true), (9, true), (-4, false), (-8, false)] {
        let early = |i: usize, force: &[f64]| force[i.saturating_add_signed(samples).min(force.len() - 1)];
        let study = study(two_records().map(|of| with_force(of, early)).to_vec());
        let study = study.hold_out(["second"]).unwrap();
        let verdict = study.diagnose().unwrap().verdict;
        if by_drive {
            assert_eq!(verdict.effects, ["control-delay", "measurement-delay"], "{samples}: {verdict:#?}");
        } else {
            assert_eq!(verdict.faults, ["measurement-delay"], "{samples}: {verdict:#?}");
            let lag_ms = verdict.reason.split(" by ").nth(1).and_then(|rest| rest.split(' ').next());
            let lag_ms: f64 = lag_ms.unwrap().parse().unwrap();
            // Of half a sample the drive holds its force, which tolerances describe.
            assert!((lag_ms + samples as f64 + 0.5).abs() < 0.5, "{samples}: {}", verdict.reason);
        }
        let found = study.identify().unwrap();
        let delay = &found.tolerances["delay of the motion behind the force"];
        assert!((1e3 * delay.value - samples as f64 - 0.5).abs() < 0.3, "{samples}: {delay:?}");
        let mass = &found.parameters["moving_mass"];
        assert!((mass.value / 80.0 - 1.0).abs() < 2e-3, "{samples}: {mass:?}");
    }
}

/// A held-out record in which a force acts that nothing describes is said to contradict the others.
#[test]
fn recover_a_record_in_which_something_else_acts() {
    let [first, second] = two_records();
    let push = |i: usize, force: &[f64]| force[i] + 60.0 * (1.45e-3 * i as f64).sin();
    let verdict = study(vec![first, with_force(second, push)])
        .hold_out(["second"])
        .unwrap()
        .diagnose()
        .unwrap()
        .verdict;
    assert_eq!(verdict.kind, VerdictKind::Measurement, "{verdict:#?}");
    assert!(verdict.reason.contains("second contradicts the fitted records"), "{}", verdict.reason);
}

/// Builds a record of a mass of 25 kg from its accelerations (m/s²) and its dry friction over 15 N.
fn kinematic(samples: usize, of: impl Fn(usize) -> (f64, f64)) -> MotionArrays {
    let (mut x, mut v) = (0.0, 0.0);
    let mut random = Draws(5);
    let (mut position_m, mut force) = (Vec::new(), Vec::new());
    for i in 0..samples {
        let (a, dry) = of(i);
        position_m.push(x);
        force.push(25.0 * a + 50.0 * v + 15.0 * dry + 0.1 * random.normal());
        x += 1e-3 * v + 0.5e-6 * a;
        v += 1e-3 * a;
    }
    MotionArrays {
        name: "strokes".into(),
        time_s: (0..samples).map(|i| 1e-3 * i as f64).collect(),
        command_m: position_m.clone(),
        position_m,
        load: DriveEffort::Force(force),
        others: Default::default(),
    }
}

/// Strokes in one direction, after which the carriage springs back by 0.1 mm, do not separate friction from an offset.
#[test]
fn limit_a_rebound_is_no_stroke() {
    let strokes = kinematic(6000, |i| match i % 1000 {
        100..200 => (2.0, 1.0),
        200..500 => (0.0, 1.0),
        500..600 => (-2.0, 1.0),
        // Back by 0.1 mm within 40 ms; friction has not changed its sign.
        600..620 => (-0.25, 0.5),
        620..640 => (0.25, 0.5),
        _ => (0.0, 0.0),
    });
    let refusal = study(vec![strokes]).identify().unwrap_err().to_string();
    assert!(refusal.contains("friction_offset") && refusal.contains("one direction only"), "{refusal}");
}

/// Moves of 60 ms between rests: all of their samples are closer to a rest than those of longer moves may be. Moves that
/// repeat are one move, too short for the noise of its samples.
#[test]
fn recover_a_mass_from_short_moves() {
    for repeats in [false, true] {
        let moves = kinematic(6000, |i| {
            let sign = if i % 200 < 100 { 1.0 } else { -1.0 };
            let size = if repeats { 4.0 } else { 3.0 + 0.3 * (i / 200 % 7) as f64 };
            match i % 100 {
                20..50 => (size * sign, sign),
                50..80 => (-size * sign, sign),
                _ => (0.0, 0.0),
            }
        });
        let found = study(vec![moves]).identify().unwrap();
        let mass = &found.parameters["moving_mass"];
        assert!((mass.value / 25.0 - 1.0).abs() < 0.03, "{mass:?}");
        assert_eq!(mass.interval95.is_none(), repeats, "{mass:?}");
        let says = found.stamp.warnings.iter().any(|w| w.contains("too few samples for intervals"));
        assert_eq!(says, repeats, "{:?}", found.stamp.warnings);
    }
}

/// A mass at a single frequency has no interval, whatever the samples: they are not blamed.
#[test]
fn limit_a_single_frequency_is_not_too_few_samples() {
    let freeze = ["viscous_friction", "coulomb_friction", "friction_offset"].map(String::from).to_vec();
    let settings = Settings { freeze, ..Settings::default() };
    let found = study(vec![pure_sines("one", &[(0.05, 1.0)])]).with_settings(settings).identify().unwrap();
    let warnings = &found.stamp.warnings;
    assert!(found.parameters["moving_mass"].interval95.is_none(), "{warnings:?}");
    assert!(warnings.iter().any(|w| w.contains("single frequency")), "{warnings:?}");
    assert!(!warnings.iter().any(|w| w.contains("too few samples")), "{warnings:?}");
}
