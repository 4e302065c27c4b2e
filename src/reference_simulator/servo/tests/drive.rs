//! Tests of loops, limits and paths.

use super::{ideal_run, largest, linear, ramp, tone};
use crate::SimulatorError;
use crate::servo::drive::{Integral, POSITION_TICKS};
use crate::servo::nominal::{Axis, Nominal};
use crate::servo::path::{Circle, Feed};
use crate::servo::run::{Machine, STEPS, run};
use crate::servo::sensor::Sensors;

#[test]
fn limit_following_error_is_speed_over_gain() {
    let mut axis = linear();
    let command = ramp(0.1, 0.9);
    let record = ideal_run(&axis, &command);
    // Just before a new command, the motor has moved for the millisecond of the last command.
    let error = command[890] - record.position_m[890];
    assert!((error / (0.1 / 120.0) - 1.0).abs() < 1e-4, "{error}");
    axis.nominal.loops.feed_forward = 1.0;
    let error = command[890] - ideal_run(&axis, &command).position_m[890];
    assert!(error.abs() < 1e-3 * 0.1 / 120.0, "{error}");
}

/// A sine through the linear axis: x/r = k V/(s + k V) at s = iω. The velocity loop is V = (800 s +
/// 800/T_i)/(s² + 800 s + 800/T_i); the hold of a demand adds a mean delay of half a millisecond.
#[test]
fn limit_sine_response_is_that_of_the_cascade() {
    let omega = std::f64::consts::TAU;
    let command: Vec<f64> = (0..3000).map(|k| 0.01 * (omega * f64::from(k) * 1e-3).sin()).collect();
    let record = ideal_run(&linear(), &command);
    let (reference, answer) =
        (tone(&command[2000..], omega, 1e-3), tone(&record.position_m[2000..], omega, 1e-3));
    let complex = |re: f64, im: f64| num(re, im);
    let measured = complex(answer.0, answer.1).over(complex(reference.0, reference.1));
    let velocity = complex(20_000.0, 800.0 * omega).over(complex(20_000.0 - omega * omega, 800.0 * omega));
    let hold = complex((0.5e-3 * omega).cos(), -(0.5e-3 * omega).sin());
    let open = velocity.times(hold).times(complex(120.0, 0.0));
    let expected = open.over(complex(open.re, open.im + omega));
    let off = (measured.re - expected.re).hypot(measured.im - expected.im);
    assert!(off < 2e-4, "{off}: {measured:?} for {expected:?}");
}

#[derive(Clone, Copy, Debug)]
struct Complex {
    re: f64,
    im: f64,
}

fn num(re: f64, im: f64) -> Complex {
    Complex { re, im }
}

impl Complex {
    fn times(self, other: Self) -> Self {
        num(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)
    }

    fn over(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        self.times(num(other.re / square, -other.im / square))
    }
}

#[test]
fn integral_sum_stops_at_the_limit() {
    let mut pi = Integral::default();
    for _ in 0..1000 {
        assert_eq!(pi.limited(2.0, 0.1, 10.0, 5.0), 5.0);
    }
    assert_eq!(pi.limited(2.0, 0.1, -1.0, 5.0), 2.0 * (-1.0 - 0.1), "the sum is not empty");
    // k (e + share Σe): the sum holds −1 and two halves.
    assert_eq!(pi.limited(2.0, 0.1, 0.5, 5.0), 2.0 * (0.5 + 0.1 * -0.5));
}

/// A step of 2 mm drives voltage and current to their limits and no further, and the axis reaches its target.
#[test]
fn voltage_and_current_keep_their_limits() {
    let axis = Axis::x();
    let limit = 560.0 / 3f64.sqrt();
    let mut machine = Machine::at_rest(&axis, &Sensors::default());
    let (mut volts, mut amperes, mut furthest) = (0.0f64, 0.0f64, 0.0f64);
    for _ in 0..600 * POSITION_TICKS {
        machine.advance(0.002, STEPS);
        volts = volts.max(machine.voltage_v[0].hypot(machine.voltage_v[1]));
        amperes = amperes.max(machine.plant.current_a()[1].abs());
        furthest = furthest.max(machine.plant.table_m());
    }
    assert!(volts <= limit * (1.0 + 1e-12) && volts > 0.999 * limit, "{volts} of {limit}");
    assert!(
        amperes < 1.05 * axis.nominal.current_limit_a && amperes > 0.5 * axis.nominal.current_limit_a,
        "{amperes}"
    );
    assert!((machine.plant.table_m() - 0.002).abs() < 2e-5, "{}", machine.plant.table_m());
    assert!(furthest < 0.0022, "{furthest}");
}

#[test]
fn paths_begin_at_rest_and_keep_their_feeds() {
    for feed in Feed::standard() {
        let command = feed.commands_m().unwrap();
        assert!(command.len() <= 40_001, "{}: {} rows", feed.name(), command.len());
        let speed = largest(command.windows(2).map(|pair| (pair[1] - pair[0]) / 1e-3));
        assert!((speed * 60_000.0 / feed.feed_mm_min - 1.0).abs() < 1e-4, "{}: {speed}", feed.name());
        assert!((largest(command.iter().copied()) - 0.1).abs() < 1e-6);
        assert_eq!(command[0], 0.0);
        let jump = largest(command.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]) / 1e-6));
        assert!(jump < 0.25, "{jump} m/s²");
    }
    let [x, y] = Circle::of(120.0).commands_m().unwrap();
    assert!(x.iter().zip(&y).all(|(x, y)| (x.hypot(y - 0.05) - 0.05).abs() < 1e-15));
    assert!(y[500] < 0.1 * x[500] && x[500] > 0.0, "tangential along x");
}

/// Two revolutions of three seconds coincide, in command and in motion; the circle of the motion differs from
/// the command.
#[test]
fn circle_closes() {
    let circle = Circle { speed_rad_min: 20.0 * std::f64::consts::TAU, ..Circle::of(60.0) };
    let commands = circle.commands_m().unwrap();
    let axes = [Axis::x(), Axis { nominal: Nominal::y(), ..Axis::y() }];
    let mut table = Vec::new();
    for (axis, command) in axes.iter().zip(&commands) {
        let record = ideal_run(axis, command);
        // The first revolution still contains the transient of the start.
        for k in 2500..4000 {
            assert!((command[k] - command[k + 3000]).abs() < 1e-12);
            let off = record.table_m[k] - record.table_m[k + 3000];
            assert!(off.abs() < 2e-7, "{off} at {k}");
        }
        table.push(record.table_m);
    }
    let contour = largest((4000..7000).map(|k| table[0][k].hypot(table[1][k] - 0.05) - 0.05));
    assert!((1e-6..1e-4).contains(&contour), "{contour}");
}

#[test]
fn inadmissible_values_are_refused_by_name() {
    let mut axis = Axis::x();
    axis.nominal.table_kg = f64::NAN;
    assert!(matches!(
        run(&axis, &Sensors::default(), &[0.0], 1),
        Err(SimulatorError::Refused { key: "table_kg", .. })
    ));
    let sensors = Sensors { scale_step_m: -1.0, ..Sensors::default() };
    assert!(matches!(
        run(&Axis::x(), &sensors, &[0.0], 1),
        Err(SimulatorError::Refused { key: "scale_step_m", .. })
    ));
    assert!(matches!(Feed::of(0.0).commands_m(), Err(SimulatorError::Refused { key: "feed_mm_min", .. })));
    let mut axis = Axis::x();
    axis.nominal.table_friction.viscous_n_s_m = f64::NAN;
    assert!(matches!(axis.check(), Err(SimulatorError::Refused { key: "viscous_n_s_m", .. })));
    let mut axis = Axis::x();
    axis.nominal.loops.position_gain_1_s = -120.0;
    assert!(matches!(
        run(&axis, &Sensors::default(), &ramp(0.1, 2.0), 1),
        Err(SimulatorError::Diverged { .. })
    ));
}
