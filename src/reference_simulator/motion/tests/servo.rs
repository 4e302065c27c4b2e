//! Tests of paths, drive and sensors.

use super::{drive, ideal_axis, machine};
use crate::draw::Draw;
use crate::motion::drive::{Drive, Loops, Settings, quantised};
use crate::motion::path::{Path, Piece};
use crate::motion::plant::Friction;
use crate::motion::run::{Machine, RECORD_S, STEP_S, Sensors, Side};

fn stroke(to_m: f64, speed_m_s: f64) -> Path {
    Path {
        start_m: 0.05,
        pieces: vec![Piece::Stroke { to_m, speed_m_s, acceleration_m_s2: 2.0 }, Piece::Dwell(0.3)],
    }
}

#[test]
fn paths_keep_their_speeds_accelerations_and_ends() {
    let pieces = vec![
        Piece::Stroke { to_m: 0.25, speed_m_s: 0.2, acceleration_m_s2: 1.5 },
        Piece::Dwell(0.1),
        Piece::Stroke { to_m: 0.24, speed_m_s: 0.2, acceleration_m_s2: 1.5 },
        Piece::Sine { amplitude_m: 0.02, frequency_hz: 2.0, cycles: 4 },
    ];
    let path = Path { start_m: 0.05, pieces };
    let values = path.sampled(1e-4, (path.duration_s() / 1e-4) as usize + 10);
    let speed: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]) / 1e-4).collect();
    let acceleration: Vec<f64> = speed.windows(2).map(|pair| (pair[1] - pair[0]) / 1e-4).collect();
    let largest = |values: &[f64]| values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!((largest(&speed[..12_000]) - 0.2).abs() < 1e-6, "{}", largest(&speed));
    assert!((largest(&acceleration[..14_000]) - 1.5).abs() < 0.01, "{}", largest(&acceleration));
    assert!(largest(&acceleration) < 6.0, "acceleration has a jump: {}", largest(&acceleration));
    assert!((values.last().unwrap() - 0.24).abs() < 1e-9);
}

#[test]
fn limit_following_error_is_speed_over_gain_and_friction_over_stiffness() {
    for friction in [false, true] {
        let mut machine = machine();
        machine.axis.pull_n = 0.0;
        if !friction {
            machine = Machine { axis: ideal_axis(), drive: drive() };
        }
        machine.axis.coupling.damping_n_s_m = 2e3;
        let track = machine.run(&stroke(0.55, 0.2), STEP_S, None);
        let at = 1500;
        let error = track.command_m[at] - track.motor_m[at];
        let force = if friction { 23.0 + 0.2 * (60.0 + 120.0 / (1.0 + 0.05 * 0.2)) } else { 0.0 };
        let expected = 0.2 / 60.0 + force / (60.0 * 12_000.0);
        assert!((error / expected - 1.0).abs() < 1e-4, "{error} for {expected}");
        assert!((track.force_n[at] - force).abs() < 0.02 * force + 1e-3, "{} for {force}", track.force_n[at]);
        // The table lags by the deflection due to its friction.
        let behind = track.motor_m[at] - track.table_m[at];
        let guide = if friction { 15.0 + 0.2 * 120.0 / 1.01 } else { 0.0 };
        assert!((behind - guide * (1.0 / 3e7 + 1.0 / 1e8)).abs() < 2e-8, "{behind}");
    }
}

/// Full velocity feed-forward and an integral velocity loop are a PID controller: u = k_v·((k_p + 1/T_i)·e +
/// ė + (k_p/T_i)·∫e dt).
#[test]
fn limit_cascade_with_feed_forward_and_integral_is_a_pid_controller() {
    let integral_time_s = 0.05;
    let drive = Drive { set: Settings { feed_forward: 1.0, integral_time_s, ..drive().set }, ..drive() };
    let (mut loops, mut draw) = (Loops::at_rest(&drive, 0.0), Draw::new(1));
    let (mut sum, mut before) = (0.0, 0.0);
    for k in 0..200 {
        let (reference, position) = (draw.within(1e-3), draw.within(1e-3));
        let error = reference - position;
        let found = loops.sample(&drive, 1e-3 * f64::from(k), reference, position, 0.0);
        let proportional = drive.set.position_gain_1_s * error + before / integral_time_s;
        let expected = drive.set.velocity_gain_n_s_m
            * (proportional
                + (error - before) / drive.set.period_s
                + drive.set.position_gain_1_s / integral_time_s * sum);
        assert!((found - expected).abs() < 1e-9 * drive.set.velocity_gain_n_s_m, "{found} for {expected}");
        sum += error * drive.set.period_s;
        before = error;
    }
}

/// A scale in the position loop with an integral velocity loop holds the table against a pull; the motor's
/// encoder leaves the deflection.
#[test]
fn limit_a_scale_in_the_loop_removes_the_deflection_at_the_table() {
    let mut axis = ideal_axis();
    axis.pull_n = 300.0;
    (axis.coupling.damping_n_s_m, axis.nut.damping_n_s_m) = (2e3, 2e3);
    let error_m = |is_direct: bool| {
        let set = Settings { is_direct, integral_time_s: 0.05, ..drive().set };
        let machine = Machine { axis: axis.clone(), drive: Drive { set, ..drive() } };
        let path = Path { start_m: 0.1, pieces: vec![Piece::Dwell(3.0)] };
        let track = machine.run(&path, STEP_S, None);
        track.command_m.last().unwrap() - track.table_m.last().unwrap()
    };
    let deflection = 300.0 * (1.0 / 3e7 + 1.0 / 1e8);
    assert!((error_m(false) - deflection).abs() < 0.02 * deflection, "{}", error_m(false));
    assert!(error_m(true).abs() < 0.02 * deflection, "{}", error_m(true));
}

/// The force at constant speed is the friction curve, stated here independently: level, Stribeck fall,
/// asymmetry, thinning.
#[test]
fn constant_speed_shows_the_friction_curve() {
    let mut machine = Machine { axis: ideal_axis(), drive: drive() };
    machine.axis.coupling.damping_n_s_m = 2e3;
    machine.axis.guide = Friction {
        coulomb_n: 30.0,
        viscous_n_s_m: 200.0,
        excess: 0.5,
        stribeck_m_s: 0.02,
        asymmetry: [0.1, 0.2],
        thinning: 0.3,
        reference_speed_m_s: 0.4,
        presliding_m: 2e-6,
        ..Friction::none()
    };
    for speed in [0.01f64, 0.03, 0.1, 0.3] {
        for sign in [1.0, -1.0] {
            let start = if sign > 0.0 { 0.05 } else { 0.65 };
            let path = Path {
                start_m: start,
                pieces: vec![Piece::Stroke {
                    to_m: start + sign * 0.6,
                    speed_m_s: speed,
                    acceleration_m_s2: 5.0,
                }],
            };
            let track = machine.run(&Path { pieces: path.pieces.clone(), ..path }, STEP_S, None);
            let force = track.force_n[1500];
            let dry = 30.0
                * (1.0 + 0.5 * 2.0 / ((speed / 0.02).exp() + (-speed / 0.02).exp()))
                * (1.0 + sign * 0.1);
            let wet = 200.0 * speed * (1.0 + sign * 0.2 * (speed / 0.02).tanh()) / (1.0 + 0.3 * speed / 0.4);
            assert!(
                (force - sign * (dry + wet)).abs() < 1e-2 * (dry + wet),
                "{speed} {sign}: {force} for {}",
                dry + wet
            );
        }
    }
}

#[test]
fn dead_time_changes_the_force_only_during_acceleration() {
    let path = stroke(0.35, 0.2);
    let motion = |dead_time_s: f64| {
        let mut machine = machine();
        machine.axis.coupling.damping_n_s_m = 2e3;
        machine.drive.dead_time_s = dead_time_s;
        machine.run(&path, STEP_S, None)
    };
    let (without, with) = (motion(0.0), motion(5e-4));
    // During acceleration the demand leads the motion by the dead time: its loop error grows, and its plateau
    // is unchanged.
    let change: f64 =
        with.force_n.iter().zip(&without.force_n).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(change > 0.1, "{change}");
    assert!(
        (with.force_n[1200] - without.force_n[1200]).abs() < 0.05,
        "{} {}",
        with.force_n[1200],
        without.force_n[1200]
    );
    assert_eq!(quantised(1.26, 0.5), 1.5);
    assert_eq!(quantised(1.26, 0.0), 1.26);
}

#[test]
fn sensors_have_the_stated_rounding_delay_and_noise_for_a_seed() {
    let track = machine().run(&stroke(0.35, 0.2), STEP_S, None);
    let sensors = Sensors {
        side: Side::Motor,
        quantum_m: 1e-6,
        delay_s: 2e-4,
        jitter_s: 0.0,
        noise_m: 0.0,
        noise_n: 2.0,
        coloured: 0.5,
        corner_hz: 20.0,
    };
    let log = sensors.read(&track, |_| {}, &mut Draw::new(3));
    let at = 1200;
    assert!((log.position_m[at] - (track.motor_m[at] - 0.2 * 2e-4)).abs() < 0.6e-6);
    assert!(log.position_m.iter().all(|x| ((x / 1e-6).round() - x / 1e-6).abs() < 1e-6));
    assert_eq!(log, sensors.read(&track, |_| {}, &mut Draw::new(3)));
    assert!(log != sensors.read(&track, |_| {}, &mut Draw::new(4)));
    assert_eq!(track, machine().run(&stroke(0.35, 0.2), STEP_S, None));
    assert_eq!(sensors.exact(&track).force_n, track.force_n);
    let noise = sensors.noise(200_000, &mut Draw::new(1));
    let power = noise.iter().map(|value| value * value).sum::<f64>() / noise.len() as f64;
    assert!((power / 4.0 - 1.0).abs() < 0.05, "{power}");
    // Neighbours share the coloured half: half of e^{−2π 20 Hz 1 ms}.
    let neighbours = noise.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / noise.len() as f64 / power;
    assert!((neighbours - 0.5 * (-0.1256f64).exp()).abs() < 0.02, "{neighbours}");
    assert_eq!(track.command_m.len(), (stroke(0.35, 0.2).duration_s() / RECORD_S).ceil() as usize + 1);
    // The random motor force has its own seed.
    let with_motor_noise =
        |seed| machine().run(&stroke(0.35, 0.2), STEP_S, Some((1.0, 30.0, &mut Draw::new(seed)))).force_n;
    assert!(with_motor_noise(1) == with_motor_noise(1) && with_motor_noise(1) != with_motor_noise(2));
}
