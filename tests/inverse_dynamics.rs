//! Identification and diagnosis of motion records by the library, on real records and on records of an
//! independent model.

use config::read_machine;
use diagnosis::motion::{MotionDiagnosis, MotionSettings, diagnose_motion, gap_of};
use diagnosis::{Status, VerdictKind};
use dynamics::inverse_dynamics::{
    MotionSignal, Phase, Preprocessing, Rigid, free_parameters, prediction, recorded,
};
use identification::motion::estimate;
use jointid::Study;
use long_work::Control;
use measurement::{DriveEffort, MotionRecord, read_set};

use crate::support::axis::{Axis, course};

const CONFIG: &str = "configs/emps.toml";

fn emps_records() -> Option<Vec<MotionSignal>> {
    let set = read_set(test_data::shared("realdata/emps")?.to_str().unwrap()).unwrap();
    Some(
        set.motions
            .iter()
            .map(|r| MotionSignal::new(r, Preprocessing::default_for(r.step_s)).unwrap())
            .collect(),
    )
}

fn near(found: f64, published: f64, relative: f64) {
    assert!((found / published - 1.0).abs() < relative, "{found} for {published}");
}

/// Figures of the data set's README: least squares by its authors, symmetric and asymmetric, and their
/// prediction errors on the other record.
#[test]
fn published_emps_least_squares() {
    let Some(motions) = emps_records() else { return };
    let (sweep, pulses) = (&motions[0], &motions[1]);
    assert_eq!((sweep.name.as_str(), sweep.period), ("sweep", Some(624)));
    let config = read_machine(CONFIG, &[], &[]).unwrap();
    let asymmetry = config.effects.iter().find(|e| e.id == "friction-asymmetry").unwrap();
    let asymmetric = config.machine.with_effect(asymmetry).unwrap();
    type Values<'v> = &'v [(&'v str, f64)];
    let figures: [(_, Values<'_>, f64, f64); 2] = [
        (
            &config.machine,
            &[
                ("moving_mass", 95.1089),
                ("viscous_friction", 203.5034),
                ("coulomb_friction", 20.3935),
                ("friction_offset", -3.1648),
            ],
            0.040834,
            0.059824,
        ),
        // F_v = (F_v+ + F_v-)/2, d = (F_v+ - F_v-)/2, F_c and offset likewise.
        (
            &asymmetric,
            &[
                ("viscous_friction", 0.5 * (166.71 + 240.42)),
                ("viscous_asymmetry", 0.5 * (166.71 - 240.42)),
                ("coulomb_friction", 0.5 * (20.144 + 20.628)),
            ],
            0.031117,
            0.05365,
        ),
    ];
    for (machine, values, fitted, predicted) in figures {
        let free = free_parameters(machine, &[]).unwrap();
        let rigid = Rigid::new(machine, &machine.start()).unwrap();
        let fit = estimate(&rigid, machine, &machine.start(), &free, &[sweep]).unwrap();
        for (id, published) in values {
            // Printed to four or five digits.
            near(fit.values[machine.parameter(id).unwrap()], *published, 3e-4);
        }
        near(fit.squares.sqrt() / recorded(&[sweep]).norm(), fitted, 1e-4);
        let y = recorded(&[pulses]);
        near((&y - prediction(&rigid, machine, &fit.values, &[pulses])).norm() / y.norm(), predicted, 1e-4);
        for e in fit.estimates(machine, &free, &[sweep]) {
            let half95 = e.interval95.unwrap().1 - e.value;
            assert!(!e.at_bound && half95 > 0.0);
            // Residuals that repeat in all four periods count once, so the interval is wider than for white
            // noise.
            let at = free.iter().position(|i| *i == e.parameter).unwrap();
            let inverse = (fit.derivatives.transpose() * &fit.derivatives).try_inverse().unwrap();
            let white = 1.96 * (fit.squares / fit.residual.len() as f64 * inverse[(at, at)]).sqrt();
            assert!(half95 > 1.5 * white, "{}", machine.parameters[e.parameter].id);
        }
    }
}

fn diagnose(
    fit: &[&MotionSignal],
    held_out: &[&MotionSignal],
    without: &[&str],
    freeze: &[&str],
) -> MotionDiagnosis {
    let owned = |list: &[&str]| list.iter().map(|s| s.to_string()).collect::<Vec<String>>();
    let config = read_machine(CONFIG, &[], &owned(without)).unwrap();
    let settings = MotionSettings { seed: 1, draws: 240, all_facts: false };
    let found = diagnose_motion(
        &config.machine,
        &config.effects,
        &owned(freeze),
        (fit, held_out),
        settings,
        &Control::default(),
    )
    .unwrap();
    println!("{:?} {:?}: {}", found.verdict.kind, found.verdict.effects, found.verdict.reason);
    found
}

fn names(found: &MotionDiagnosis, id: &str) -> bool {
    found.verdict.effects.iter().any(|e| e.contains(id))
}

/// A band brake on a shaken actuator: friction of 9.3 to 10.2 kN behind a clearance of 3 mm. The force is not
/// linear in presliding, and from its start values a fit ends at twice the error. An independent elastic,
/// perfectly plastic law leaves 21.0 % of the force and 22.3 % of the held-out one.
#[test]
#[ignore = "second tier"]
fn published_damper_with_play() {
    let Some(folder) = test_data::shared("cases/motion-damper-with-play") else { return };
    let path = |name: &str| folder.join(name).display().to_string();
    let study = |machine: &str| {
        Study::new(jointid::read_machine(&path(machine)).unwrap(), read_set(&path("")).unwrap())
    };
    let found = study("machine-presliding.toml").identify().unwrap();
    assert!(
        found.records["a10"].force_error < 0.21 && found.records["a15"].force_error < 0.223,
        "{:#?}",
        found.records
    );
    let value = |id: &str| found.parameters[id].value;
    assert!((8e3..10.6e3).contains(&value("coulomb_friction")), "{}", value("coulomb_friction"));
    assert!((1.7e6..2.4e6).contains(&value("presliding_stiffness")), "{}", value("presliding_stiffness"));
    let found = study("machine.toml").diagnose().unwrap();
    let named = &found.verdict.effects;
    assert!(
        named[0].contains("backlash") && named.iter().all(|id| id.contains("presliding-friction")),
        "{:?}",
        found.verdict
    );
    assert!(!named.iter().any(|id| id.contains("control-delay")), "{named:?}");
    let width_m = found.chosen.parameters["backlash_width"];
    assert!((2.5e-3..3.2e-3).contains(&width_m), "{width_m}");
}

/// The real axis with effects withheld, and as configured, where asymmetry is known to be missing. The delay
/// of the held-out record is reported.
#[test]
#[ignore = "second tier"]
fn published_emps_withheld_effects_are_named() {
    let Some(motions) = emps_records() else { return };
    for (without, missing, least) in [
        (&["coulomb-friction"][..], "coulomb-friction", 0.9),
        (&["viscous-friction"], "viscous-friction", 0.9),
        (&[], "friction-asymmetry", 0.25),
    ] {
        let found = diagnose(&[&motions[0]], &[&motions[1]], without, &[]);
        assert!(
            matches!(found.verdict.kind, VerdictKind::Effect | VerdictKind::Ambiguous)
                && names(&found, missing),
            "{missing}"
        );
        let closed = found.closed(&found.chosen_held_out).unwrap();
        let (low, high) = found.closed95.unwrap();
        println!(
            "held out {:?} to {:?}, closed {closed:.3} ({low:.3} to {high:.3})",
            gap_of(&found.held_out),
            gap_of(&found.chosen_held_out)
        );
        assert!(closed > least && low < closed && closed < high);
        let contradiction = found
            .contradictions
            .iter()
            .find(|c| c.name == "pulses")
            .expect("a contradiction of the delayed record «pulses»");
        assert!(contradiction.description.contains("lags its force"), "{}", contradiction.description);
        let delay = |name: &str| found.shifts.iter().find(|s| s.name == name).unwrap().delay_s;
        assert!(delay("pulses") > 0.5e-3 && delay("pulses") - delay("sweep") > 0.25e-3);
    }
}

/// Simulates a record of the independent axis, whose integration method and friction law differ from the
/// model's.
fn simulated_record(name: &str, axis: &Axis, seed: u64) -> MotionSignal {
    let record = MotionRecord {
        name: name.into(),
        source: format!("{name}.csv"),
        step_s: 1e-3,
        time_s: Vec::new(),
        is_angle: false,
        command_m: Vec::new(),
        position_m: Vec::new(),
        load: DriveEffort::Force(Vec::new()),
        others: Default::default(),
    };
    let samples = axis.run(&course(seed), seed);
    let record = MotionRecord {
        time_s: (0..samples.len()).map(|i| 1e-3 * i as f64).collect(),
        command_m: samples.iter().map(|s| s.0).collect(),
        position_m: samples.iter().map(|s| s.1).collect(),
        load: DriveEffort::Force(samples.iter().map(|s| s.2).collect()),
        ..record
    };
    MotionSignal::new(&record, Preprocessing::default_for(1e-3)).unwrap()
}

fn diagnose_axis(axis: &Axis, seed: u64) -> MotionDiagnosis {
    let (fit, held_out) =
        (simulated_record("fit", axis, seed), simulated_record("held-out", axis, seed + 1000));
    diagnose(&[&fit], &[&held_out], &[], &[])
}

/// Axes without missing effects, with quantised encoders, coloured force noise, slightly varying and drifting
/// friction: parameters are recovered and no effect is named.
///
/// Filters blur the reversals of an axis with standstills, which may look like presliding. No other effect
/// may be named, and presliding on at most one axis in three.
#[test]
fn recover_no_effect_from_axes_as_described() {
    let mut named = Vec::new();
    let axes = test_data::draws(2, 6);
    for seed in 0..axes {
        let axis = Axis { friction_variation: 0.01, friction_drift: 0.01, ..Axis::nominal() };
        let found = diagnose_axis(&axis, seed);
        let value = |id: &str| found.nominal.1[found.nominal.0.machine.parameter(id).unwrap()];
        near(value("moving_mass"), axis.mass_kg, 0.01);
        near(value("viscous_friction"), axis.viscous, 0.05);
        let only = |id: &str| matches!(&found.verdict.effects[..], [named] if named.is_only(id));
        assert!(
            found.verdict.kind == VerdictKind::None || only("presliding-friction"),
            "{}",
            found.verdict.reason
        );
        named.extend(found.verdict.effects);
    }
    println!("effects named on axes as described: {named:?}");
    assert!(named.len() as u64 <= axes.div_ceil(3), "{named:?}");
}

/// One effect per axis, large enough to be visible in the residual, is named alone or first in a combination.
#[test]
#[ignore = "second tier"]
fn recover_effects_of_an_independent_model() {
    let nominal = Axis { friction_variation: 0.01, friction_drift: 0.005, ..Axis::nominal() };
    for (effect, axis) in [
        ("friction-asymmetry", Axis { viscous_backward: 320.0, ..nominal }),
        ("stribeck-friction", Axis { stribeck: 14.0, ..nominal }),
        ("control-delay", Axis { delay_s: 4e-3, ..nominal }),
    ] {
        let found = diagnose_axis(&axis, 3);
        assert!(matches!(found.verdict.kind, VerdictKind::Effect | VerdictKind::Ambiguous), "{effect}");
        assert!(found.verdict.effects.iter().any(|e| e.first() == Some(effect)), "{effect}");
        assert!(found.closed(&found.chosen_held_out).unwrap() > 0.9, "{effect}");
    }
}

/// The force is recorded 2 % too large, on an axis of known mass whose friction varies along the travel by as
/// much. Without nuisance parameters the fit would hide the gain. It shows at reversals and during
/// acceleration.
#[test]
fn recover_a_force_gain_despite_varying_friction() {
    let axis = Axis { friction_variation: 0.02, friction_drift: 0.01, ..Axis::nominal() };
    let scaled = |name: &str, seed: u64| {
        let mut motion = simulated_record(name, &axis, seed);
        motion.load.iter_mut().for_each(|force| *force *= 1.02);
        motion
    };
    let weighed = ["lower=79.9", "start=80.0", "upper=80.1"].map(|s| format!("parameter.moving_mass.{s}"));
    let config = read_machine(CONFIG, &weighed, &[]).unwrap();
    let (fit, held_out) = (scaled("fit", 4), scaled("held-out", 1004));
    let settings = MotionSettings { seed: 1, draws: 240, all_facts: false };
    let found = diagnose_motion(
        &config.machine,
        &config.effects,
        &[],
        (&[&fit], &[&held_out]),
        settings,
        &Control::default(),
    )
    .unwrap();
    println!(
        "{:?} {:?}: {} ({:?})",
        found.verdict.kind, found.verdict.effects, found.verdict.reason, found.phase
    );
    assert!(
        matches!(found.verdict.kind, VerdictKind::Effect | VerdictKind::Ambiguous)
            && names(&found, "force-gain")
    );
    assert!(matches!(found.phase, Some(Phase::Reversal | Phase::Acceleration)));
}

/// An effect missing in the library is located but not named: a spring at the table acts along its position.
#[test]
fn recover_the_location_of_an_unknown_effect() {
    let found = diagnose_axis(
        &Axis { spring_n_per_m: 150.0, friction_variation: 0.01, friction_drift: 0.005, ..Axis::nominal() },
        5,
    );
    assert_eq!(found.verdict.kind, VerdictKind::Unknown);
    assert_eq!((found.located[0].over, found.located[0].shape), ("position", "stiffness"));
}

/// A force delay in all records is an effect; a larger delay of one record is a data fault.
#[test]
#[ignore = "second tier"]
fn recover_the_record_with_the_largest_delay() {
    let axis =
        |delay_s: f64| Axis { delay_s, friction_variation: 0.005, friction_drift: 0.002, ..Axis::nominal() };
    let (a, b, held_out) = (
        simulated_record("a", &axis(4e-3), 3),
        simulated_record("b", &axis(4e-3), 13),
        simulated_record("held-out", &axis(4e-3), 1003),
    );
    let equal_delays = diagnose(&[&a, &b, &simulated_record("c", &axis(4e-3), 23)], &[&held_out], &[], &[]);
    assert!(names(&equal_delays, "control-delay"));
    let larger_delay = diagnose(&[&a, &b, &simulated_record("c", &axis(5.5e-3), 23)], &[&held_out], &[], &[]);
    assert_eq!(larger_delay.verdict.kind, VerdictKind::Measurement);
    assert!(larger_delay.verdict.reason.starts_with("c "), "{}", larger_delay.verdict.reason);
}

/// A held-out record whose force has another scale is reported as a data fault, even if no effect is found.
#[test]
#[ignore = "second tier"]
fn recover_a_held_out_record_of_another_scale() {
    let axis = Axis { friction_variation: 0.005, friction_drift: 0.002, ..Axis::nominal() };
    let (fit, mut held_out) = (simulated_record("fit", &axis, 1), simulated_record("held-out", &axis, 1001));
    assert_eq!(diagnose(&[&fit], &[&held_out], &[], &[]).verdict.kind, VerdictKind::None);
    held_out.load.iter_mut().for_each(|force| *force *= 1.2);
    let found = diagnose(&[&fit], &[&held_out], &[], &[]);
    assert_eq!(found.verdict.kind, VerdictKind::Measurement);
    assert!(found.verdict.reason.starts_with("held-out contradicts"), "{}", found.verdict.reason);
}

/// A wrong sign or unit of the force, of a fitted record, a held-out one or all, is named with its record and
/// not explained by an effect. An effect that is there, too, is named from the corrected records.
#[test]
#[ignore = "second tier"]
fn fault_sign_and_unit_of_the_force() {
    let nominal = Axis { friction_variation: 0.01, friction_drift: 0.005, ..Axis::nominal() };
    let asymmetric = Axis { viscous_backward: 320.0, ..nominal };
    let sound = |axis: &Axis| {
        [("a", 21), ("b", 22), ("c", 1021)].map(|(name, seed)| simulated_record(name, axis, seed))
    };
    let (sound, with_effect) = (sound(&nominal), sound(&asymmetric));
    let scaled = |records: &[MotionSignal; 3], factors: [f64; 3]| {
        let mut records = records.clone();
        let each = records.iter_mut().zip(factors);
        each.for_each(|(record, factor)| record.load.iter_mut().for_each(|force| *force *= factor));
        diagnose(&[&records[0], &records[1]], &[&records[2]], &[], &[])
    };
    for (factors, faults) in [
        ([-1.0, -1.0, -1.0], &["polarity"][..]),
        ([1e-3, 1e-3, 1e-3], &["scale"]),
        ([1.0, -1.0, 1.0], &["polarity@b"]),
        ([9.80665, 1.0, 1.0], &["scale@a"]),
        ([1.0, 1.0, 3.0], &["scale@c"]),
        ([1.0, 1.0, -1e3], &["polarity@c", "scale@c"]),
    ] {
        let found = scaled(&sound, factors).verdict;
        assert_eq!(
            (found.kind, &found.faults[..]),
            (VerdictKind::Measurement, &faults.iter().map(|id| id.to_string()).collect::<Vec<_>>()[..])
        );
        assert!(found.effects.is_empty() && found.reason.contains("force"), "{}", found.reason);
    }
    let found = scaled(&with_effect, [1.0, 1.0, -1.0]);
    assert!(names(&found, "friction-asymmetry") && found.verdict.kind == VerdictKind::Effect);
    assert_eq!(
        (found.verdict.confirmed, &found.verdict.faults[..]),
        (Some(true), &["polarity@c".to_string()][..])
    );
    // Sound records with a large missing effect are not accused.
    let found = diagnose(
        &[&with_effect[0], &with_effect[1]],
        &[&with_effect[2]],
        &["viscous-friction", "coulomb-friction"],
        &[],
    );
    assert!(found.verdict.faults.is_empty(), "{:?}", found.verdict.faults);
}

/// A wrong value of a frozen parameter is reported as such, not explained by an effect.
#[test]
fn recover_a_wrong_frozen_parameter() {
    let axis = Axis { friction_variation: 0.01, ..Axis::nominal() };
    let (fit, held_out) = (simulated_record("fit", &axis, 7), simulated_record("held-out", &axis, 1007));
    let found = diagnose(&[&fit], &[&held_out], &[], &["moving_mass"]);
    assert_eq!(found.verdict.kind, VerdictKind::WrongParameter);
    assert!(found.verdict.reason.contains("moving_mass"));
}

/// A motion without reversals cannot distinguish friction from an offset.
#[test]
fn limit_a_motion_without_reversal_is_insufficient() {
    let axis = Axis::nominal();
    let reversing = simulated_record("fit", &axis, 2);
    let forward: Vec<usize> =
        (0..reversing.position_m.len()).filter(|i| reversing.velocity_m_s[*i] > 0.01).collect();
    let of = |x: &[f64]| forward.iter().map(|i| x[*i]).collect::<Vec<f64>>();
    let mut motion = MotionSignal {
        position_m: of(&reversing.position_m),
        velocity_m_s: of(&reversing.velocity_m_s),
        acceleration_m_s2: of(&reversing.acceleration_m_s2),
        command_m: of(&reversing.command_m),
        load: Vec::new(),
        is_moving: Vec::new(),
        period: None,
        ..reversing.clone()
    };
    motion.load = motion.thinned(&vec![30.0; motion.position_m.len()]).unwrap();
    motion.is_moving = vec![true; motion.load.len()];
    let found = diagnose(&[&motion], &[], &[], &[]);
    assert_eq!(found.verdict.kind, VerdictKind::Insufficient);
}

/// One thread and two give the same result, bit by bit.
#[test]
fn limit_threads_do_not_matter() {
    let axis = Axis { viscous_backward: 300.0, ..Axis::nominal() };
    let (fit, held_out) = (simulated_record("fit", &axis, 9), simulated_record("held-out", &axis, 1009));
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| diagnose(&[&fit], &[&held_out], &[], &[]));
        let tried: Vec<(String, Status, u64)> =
            found.tried.iter().map(|t| (t.id.clone(), t.status.clone(), t.gain.to_bits())).collect();
        (tried, found.judged.unwrap().0.null.largest, found.chosen.1)
    };
    assert_eq!(of(1), of(2));
}
