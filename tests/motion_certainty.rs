//! Coverage of intervals from motion records: axes of the independent model with drawn parameters, commands
//! and noise.

use jointid::measurement::{DriveEffort, MeasurementSet, MotionArrays, SetArrays};
use jointid::{Settings, Study, read_machine};
use numeric::distribution::clopper_pearson;
use numeric::statistics::median;
use report::document::IdentificationDocument;
use test_data::is_study;

use crate::support::Draws;
use crate::support::axis::{Axis, course};

pub(crate) const CONFIG: &str = "configs/emps.toml";
/// Standard deviation (N) of the noise of the recorded force.
const NOISE: f64 = 2.0;
/// Fitted parameters.
const PARAMETERS: [&str; 4] = ["moving_mass", "viscous_friction", "coulomb_friction", "friction_offset"];

fn logarithmic(random: &mut Draws, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.next())
}

fn uniform(random: &mut Draws, low: f64, high: f64) -> f64 {
    low + (high - low) * random.next()
}

/// Moves between random positions, with random speeds and accelerations and short rests, 24 s long.
fn moves(random: &mut Draws) -> Vec<f64> {
    let mut command = vec![0.0];
    while command.len() < 24_000 {
        let (from, to) = (command[command.len() - 1], uniform(random, 0.0, 0.2));
        let (acceleration, fastest) = (logarithmic(random, 0.3, 3.0), logarithmic(random, 0.02, 0.2));
        let distance: f64 = (to - from).abs();
        if distance < 0.02 {
            continue;
        }
        let speed = fastest.min((distance * acceleration).sqrt());
        let (ramp, whole) = (speed / acceleration, distance / speed + speed / acceleration);
        for i in 1..=(1e3 * whole) as usize {
            let t = 1e-3 * i as f64;
            let travel = if t < ramp {
                0.5 * acceleration * t * t
            } else if t < whole - ramp {
                speed * (t - 0.5 * ramp)
            } else {
                distance - 0.5 * acceleration * (whole - t).powi(2)
            };
            command.push(from + travel * (to - from).signum());
        }
        let last = command[command.len() - 1];
        command.extend(std::iter::repeat_n(last, uniform(random, 0.0, 300.0) as usize));
    }
    command.truncate(24_000);
    command
}

/// A sum of three sines that begins and ends at rest, 24 s long: reversals without rests.
fn sines(random: &mut Draws) -> Vec<f64> {
    let waves: Vec<[f64; 3]> = [(0.25, 0.06), (0.7, 0.02), (1.7, 0.006)]
        .into_iter()
        .map(|(hz, size)| {
            [
                hz * logarithmic(random, 0.74, 1.35),
                size * logarithmic(random, 0.74, 1.35),
                std::f64::consts::TAU * random.next(),
            ]
        })
        .collect();
    let at = |i: usize| {
        let t = 1e-3 * i as f64;
        let fade = 0.5 - 0.5 * (std::f64::consts::PI * t.min(24.0 - t).min(1.0)).cos();
        0.1 + fade
            * waves
                .iter()
                .map(|[hz, size, phase]| size * (std::f64::consts::TAU * hz * t + phase).sin())
                .sum::<f64>()
    };
    (0..24_000).map(at).collect()
}

/// Draws an axis, optionally with small print, and its command.
fn drawn(number: u64, small_print: bool) -> (Axis, Vec<f64>, Draws) {
    let mut random = Draws(number.wrapping_mul(0x2545_F491_4F6C_DD1D));
    let viscous = logarithmic(&mut random, 100.0, 400.0);
    let described = Axis {
        mass_kg: logarithmic(&mut random, 40.0, 160.0),
        coulomb: logarithmic(&mut random, 10.0, 40.0),
        viscous,
        viscous_backward: viscous,
        ..Axis::nominal()
    };
    let deviating = Axis {
        ripple: 1.5,
        ripple_per_m: std::f64::consts::TAU / logarithmic(&mut random, 0.005, 0.06),
        ripple_phase: std::f64::consts::TAU * random.next(),
        stribeck: 0.04 * described.coulomb,
        stribeck_velocity: logarithmic(&mut random, 0.005, 0.03),
        friction_variation: 0.03,
        variation_per_m: std::f64::consts::PI / 0.2 * uniform(&mut random, 0.7, 4.0),
        variation_phase: std::f64::consts::TAU * random.next(),
        ..described
    };
    let command = match number % 4 {
        0 => course(number),
        1 => moves(&mut random),
        2 => sines(&mut random),
        _ => {
            let twice = course(number);
            let other = course(number + 500);
            [&twice[..twice.len() / 2], &other[..other.len() / 2]].concat()
        }
    };
    (if small_print { deviating } else { described }, command, random)
}

/// Simulates a record with noise of 2 N whose correlation decays over 1 to 50 ms.
pub(crate) fn record(
    name: &str,
    axis: &Axis,
    command: &[f64],
    random: &mut Draws,
    noise: f64,
) -> MotionArrays {
    let samples = axis.run(command, (random.next() * 1e9) as u64);
    let colour = (-1.0 / logarithmic(random, 1.0, 50.0)).exp();
    let mut state = random.normal();
    let mut force = Vec::with_capacity(samples.len());
    for sample in &samples {
        state = colour * state + (1.0 - colour * colour).sqrt() * random.normal();
        force.push(sample.2 + noise * state);
    }
    MotionArrays {
        name: name.into(),
        time_s: (0..samples.len()).map(|i| 1e-3 * i as f64).collect(),
        command_m: samples.iter().map(|s| s.0).collect(),
        position_m: samples.iter().map(|s| s.1).collect(),
        load: DriveEffort::Force(force),
        others: Default::default(),
    }
}

fn identified(record: MotionArrays, tolerances: bool) -> IdentificationDocument {
    let set = SetArrays { title: "drawn".into(), motions: vec![record], ..SetArrays::default() };
    let study = Study::new(read_machine(CONFIG).unwrap(), MeasurementSet::from_arrays(&set).unwrap());
    study.with_settings(Settings { fit_tolerances: tolerances, ..Settings::default() }).identify().unwrap()
}

/// Returns the record of a mass of 95 kg with friction that moves as a sum of sines: amplitude (m) and frequency
/// (Hz).
pub(crate) fn pure_sines(name: &str, sines: &[(f64, f64)]) -> MotionArrays {
    let time_s: Vec<f64> = (0..10_000).map(|i| 1e-3 * f64::from(i)).collect();
    let mut random = Draws(17);
    let sum = |t: f64, of: &dyn Fn(f64, f64) -> f64| {
        sines.iter().map(|(amplitude, hz)| amplitude * of(std::f64::consts::TAU * hz, t)).sum::<f64>()
    };
    let position_m: Vec<f64> = time_s.iter().map(|t| sum(*t, &|omega, t| (omega * t).sin())).collect();
    let mut force = |t: f64| {
        let v = sum(t, &|omega, t| omega * (omega * t).cos());
        let a = sum(t, &|omega, t| -omega * omega * (omega * t).sin());
        95.0 * a + 200.0 * v + 20.0 * v.signum() + 0.1 * random.normal()
    };
    MotionArrays {
        name: name.into(),
        load: DriveEffort::Force(time_s.iter().map(|t| force(*t)).collect()),
        command_m: position_m.clone(),
        position_m,
        time_s,
        others: Default::default(),
    }
}

/// A sine is its own second derivative: a force in proportion to position acts as inertia. One frequency leaves
/// the mass open at any amplitude, with tolerances and without; friction, and the mass of two frequencies, stay
/// identifiable.
#[test]
fn limit_a_single_frequency_does_not_separate_mass_from_a_force_along_the_travel() {
    for sine in [(0.05, 1.0), (0.1, 0.5), (0.02, 3.0), (0.01, 5.0)] {
        for tolerances in [true, false] {
            let found = identified(pure_sines("one", &[sine]), tolerances);
            let mass = &found.parameters["moving_mass"];
            assert_eq!((mass.identifiable, mass.interval95), (Some(false), None), "{sine:?} {tolerances}");
            assert!((mass.value / 95.0 - 1.0).abs() < 0.02, "{sine:?} {tolerances}: {}", mass.value);
            let words = format!(
                "not identifiable: moving_mass; these records move at a single frequency, {:.2} Hz",
                sine.1
            );
            assert!(found.stamp.warnings.iter().any(|w| w.starts_with(&words)), "{:?}", found.stamp.warnings);
        }
        let plain = identified(pure_sines("one", &[sine]), false);
        assert_eq!(plain.parameters["viscous_friction"].identifiable, Some(true), "{sine:?}");
    }
    // The ripple that the fit allows for moves the mass more where the frequencies are close.
    for (sines, within) in [([(0.05, 1.0), (0.02, 3.0)], 0.005), ([(0.05, 1.0), (0.05, 1.1)], 0.02)] {
        for tolerances in [true, false] {
            let mass = &identified(pure_sines("two", &sines), tolerances).parameters["moving_mass"];
            assert!((mass.value / 95.0 - 1.0).abs() < within, "{sines:?} {tolerances}: {}", mass.value);
            assert!(mass.identifiable != Some(false) && mass.interval95.is_some(), "{sines:?} {tolerances}");
        }
    }
}

/// Tests that at most 5 % of the values miss, one-sided at 5 %, with axes, not values, as draws. Prints count
/// and widths. With noise alone intervals are at most twice as wide as those of plain least squares.
fn check_coverage(first: u64, count: u64, small_print: bool) {
    let mut excess: Vec<f64> = Vec::new();
    let (mut values, mut missed, mut depending) = (0, 0, 0);
    let mut by_parameter = vec![(0, Vec::new(), Vec::new()); PARAMETERS.len()];
    for number in first..first + count {
        let (axis, command, mut random) = drawn(number, small_print);
        let measured = record("drawn", &axis, &command, &mut random, NOISE);
        // Among records with small print, widths are compared in a study only.
        let plain = (!small_print || is_study()).then(|| identified(measured.clone(), false));
        let found = identified(measured, true);
        let mut own = Vec::new();
        let (mut misses, mut of) = (0, 0);
        for ((id, truth), sum) in
            PARAMETERS.iter().zip([axis.mass_kg, axis.viscous, axis.coulomb, 0.0]).zip(&mut by_parameter)
        {
            let row = &found.parameters[*id];
            let [low, high] = row.interval95.unwrap();
            sum.1.push(0.5 * (high - low) / if truth == 0.0 { 1.0 } else { truth });
            let width = |plain: &IdentificationDocument| {
                plain.parameters[*id].interval95.map(|[a, b]| b - a).unwrap()
            };
            sum.2.extend(plain.as_ref().map(|plain| (high - low) / width(plain)));
            depending += usize::from(row.depends_on_discrepancy);
            if row.identifiable != Some(true) {
                continue;
            }
            of += 1;
            if !(low..=high).contains(&truth) {
                misses += 1;
                sum.0 += 1;
                own.push(format!("{id} {:+.2} half-widths", (row.value - truth) / (0.5 * (high - low))));
            }
        }
        let text = own.into_iter().chain(found.stamp.warnings.clone()).collect::<Vec<String>>();
        println!("{number}: {}", text.join("; "));
        excess.push(f64::from(misses) - 0.05 * f64::from(of));
        (values, missed) = (values + of, missed + misses);
    }
    let axes = count as f64;
    let mean = excess.iter().sum::<f64>() / axes;
    let sd = (excess.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (axes - 1.0)).sqrt();
    let z = mean / (sd / axes.sqrt()).max(1e-9);
    println!(
        "small print {small_print}: {missed} of {values} identifiable values miss, exact 95 % interval {:.3?}, z = {z:.2}; {depending} depend on the discrepancy",
        clopper_pearson(missed as usize, values as usize, 0.95).unwrap()
    );
    for (id, (missed, widths, ratios)) in PARAMETERS.iter().zip(by_parameter) {
        let (width, ratio) = (median(widths).unwrap(), median(ratios).unwrap_or(f64::NAN));
        println!(
            "{id}: {missed} miss, median half-width {width:.4} of the value (N for the offset), {ratio:.2} times that of plain least squares"
        );
        assert!(
            small_print || ratio <= 2.0,
            "{id}: intervals are {ratio:.2} times as wide as those of plain least squares"
        );
    }
    assert!(z < 1.645, "more than 5 % of the identifiable values miss the true value");
}

/// Noise alone.
#[test]
#[ignore = "second tier"]
fn recover_axes_with_coloured_noise() {
    check_coverage(7_000, test_data::draws(8, 40), false);
}

/// 1.5 N of ripple, 4 % of Stribeck friction and 3 % of friction along the travel, none of them described.
#[test]
#[ignore = "second tier"]
fn recover_axes_with_small_print() {
    check_coverage(7_000, test_data::draws(8, 40), true);
}

/// The motion follows a sampled force half a sample late. The delay is estimated, and the mass is no longer
/// biased by it.
#[test]
fn recover_the_delay_of_a_sampled_loop() {
    let (axis, command, mut random) = drawn(4, false);
    let found = identified(record("quiet", &axis, &command, &mut random, 0.1), true);
    let delay = &found.tolerances["delay of the motion behind the force"];
    assert!((delay.value - 0.5e-3).abs() < 0.1e-3, "{delay:?}");
    for (id, truth) in [("moving_mass", axis.mass_kg), ("viscous_friction", axis.viscous)] {
        let row = &found.parameters[id];
        assert!(
            (row.value / truth - 1.0).abs() < 5e-3 && row.identifiable == Some(true),
            "{id}: {row:?} for {truth}"
        );
    }
}

/// Friction that differs by direction is no small print: no value is reported as identifiable, and the text
/// proposes a diagnosis.
#[test]
fn recover_values_that_depend_on_a_missing_effect() {
    let axis = Axis { viscous_backward: 320.0, ..Axis::nominal() };
    let found = identified(record("asymmetric", &axis, &course(3), &mut Draws(3), 0.3), true);
    let mass = &found.parameters["moving_mass"];
    assert!(mass.identifiable.is_none() && mass.depends_on_discrepancy, "{mass:?}");
    assert!(found.stamp.warnings.iter().any(|w| w.contains("run diagnose")), "{:?}", found.stamp.warnings);
    let plain = identified(record("plain", &Axis::nominal(), &course(3), &mut Draws(3), 0.3), true);
    assert_eq!(plain.parameters["moving_mass"].identifiable, Some(true), "{:?}", plain.stamp.warnings);
}
